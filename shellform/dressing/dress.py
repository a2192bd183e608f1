# SPDX-License-Identifier: LGPL-3.0-or-later
"""Putting a garment on a standing wearer, Fig. 7 of the paper.

(a) The feet are left out. (b) The garment, below the legs at first, is pulled up by its waist edge
over legs and hips to the height it was made for. (c) The feet are met again. (d) A belt of given
tension draws the waist together while the hands let go; then everything settles (settle.py).

All of it happens before the recorded motion: the wearer stands still before its first frame. Cloth
slides easily while it is pulled up (`Dressing.slip`), as a person would shake it into place; the
friction of the scene holds from the belt on.
"""

from collections.abc import Callable

import numpy as np

from meshes import Surface
from shellform.contact_coupling.contact import require_contact
from shellform.dynamics.explicit import Newmark
from shellform.motion.wearer import Wearer

from .belt import Belt, Hands
from .procedure import Dressing, Watch, unwatched
from .settings import borrowed
from .settle import advance_watched, settle

GAP = 0.03  # between the waist edge and the legs above it, before [m]


def dress(
    stepper: Newmark,
    tension: float,
    dressing: Dressing | None = None,
    watch: Watch | None = None,
    every: float = 0.05,
) -> tuple[Belt, dict]:
    """Dress the wearer; the stepper's clock ends at the wearer's first frame.

    After an error, or Ctrl-C, the stepper and its contact are as they were before.

    Parameters
    ----------
    stepper : Newmark on a surface that lies as it will be on the body, with the edge 'waist'; its
        contact is with a Wearer that starts from rest
    tension : float [N], of the belt
    dressing : Dressing or None
    watch : function of (stage, stepper), called every `every` [s] while stages 'pull', 'belt' and
        'settle' last, and at 'below', 'up', 'belted', 'settled'

    Returns
    -------
    belt : Belt, which stays
    report : dict of what was reached: `seconds` it took, root mean square `speed` [m/s], whether
        `settled`, and the figures of `fit`
    """
    dressing = Dressing() if dressing is None else dressing
    watch = unwatched if watch is None else watch
    contact = require_contact(stepper, "dressing")
    wearer = contact.body
    allowed, friction = contact.correction.allowed, contact.friction
    reach = allowed.copy()
    start = wearer.start - dressing.seconds
    with borrowed(stepper):
        stepper.time, stepper.drag = start, dressing.drag

        # (a), below the legs, feet left out
        drop = drop_below(stepper.shell.surface, wearer, start)
        stepper.owned[:, 2] -= drop
        stepper.scatter()
        allowed &= ~feet(wearer)
        contact.friction = dressing.slip
        watch("below", stepper)

        # (b), up over legs and hips
        hands = hands_at_waist(stepper, dressing, _lift(start, dressing.pull, drop))
        advance_watched(stepper, start + dressing.pull, every, lambda: watch("pull", stepper))
        watch("up", stepper)

        # (c) and (d)
        allowed[:] = reach
        contact.friction = friction
        belt = stepper.add(Belt("waist"))
        change_hands(stepper, belt, hands, tension, dressing, watch)
        watch("belted", stepper)
        report = settle(stepper, belt, dressing, watch, every)
    before = dressing.pull + dressing.belt + dressing.release
    return belt, {"seconds": before + report.pop("seconds")} | report


def drop_below(surface: Surface, wearer: Wearer, time: float) -> float:
    """How far [m] a garment is let down so that its waist edge is below all but the feet."""
    pose = wearer.new_pose(time)
    legs = [k for k, segment in enumerate(wearer.carriers) if not segment.endswith("foot")]
    # an ellipsoid reaches sqrt(sum (r_i e_i . z)^2) below its centre
    reach = np.sqrt(np.sum((wearer.radii[legs] * pose.axes[legs, :, 2]) ** 2, axis=1))
    low = (pose.centres[legs, 2] - reach).min()
    waist = surface.points[np.unique(surface.edges["waist"]), 2].max()
    return float(waist - low + GAP)


def feet(wearer: Wearer) -> int:
    """The feet as a set of ellipsoids, in bits."""
    return wearer.mask([n for n, s in zip(wearer.names, wearer.carriers) if s.endswith("foot")])


def hands_at_waist(stepper: Newmark, dressing: Dressing, places: Callable) -> Hands:
    """Hands on the waist, damped by half of what is critical for a node of mean mass."""
    mass = stepper.shell.comm.allreduce(stepper.mass.sum()) / len(stepper.shell.surface.points)
    damping = 0.5 * np.sqrt(dressing.grip * mass)
    return stepper.add(Hands("waist", places, dressing.grip, damping))


def change_hands(
    stepper: Newmark, belt: Belt, hands: Hands, tension: float, dressing: Dressing, watch: Watch
) -> None:
    """Tighten the belt to its tension [N], then let go of the waist."""
    begin = stepper.time

    def tighten() -> None:
        since = stepper.time - begin
        belt.tension = tension * min(1.0, since / dressing.belt)
        hands.hold = min(1.0, max(0.0, 1 - (since - dressing.belt) / dressing.release))
        watch("belt", stepper)

    advance_watched(stepper, begin + dressing.belt + dressing.release, 0.01, tighten)
    belt.tension = tension
    stepper.remove(hands)


def _lift(start: float, seconds: float, height: float) -> Callable:
    """Shift and velocity from `height` below to 0, along the polynomial of least jerk."""

    def places(time: float) -> tuple[np.ndarray, np.ndarray]:
        s = min(max((time - start) / seconds, 0.0), 1.0)
        rise = s**3 * (10 - 15 * s + 6 * s * s) - 1
        rate = 30 * s * s * (1 - s) ** 2 / seconds
        up = np.array([0.0, 0.0, height])
        return rise * up, rate * up

    return places
