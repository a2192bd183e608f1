# SPDX-License-Identifier: LGPL-3.0-or-later
"""Explicit Newmark steps against conservation laws, exact frequencies and orders of convergence."""

from fractions import Fraction
from itertools import pairwise

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
import pytest

import meshes
from shellform import Fabric, Shell
from shellform.dynamics.explicit import Newmark
from shellform.dynamics.explicit_kernels import book, drift
from shellform.errors import Unstable
from shellform.fem.dolfinx_compat import petsc_vector
from shellform.fem.internal_force import InternalForce, by_segments
from shellform.fem.lumped_mass import lumped, nodal_areas

CLOTH = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "thickness": 1e-3, "density": 200.0}


def sheet(cells=8, degree=1, triangles=False, size=1.0, amount=0.1):
    surface = meshes.rectangle(
        size, size, (cells, cells), degree=degree, triangles=triangles,
        parameters=meshes.distorted((cells, cells), amount, seed=3), warp=(1.0, 0.0, 0.0),
    )  # fmt: skip
    return Shell(surface, Fabric.isotropic(**CLOTH))


def tumble(newmark):
    """Start a spin, a flight and a smooth deformation, the same on any number of ranks."""
    X = newmark.points - [0.5, 0.5, 0.0]
    spin = np.array([1.0, 2.0, 3.0])
    newmark.v[:] = np.cross(spin, X) + [0.3, 0.2, 0.1] + 0.05 * np.sin(7 * X[:, [1, 2, 0]])
    newmark.q[:] = np.cross(spin, newmark.w[: newmark.n_owned, 3:])


def totals(newmark):
    """Momentum (3,), angular momentum (3,), kinetic and strain energy at the present time."""
    return *newmark.momenta(), sum(newmark.shell.energy().values())


FABRICS = {
    "isotropic": Fabric.isotropic(**CLOTH),
    "woven": Fabric.orthotropic(2e7, 5e6, 0.1, 2e5, 2e5, 2e5, 5e-4, 400.0),
    "thick": Fabric.isotropic(1e7, 0.2, 0.02, 1000.0),
}

ELEMENTS = {"quad": (1, False), "triangle": (1, True), "nine nodes": (2, False)}


@pytest.mark.parametrize("element", ELEMENTS)
def test_nodal_areas_share_out_the_area(element):
    degree, triangles = ELEMENTS[element]
    surface = sheet(5, degree, triangles).surface
    areas = nodal_areas(surface)
    assert areas.min() > 0
    assert areas.sum() == pytest.approx(1.0, rel=1e-13)


def test_rotary_inertia_is_never_below_the_physical():
    shell = sheet(4)
    mass, inertia = lumped(shell.surface, shell.fabric, rotary_scale=0.0)
    assert inertia == pytest.approx(mass * shell.fabric.thickness**2 / 12, rel=1e-13)
    _, scaled = lumped(shell.surface, shell.fabric)
    assert np.all(scaled >= inertia)


def curved(degree, triangles, fabric):
    """A distorted piece of a cylinder, its warp turning from cell to cell."""
    surface = meshes.cylinder(
        0.5, 1.0, (5, 4), angle=1.5, degree=degree, triangles=triangles,
        parameters=meshes.distorted((5, 4), 0.25, seed=5),
    )  # fmt: skip
    middle = surface.points[surface.cells].mean(axis=1)
    around = np.cross([0, 0, 1.0], middle)
    return Shell(surface.replace(warp=around + [0, 0, 0.3]), fabric)


@pytest.mark.parametrize("fabric", ["woven", "isotropic"])
@pytest.mark.parametrize("element", ELEMENTS)
def test_internal_force_equals_that_of_the_static_forms(element, fabric):
    """The force of explicit steps, by segments or packed kernels, is that of the weak form."""
    shell = curved(*ELEMENTS[element], FABRICS[fabric])
    newmark_force = InternalForce(shell)
    assert by_segments(shell) == (element == "quad")
    X = shell.surface.points[shell.partition.nodes]
    w = shell.w.x.array.reshape(-1, 6)
    w[:, :3] += 0.1 * np.sin(3 * X[:, [1, 2, 0]])
    w[:, 3:] += 0.1 * np.cos(4 * X)
    r = newmark_force(w)[: shell.partition.n_owned].copy()
    vector = petsc_vector(shell.space, 6)
    shell.internal_force(vector)
    vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
    largest = shell.comm.allreduce(np.abs(r).max(), MPI.MAX)
    assert np.abs(r.ravel() - vector.array_r).max() < 1e-12 * largest


def test_directors_on_a_symmetry_plane_start_in_it():
    """Averaged normals lean out of a plane of symmetry: the supports' correction is taken over."""
    surface = meshes.cylinder(0.5, 1.0, (6, 2), angle=np.pi / 2)
    leaning = surface.directors + [0.0, 0.05, 0.0]
    leaning /= np.linalg.norm(leaning, axis=1, keepdims=True)
    shell = Shell(surface.replace(directors=leaning), FABRICS["isotropic"])
    shell.supports.symmetry("start", (0.0, 1.0, 0.0))
    Newmark(shell)
    edge = shell.partition.find("start")
    assert np.abs(shell.directors()[edge, 1]).max() < 1e-15
    assert sum(shell.energy().values()) == 0.0


@pytest.mark.parametrize("element", ELEMENTS)
def test_free_flight_conserves_momentum_and_energy(element):
    """1000 steps at half the stable step, no damping."""
    newmark = Newmark(sheet(8, *ELEMENTS[element]), time_step_factor=0.5)
    tumble(newmark)
    p0, j0, k0, e0 = totals(newmark)
    energies = []
    for _ in range(20):
        newmark.advance(newmark.time + 50 * newmark.dt)
        p, j, k, e = totals(newmark)
        assert np.abs(p - p0).max() < 1e-12 * np.abs(p0).max()
        assert np.abs(j - j0).max() < 1e-12 * np.abs(j0).max()
        energies.append((k + e) / (k0 + e0) - 1)
    assert newmark.steps >= 1000
    assert e > 1e-6 * k  # it does deform
    # bounded, and the mean of the second half is that of the first: no drift
    assert np.abs(energies).max() < 1e-4
    assert abs(np.mean(energies[10:]) - np.mean(energies[:10])) < 1e-4


def test_momentum_balance_under_gravity():
    """Momentum grows by weight times time to roundoff; drag and damping off."""
    shell = sheet(6)
    shell.loads.gravity((0.0, 0.0, -9.81))
    newmark = Newmark(shell)
    newmark.advance(0.05)
    p, *_ = totals(newmark)
    weight = shell.fabric.areal_mass * 9.81
    assert p == pytest.approx([0, 0, -weight * 0.05], abs=1e-12 * weight)


def test_impulses_are_booked_to_the_last_digits():
    """What is booked over many steps is off by half a digit a step, however many nodes there are.

    Node by node the same rounding repeats: off by 1.8e-11 here, and growing with nodes and steps.
    """
    n, steps, force, dt = 500, 2000, np.full((500, 3), 1.962 / 625), 1.72e-4
    v, held = np.zeros((n, 3)), np.zeros((n, 4), bool)
    r, mass, impulse, booked = np.zeros((n, 6)), np.ones(n), 3.0 * force, np.zeros((3, 3))
    for _ in range(steps):
        book(v, v, v, r, force, held, mass, 0.0, dt, impulse, np.zeros(5), booked)
    for found, one in ((booked[0, 0], force[0, 0] * dt), (booked[1, 0], impulse[0, 0])):
        exact = n * steps * Fraction(one)
        worst = 0.5 * np.finfo(float).eps * (n + steps)
        assert abs(Fraction(found) - exact) <= worst * exact


def test_pressure_and_moment_act_in_full():
    """Without amplitude loads stand at their full value: p A and the moments are the rates."""
    shell = sheet(4)
    shell.loads.pressure(10.0)
    shell.loads.edge_moment("right", (0.0, 3e-3, 0.0))
    newmark = Newmark(shell)
    newmark.advance(0.01)
    p, j, _ = newmark.momenta()
    assert p == pytest.approx([0, 0, 10.0 * 0.01], rel=2e-3, abs=1e-4)
    turned = 10.0 * 0.01 * np.array([0.5, -0.5, 0.0]) + [0.0, 3e-3 * 0.01, 0.0]
    assert j == pytest.approx(turned, abs=2e-5 * 10)


def test_prescribed_motion_is_followed():
    """An edge on a circle, its director turned at a rate: there at every output time."""
    shell = sheet(4)

    def place(t):
        return np.array([0.02 * np.sin(40 * t), 0.0, 0.02 * (1 - np.cos(40 * t))])

    def facing(t):
        return np.array([np.sin(5 * t), 0.0, np.cos(5 * t)])

    shell.supports.clamp("left")
    shell.supports.move("left", place, facing)
    newmark = Newmark(shell)
    edge = shell.partition.find("left")
    for k in range(1, 6):
        newmark.advance(0.01 * k)
        assert np.abs(shell.displacements()[edge] - place(newmark.time)).max() < 1e-12
        assert np.abs(shell.directors()[edge] - facing(newmark.time)).max() < 1e-12
    # what the edge gave is what the sheet has
    p = shell.comm.allreduce(newmark.mass @ newmark.v)
    given = shell.comm.allreduce(newmark.support_total)
    assert p == pytest.approx(given, abs=1e-13)


@pytest.mark.parametrize(
    "wrong", [{"time_step_factor": 1.5}, {"damping": -1e-4}, {"drag": float("nan")}]
)
def test_wrong_settings_are_refused(wrong):
    with pytest.raises(ValueError, match="not "):
        Newmark(sheet(2), **wrong)


def test_an_exploding_step_is_told_with_its_node():
    newmark = Newmark(sheet(4))
    newmark.dt, newmark.recheck = 1.5 * newmark.critical_dt, 10**9
    newmark.rewind.retries = 0
    newmark.v[:, 2] = 1e-6 * (-1.0) ** newmark.shell.partition.owned_nodes
    with pytest.raises(Unstable, match=r"node \d+ of rectangle has left the finite numbers at t ="):
        newmark.advance(5000 * newmark.dt)


def test_a_displacement_without_time_is_refused():
    shell = sheet(2)
    shell.supports.move("left", (0.0, 0.0, 0.1))
    with pytest.raises(ValueError, match="function of time"):
        Newmark(shell)


def test_amplitude_is_a_function_of_time():
    shell = sheet(4)
    shell.loads.gravity((0.0, 0.0, -9.81), amplitude=lambda t: 2.0 * t)
    newmark = Newmark(shell)
    newmark.advance(0.05)
    p, *_ = newmark.momenta()
    assert p[2] == pytest.approx(-shell.fabric.areal_mass * 9.81 * 0.05**2, rel=1e-12)


@pytest.mark.parametrize("amplitude", [None, lambda t: 1.0 + t])
def test_a_pull_is_an_external_force(amplitude):
    """Springs to the ground under gravity: momentum and work of pulls are booked, and end."""
    shell = sheet(4)
    shell.loads.gravity((0.0, 0.0, -9.81), amplitude=amplitude)
    newmark = Newmark(shell, 0.5)
    comm, k = shell.comm, 40.0

    def springs(stepper, force):
        force -= k * stepper.mass[:, None] * stepper.owned[:, :3]

    newmark.pulls.append(springs)
    newmark.v[:, 0] = 0.3
    start = comm.allreduce(newmark.mass @ newmark.v)
    kinetic = newmark.momenta()[2]
    newmark.advance(0.1)
    given = comm.allreduce(newmark.external_total)
    assert comm.allreduce(newmark.mass @ newmark.v) - start == pytest.approx(given, abs=1e-14)
    # a rigid oscillator about the ground
    root, u = np.sqrt(k), newmark.owned
    assert u[:, 0] == pytest.approx(0.3 / root * np.sin(0.1 * root), rel=1e-4)
    stored = comm.allreduce(0.5 * k * np.sum(newmark.mass * (u[:, :3] ** 2).sum(axis=1)))
    if amplitude is None:
        fallen = comm.allreduce(-9.81 * np.sum(newmark.mass * u[:, 2]))
        work = fallen - stored
        assert newmark.momenta()[2] - kinetic == pytest.approx(work, rel=1e-3)
        half = 0.5 * newmark.last_dt * comm.allreduce(np.vdot(newmark.force, newmark.v))
        assert comm.allreduce(newmark.work["external"]) + half == pytest.approx(work, rel=1e-3)
    newmark.pulls.clear()
    before = comm.allreduce(newmark.mass @ newmark.v)
    newmark.advance(0.15)
    weight = shell.fabric.areal_mass * 9.81
    growth = 0.05 if amplitude is None else 0.05 * 1.125
    change = comm.allreduce(newmark.mass @ newmark.v) - before
    assert change[0] == pytest.approx(0.0, abs=1e-14)
    assert change[2] == pytest.approx(-weight * growth, rel=0.02)


def test_free_fall_is_exact_and_undamped_by_stiffness_damping():
    shell = sheet(6)
    shell.loads.gravity((0.0, 0.0, -9.81))
    newmark = Newmark(shell, damping=1e-4)
    newmark.advance(0.1)
    drop = newmark.w[: newmark.n_owned, 2]
    assert drop == pytest.approx(-0.5 * 9.81 * 0.1**2, rel=1e-10)


def test_stiffness_damping_takes_energy_only_from_strain():
    shell = sheet(6)
    newmark = Newmark(shell, damping=2e-4)
    tumble(newmark)
    *_, k0, e0 = totals(newmark)
    p0, *_ = totals(newmark)
    newmark.advance(0.2)
    p, _, k, e = totals(newmark)
    assert k + e < 0.99999 * (k0 + e0)
    assert np.abs(p - p0).max() < 1e-12 * np.abs(p0).max()


@pytest.mark.parametrize("element", ["quads", "chords", "triangles", "9-node"])
def test_damping_resists_strain_rates_alone(element):
    """Symmetric, never giving energy, deaf to rigid motion, whatever stress there is."""
    options = {"triangles": element == "triangles", "degree": 2 if element == "9-node" else 1}
    surface = meshes.rectangle(1.0, 0.7, (3, 2), **options)
    chords = {"membrane": "chords"} if element == "chords" else {}
    shell = Shell(surface, Fabric.isotropic(1e6, 0.3, 1e-2, 1000.0), **chords)
    rng = np.random.default_rng(3)
    field = rng.standard_normal((len(surface.points), 12))
    w = shell.w.x.array.reshape(-1, 6)
    w += np.array([0.02] * 3 + [0.3] * 3) * field[shell.partition.nodes, :6]
    w[:, 3:] /= np.linalg.norm(w[:, 3:], axis=1, keepdims=True)
    x = surface.points[shell.partition.nodes] + w[:, :3]
    n, total = shell.partition.n_owned, shell.comm.allreduce
    plain, damped = InternalForce(shell), InternalForce(shell, damped=True)
    still = plain(w)[:n].copy()
    size = np.sqrt(total(np.sum(still**2)))

    def viscous(rates):
        return damped(w, 0.0, w + rates)[:n] - still

    np.testing.assert_allclose(damped(w)[:n], still, atol=1e-13 * size)
    spin, shift = np.array([0.1, -0.2, 0.3]), np.array([0.3, 0.1, -0.2])
    rigid = np.hstack([np.cross(spin, x) + shift, np.cross(spin, w[:, 3:])])
    assert np.abs(viscous(rigid)).max(initial=0.0) < 1e-12 * size
    one = field[shell.partition.nodes, 6:]
    two = field[shell.partition.nodes, 5::-1].copy()
    first = viscous(one)
    power = total(np.vdot(first, one[:n]))
    assert power > 0
    assert total(damped.loss) == pytest.approx(power, rel=1e-9)
    assert total(np.vdot(viscous(two), one[:n])) == pytest.approx(
        total(np.vdot(first, two[:n])), abs=1e-9 * power
    )
    np.testing.assert_allclose(viscous(2 * one), 2 * first, atol=1e-9 * size)


def test_damping_does_not_feed_a_buckling_sheet():
    """Pressed flat, a sheet gives energy to a bulge; damping must not take that for resistance."""
    shell = sheet(12)
    w = shell.w.x.array.reshape(-1, 6)
    x = shell.surface.points[shell.partition.nodes]
    w[:, 0] = -0.1 * x[:, 0]
    bulge = np.zeros_like(w)
    bulge[:, 2] = 1e-4 * np.sin(2 * np.pi * x[:, 0])
    bulge[:, 3] = -1e-4 * 2 * np.pi * np.cos(2 * np.pi * x[:, 0])
    n, total = shell.partition.n_owned, shell.comm.allreduce
    plain, damped = InternalForce(shell), InternalForce(shell, damped=True)
    still = plain(w)[:n].copy()
    moved = plain(w + bulge)[:n] - still
    viscous = damped(w, 0.0, w + bulge)[:n] - still
    assert total(np.vdot(moved, bulge[:n])) < 0
    assert total(np.vdot(viscous, bulge[:n])) > 0


@pytest.mark.parametrize("name", FABRICS)
@pytest.mark.parametrize("stretched", [False, True])
def test_stable_step_is_stable_and_close_to_the_limit(name, stretched):
    """At the estimate a perturbation stays bounded; 30 % above it grows."""
    surface = sheet(6).surface

    def growth(factor, steps):
        shell = Shell(surface, FABRICS[name])
        X = surface.points[shell.partition.nodes]
        if stretched:
            w = shell.w.x.array.reshape(-1, 6)
            w[:, 0], w[:, 1] = 0.1 * X[:, 0] + 0.1 * X[:, 1], -0.05 * X[:, 1]
            for edge in ("left", "right", "bottom", "top"):
                shell.supports.clamp(edge)
        newmark = Newmark(shell)
        newmark.dt, newmark.recheck = factor * newmark.critical_dt, 10**9
        newmark.rewind.retries = 0
        rng = np.random.default_rng(0)
        kick = rng.standard_normal((len(surface.points), 3))
        newmark.v[:] = 1e-6 * kick[shell.partition.owned_nodes]
        size = []
        for _ in range(4):
            try:
                newmark.advance(newmark.time + steps / 4 * newmark.dt)
            except Unstable:
                return np.inf
            size.append(shell.comm.allreduce(np.abs(newmark.v).max(), MPI.MAX))
        return size[-1] / size[0]

    assert growth(1.0, 4000) < 10
    assert growth(1.3, 400) > 1e3


@pytest.mark.slow
@pytest.mark.parametrize("name", FABRICS)
def test_a_long_run_at_the_stable_step_does_not_grow(name):
    """100 000 steps at the estimate on a stretched, sheared sheet, seeded by noise."""
    surface = sheet(2).surface
    shell = Shell(surface, FABRICS[name])
    X = surface.points[shell.partition.nodes]
    w = shell.w.x.array.reshape(-1, 6)
    w[:, 0], w[:, 1] = 0.1 * X[:, 0] + 0.1 * X[:, 1], -0.05 * X[:, 1]
    for edge in ("left", "bottom", "top"):
        shell.supports.clamp(edge)
    shell.supports.hold("right")
    newmark = Newmark(shell)
    newmark.dt, newmark.recheck = newmark.critical_dt, 10**9
    newmark.rewind.retries = 0
    noise = np.random.default_rng(0).standard_normal((2, len(surface.points), 3))
    own = shell.partition.owned_nodes
    newmark.v[:] = np.where(newmark.held[:, :3], 0.0, 1e-6 * noise[0, own])
    size = []
    for _ in range(10):
        newmark.advance(newmark.time + 10_000 * newmark.dt)
        size.append(shell.comm.allreduce(np.abs(newmark.v).max(), MPI.MAX))
    assert newmark.steps >= 99_990
    assert max(size[5:]) < 3 * max(size[:5])
    assert max(size) < 1e-4


def strip(cells, length=0.5, thickness=1e-3):
    """A cantilever strip kept in plane strain of zero Poisson's ratio: a beam."""
    surface = meshes.rectangle(length, length / cells, (cells, 1))
    shell = Shell(surface, Fabric.isotropic(1e7, 0.0, thickness, 200.0))
    for edge in ("bottom", "top"):
        shell.supports.symmetry(edge, (0, 1, 0))
    return shell


def tip(newmark):
    return newmark.shell.displacement_at((0.5, 0, 0))


def swing(steps, end, clamped, thickness=5e-3):
    """Tip of a strip thrown at some m/s under gravity after `end` seconds, and the stepper."""
    shell = strip(4) if clamped else strip(2, thickness=thickness)
    if clamped:
        shell.supports.clamp("left")
    else:
        shell.supports.hold("left")
    shell.loads.gravity((0, 0, -9.81))
    newmark = Newmark(shell)
    newmark.dt, newmark.recheck = end / steps, 10**9
    assert newmark.dt < newmark.critical_dt
    x = newmark.points[:, 0]
    newmark.v[:, 2] = -20 * x**2 if clamped else -3 * x
    newmark.q[:, 0] = 40 * x if clamped else 3
    newmark.advance(end)
    assert newmark.steps == steps
    return tip(newmark), newmark


@pytest.mark.parametrize(("clamped", "end", "first"), [(True, 0.1, 2000), (False, 0.05, 500)])
def test_second_order_in_time(clamped, end, first):
    """Large motion of a cantilever and of a pendulum at successively halved steps."""
    tips = [swing(first * 2**k, end, clamped)[0] for k in range(3)]
    errors = [np.linalg.norm(a - b) for a, b in pairwise(tips)]
    assert np.linalg.norm(tips[-1]) > 0.08  # it moves far
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)


def test_pendulum_swings_like_a_rigid_body():
    """A stiff hinged strip against the compound pendulum with the same lumped inertia."""
    from scipy.integrate import solve_ivp

    place, newmark = swing(4000, 0.2, clamped=False, thickness=0.03)
    comm, arm, length = newmark.shell.comm, newmark.points[:, 0], 0.5
    inertia = comm.allreduce(np.sum(newmark.mass * arm**2 + newmark.inertia))
    moment = comm.allreduce(np.sum(newmark.mass * arm)) * 9.81
    exact = solve_ivp(
        lambda t, y: [y[1], moment / inertia * np.cos(y[0])], (0, 0.2), [0, 3.0], rtol=1e-10
    )
    angle = exact.y[0, -1]
    goal = length * np.array([np.cos(angle) - 1, 0, -np.sin(angle)])
    assert angle > 0.7
    # what is left is the strip's own bending, which a stiffer one makes smaller
    assert np.linalg.norm(place - goal) < 1e-3 * length


def test_first_frequency_of_a_cantilever():
    """Within 0.5 % of 1.8751^2/(2 pi) sqrt(D/(rho L^4)), from the zeros of a small swing."""
    shell = strip(24, thickness=6e-3)
    shell.supports.clamp("left")
    newmark = Newmark(shell)
    length, fabric = 0.5, shell.fabric
    k = 1.875104068711961 / length
    exact = k**2 / (2 * np.pi) * np.sqrt(fabric.bending[0, 0] / fabric.areal_mass)
    s = k * newmark.points[:, 0]
    ratio = (np.cosh(k * length) + np.cos(k * length)) / (np.sinh(k * length) + np.sin(k * length))
    newmark.v[:, 2] = 1e-3 * (np.cosh(s) - np.cos(s) - ratio * (np.sinh(s) - np.sin(s)))
    slope = 1e-3 * k * (np.sinh(s) + np.sin(s) - ratio * (np.cosh(s) - np.cos(s)))
    newmark.q[:, 0] = -slope
    times, heights = [], []
    for i in range(1, 241):
        newmark.advance(i * 2.2 / exact / 240)
        times.append(newmark.time)
        heights.append(tip(newmark)[2])
    heights = np.array(heights)
    at = np.flatnonzero(heights[:-1] * heights[1:] < 0)
    zeros = [
        times[i] - heights[i] * (times[i + 1] - times[i]) / (heights[i + 1] - heights[i])
        for i in at
    ]
    frequency = 0.5 * (len(zeros) - 1) / (zeros[-1] - zeros[0])
    assert frequency == pytest.approx(exact, rel=5e-3)


def test_directors_turn_by_the_angle_of_their_speed():
    """Both sides of where the series of sine and cosine ends, and a director at rest."""
    angles = np.array([0.0, 1e-9, 1e-3, 0.0999, 0.1001, 1.0])
    w, q = np.zeros((6, 6)), np.zeros((6, 3))
    w[:, 3], q[:, 1] = 1.0, angles / 1e-4
    drift(w, np.zeros((6, 3)), q, 1e-4)
    turned = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    along = np.stack([-np.sin(angles), np.cos(angles), 0 * angles], axis=1)
    assert np.abs(w[:, 3:] - turned).max() < 4e-16
    assert np.abs(q - angles[:, None] / 1e-4 * along).max() < 4e-16 / 1e-4
