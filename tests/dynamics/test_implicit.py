# SPDX-License-Identifier: LGPL-3.0-or-later
"""Implicit Newmark steps against conservation laws and orders of convergence."""

from itertools import pairwise

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
import pytest

from shellform.dynamics.implicit import ImplicitNewmark
from shellform.dynamics.implicit_midpoint import ImplicitMidpoint
from shellform.errors import NotConverged
from tests.dynamics.test_explicit import sheet, totals, tumble
from tests.dynamics.test_explicit_accuracy import strip, tip

G = 9.81


def swing(steps, end, clamped, kind=ImplicitNewmark, **options):
    """Tip of a strip that gravity sets in motion smoothly from rest, and the stepper."""
    shell = strip(4 if clamped else 2, thickness=5e-3)
    (shell.supports.clamp if clamped else shell.supports.hold)("left")
    shell.loads.gravity((0, 0, -G), amplitude=lambda t: 5 * np.sin(np.pi * t / end) ** 2)
    stepper = kind(shell, end / steps, **options)
    stepper.advance(end)
    return tip(stepper), stepper


CASES = [
    (True, ImplicitNewmark, {}),
    pytest.param(False, ImplicitNewmark, {}, marks=pytest.mark.slow),
    pytest.param(True, ImplicitNewmark, {"alpha": -0.2}, marks=pytest.mark.slow),
    pytest.param(False, ImplicitMidpoint, {}, marks=pytest.mark.slow),
]


@pytest.mark.parametrize(("clamped", "kind", "options"), CASES)
def test_second_order_in_time(clamped, kind, options):
    """Large motion at successively halved steps, damped by alpha or not."""
    runs = [swing(25 * 2**k, 0.2, clamped, kind, **options) for k in range(3)]
    tips = [place for place, _ in runs]
    assert [stepper.steps for _, stepper in runs] == [25, 50, 100]
    errors = [np.linalg.norm(a - b) for a, b in pairwise(tips)]
    assert np.linalg.norm(tips[-1]) > 0.08
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)


@pytest.mark.slow
def test_alpha_damps_what_steps_do_not_resolve():
    """A checkerboard of velocities: its energy stays at alpha = 0 and is gone at alpha = -0.3."""
    left = []
    for alpha in (0.0, -0.3):
        stepper = ImplicitNewmark(sheet(4), 5e-3, alpha=alpha)
        stepper.v[:, 0] = 1e-6 * (-1.0) ** stepper.shell.partition.owned_nodes
        mass = stepper.shell.comm.allreduce(stepper.mass.sum())
        stepper.v[:, 0] -= stepper.shell.comm.allreduce(stepper.mass @ stepper.v[:, 0]) / mass
        stepper.q[:] = 0.0
        *_, before, _ = totals(stepper)
        stepper.advance(0.6)
        *_, kinetic, strain = totals(stepper)
        left.append((kinetic + strain) / before)
    assert left[0] == pytest.approx(1.0, rel=1e-3)
    assert left[1] < 1e-3


@pytest.mark.slow
def test_tolerance_controls_the_error():
    """Steps follow the error asked for; an eighth of it leaves about a quarter of the error."""
    goal, _ = swing(300, 0.2, True)
    errors, steps = [], []
    for tolerance in (8e-6, 1e-6):
        place, stepper = swing(20, 0.2, True, tolerance=tolerance)
        errors.append(np.linalg.norm(place - goal))
        steps.append(stepper.steps)
    assert 20 < steps[0] < steps[1] < 400
    assert 2 < errors[0] / errors[1] < 8
    assert errors[0] < 100 * 8e-6


def test_free_flight_conserves_momentum():
    stepper = ImplicitNewmark(sheet(6), 1e-3)
    tumble(stepper)
    p0, j0, k0, e0 = totals(stepper)
    stepper.advance(0.1)
    p, j, k, e = totals(stepper)
    assert np.abs(p - p0).max() < 1e-12 * np.abs(p0).max()
    assert np.abs(j - j0).max() < 1e-4 * np.abs(j0).max()
    assert k + e == pytest.approx(k0 + e0, rel=1e-4)


def test_damping_leaves_free_fall_exact():
    shell = sheet(4)
    shell.loads.gravity((0.0, 0.0, -G))
    stepper = ImplicitNewmark(shell, 5e-3, gamma=0.7)
    stepper.advance(0.1)
    drop = stepper.w[: stepper.n_owned, 2]
    assert drop == pytest.approx(-0.5 * G * 0.1**2, rel=1e-9)


@pytest.mark.slow
def test_midpoint_conserves_angular_momentum():
    """1000 steps of a tumbling, deforming sheet keep it to 1e-6, energy to the steps' error."""
    stepper = ImplicitMidpoint(sheet(3), 1e-3)
    tumble(stepper)
    p0, j0, k0, e0 = totals(stepper)
    for _ in range(10):
        stepper.advance(stepper.time + 0.1)
        p, j, k, e = totals(stepper)
        assert np.abs(p - p0).max() < 1e-12 * np.abs(p0).max()
        assert np.abs(j - j0).max() < 1e-6 * np.abs(j0).max()
        assert k + e == pytest.approx(k0 + e0, rel=1e-4)
    assert stepper.steps == 1000
    assert e > 1e-6 * k


@pytest.mark.slow
@pytest.mark.parametrize("kind", [ImplicitNewmark, ImplicitMidpoint])
def test_prescribed_motion_is_followed(kind):
    """An edge on a circle, its director turned at a rate: there, at the right velocity."""
    shell = sheet(3)

    def place(t):
        return np.array([0.02 * np.sin(40 * t), 0.0, 0.02 * (1 - np.cos(40 * t))])

    def facing(t):
        return np.array([np.sin(5 * t), 0.0, np.cos(5 * t)])

    shell.supports.clamp("left")
    shell.supports.move("left", place, facing)
    stepper = kind(shell, 1e-3)
    stepper.advance(0.02)
    edge = shell.partition.find("left")
    assert np.abs(shell.displacements()[edge] - place(0.02)).max() < 1e-12
    assert np.abs(shell.directors()[edge] - facing(0.02)).max() < 1e-12
    v, q = (shell.partition.gather(field)[edge] for field in stepper.velocities())
    assert v == pytest.approx(np.tile([0.8 * np.cos(0.8), 0, 0.8 * np.sin(0.8)], (4, 1)), abs=1e-6)
    assert q == pytest.approx(np.tile([5 * np.cos(0.1), 0, -5 * np.sin(0.1)], (4, 1)), abs=1e-6)
    # what the edge gave is what the sheet has
    p, given = shell.comm.allreduce(stepper.mass @ stepper.v), stepper.support_total
    assert p == pytest.approx(shell.comm.allreduce(given), abs=1e-13)


@pytest.mark.parametrize("kind", [ImplicitNewmark, ImplicitMidpoint])
def test_slides_down_an_inclined_support(kind):
    """A sheet guided by a plane of any inclination: g sin t^2/2 along it, m g cos across."""
    shell, angle = sheet(2), 0.4
    normal = np.array([np.sin(angle), 0.0, np.cos(angle)])
    shell.supports.hold_normal(lambda X: np.ones(len(X), bool), normal)
    shell.loads.gravity((0.0, 0.0, -G))
    stepper = kind(shell, 5e-3)
    stepper.advance(0.1)
    along = np.array([np.cos(angle), 0.0, -np.sin(angle)])
    exact = 0.5 * G * np.sin(angle) * 0.1**2 * along
    assert shell.displacements() == pytest.approx(np.tile(exact, (9, 1)), abs=1e-9)
    pushed = shell.comm.allreduce(stepper.support_total)
    weight = shell.fabric.areal_mass * G
    assert pushed == pytest.approx(weight * np.cos(angle) * 0.1 * normal, abs=1e-9)


def test_drag_is_that_of_still_air():
    """Speed decays by exp(-c t); what is lost is booked."""
    stepper = ImplicitNewmark(sheet(2), 5e-3, drag=3.0)
    stepper.v[:] = [1.0, 2.0, 3.0]
    (p0, _, k0), comm = stepper.momenta(), stepper.shell.comm
    stepper.advance(0.1)
    p, _, k = stepper.momenta()
    assert p == pytest.approx(np.exp(-0.3) * p0, rel=1e-12)
    assert p - p0 == pytest.approx(comm.allreduce(stepper.drag_total), rel=1e-12)
    assert k0 - k == pytest.approx(comm.allreduce(stepper.work["drag"]), rel=1e-12)


def starved(iterations):
    """A strip under a sudden load whose SNES may take so many iterations, set by its prefix."""
    PETSc.Options("starved_")["snes_max_it"] = iterations
    shell = strip(4, thickness=5e-3)
    shell.supports.clamp("left")
    shell.loads.gravity((0, 0, -50.0))
    return ImplicitNewmark(shell, 0.02, prefix="starved_")


def test_failed_steps_are_cut_back_and_grow_again():
    """Few iterations are enough for short steps only; the end is that of a run with short steps."""
    stepper = starved(3)
    assert stepper.newton.snes.getTolerances()[3] == 3
    stepper.advance(0.1)
    assert stepper.cutbacks > 0
    assert stepper.time == pytest.approx(0.1, rel=1e-12)
    shortest = stepper.dt
    stepper.newton.snes.setTolerances(max_it=25)
    stepper.advance(0.2)
    assert stepper.dt > shortest
    fine = starved(25)
    fine.dt = fine.largest_dt = 1e-3
    fine.advance(0.2)
    # second order: what steps of up to 0.02 s leave over
    assert np.linalg.norm(tip(stepper) - tip(fine)) < 0.05 * np.linalg.norm(tip(fine))


def test_state_is_kept_when_every_step_fails():
    stepper = starved(25)
    stepper.advance(0.02)
    place, speed = stepper.owned.copy(), stepper.v.copy()
    stepper.newton.snes.setTolerances(max_it=0)
    with pytest.raises(NotConverged, match=r"no step of .* from t = 0\.02 s: SNES says"):
        stepper.advance(0.04)
    assert stepper.time == 0.02
    assert np.array_equal(stepper.owned, place)
    assert np.array_equal(stepper.v, speed)
    stepper.newton.snes.setTolerances(max_it=25)
    stepper.dt = 0.02
    stepper.advance(0.04)
    moved = np.abs(stepper.owned - place).max(initial=0.0)
    assert stepper.shell.comm.allreduce(moved, MPI.MAX) > 1e-3


@pytest.mark.parametrize("values", [{"alpha": 0.1}, {"alpha": -0.5}])
def test_refuses_alpha_out_of_range(values):
    with pytest.raises(ValueError, match="from -1/3 to 0"):
        ImplicitNewmark(sheet(2), 1e-3, **values)


@pytest.mark.parametrize("values", [{"beta": 0.0}, {"gamma": 0.4}])
def test_refuses_parameters_out_of_range(values):
    with pytest.raises(ValueError, match="implicit steps need"):
        ImplicitNewmark(sheet(2), 1e-3, **values)
