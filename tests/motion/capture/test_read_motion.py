# SPDX-License-Identifier: LGPL-3.0-or-later
"""Body from motion: capture files, labels, repairs and Eq. 17 against motions known beforehand."""

import sys

import numpy as np
import pytest

from contact.body.segment_frame import pose_from_markers
from shellform.motion.capture.gaps_and_spikes import low_pass
from shellform.motion.capture.joint_centres import fixed_in
from shellform.motion.capture.read_motion import (
    choose_map,
    read_markers,
    read_motion,
    recording,
    segment_map,
)

THIGH, SHANK, KNEE, ANKLE = 0.42, 0.41, 0.055, 0.044
PW, PD = 0.25, 0.13  # width and depth of the walker's pelvis [m]

# labels by public captures: BMC; OpenSim's Rajagopal; Camargo; OpenCap; Plug-in Gait
BMC = {
    "asis": "{S}.ASIS", "psis": "{S}.PSIS", "knee": "{S}.Knee", "knee_in": "{S}.Knee.Medial",
    "ankle": "{S}.Ankle", "ankle_in": "{S}.Ankle.Medial", "heel": "{S}.Heel", "toe": "{S}.MT2",
    "toe_out": "{S}.MT5",
}  # fmt: skip
LATERAL = {k: v for k, v in BMC.items() if not k.endswith("_in")}
RAJAGOPAL = {**LATERAL, "toe": "{S}.Toe", "t1": "{S}.TH1", "t2": "{S}.TH2", "t3": "{S}.TH3"}
CAMARGO = {
    "asis": "{S}_ASIS", "psis": "{S}_PSIS", "knee": "{S}_Knee_Lat", "ankle": "{S}_Ankle_Lat",
    "heel": "{S}_Heel", "toe": "{S}_Toe_Tip", "toe_out": "{S}_Toe_Lat", "t1": "{S}_Thigh_Upper",
    "t2": "{S}_Thigh_Front", "t3": "{S}_Thigh_Rear",
}  # fmt: skip
OPENCAP = {
    "asis": "{s}.ASIS_study", "psis": "{s}.PSIS_study", "knee": "{s}_knee_study",
    "knee_in": "{s}_mknee_study", "ankle": "{s}_ankle_study", "ankle_in": "{s}_mankle_study",
    "heel": "{s}_calc_study", "toe": "{s}_toe_study", "toe_out": "{s}_5meta_study",
}  # fmt: skip
PLUG_IN = {
    "asis": "{S}ASI", "psis": "{S}PSI", "knee": "{S}KNE", "ankle": "{S}ANK", "heel": "{S}HEE",
    "toe": "{S}TOE", "hip_c": "{S}FEP", "knee_c": "{S}FEO", "ankle_c": "{S}TIO",
}  # fmt: skip


def along(position, *axes_and_steps):
    """A point moved by steps along axes given frame by frame."""
    return position + sum(step * axis for axis, step in axes_and_steps)


def walker(labels, speed=1.2, bend=0.0, seconds=3.5, rate=100.0, twist=0.0):
    """Names, tracks (n, m, 3) [m] and true joint centres of a walk along a line or an arc.

    A stride takes 1 s, so its length is `speed` in m. The path turns by `bend` [rad/s] to the
    left; thighs turn about their own axis by `twist` [rad].
    """
    t = np.arange(round(seconds * rate)) / rate
    yaw, one = bend * t, np.ones_like(t)
    ahead = np.stack([np.cos(yaw), np.sin(yaw), 0 * t], axis=1)
    right = np.stack([np.sin(yaw), -np.cos(yaw), 0 * t], axis=1)
    up = np.stack([0 * t, 0 * t, one], axis=1)
    if bend:
        r = speed / bend
        place = np.stack([r * np.sin(yaw), r - r * np.cos(yaw), 0.95 * one], axis=1)
    else:
        place = np.stack([speed * t, 0 * t, 0.95 * one], axis=1)
    names, tracks, truth = [], [], {}
    for side, sign in (("right", 1.0), ("left", -1.0)):
        phase = 2 * np.pi * t + (0 if sign > 0 else np.pi)
        swing, flex = 0.22 * np.sin(phase)[:, None], 0.3 * (1 + np.cos(phase))[:, None]
        out = sign * right
        hip = along(
            place,
            (ahead, -(0.24 * PD + 9.9e-3)),
            (up, -(0.30 * PW + 10.9e-3)),
            (out, 0.33 * PW + 7.3e-3),
        )
        fore = np.cos(swing) * ahead + np.sin(swing) * up
        down = np.sin(swing) * ahead - np.cos(swing) * up
        angle = twist * np.sin(2 * phase)[:, None]
        axis = np.cos(angle) * out + np.sin(angle) * fore
        front = np.cos(angle) * fore - np.sin(angle) * out
        knee = hip + THIGH * down
        calf = np.sin(swing - flex) * ahead - np.cos(swing - flex) * up
        ankle = knee + SHANK * calf
        heel = along(ankle, (ahead, -0.05), (up, -0.06))
        toe = along(ankle, (ahead, 0.15), (up, -0.07))
        where = {
            "asis": along(place, (out, PW / 2)),
            "psis": along(place, (out, 0.05), (ahead, -PD)),
            "knee": along(knee, (axis, KNEE)), "knee_in": along(knee, (axis, -KNEE)),
            "ankle": along(ankle, (out, ANKLE)), "ankle_in": along(ankle, (out, -ANKLE)),
            "heel": heel, "toe": toe, "toe_out": along(toe, (out, 0.05), (ahead, -0.03)),
            "t1": along(hip, (down, 0.18), (axis, 0.09), (front, 0.01)),
            "t2": along(hip, (down, 0.26), (axis, 0.07), (front, 0.05)),
            "t3": along(hip, (down, 0.27), (axis, 0.08), (front, -0.04)),
            "hip_c": hip, "knee_c": knee, "ankle_c": ankle,
        }  # fmt: skip
        truth[side] = {"hip": hip, "knee": knee, "ankle": ankle}
        for place_name, label in labels.items():
            names.append(label.replace("{S}", side[0].upper()).replace("{s}", side[0]))
            tracks.append(where[place_name])
    return names, np.stack(tracks, axis=1), truth


def y_up(tracks):
    """The same with y up and x kept: (x, y, z) -> (x, z, -y)."""
    return np.stack([tracks[..., 0], tracks[..., 2], -tracks[..., 1]], axis=-1)


def write_trc(path, names, tracks, rate=100.0, unit="mm", doubled=False, said=None):
    """A TRC file; times rounded to 1 ms as cameras' programs do; `doubled`: tabs as OpenSim's."""
    tab = "\t\t" if doubled else "\t"
    values = [f"{rate:g}", f"{rate:g}", f"{len(tracks)}", f"{said or len(names)}", f" {unit}"]
    lines = [
        "PathFileType  4\t(X/Y/Z) C:\\walk.trc",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate",
        tab.join(values) + f"\t{rate:g}",
        "Frame#\tTime\t" + "\t\t\t".join(names) + "\t\t",
        "\t\t" + "\t".join(f"{c}{k + 1}" for k in range(len(names)) for c in "XYZ"),
        "\t\t\t" if doubled else "",
    ]
    for k, frame in enumerate(tracks):
        cells = ["" if np.isnan(v) else repr(float(v)) for v in frame.ravel()]
        lines.append("\t".join([str(k + 1), f"{k / rate:.3f}", *cells]))
    path.write_text("\n".join(lines) + "\n")
    return path


def write_csv(path, names, tracks, rate=100.0, unit=None):
    ends = [f"{c} [{unit}]" if unit else c for c in "xyz"]
    lines = ["time," + ",".join(f"{n}_{e}" for n in names for e in ends)]
    for k, frame in enumerate(tracks):
        cells = ["" if np.isnan(v) else repr(float(v)) for v in frame.ravel()]
        lines.append(",".join([repr(k / rate), *cells]))
    path.write_text("\n".join(lines) + "\n")
    return path


def write_c3d(path, names, tracks, rate=100.0, unit="mm", up="+Z", groups=()):
    ezc3d = pytest.importorskip("ezc3d", reason="C3D files are read by ezc3d, not installed here")
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [rate]
    file["parameters"]["POINT"]["LABELS"]["value"] = list(names)
    file["parameters"]["POINT"]["UNITS"]["value"] = [unit]
    file.add_parameter("POINT", "X_SCREEN", ["+X"])
    file.add_parameter("POINT", "Y_SCREEN", [up])
    for name, members in groups:
        file.add_parameter("POINT", name, list(members))
    points = np.ones((4, len(names), len(tracks)))
    points[:3] = np.transpose(tracks, (2, 1, 0))
    file["data"]["points"] = points
    file.write(str(path))
    return path


WRITERS = {"trc": write_trc, "csv": write_csv, "c3d": write_c3d}
SCALE = {"m": 1.0, "cm": 100.0, "mm": 1000.0}

DIRECT = """
[markers]
a = ["R.Heel"]
b = ["R.ASIS"]
c = ["side"]
[segments]
limb = { J1 = "a", J2 = "b", M = "c" }
"""


@pytest.mark.parametrize("kind", ["trc", "csv", "c3d"])
@pytest.mark.parametrize("unit", ["mm", "m"])
@pytest.mark.parametrize("up", ["y", "z"])
def test_pose_of_a_known_rigid_motion(tmp_path, kind, unit, up):
    """Centre and axes of Eq. 17 to 1e-12 (C3D: to its 4-byte numbers), det +1, rate and times."""
    n, rate = 40, 150.0
    t = np.arange(n) / rate
    angle = 2.0 * t + 0.3 * np.sin(9 * t)
    tilt = np.radians(8.0)
    e1 = np.stack([np.sin(tilt) * np.cos(angle), np.sin(tilt) * np.sin(angle), 0 * t], axis=1)
    e1[:, 2] = np.cos(tilt)
    e2 = np.stack([-np.sin(angle), np.cos(angle), 0 * t], axis=1)
    centre = np.stack([1.3 * t, 0.2 * np.sin(5 * t), 0.8 + 0.05 * t], axis=1)
    tracks = np.stack(
        [centre - 0.45 * e1, centre + 0.45 * e1, centre + 0.1 * e1 + 0.07 * e2], axis=1
    )
    moved = (tracks if up == "z" else y_up(tracks)) * SCALE[unit]
    path = tmp_path / f"limb.{kind}"
    extra = {"up": "+" + up.upper()} if kind == "c3d" else {}
    WRITERS[kind](path, ["R.Heel", "R.ASIS", "side"], moved, rate=rate, unit=unit, **extra)
    (tmp_path / "direct.toml").write_text(DIRECT)
    rec = read_motion(path, tmp_path / "direct.toml", cutoff=None)
    found, axes = pose_from_markers(*np.moveaxis(rec.points["limb"], 1, 0))
    exact = np.stack([e1, e2, np.cross(e1, e2)], axis=1)
    close = 1e-12 if kind != "c3d" else 2e-6
    assert np.abs(found - centre).max() < close
    assert np.abs(axes - exact).max() < close * (1 if kind != "c3d" else 10)
    assert np.abs(np.linalg.det(axes) - 1).max() < 1e-12
    assert rec.rate == pytest.approx(rate, rel=1e-9)
    assert np.abs(rec.times - rec.times[0] - t).max() < 1e-9


SETS = {
    "medial": (BMC, "medial"),
    "opencap": (OPENCAP, "medial"),
    "plug-in": (PLUG_IN, "plug-in-gait"),
    "lateral": (LATERAL, "lateral"),
    "rajagopal": (RAJAGOPAL, "lateral"),
    "camargo": (CAMARGO, "lateral"),
}


@pytest.mark.parametrize("key", SETS)
def test_label_sets_give_the_joint_centres(tmp_path, key):
    """Hip, knee and ankle of a walker with the published pelvis, to 1e-9 m, in every label set."""
    labels, name = SETS[key]
    names, tracks, truth = walker(labels)
    path = write_trc(tmp_path / "walk.trc", names, 1000 * y_up(tracks), doubled=True, said=28)
    rec = read_motion(path, cutoff=None)
    assert f"map '{name}'" in rec.notes
    for side in ("right", "left"):
        for joint, centre in truth[side].items():
            assert np.abs(rec.joint_centre(f"{side}_{joint}") - centre).max() < 1e-9, joint
        assert rec.points[f"{side}_foot"].shape == (350, 3, 3)
    for segment, (_, spread) in rec.lengths().items():
        assert spread < 1e-9, segment


def test_a_cluster_carries_the_axis(tmp_path):
    """Thighs that turn by 10 degrees about themselves: a cluster finds the knee, a pelvis not."""
    off = {}
    for key, labels in (("cluster", CAMARGO), ("none", LATERAL)):
        names, tracks, truth = walker(labels, twist=np.radians(10))
        path = write_trc(tmp_path / f"{key}.trc", names, y_up(tracks), unit="m")
        rec = read_motion(path, cutoff=None, rigid=False)
        off[key] = np.linalg.norm(rec.joint_centre("right_knee") - truth["right"]["knee"], axis=1)
    assert off["cluster"].max() < 5e-4
    assert off["none"].max() == pytest.approx(2 * KNEE * np.sin(np.radians(5)), rel=0.05)


def test_direction_fixed_in_a_turning_cluster():
    """The best rotation of a cluster is the one that turned it."""
    rng = np.random.default_rng(2)
    shape, axis = rng.normal(size=(4, 3)), np.array([0.6, 0.0, 0.8])
    angle = np.linspace(0, 2, 30)
    turn = np.zeros((30, 3, 3))
    turn[:, 2, 2] = 1
    turn[:, 0, 0] = turn[:, 1, 1] = np.cos(angle)
    turn[:, 1, 0], turn[:, 0, 1] = np.sin(angle), -np.sin(angle)
    cluster = np.einsum("nab,kb->nka", turn, shape) + rng.normal(size=(30, 1, 3))
    turned = turn @ axis
    assert np.abs(fixed_in(cluster, turned) - turned).max() < 1e-12


@pytest.mark.parametrize("bend", [0.0, 0.4, -0.4])
def test_stride_and_cadence_along_the_path(tmp_path, bend):
    """A stride of 1.2 m in 1 s, straight and on a circle of 3 m: both to 1 %; the turn to 3 %."""
    names, tracks, _ = walker(BMC, bend=bend, seconds=5.3)
    rec = read_motion(write_csv(tmp_path / "walk.csv", names, tracks))
    assert rec.facts["stride_length"] == pytest.approx(1.2, rel=0.01)
    assert rec.facts["cadence"] == pytest.approx(120.0, rel=0.01)
    assert rec.facts["turn"] == pytest.approx(bend * 4.3, rel=0.03, abs=0.01)
    legs = (THIGH + SHANK) / 0.4954  # thigh and shank over stature, de Leva 1996
    assert rec.facts["stature"] == pytest.approx(legs, rel=1e-3)


def test_a_short_walk_repeats(tmp_path):
    """Less than two strikes of one foot: the stride from the repetition of the posture."""
    names, tracks, _ = walker(BMC, seconds=1.4)
    rec = recording(read_markers(write_csv(tmp_path / "walk.csv", names, tracks[10:])))
    assert rec.facts["strides"] == 0
    assert rec.facts["stride_length"] == pytest.approx(1.2, rel=0.02)
    assert rec.facts["cadence"] == pytest.approx(120.0, rel=0.02)


def test_mirrored_labels_are_swapped(tmp_path):
    """Right and left exchanged in all labels: the same recording as without. A left-handed file:
    its mirror image."""
    names, tracks, truth = walker(BMC)
    other = [{"R": "L", "L": "R"}[n[0]] + n[1:] for n in names]
    right = read_motion(write_trc(tmp_path / "a.trc", names, 1000 * tracks), cutoff=None)
    wrong = read_motion(write_trc(tmp_path / "b.trc", other, 1000 * tracks), cutoff=None)
    assert any("mirrored" in note for note in wrong.notes)
    assert not any("mirrored" in note for note in right.notes)
    for segment, track in right.points.items():
        assert np.abs(track - wrong.points[segment]).max() < 1e-12, segment
    assert np.abs(wrong.joint_centre("left_knee") - truth["left"]["knee"]).max() < 1e-9
    mirror = np.array([1.0, -1.0, 1.0])
    image = read_motion(write_trc(tmp_path / "c.trc", names, 1000 * tracks * mirror), cutoff=None)
    assert any("mirrored" in note for note in image.notes)
    assert np.abs(image.joint_centre("left_knee") - mirror * truth["right"]["knee"]).max() < 1e-9


def test_gaps_and_spikes_are_mended_and_told(tmp_path):
    """Gaps of 80 ms come back to 1 mm; a spike of 60 mm goes; ends without a marker are cut."""
    names, tracks, truth = walker(BMC)
    marred = tracks.copy()
    knee, medial, toe = (names.index(n) for n in ("R.Knee", "R.Knee.Medial", "L.MT5"))
    marred[100:108, knee] = np.nan
    marred[200:203, toe] += [0.06, 0.0, 0.04]
    marred[:5, medial] = marred[-7:, medial] = np.nan
    path = write_trc(tmp_path / "walk.trc", names, 1000 * marred)
    rec = read_motion(path, cutoff=None)
    assert len(rec.times) == 350 - 12 and rec.times[0] == pytest.approx(0.05)
    assert np.abs(rec.joint_centre("right_knee") - truth["right"]["knee"][5:-7]).max() < 1e-3
    assert np.abs(rec.points["left_foot"][:, 2] - tracks[5:-7, toe]).max() < 1e-3
    said = "\n".join(rec.notes)
    assert "filled at t = 1.000 s for 80 ms: R.Knee" in said
    assert "'L.MT5' jumps at t = " in said and "R.Knee.Medial" in said
    assert sum("jumps" in note for note in rec.notes) == 1
    with pytest.raises(ValueError, match=r"walk\.trc.*'R\.Knee'.*t = 1\.000 s.*0\.080 s.*max_gap"):
        read_motion(path, max_gap=0.05)
    part = read_motion(path, max_gap=0.05, window=(1.2, 3.0))
    assert part.times[0] == pytest.approx(1.2)


def test_low_pass_halves_the_power_at_its_cutoff():
    """No shift, 1/sqrt(2) at 6 Hz, untouched at 0.5 Hz, gone at 40 Hz."""
    t = np.arange(2000) / 200.0
    for frequency, gain in ((0.5, 1.0), (6.0, np.sqrt(0.5)), (40.0, 0.0)):
        wave = np.sin(2 * np.pi * frequency * t)
        out = low_pass(wave[:, None], 200.0, 6.0)[400:-400, 0]
        assert np.abs(out - gain * wave[400:-400]).max() < 0.01, frequency


def test_c3d_leaves_out_what_is_no_place(tmp_path):
    """Angles, prefixes, residuals below 0, and a vertical told by the file alone."""
    names, tracks, truth = walker(PLUG_IN)
    tracks[50:54, names.index("RKNE")] = np.nan
    more = np.concatenate([tracks, 0.09 + 0 * tracks[:, :2]], axis=1)
    labels = [f"Ann:{n}" for n in [*names, "RKneeAngles", "odd"]]
    path = write_c3d(
        tmp_path / "a.c3d", labels, 1000 * more, groups=[("ANGLES", ["Ann:RKneeAngles", "Ann:odd"])]
    )
    markers = read_markers(path)
    assert markers.names == tuple(names)
    assert np.isnan(markers.track("RKNE")).all(axis=1).sum() == 4
    rec = recording(markers, cutoff=None)
    assert np.abs(rec.joint_centre("left_hip") - truth["left"]["hip"]).max() < 1e-6
    unknown = write_c3d(tmp_path / "b.c3d", ["p", "q"], 1000 * y_up(tracks[:, [0, 4]]), up="+Y")
    assert any("up is y, from the file" in note for note in read_markers(unknown).notes)


def test_c3d_without_ezc3d(tmp_path, monkeypatch):
    """A sentence, and only when a C3D file is read."""
    (tmp_path / "a.c3d").write_bytes(bytes(1024))
    monkeypatch.setitem(sys.modules, "ezc3d", None)
    names, tracks, _ = walker(BMC, seconds=0.5)
    assert len(read_markers(write_csv(tmp_path / "a.csv", names, tracks)).names) == 18
    with pytest.raises(ImportError, match=r"a\.c3d.*ezc3d.*pip install"):
        read_markers(tmp_path / "a.c3d")


def test_c3d_cut_off(tmp_path):
    """A file shorter than its header tells, one without a header, one that is none."""
    names, tracks, _ = walker(PLUG_IN, seconds=0.5)
    path = write_c3d(tmp_path / "a.c3d", names, 1000 * tracks)
    assert len(read_markers(path).times) == 50
    whole = path.read_bytes()
    for part in (whole[: len(whole) // 2], whole[:-600], whole[:300], b"no" * 1000):
        path.write_bytes(part)
        with pytest.raises(ValueError, match=r"a\.c3d: .*cut off"):
            read_markers(path)


def test_bad_files_are_refused_in_a_sentence(tmp_path):
    names, tracks, _ = walker(BMC, seconds=0.5)
    path = tmp_path / "walk.trc"

    def refused(match, **changes):
        with pytest.raises(ValueError, match=match) as error:
            read_motion(path, **changes)
        assert str(path) in str(error.value) and "\n" not in str(error.value)

    write_trc(path, names, 1000 * tracks, unit="m")
    refused(r"unit 'm' in the header.*span 9\d\d.*unit='mm'")
    assert np.ptp(read_markers(path, unit="mm").positions[0], axis=0).max() < 2.5
    write_trc(path, names, 1000 * tracks)
    refused("unknown unit 'furlong'", unit="furlong")
    refused("window", window=(7, 8))
    refused("cutoff must lie between", cutoff=90.0)
    text = path.read_text()
    path.write_text(text[: int(0.7 * len(text))])
    refused("cut off in frame 3. of 50")
    lines = text.splitlines()
    path.write_text("\n".join([*lines[:20], lines[20].rsplit("\t", 1)[0], *lines[21:]]) + "\n")
    refused("cut off in frame 15 of 50")
    path.write_text(text.replace("Frame#", "Bild"))
    refused("'Frame#'")
    path.write_text(text.replace("\t0.010\t", "\t0.010\tx"))
    refused(r"line 8, column 3 holds 'x")
    path.write_text(text.replace("100\t100", "300\t300"))
    refused("rate is 300 Hz.*100 Hz")
    path.write_text(text.replace("R.ASIS", "L.ASIS"))
    refused("two markers are called 'L.ASIS'")
    blank = 1000 * tracks
    blank[:, names.index("R.Ankle")] = np.nan
    write_trc(path, names, blank)
    refused(r"'R\.Ankle' holds no numbers", map="medial")
    write_trc(path, [n.replace("R.Knee", "R.Kneee") for n in names], 1000 * tracks)
    refused(r"right_knee_lateral.*closest label: 'R\.Kneee'", map="medial")
    refused("no shipped map fits.*medial.*plug-in-gait.*lateral")
    swapped = [{"R.Knee": "R.Knee.Medial", "R.Knee.Medial": "R.Knee"}.get(n, n) for n in names]
    write_trc(path, swapped, 1000 * tracks)
    refused("right_thigh lies inward.*lateral and medial")
    flipped = [n.translate(str.maketrans("RL", "LR")) if "Knee" in n else n for n in names]
    write_trc(path, flipped, 1000 * tracks)
    refused("pelvis and legs disagree about right and left")
    lying = 1000 * tracks[..., [2, 1, 0]]
    write_trc(path, names, lying)
    refused("x points up")
    slanted = 1000 * np.stack(
        [tracks[..., 0], tracks[..., 1] - tracks[..., 2], tracks[..., 1] + tracks[..., 2]], axis=-1
    )
    write_trc(path, names, slanted)
    refused("vertical is not clear.*up='y'")


def test_a_marker_on_the_axis_is_refused(tmp_path):
    """M 5 mm off J1-J2 does not tell how the segment turns."""
    t = np.arange(30) / 100
    line = np.stack([t, 0 * t, 0 * t], axis=1)
    tracks = np.stack([line, line + [0, 0, 0.9], line + [0, 0.005, 0.4]], axis=1)
    (tmp_path / "map.toml").write_text(DIRECT)
    path = write_csv(tmp_path / "a.csv", ["R.Heel", "R.ASIS", "side"], tracks)
    with pytest.raises(ValueError, match=r"a\.csv: M of 'limb' is 5\.0 mm off"):
        read_motion(path, tmp_path / "map.toml", up="z")


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ("[segments]", "[segment]", "unknown key 'segment'"),
        ('J2 = "b"', 'J2 = "bb"', "J2 of segment 'limb' is 'bb'.*closest point: 'b'"),
        ('M = "c"', 'N = "c"', "unknown key 'N'"),
        (', M = "c"', "", "M of segment 'limb' is missing"),
        ("[segments]", '[points]\nd = { midpoint = ["a", "q"] }\n[segments]', "uses 'q'"),
        ("[segments]", '[points]\nd = { middle = ["a", "b"] }\n[segments]', "no known rule"),
        ("[segments]", '[points]\nd = { offset = "a", by = 1 }\n[segments]', "lacks 'along'"),
        ("[segments]", '[points]\nd = { same = "d" }\n[segments]', "made of itself"),
        ("a = [", "a = 3 #", "list of labels"),
        ("a = [", "a = [[", "no TOML|list of labels"),
    ],
)
def test_maps_are_checked(tmp_path, old, new, match):
    path = tmp_path / "map.toml"
    path.write_text(DIRECT.replace(old, new))
    with pytest.raises(ValueError, match=match) as error:
        segment_map(path)
    assert str(path) in str(error.value)
    with pytest.raises(ValueError, match="no map 'media'; there are medial"):
        segment_map("media")


def test_bmc_walk(paper_data):
    """Real walk, y up, mm: 2.03 m in 250 frames at 150 Hz; bones; lateral markers alone; a belt."""
    path = paper_data / "bmc_walk2.trc"
    markers = read_markers(path)
    rec = recording(markers)
    assert len(markers.names) == 28 and rec.rate == pytest.approx(150.0)
    assert len(rec.times) == 251
    speed = 2.03 / (250 / 150)  # way of the pelvis over the time, the capture's description
    assert rec.facts["speed"] == pytest.approx(speed, rel=0.03)
    feet = {s: [t for n, t in rec.facts["events"] if n.startswith(s)] for s in ("left", "right")}
    step = feet["right"][0] - feet["left"][0]
    assert rec.facts["cadence"] == pytest.approx(60 / step, rel=0.03)
    bones(recording(markers, cutoff=None, rigid=False), rec)
    assert any("L.MT2" in note for note in rec.notes)
    assert choose_map(markers).name == "medial"
    other = {"R": "L", "L": "R"}  # labels of the wrong side, as another walk of this set has them
    names = tuple(other[n[0]] + n[1:] for n in markers.names)
    wrong = type(markers)(names, markers.times, markers.positions, markers.rate, "mirrored")
    for segment, track in recording(wrong).points.items():
        assert np.abs(track - rec.points[segment]).max() < 1e-12
    lateral = recording(markers, "lateral", rigid=False)
    both = recording(markers, "medial", rigid=False)
    for joint in ("right_knee", "left_knee", "right_ankle", "left_ankle"):
        off = np.linalg.norm(lateral.joint_centre(joint) - both.joint_centre(joint), axis=1)
        assert np.median(off) < 0.02, joint
    still = markers.positions - (markers.times * 1.2)[:, None, None] * [1.0, 0.0, 0.0]
    walking = type(markers)(markers.names, markers.times, still, markers.rate, "belt")
    belt = recording(walking).facts
    assert belt["belt_speed"] == pytest.approx(1.2, rel=0.05)
    assert belt["stride_length"] == pytest.approx(rec.facts["stride_length"], rel=0.03)


def test_biomechzoo_walk(paper_data):
    """Real walk, z up, along y: cadence and strides against the foot strikes the file marks."""
    ezc3d = pytest.importorskip("ezc3d", reason="C3D files are read by ezc3d, not installed here")
    path = paper_data / "biomechzoo_HC038A11.c3d"
    rec = read_motion(path)
    assert rec.rate == pytest.approx(100.0) and len(rec.times) == 246
    assert rec.facts["heading"] == pytest.approx(np.pi / 2, abs=0.1)
    event = ezc3d.c3d(str(path))["parameters"]["EVENT"]
    labels, sides = event["LABELS"]["value"], event["CONTEXTS"]["value"]
    seconds, lengths, durations = event["TIMES"]["value"][1], [], []
    for side in ("right", "left"):
        marked = sorted(
            t for t, w, s in zip(seconds, labels, sides)
            if w == "Foot Strike" and s.lower() == side
        )  # fmt: skip
        heel = rec.points[f"{side}_foot"][
            np.rint((np.array(marked) - rec.times[0]) * 100).astype(int), 0
        ]
        durations += np.diff(marked).tolist()
        lengths += np.linalg.norm(np.diff(heel[:, :2], axis=0), axis=1).tolist()
        found = [t for n, t in rec.facts["events"] if n.startswith(side)]
        for t in marked:
            assert min(abs(t - f) for f in found) < 0.05
    assert rec.facts["cadence"] == pytest.approx(120 / np.median(durations), rel=0.03)
    assert rec.facts["stride_length"] == pytest.approx(np.median(lengths), rel=0.03)
    assert rec.facts["stature"] == pytest.approx(1.74, rel=0.05)  # PROCESSING:Height
    raw = read_motion(path, cutoff=None, rigid=False)
    bones(raw, rec)
    # PROCESSING:RFemurLength, RTibiaLength
    assert raw.lengths()["right_thigh"][0] == pytest.approx(0.4125, rel=0.02)
    assert raw.lengths()["right_shank"][0] == pytest.approx(0.4198, rel=0.02)
    lateral = read_motion(path, "lateral", rigid=False)
    for joint in ("right_hip", "right_knee", "left_knee", "right_ankle", "left_ankle"):
        off = np.linalg.norm(lateral.joint_centre(joint) - raw.joint_centre(joint), axis=1)
        assert np.median(off) < 0.03, joint


def bones(raw, rec):
    """Thigh and shank: 2 % (standard deviation) as measured, constant in the recording; det +1."""
    for segment, track in raw.points.items():
        _, axes = pose_from_markers(*np.moveaxis(rec.points[segment], 1, 0))
        assert np.abs(np.linalg.det(axes) - 1).max() < 1e-12
        if segment.endswith(("thigh", "shank")):
            length = np.linalg.norm(track[:, 1] - track[:, 0], axis=1)
            assert length.std() < 0.02 * np.median(length), segment
            assert rec.lengths()[segment][1] < 1e-9, segment
