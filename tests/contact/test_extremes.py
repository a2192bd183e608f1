# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact and motion at the extremes: nothing passes, grows, hangs or is wrong without a word."""

from dataclasses import replace

import numpy as np
import pytest

from contact.body.pose_check import first_jump
from contact.body.segments import Body, Fixed, Segment, Steady
from contact.solver.velocity_correction import VelocityCorrection
from demos.studies.extremes import body_cases as meeting
from demos.studies.extremes import captures as captures
from shellform.contact_coupling.contact import Contact
from shellform.motion.capture.gaps_and_spikes import low_pass, without_spikes
from shellform.motion.capture.noise import noise_of, residual_noise
from shellform.motion.capture.read_motion import read_markers, recording
from shellform.motion.wearer import Wearer

ROUNDOFF = 1e-12
NONE = np.zeros(3)


# ---------------------------------------------------------------- contact


@pytest.mark.parametrize("speed", [1.0, 300.0])
def test_impact(speed):
    """A patch against a sphere: momentum exact, none inside, energy does not grow."""
    out = meeting.impact(speed)
    assert out["momentum"] < ROUNDOFF and out["inside"] < 1e-9
    assert out["growth"] < 1e-9 and out["row"]["momentum_z"] > 0.5 * out["first"]["momentum_z"]


@pytest.mark.slow
def test_impact_of_implicit_steps():
    """The same at 300 m/s, a step three times as long as the way to the body."""
    out = meeting.impact(300.0, dt=1e-4)
    assert out["momentum"] < ROUNDOFF and out["inside"] < 2e-9 and out["growth"] < 0
    assert out["touch"].rounds < 200


@pytest.mark.parametrize(("friction", "slope"), [(0.0, 1.0), (10.0, 9.9), (10.0, 20.0), (1e6, 1e3)])
def test_friction(friction, slope):
    """Stick is exact below the cone; above it the slip is that of steps under a steady pull."""
    for dt in (2e-3, 1e-3):
        slip, exact = meeting.incline(friction, slope, dt=dt)
        if slope <= friction:
            assert exact == 0.0 and abs(slip) < 1e-12
        else:  # sum of velocities a k dt over k = 1 to n: (1 + 1/n) a t^2/2
            assert slip == pytest.approx(exact * (1 + dt), rel=1e-4)


@pytest.mark.parametrize("aspect", [1.0, 1e3, 1e6])
def test_slender_ellipsoids(aspect):
    out = meeting.slender(aspect)
    assert out["met"] > 100 and out["momentum"] < ROUNDOFF
    assert out["inside"] < 1e-12 and out["growth"] < 1e-9


def test_ellipsoids_that_roundoff_would_lose_are_refused():
    """More than 1e9 between semi-axes, of a segment and of a wearer."""
    with pytest.raises(ValueError, match=r"'blade' has radii from 1e-11 to 0.1 m.*shorter"):
        meeting.slender(1e10)
    with pytest.raises(ValueError, match=r"'calf' needs three finite radii > 0"):
        Wearer(captures.walk(), [("calf", "right_shank", NONE, (0.05, np.nan, 0.2))])


@pytest.mark.parametrize("samples", [0, 1, 3])
@pytest.mark.parametrize("radius", [0.0005, 0.003, 0.012, 0.022])
def test_thin_rods_are_met_by_edges(radius, samples):
    """Rows of nodes 40 mm apart, the rod in the middle between two of them."""
    out = meeting.over_rod(radius, samples)
    assert out["caught"] and out["momentum"] < ROUNDOFF


@pytest.mark.parametrize("count", [1, 62, 200])
def test_number_of_ellipsoids(count):
    out = meeting.row_of_spheres(count)
    assert out["own"] == count and out["momentum"] < ROUNDOFF and out["inside"] < 1e-15


def test_many_ellipsoids_are_as_few_where_the_others_are_far():
    """60 ellipsoids and 140 far away move points bit for bit as the 60 do."""
    rng, ends = np.random.default_rng(1), []
    near, far = rng.uniform(-0.2, 0.2, (60, 3)), rng.uniform(50, 60, (140, 3))
    for centres in (near, np.vstack([near, far])):
        body = Body([Segment(f"s{k}", (0.1, 0.07, 0.05), Fixed(c)) for k, c in enumerate(centres)])
        rng = np.random.default_rng(2)
        x = rng.uniform(-0.4, 0.4, (2000, 3))
        assert meeting.points_on(body, x, rng.standard_normal(x.shape), 1e-3, 20)["met"] > 100
        ends.append(x)
    assert np.array_equal(*ends)
    assert body.mask(["s3"]) == 8
    with pytest.raises(ValueError, match="'s62' cannot be told from 's150'"):
        body.mask(["s150"])
    with pytest.raises(ValueError, match="only 62 can be told apart as soft ones"):
        VelocityCorrection(body, 1, flesh=1e5)


def test_many_ellipsoids_of_a_wearer_are_told_apart_by_their_segments():
    """200 ellipsoids on seven segments: a set names the segments; soft creases work."""
    rec = captures.walk()
    names = list(rec.points)
    rows = [(f"e{k}", names[k % 7], np.full(3, 1e-3 * k), (0.05, 0.05, 0.05)) for k in range(200)]
    wearer = Wearer(rec, rows)
    leg = [name for name, segment in zip(wearer.names, wearer.carriers) if "left" in segment]
    correction = VelocityCorrection(wearer, 2, flesh=1e5)
    correction.allowed[1] &= ~wearer.mask(leg)
    pose = wearer.new_pose(wearer.start)
    x = np.tile(pose.centres[wearer.index(leg[0])], (2, 1)) + [[0.049, 0, 0]]
    v = np.zeros((2, 3))
    correction(x, v, np.ones(2), 1e-4, wearer.start)
    touched = [wearer.carriers[k] for k in correction.segment if k >= 0]
    assert "left" in touched[0] and not any("left" in name for name in touched[1:])
    with pytest.raises(ValueError, match="cannot be told from"):
        wearer.mask([leg[0]])


@pytest.mark.parametrize(
    ("given", "match"),
    [
        ({"mass": np.nan}, "node 0 has a mass of nan kg"),
        ({"mass": 0.0}, "node 0 has a mass of 0.0 kg"),
        ({"dt": 0.0}, "time step above 0 s"),
        ({"dt": np.nan}, "time step above 0 s"),
        ({"t": np.inf}, "at a finite time"),
    ],
)
def test_masses_and_steps_that_are_none(given, match):
    correction = VelocityCorrection(Body([Segment("ball", [0.1] * 3, Fixed())]), 1)
    x, v = np.array([[0.0, 0.0, 0.1001]]), np.array([[0.0, 0.0, -1.0]])
    given = {"mass": 1.0, "dt": 1e-3, "t": 0.0} | given
    with pytest.raises(ValueError, match=match):
        correction(x, v, np.array([given["mass"]]), given["dt"], given["t"])


def test_a_body_that_jumps_under_explicit_steps():
    body = Body([Segment("ball", [0.25] * 3, meeting.jump(0.05, 0.02))])
    with pytest.raises(ValueError, match=r"'ball' jumps by 0.05 m between t = .*motion"):
        meeting.cloth_on(meeting.patch(cells=2), body, 0.05)


def test_a_rod_below_the_cells_is_refused_under_implicit_steps():
    body = Body([Segment("rod", (0.003, 10.0, 0.003), Fixed())])
    with pytest.raises(ValueError, match=r"'rod', 6 mm thick, .* nodes of cells 56.6 mm across"):
        meeting.patch(side=0.2, cells=5, dt=1e-3).add(Contact(body))


@pytest.mark.parametrize("dt", [1e-5, 1e-3])
def test_body_at_50_metres_a_second(dt):
    """Head on without friction, a sphere gives points (nearly) its speed, inelastically."""
    ahead = Steady((-0.3, 0.0, 0.0), velocity=(50.0, 0.0, 0.0))
    out = meeting.moving(ahead, dt, round(0.012 / dt), friction=0.0)
    assert out["met"] > 20 and out["momentum"] < ROUNDOFF and out["inside"] < 1e-12
    assert 49.0 < out["fastest"] < 50.0 * (1 + 1e-12)


@pytest.mark.parametrize("spin", [10.0, 1000.0])
def test_spinning_ellipsoid(spin):
    """A blade that sweeps points: they get no more than the tip's speed, twice with what they
    slide out, and leave with none inside."""
    x = np.array([[0.1, 0.0, -0.1], [0.1, 0.02, -0.12]])
    turning = Steady(spin=(0.0, spin, 0.0))
    out = meeting.moving(turning, 1e-4, round(2e4 / spin), (0.2, 0.05, 0.05), x, friction=0.0)
    assert 0 < out["fastest"] < 2 * 0.2 * spin
    assert out["momentum"] < ROUNDOFF and out["inside"] < 1e-12


def test_jumps_are_told_from_motion():
    """Whatever moves as its velocity says, or starts and stops at once, does not jump."""

    def over(motion, t, dt):
        pose, end = (Body([Segment("s", (0.2, 0.1, 0.1), motion)]).new_pose(s) for s in (t, t + dt))
        return first_jump(*pose, *end, np.array([[0.2, 0.1, 0.1]]), dt)

    quick = Steady((0.0, 0.0, 0.0), velocity=(50.0, 0.0, 0.0), spin=(0.0, 0.0, 300.0))
    for dt in (1e-6, 1e-3, 0.1):
        assert over(quick, 0.3, dt) == (-1, 0.0)
        assert over(meeting.jump(0.009, 0.05), 0.05 - 0.5 * dt, dt) == (-1, 0.0)
        b, size = over(meeting.jump(0.5, 0.05), 0.05 - 0.5 * dt, dt)
        assert b == 0 and size == pytest.approx(0.5)

    def starts(t):
        speed = 50.0 if t > 0 else 0.0
        return np.array([speed * t, 0.0, 0.0]), np.eye(3), np.array([speed, 0.0, 0.0]), NONE

    assert over(starts, -1e-4, 1e-3) == (-1, 0.0)


def test_a_body_that_jumps_under_implicit_steps():
    body = Body([Segment("ball", [0.25] * 3, meeting.jump(0.05, 0.02))])
    with pytest.raises(ValueError, match=r"'ball' jumps by 0.05 m between t = 0.0.*motion"):
        meeting.cloth_on(meeting.patch(dt=1e-3, cells=2), body, 0.05)


def test_points_without_a_normal_find_a_way_out():
    """At the centre, where no direction is shortest; on the skin, moving in."""
    for radii in ([0.1] * 3, [0.1, 0.05, 0.02], [0.02, 0.1, 0.1]):
        body = Body([Segment("s", radii, Fixed())])
        x = np.zeros((1, 3))
        steps = round(min(radii) / 0.1 / 1e-3)
        out = meeting.points_on(body, x, np.zeros((1, 3)), 1e-3, steps)
        assert out["inside"] < 1e-12 and np.linalg.norm(x) == pytest.approx(min(radii))
        assert out["fastest"] < 0.1 * (1 + 1e-12)  # the recovery speed
    body = Body([Segment("s", [0.1] * 3, Fixed())])
    x = np.random.default_rng(0).standard_normal((200, 3))
    x *= 0.1 / np.linalg.norm(x, axis=1)[:, None]
    out = meeting.points_on(body, x, -100.0 * x, 1e-3, 5)
    assert out["inside"] < 1e-12 and out["growth"] < 1e-9 and out["met"] >= 200


def test_cloth_starts_inside_and_comes_out():
    """A body that is there within the cloth at the start pushes it out at its recovery speed."""
    body = Body([Segment("ball", [0.25] * 3, Fixed((0.0, 0.0, -0.25)))])
    out = meeting.cloth_on(meeting.patch(side=0.2, height=-0.02), body, 0.5)
    assert out["inside"] < 1e-9 and out["momentum"] < 1e-10
    assert out["row"]["kinetic"] < 1e-3  # none of it was shot out


@pytest.mark.parametrize("overlap", [0.02, 0.05])
def test_bodies_that_close_over_cloth(overlap):
    """Soft ones let the cloth rest in the crease and give it back; hard ones fling it, finitely."""
    soft, hard = (meeting.closing(overlap, flesh) for flesh in (2e5, None))
    for out in (soft, hard):
        assert out["momentum"] < 1e-10 and np.isfinite(out["points"]).all()
    left = [out["row"]["kinetic"] + out["row"]["strain"] for out in (soft, hard)]
    mass = 0.01 * meeting.CLOTH["density"] * meeting.CLOTH["thickness"]
    assert left[0] < 0.5 * mass * 0.05**2 and left[0] < 0.01 * left[1]
    assert hard["row"]["kinetic"] < 0.5 * mass * 5.0**2


@pytest.mark.parametrize("bad", ["x", "v"])
def test_what_is_no_number_stops_the_step(bad):
    body = Body([Segment("ball", [0.1] * 3, Fixed())])
    x, v = np.array([[0.0, 0.0, 0.2]]), np.zeros((1, 3))
    (x if bad == "x" else v)[0, 1] = np.nan
    with pytest.raises(FloatingPointError, match="node 0"):
        meeting.points_on(body, x, v, 1e-3, 1)


# ---------------------------------------------------------------- captures


def test_rates_from_10_to_2000_hertz():
    """One motion, seen oftener or seldomer: the same curves, as far as sampling lets them be."""
    whole = captures.read(captures.thinned(1), cutoff=6.0)
    far = [captures.off(captures.read(captures.thinned(e)), whole) for e in (2, 20, 100)]
    assert far[0] < 1e-5 and far[1] < 5e-4 and far[2] < 5e-3
    with pytest.raises(
        ValueError, match=r"0 and 4 Hz at 10 frames a second, not 6 Hz; lower cutoff"
    ):
        captures.read(captures.thinned(200))
    slow = captures.read(captures.thinned(200), cutoff=3.0)
    assert not any("jumps" in note for note in slow.notes)  # its own motion is no error
    assert captures.off(slow, captures.read(captures.thinned(1), cutoff=3.0)) < 0.02


def test_low_pass_leaves_of_noise_what_it_should():
    """White noise through the filter: places and accelerations, against the integrals."""
    rng, rate = np.random.default_rng(0), 1000.0
    noise = rng.standard_normal((200_000, 3)) / np.sqrt(3)
    left = low_pass(noise, rate, 6.0)
    bent = np.diff(left, 2, axis=0) * rate**2
    rms = [np.sqrt(np.mean(np.sum(e**2, axis=1))) for e in (left, bent)]
    assert rms == pytest.approx(residual_noise(1.0, rate, 6.0), rel=0.02)
    assert noise_of(noise) == pytest.approx(1.0, rel=0.02)


@pytest.mark.parametrize("rms", [1e-3, 5e-3, 20e-3])
def test_noise_is_told_with_what_is_left_of_it(rms):
    """1, 5, 20 mm: the recording is off as foretold, in places and accelerations."""
    measured, foretold, rec = captures.noise_left(rms)
    assert measured == pytest.approx(foretold, rel=0.15)
    said = [note for note in rec.notes if note.startswith("markers shake by")]
    assert len(said) == (rms > 3e-3)
    if said:
        assert float(said[0].split()[3]) == pytest.approx(1e3 * rms, rel=0.1)
    clean = captures.read(captures.markers_of(captures.walk()))
    off = np.degrees(np.abs(captures.knee(rec) - captures.knee(clean))[40:-40])
    # the thigh turns by the noise of both its ends over its length, the shank likewise
    angle = np.degrees(2 * foretold[0] / np.sqrt(3) / 0.4)
    assert np.sqrt(np.mean(off**2)) < 1.2 * angle


def test_gaps_and_jumps_that_come_back():
    """What is off for up to 100 ms is replaced and told, also between two edges."""
    clean = captures.read(captures.markers_of(captures.walk()))
    for size, frames in ((0.03, 1), (0.05, 5), (0.5, 10)):
        rec = captures.read(captures.spoilt(captures.set_aside(size, frames, 4)))
        assert any("'right_thigh.J2' jumps" in note for note in rec.notes)
        assert captures.off(rec, clean) < 2e-3, (size, frames)


def test_jumps_that_stay():
    """Small ones are told with their size, large ones refused: of a marker, or of them all."""
    rec = captures.read(captures.spoilt(captures.set_aside(0.05, None, 4)))
    note = next(note for note in rec.notes if "it stays" in note)
    assert float(note.split("it stays ")[1].split()[0]) == pytest.approx(50, abs=2)
    for marker, who in ((4, "right_thigh.J2"), (None, "pelvis.J1")):
        for size in (0.2, 10.0):
            with pytest.raises(ValueError, match=rf"'{who}' jumps by.*t = 1\.\d* s and stays"):
                captures.read(captures.spoilt(captures.set_aside(size, None, marker)))


def test_nobody_moves_at_100_metres_a_second():
    """Frames in the wrong unit of time, or noise that nothing filters."""
    whole = captures.markers_of(captures.walk())
    quick = replace(whole, times=whole.times / 50, rate=whole.rate * 50)
    with pytest.raises(ValueError, match=r"moves at \d+ m/s at t = .*faster than 30 m/s"):
        captures.read(quick, cutoff=None)


@pytest.mark.parametrize("rate", [50.0, 200.0])
def test_spline_between_frames_overshoots_a_step_by_a_tenth(rate):
    """A jump within one frame: the wearer gets there in it, and swings by 11 % at most."""
    times = np.arange(41) / rate
    rec = captures.walk()
    still = {name: np.repeat(track[:1], 41, axis=0) for name, track in rec.points.items()}
    for track in still.values():
        track[20:, :, 0] += 1.0
    wearer = Wearer(replace(rec, times=times, points=still), [])
    joints = wearer.new_joints()
    way = np.array(
        [wearer.joint_state(t, joints).centres[0, 0] for t in np.linspace(0, times[-1], 4001)]
    )
    way -= way[0]
    # cardinal splines: s(x) between knots of a step, extreme +-0.11 in the next interval
    assert way.min() > -0.11 and way.max() < 1.11 and way.max() > 1.05


def test_turning_walk_bends_the_joints_as_before():
    """The walk turned by 90 degrees on the way: same knees, and the turn is told."""
    straight = captures.read(captures.markers_of(captures.walk()))
    rec = captures.read(captures.markers_of(captures.turning(0.5 * np.pi)))
    inner = slice(40, -40)
    bent = np.abs(captures.knee(rec) - captures.knee(straight))[inner]
    assert bent.max() < np.radians(0.5)
    long = rec.times[-1] - rec.times[0]
    turn = 0.5 * np.pi * (1 - rec.facts["stride_time"] / long)
    assert rec.facts["turn"] == pytest.approx(turn, abs=0.05)


def test_headers_that_lie(shared_tmp_path, comm):
    """Numbers of frames and markers are counted; a wrong rate or unit is a sentence."""
    path = shared_tmp_path / "walk.trc"
    markers = captures.markers_of(captures.walk())

    def told(**given):
        if comm.rank == 0:
            captures.trc(path, markers, **given)
        comm.Barrier()
        try:
            return "; ".join(read_markers(path, up="z").notes)
        except ValueError as refusal:
            assert str(path) in str(refusal) and "\n" not in str(refusal)
            return str(refusal)
        finally:
            comm.Barrier()

    frames = len(markers.times)
    assert f"header says 9 frames, the file holds {frames}" in told(frames=9)
    assert "header says 3 markers, the file names 21" in told(count=3)
    assert "rate is 60 Hz" in told(rate=60)
    assert "unknown unit 'furlong'" in told(unit="furlong")
    assert "unit m, from the size of the person" in told(unit="")


def test_rounded_times_without_a_rate(shared_tmp_path, comm):
    """150 frames a second in milliseconds, 7, 6, 7, ...: even, at 150 Hz."""
    path = shared_tmp_path / "walk.csv"
    if comm.rank == 0:
        lines = ["time,a_x,a_y,a_z,b_x,b_y,b_z"]
        lines += [f"{k / 150:.3f},{k},0,1,{k},0,2" for k in range(300)]
        path.write_text("\n".join(lines))
    comm.Barrier()
    markers = read_markers(path, unit="m", up="z")
    assert markers.rate == pytest.approx(150.0, rel=1e-3 / markers.times[-1])
    assert np.ptp(np.diff(markers.times)) < 1e-12


@pytest.mark.parametrize(
    ("ending", "inside", "match"),
    [
        (".csv", bytes(range(256)) * 20, "byte 0 is no text"),
        (".trc", bytes(range(256)) * 20, "byte 0 is no text"),
        (".c3d", bytes(range(256)) * 20, "cut off|ezc3d|pip install"),
        (".csv", b"t,a_x,a_y,a_z\n0,1,inf,2\n1,1,1,1\n2,1,1,1\n", "line 2, column 3 holds 'inf'"),
    ],
)
def test_junk(shared_tmp_path, comm, ending, inside, match):
    path = shared_tmp_path / f"walk{ending}"
    if comm.rank == 0:
        path.write_bytes(inside)
    comm.Barrier()
    with pytest.raises((ValueError, ImportError), match=match) as refusal:
        read_markers(path)
    assert str(path) in str(refusal.value) and "\n" not in str(refusal.value)


def test_one_wrong_number_does_not_turn_a_capture(paper_data):
    """A place 1e27 m away in one frame is a spike, not the vertical; mirrored, lateral alone."""
    markers = read_markers(paper_data / "bmc_walk2.trc")
    rec = recording(markers)
    raw = markers.positions.copy()
    raw[100, markers.names.index("L.ASIS")] = 1e27
    spoilt = recording(replace(markers, positions=raw))
    assert any("'L.ASIS' jumps" in note for note in spoilt.notes)
    off = np.abs(spoilt.joint_centre("left_hip") - rec.joint_centre("left_hip"))
    assert off.max() < 5e-3
    keep = [k for k, name in enumerate(markers.names) if "Medial" not in name]
    lateral = replace(
        markers, names=tuple(markers.names[k] for k in keep), positions=markers.positions[:, keep]
    )
    assert "map 'lateral'" in recording(lateral).notes
    other = {"R": "L", "L": "R"}
    swapped = replace(markers, names=tuple(other[n[0]] + n[1:] for n in markers.names))
    assert any("mirrored" in note for note in recording(swapped).notes)


def test_a_small_spike_keeps_its_neighbours():
    """Two spikes farther apart than a gap may be are two; nearer they are one."""
    t = np.arange(200) / 100.0
    track = np.stack([t, np.sin(t), 0 * t], axis=1)
    for apart, runs in ((5, 1), (40, 2)):
        marred = track.copy()
        marred[[80, 80 + apart], 2] += 0.05
        mended, notes = without_spikes(marred, "knee", t, 0.1)
        assert len(notes) == runs and np.abs(mended - track).max() < 1e-5


@pytest.mark.thorough
@pytest.mark.slow
def test_table():
    """Every direction is told in four strings, with one of three verdicts."""
    from demos.studies.extremes.bodies import rows

    table = rows()
    assert len({direction for direction, *_ in table}) > 12
    for cells in table:
        assert len(cells) == 4 and all(isinstance(cell, str) and cell for cell in cells)
        assert cells[2] == "converges" or cells[2].startswith(("degrades: ", "refused: "))
        assert "balances do not close" not in cells[2] and "\n" not in "".join(cells)
