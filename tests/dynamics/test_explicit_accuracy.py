# SPDX-License-Identifier: LGPL-3.0-or-later
"""Explicit steps against exact motions: order in time, a pendulum, a cantilever."""

from itertools import pairwise

import numpy as np
import pytest

import meshes
from shellform import Fabric, Shell
from shellform.dynamics.explicit import Newmark


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
