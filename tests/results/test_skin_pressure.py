# SPDX-License-Identifier: LGPL-3.0-or-later
"""The pressure map: areas in closed form, a slow twin, N/R, a weight, turned scenes, ranks."""

import subprocess
import sys
import tracemalloc

from mpi4py import MPI

import numpy as np
import pytest
from numba.core.runtime import rtsys

import meshes
from contact.body.segments import Body, Fixed, Segment
from contact.geometry.ellipsoid import closest_points
from shellform import Fabric, Shell
from shellform.contact_coupling.contact import Contact
from shellform.dynamics import checkpoint
from shellform.dynamics.explicit import Newmark
from shellform.fem.director import rotation_matrix
from shellform.fem.lumped_mass import nodal_areas
from shellform.pictures.skin_pressure import pressure_figure
from shellform.results.pressure_map import load, save, summary
from shellform.results.skin_pressure import Pressure
from tests.contact.geometry.test_surface_patches import outward
from tests.contact_coupling.test_explicit_contact import G, over_sphere
from tests.results.test_joint_torque import curtain

STEPS = 150


def mapped(size=0.03, **scene):
    """The curtain of test_torque with a map; nothing has moved yet."""
    stepper, touch, _ = curtain(**scene)
    return stepper, touch, stepper.add(Pressure(size))


def test_twin_in_plain_numpy():
    """Node by node, with the patches found by comparing edges; two windows."""
    stepper, touch, pressure = mapped()
    patches, wearer = pressure.patches, touch.correction.body
    comm, areal = stepper.shell.comm, stepper.shell.fabric.areal_mass
    P = len(patches.areas)
    sums = np.zeros((P, 3))

    def edges(b, table, low, high, count):
        return np.interp(np.arange(count + 1) / count, table[b], np.linspace(low, high, 129))

    def between(value, edges):
        k = np.searchsorted(edges, value, side="right") - 1
        return min(max(k, 0), len(edges) - 2)

    def twin(stepper, dt):
        x = stepper.points + stepper.owned[:, :3]
        pose, correction = wearer.new_pose(stepper.time), touch.correction
        for i in np.flatnonzero(correction.segment >= 0):
            b, J = correction.segment[i], correction.last.impulse[i]
            foot, n, _ = closest_points(x[i], wearer.radii[b], pose.centres[b], pose.axes[b])
            u = pose.axes[b] @ (foot[0] - pose.centres[b]) / wearer.radii[b]
            rows, columns = patches.rows[b], patches.columns[b]
            row = rows * np.interp(u[0], np.linspace(-1, 1, 129), patches.heights[b]) - 0.5
            around = np.linspace(-np.pi, np.pi, 129)
            angle = np.arctan2(u[2], u[1])
            column = columns * np.interp(angle, around, patches.sectors[b]) - 0.5
            # the weight of a patch falls linearly to zero over one patch, clamped at the poles
            R = np.arange(rows)
            up = np.maximum(0, 1 - np.abs(np.clip(row, 0, rows - 1) - R))
            gap = np.abs((column - np.arange(columns) + 0.5 * columns) % columns - 0.5 * columns)
            weight = np.outer(up, np.maximum(0, 1 - gap)).ravel()
            assert weight.sum() == pytest.approx(1)
            # the heaviest of the four is the patch whose edges hold the point
            k = between(u[0], edges(b, patches.heights, -1, 1, rows))
            j = between(angle, edges(b, patches.sectors, -np.pi, np.pi, columns))
            assert weight[k * columns + j] > weight.max() - 1e-6
            own = slice(patches.first[b], patches.first[b + 1])
            normal = J @ n[0]
            rest = np.linalg.norm(J - normal * n[0])
            area = stepper.mass[i] / areal
            sums[own] += np.outer(weight, [normal, rest, area * dt])

    stepper.add(twin)
    peaks, whole = [], np.zeros((P, 3))
    for end in (70, STEPS):
        before = stepper.time
        stepper.advance(end * stepper.dt)
        span = stepper.time - before
        mine = comm.allreduce(sums)
        sums[:] = 0.0
        peaks.append(mine[:, 0] / (patches.areas * span))
        mine[:, 2] = np.minimum(mine[:, 2], patches.areas * span)
        whole += mine
        window = pressure.record(stepper.time)
        assert np.abs(window - peaks[-1]).max() < 1e-9 * np.abs(peaks[-1]).max()
    result = pressure.result()
    assert result.seconds == pytest.approx(stepper.time, rel=1e-12)
    for got, column in ((result.mean, 0), (result.rubbing, 1), (result.share, 2)):
        exact = whole[:, column] / (patches.areas * stepper.time)
        assert np.abs(got - exact).max() < 1e-9 * exact.max() and exact.max() > 0
    highest = np.maximum(0, np.max(peaks, axis=0))
    assert np.abs(result.peak - highest).max() < 1e-9 * highest.max()
    touched = highest > 1e-6 * highest.max()
    assert set(np.unique(result.peak_time[touched])) <= {70 * stepper.dt, stepper.time}
    assert result.share.max() <= 1 + 1e-12 and result.share.min() >= 0
    told = summary(result)
    force = sum(row["normal_force"] for row in told.values())
    assert force == pytest.approx(whole[:, 0].sum() / stepper.time, rel=1e-9)
    assert max(row["peak_pressure"] for row in told.values()) == pytest.approx(highest.max())
    assert told["thigh"]["peak_place"] in result.centres.tolist()


def test_normal_force_is_what_contact_booked():
    """Without friction, on one convex body: all of every impulse, and nothing rubs."""
    stepper, touch = over_sphere(friction=0.0, height=1e-3)
    pressure = stepper.add(Pressure(0.05))
    booked = np.zeros(1)
    stepper.add(
        lambda *_: booked.__iadd__(np.linalg.norm(touch.correction.last.impulse, axis=1).sum())
    )
    stepper.advance(0.05)
    pressure.record(stepper.time)
    force = stepper.shell.comm.allreduce(booked)[0] / stepper.time
    result = pressure.result()
    assert summary(result)["limb"]["normal_force"] == pytest.approx(force, rel=1e-6)
    assert force > 0
    assert result.rubbing.max() < 1e-3 * result.mean.max()


def test_windows_of_standing_do_not_count():
    """The map of what comes after a window that does not count is that of this alone."""
    stepper, _ = over_sphere(friction=0.0, height=1e-3)
    pressure = stepper.add(Pressure(0.05))
    stepper.advance(0.03)
    assert pressure.record(stepper.time, counts=False).max() > 0
    assert pressure.result().seconds == 0 and not pressure.result().peak.any()
    begin = stepper.time
    stepper.advance(0.05)
    window = pressure.record(stepper.time)
    result = pressure.result()
    assert result.seconds == pytest.approx(stepper.time - begin, rel=1e-9)
    np.testing.assert_allclose(result.mean, window, rtol=1e-12)
    np.testing.assert_array_equal(result.peak, np.maximum(window, 0))


def test_map_of_a_sheet_at_rest_carries_its_weight():
    """Pressure times normals over the patches: the weight of a frictionless cap, 2 %."""
    R, rest = 0.25, 0.25 + 5e-4
    surface = meshes.spherical_cap(rest, (0.3, 0.9), cells=(24, 6)).replace(warp=(0.0, 0.0, 1.0))
    shell = Shell(surface, Fabric.isotropic(1e5, 0.3, 1e-3, 200.0))
    shell.loads.gravity((0.0, 0.0, -G))
    stepper = Newmark(shell, 0.8, drag=8.0, damping=1e-3)
    axes = np.array([[0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [-0.8, 0.0, 0.6]])
    stepper.add(Contact(Body([Segment("head", [R] * 3, Fixed((0, 0, 0), axes))]), friction=0.0))
    pressure = stepper.add(Pressure(0.02))
    stepper.advance(0.4)
    pressure.restore((np.zeros_like(pressure.total), 0.0))
    stepper.advance(0.6)
    pressure.record(stepper.time)
    result = pressure.result()
    n = outward(pressure.patches) @ axes
    push = (result.mean * result.areas) @ n
    weight = shell.fabric.areal_mass * nodal_areas(surface).sum() * G
    assert push[2] == pytest.approx(weight, rel=2e-2)
    assert np.abs(push[:2]).max() < 2e-2 * weight


def sleeve(cells, size):
    """Pressure over the exact N/R in patches under the middle of a stretched sleeve."""
    rest, radius, long = 0.048, 0.05, 0.1
    surface = meshes.cylinder(rest, long, cells).transform(translation=(0, 0, -0.5 * long))
    surface = surface.replace(warp=(0.0, 0.0, 1.0))
    fabric = Fabric.from_stiffness(
        1e3 * np.diag([1, 1, 0.5]), 1e-7 * np.diag([1, 1, 0.5]), areal_mass=0.2, thickness=1e-3
    )
    shell = Shell(surface, fabric)
    X = surface.points[shell.partition.nodes]
    shell.w.x.array.reshape(-1, 6)[:, :2] = (radius / rest - 1) * X[:, :2]
    stepper = Newmark(shell, 0.9, damping=2e-4, drag=60.0)
    # e1 along the sleeve; the body is 0.1 % thinner at its ends than in the middle
    skin = radius - 5e-4
    axes = np.eye(3)[[2, 0, 1]]
    body = Body([Segment("arm", (1.0, skin, skin), Fixed((0, 0, 0), axes))])
    stepper.add(Contact(body, friction=0.0))
    pressure = stepper.add(Pressure(size))
    stepper.advance(0.02)
    pressure.restore((np.zeros_like(pressure.total), 0.0))
    stepper.advance(0.04)
    pressure.record(stepper.time)
    result = pressure.result()
    # second Piola-Kirchhoff force per rest length, pushed forward: N = E t e (R/r), e Green's
    hoop = 1e3 * 0.5 * ((radius / rest) ** 2 - 1) * radius / rest
    edge = 0.5 * long - 2.0 * size
    under = np.abs(result.centres[:, 0]) < edge
    assert under.sum() > 0 and not result.mean[np.abs(result.centres[:, 0]) > long].any()
    return result, hoop / skin, under


def test_sleeve_presses_with_tension_over_radius():
    """N/R: mean within 1 %, every patch, of two by two nodes, within 8 %; covered all the time."""
    result, exact, under = sleeve((40, 16), 0.015)
    areas = result.areas[under]
    assert areas @ result.mean[under] / areas.sum() == pytest.approx(exact, rel=1e-2)
    assert np.abs(result.mean[under] / exact - 1).max() < 0.08
    # the area of cloth at rest is smaller than on the arm by the stretch, 4 %
    assert result.share[under] == pytest.approx(1.0, abs=0.1)
    assert result.mean[under] == pytest.approx(result.peak[under], rel=1e-9)


@pytest.fixture(scope="module")
def plain():
    """Map of the curtain."""
    stepper, _, pressure = mapped()
    stepper.advance(STEPS * stepper.dt)
    pressure.record(stepper.time)
    return pressure.result()


def assert_equal_maps(one, other, rel=1e-9):
    for name in ("mean", "peak", "rubbing", "share"):
        a, b = getattr(one, name), getattr(other, name)
        assert np.abs(a - b).max() < rel * np.abs(b).max()
    assert one.seconds == pytest.approx(other.seconds, rel=1e-12)


def test_map_turns_with_the_body(plain):
    """It rides on the segments: a turned scene has the same map."""
    stepper, _, pressure = mapped(turn=rotation_matrix([0.7, -1.1, 0.4]))
    stepper.advance(STEPS * stepper.dt)
    pressure.record(stepper.time)
    assert_equal_maps(pressure.result(), plain, rel=1e-7)
    assert plain.mean.max() > 10


@pytest.mark.skipif(MPI.COMM_WORLD.size == 1, reason="compares many ranks with one")
def test_map_on_many_ranks(plain):
    """As on one rank; also after going back to a state taken half-way."""
    stepper, _, pressure = mapped(comm=MPI.COMM_SELF)
    stepper.advance(75 * stepper.dt)
    state = pressure.state()
    pressure.total[:] = 7.0
    pressure.restore(state)
    stepper.advance(STEPS * stepper.dt)
    pressure.record(stepper.time)
    assert_equal_maps(pressure.result(), plain)


def test_goes_on_from_a_checkpoint(shared_tmp_path):
    """A window left open when the run stops is the same as one that was not."""
    path = shared_tmp_path / "checkpoint.npz"
    stepper, _, pressure = mapped()
    stepper.advance(60 * stepper.dt)
    pressure.record(stepper.time)
    stepper.advance(100 * stepper.dt)
    checkpoint.save(path, stepper)
    again, _, _ = curtain()
    state = checkpoint.load(path, again)
    resumed = again.add(Pressure(0.03, state))
    for one, hook in ((stepper, pressure), (again, resumed)):
        one.advance(STEPS * one.dt)
        hook.record(one.time)
    assert_equal_maps(resumed.result(), pressure.result())
    with pytest.raises(ValueError, match=r"patches of 0.03 m, not \d+ of 0.05 m"):
        again.add(Pressure(0.05, state))
    with pytest.raises(ValueError, match="no pressure map"):
        again.add(Pressure(0.03, {}))


def test_steps_allocate_nothing():
    """No array is made in a step, and no hook is there that was not asked for."""
    stepper, _, pressure = mapped()
    stepper.advance(75 * stepper.dt)
    pressure(stepper, stepper.dt)
    tracemalloc.start()
    before = rtsys.get_allocation_stats().alloc
    for _ in range(20):
        pressure(stepper, stepper.dt)
    made = rtsys.get_allocation_stats().alloc - before
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    # numba wraps each of its 16 arguments that are arrays
    assert made == 20 * 16
    assert peak < min(stepper.v.nbytes, 4000)
    assert not any(isinstance(part, Pressure) for part in curtain()[0].parts)


@pytest.mark.serial
def test_not_loaded_unless_asked_for():
    code = (
        "import sys, shellform.simulation.run, shellform.pictures.walk; print(sorted(sys.modules))"
    )
    names = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "'shellform.contact_coupling.contact'" in names.stdout
    assert (
        "shellform.results.skin_pressure" not in names.stdout
        and "contact.geometry.surface_patches" not in names.stdout
    )


def test_bad_input():
    stepper, touch = over_sphere()
    for size in (0.0, np.nan, -1.0, 1e-5):
        with pytest.raises(ValueError, match=r"size of at least 0\.001 m"):
            stepper.add(Pressure(size))
    sampled = Newmark(Shell(meshes.rectangle(0.5, 0.5, (4, 4)), stepper.shell.fabric))
    with pytest.raises(ValueError, match="needs a contact"):
        sampled.add(Pressure())
    sampled.add(Contact(touch.body, samples=1))
    with pytest.raises(ValueError, match="leave out the samples"):
        sampled.add(Pressure())


def test_file_and_picture(plain, shared_tmp_path, comm):
    """What is read is what was written; a picture of it is drawn, on its own body only."""
    if comm.rank:
        return
    path = shared_tmp_path / "pressure.npz"
    save(path, plain)
    back = load(path)
    assert back.names == plain.names and back.size == plain.size
    for name in ("radii", "owner", "centres", "areas", "mean", "peak", "peak_time", "share"):
        np.testing.assert_array_equal(getattr(back, name), getattr(plain, name))
    assert list(shared_tmp_path.iterdir()) == [path]
    body = Body([Segment(n, r, Fixed()) for n, r in zip(back.names, back.radii, strict=True)])
    picture = shared_tmp_path / "pressure.png"
    pressure_figure(picture, body, back, 0.0, "curtain")
    assert picture.read_bytes()[:4] == b"\x89PNG"
    other = Body([Segment(name, (0.1, 0.1, 0.1), Fixed()) for name in back.names])
    with pytest.raises(ValueError, match="draw it on the wearer of its run"):
        pressure_figure(picture, other, back, 0.0)
