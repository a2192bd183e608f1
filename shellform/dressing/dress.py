# SPDX-License-Identifier: LGPL-3.0-or-later
"""Putting a garment on a standing wearer, Fig. 7 of the paper.

(a) The feet are left out. (b) The garment, below the legs at first, is pulled up by its waist edge
over legs and hips to the height it was made for. (c) The feet are met again. (d) A belt of given
tension draws the waist together while the hands let go; then everything settles, until the mean
speed of the cloth is `quiet`.

All of it happens before the recorded motion: the wearer stands still before its first frame, and
what time is left over is skipped. Cloth slides easily while it is pulled up (`slip`), as a person
would shake it into place; the friction of the scene holds from the belt on.
"""

from dataclasses import dataclass

import numpy as np

from shellform.fem.arc import arc_lengths

from .belt import Belt, Hands, Ring

GAP = 0.03  # between the waist edge and the legs above it, before [m]
AWAY = 2  # cells from the waist that count as the belt's


@dataclass(frozen=True)
class Dressing:
    """How a garment is put on.

    pull, belt, release, settle : float [s], time to pull it up, to tighten the belt, to let go, and
        at most to settle
    drag : float [1/s], of the air while dressing; slip : float, friction while pulling up
    grip : float [N/m], of the hands on each node of the waist
    quiet : float [m/s], root mean square speed of the settled cloth
    """

    pull: float = 1.2
    belt: float = 0.3
    release: float = 0.2
    settle: float = 3.0
    drag: float = 4.0
    slip: float = 0.02
    grip: float = 150.0
    quiet: float = 0.01

    @property
    def seconds(self):
        """Longest time it can take [s]."""
        return self.pull + self.belt + self.release + self.settle


def drop_below(surface, wearer, time):
    """How far [m] a garment is let down so that its waist edge is below all but the feet."""
    pose = wearer.new_pose(time)
    worn = [k for k, segment in enumerate(wearer.segments) if not segment.endswith("foot")]
    # an ellipsoid reaches sqrt(sum (r_i e_i . z)^2) below its centre
    reach = np.sqrt(np.sum((wearer.radii[worn] * pose.axes[worn, :, 2]) ** 2, axis=1))
    low = (pose.centres[worn, 2] - reach).min()
    waist = surface.points[np.unique(surface.edges["waist"]), 2].max()
    return float(waist - low + GAP)


def dress(stepper, touch, tension, plan=None, watch=None, every=0.05):
    """Dress the wearer; the stepper's clock ends at the wearer's first frame.

    Parameters
    ----------
    stepper : Newmark on a surface that lies as it will be worn, with the edge 'waist'
    touch : Touch whose body is a Wearer that starts from rest
    tension : float [N], of the belt
    plan : Dressing or None
    watch : function of (stage, stepper), called every `every` [s] while stages 'pull', 'belt' and
        'settle' last, and at 'below', 'up', 'belted', 'settled'

    Returns
    -------
    belt : Belt, which stays
    report : dict of what was reached: `seconds` it took, root mean square `speed` [m/s], whether
        `settled`, and the figures of `fit`
    """
    plan = Dressing() if plan is None else plan
    correction, wearer = touch.correction, touch.correction.body
    watch = watch or (lambda stage, stepper: None)
    feet = wearer.mask([n for n, s in zip(wearer.names, wearer.segments) if s.endswith("foot")])
    reach, law, drag = correction.allowed.copy(), correction.friction, stepper.drag
    start = wearer.start - plan.seconds
    stepper.time, stepper.drag = start, plan.drag

    # (a), below the legs, feet left out
    drop = drop_below(stepper.shell.surface, wearer, start)
    stepper.owned[:, 2] -= drop
    stepper.scatter()
    correction.allowed &= ~feet
    correction.friction = plan.slip
    watch("below", stepper)

    # (b), up over legs and hips
    mass = stepper.shell.comm.allreduce(stepper.mass.sum()) / len(stepper.shell.surface.points)
    damping = 0.5 * np.sqrt(plan.grip * mass)
    hands = Hands(stepper, "waist", _lift(start, plan.pull, drop), plan.grip, damping)
    _go(stepper, start + plan.pull, every, lambda: watch("pull", stepper))
    watch("up", stepper)

    # (c) and (d)
    correction.allowed[:] = reach
    correction.friction = law
    belt = Belt(stepper, "waist")
    begin = stepper.time

    def tighten():
        belt.tension = tension * min(1.0, (stepper.time - begin) / plan.belt)
        hands.hold = min(1.0, max(0.0, 1 - (stepper.time - begin - plan.belt) / plan.release))
        watch("belt", stepper)

    _go(stepper, begin + plan.belt + plan.release, 0.01, tighten)
    belt.tension = tension
    stepper.pulls.remove(hands)
    watch("belted", stepper)
    report = settle(stepper, touch, belt, plan, watch, every)
    stepper.drag = drag
    return belt, {"seconds": plan.pull + plan.belt + plan.release + report.pop("seconds")} | report


def settle(stepper, touch, belt, plan, watch, every=0.05):
    """Wait until the cloth is quiet; the clock ends at the wearer's first frame.

    Returns
    -------
    dict: `seconds` it took, root mean square `speed` [m/s], whether `settled`, figures of `fit`
    """
    end, begin = touch.correction.body.start, stepper.time
    stepper.drag = plan.drag
    while stepper.time < end - 1e-9 and speed(stepper) > plan.quiet:
        _go(stepper, min(stepper.time + 0.1, end), every, lambda: watch("settle", stepper))
    report = {"seconds": stepper.time - begin, "speed": speed(stepper)}
    report |= {"settled": report["speed"] <= plan.quiet} | fit(stepper, touch, belt)
    stepper.time = end
    watch("settled", stepper)
    return report


def fit(stepper, touch, belt):
    """How the garment sits: depth in the body, stretch, what the belt does; on all ranks.

    `belt_tension` is measured by what holds against it: a cable presses with its tension times the
    angle by which it turns. On the nodes of the waist that is the outward force of the body,
    which is `belt_pressed` by itself, and that of the cloth, which is gathered and resists.
    `stretch` is the largest `elongation` of the cloth along a cell edge farther from the waist.
    """
    shell, correction = stepper.shell, touch.correction
    comm, surface = shell.comm, shell.surface
    correction.reset()
    # drag of the air would take dt/2 of its rate off the contact forces
    drag, stepper.drag = stepper.drag, 0.0
    stepper.advance(stepper.time + 200 * stepper.dt)
    stepper.drag = drag
    ring = Ring(stepper, "waist")
    x = ring.look(stepper)
    contact, cloth = np.zeros((2, *x.shape))
    contact[ring.mine] = (correction.window.impulse / correction.window.seconds)[ring.own]
    cloth[ring.mine] = -stepper.internal_force()[ring.own, :3]
    along = np.roll(x, -1, axis=0) - x
    along /= np.linalg.norm(along, axis=1)[:, None]
    turn = np.roll(along, 1, axis=0) - along
    size = np.linalg.norm(turn, axis=1)
    outward = turn / np.maximum(size, 1e-12)[:, None]
    pressed, resisted = (
        float(np.sum(comm.allreduce(force) * outward) / size.sum()) for force in (contact, cloth)
    )
    return {
        "depth": max(comm.allgather(max(correction.max_depth, 0.0))),
        "stretch": float(elongation(shell.positions(), shell.directors(), surface).max()),
        "belt_asked": belt.tension,
        "belt_tension": pressed + resisted,
        "belt_pressed": pressed,
        "pinched": comm.allreduce(correction.pinched),
    }


def near_waist(surface):
    """Mask (n,) of the points at the waist and up to AWAY cells from it."""
    cells = surface.cells[:, :4]
    near = np.zeros(len(surface.points), bool)
    near[np.unique(surface.edges["waist"])] = True
    for _ in range(AWAY):
        near[np.unique(cells[near[cells].any(axis=1)])] = True
    return near


def elongation(positions, directors, surface):
    """Elongation (k,) of the cloth along the cell edges that are not `near_waist`.

    Of its length, not of the distance of the nodes: at the fork the cloth turns by 90 degrees along
    an edge, and a fold that opens moves its ends apart by up to 10 % without any strain.
    """
    near, cells = near_waist(surface), surface.cells[:, :4]
    pairs = np.stack([cells, np.roll(cells, -1, axis=1)], 2).reshape(-1, 2)
    pairs = pairs[~near[pairs].any(axis=1)]
    now = arc_lengths(positions[pairs], directors[pairs])
    return now / arc_lengths(surface.points[pairs], surface.directors[pairs]) - 1


def speed(stepper):
    """Root mean square speed of the cloth [m/s], on every rank."""
    sums = np.array([stepper.mass @ np.sum(stepper.v**2, axis=1), stepper.mass.sum()])
    squares, mass = stepper.shell.comm.allreduce(sums)
    return float(np.sqrt(squares / mass))


def _lift(start, seconds, height):
    """Shift and velocity from `height` below to 0, along the polynomial of least jerk."""

    def places(time):
        s = min(max((time - start) / seconds, 0.0), 1.0)
        rise = s**3 * (10 - 15 * s + 6 * s * s) - 1
        rate = 30 * s * s * (1 - s) ** 2 / seconds
        up = np.array([0.0, 0.0, height])
        return rise * up, rate * up

    return places


def _go(stepper, until, every, watch):
    """Advance in parts of about `every` [s], calling watch after each."""
    parts = max(1, int(np.ceil((until - stepper.time) / every - 1e-9)))
    for time in np.linspace(stepper.time, until, parts + 1)[1:]:
        stepper.advance(time)
        watch()


STAGES = {"below": "feet left out", "pull": "pulled up", "belted": "feet back, belt", "settled": ""}
