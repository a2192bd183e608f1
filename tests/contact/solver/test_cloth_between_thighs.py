# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cloth between two parts that pass each other: flesh gives way to it where flesh meets flesh.

Two balls close until each would be past the middle plane, and slide along it in opposite senses, as
thighs do in a walk. Between them are two nodes of cloth with a spring. Where the balls are pressed
flat and room is left, nothing can be pushed: momentum and energy stay what they were. Where they
pass through each other, both may hold the nodes but not tear at the spring.
"""

import numpy as np

from contact.body.segments import Pose
from contact.body.skinned_surface import Bend, SkinnedSurface
from contact.solver.surface_correction import SurfaceCorrection
from tests.contact.solver.surfaces import ball

RADIUS, GAP, ROOM = 0.06, 0.003, 0.002  # [m]; the gap is from the middle plane at first
DEEP, SLIDE, LONG = 0.006, 0.3, 0.1  # how far each comes nearer [m], speed along [m/s], time [s]
OFFSET, APART = 3e-4, 0.01  # of cloth from skin, of the nodes [m]
MASS, SPRING, DT = 2e-4, 2e3, 1e-4  # [kg], [N/m], [s]
RECOVERY = 0.1  # m/s
BOUND = Pose(
    np.array([[0.0, RADIUS + GAP, 0.0], [0.0, -RADIUS - GAP, 0.0]]),
    np.array([np.eye(3), np.eye(3)]), np.zeros((2, 3)), np.zeros((2, 3)),
)  # fmt: skip


def closing(t, out):
    """The left ball forward, the right one back, both to the middle and away again."""
    near, rate = np.sin(np.pi * t / LONG) ** 2, np.sin(2 * np.pi * t / LONG) * np.pi / LONG
    for j, sign in enumerate((1.0, -1.0)):
        along = sign * SLIDE
        out.centres[j] = BOUND.centres[j] + [along * (t - LONG / 2), -sign * DEEP * near, 0.0]
        out.velocities[j] = [along, -sign * DEEP * rate, 0.0]
        out.axes[j] = np.eye(3)
    return out


def surface_of(room):
    """Both balls as one skin; room : left of each at the middle plane [m], None: nothing gives."""
    one = ball(RADIUS, 3)
    points = np.concatenate([one.local + centre for centre in BOUND.centres])
    triangles = np.concatenate([one.triangles, one.triangles + len(one.local)])
    bends = []
    if room is not None:
        left, whole = np.array([0.0, 1.0, 0.0]), np.ones(len(points))
        bends = [
            Bend("left", "right", np.zeros(3), left, -left, 0.006, 0.9, room, whole)
        ]  # fmt: skip
    weights = np.repeat(np.eye(2), len(one.local), axis=0)
    return SkinnedSurface(points, triangles, weights, ("left", "right"), closing, BOUND, bends)


def passed(room):
    """Greatest pull of the spring [N], greatest sum of impulses [N s], steps that pinch nodes,
    what is missing of the energy balance [J] and the least loss of a step [J]."""
    surface = surface_of(room)
    correction = SurfaceCorrection(surface, 2, friction=0.3, offset=OFFSET, recovery=RECOVERY)
    x, v, mass = (
        np.array([[-APART / 2, 0, 0], [APART / 2, 0, 0]]),
        np.zeros((2, 3)),
        np.full(2, MASS),
    )
    most, pinched, balance, least = 0.0, 0, 0.0, 0.0
    for step in range(int(LONG / DT)):
        line = x[1] - x[0]
        pull = SPRING * max(np.linalg.norm(line) - APART, 0.0)
        most, old = max(most, pull), v.copy()
        kick = DT / MASS * pull * np.array([line, -line]) / np.linalg.norm(line)
        v += kick
        correction(x, v, mass, DT, step * DT, old)
        pinched += correction.pinched
        done, rubbed, pressed = correction.at_vertices[:, 3:].sum(axis=0)
        balance += 0.5 * MASS * np.sum(v**2 - old**2 - kick * (v + old)) - done + rubbed + pressed
        least = min(least, rubbed + pressed)
        x += DT * v
    return most, np.abs(correction.window.impulse).max(), pinched, balance, least


def test_flesh_leaves_cloth_between_thighs_alone():
    assert passed(ROOM) == (0.0, 0.0, 0, 0.0, 0.0)


def test_parts_that_pass_through_each_other_do_not_tear_at_it():
    """Met as two hard walls at once they pull with 58 N."""
    pull, impulse, pinched, balance, least = passed(None)
    assert pinched > 10 and pull < 1.0 and impulse < 1e-3
    # a node that is moved out is given no more than the recovery speed
    assert abs(balance) < 1e-15 and least > -MASS * RECOVERY**2


def test_skins_keep_their_room():
    surface = surface_of(ROOM)
    for t in np.linspace(0.0, LONG, 21):
        x = surface.positions(t, np.empty((surface.vertex_count, 3)))
        n = len(x) // 2
        assert x[:n, 1].min() >= ROOM and x[n:, 1].max() <= -ROOM
