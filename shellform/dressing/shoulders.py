# SPDX-License-Identifier: LGPL-3.0-or-later
"""Putting on what hangs on the shoulders: sewn around raised arms, let down with them.

(a) The shirt lies around trunk and arms as it was sewn. (b) The wearer lets the arms down, and the
cloth, which slides easily meanwhile, comes to hang. (c) With the friction of the scene everything
settles (settle.py). There is no belt: at rest the body carries the weight of the cloth.
"""

from shellform.contact_coupling.contact import require_contact
from shellform.dynamics.explicit import Newmark

from .procedure import Dressing, Watch, unwatched
from .settings import borrowed
from .settle import advance_watched

STEP = 0.05  # s, between looks of the watcher
STILL, RELEASED = 300.0, 0.1  # drag [1/s] that keeps what sewing has stretched from snapping; [s]


def let_down(
    stepper: Newmark, dressing: Dressing | None = None, watch: Watch | None = None
) -> float:
    """Follow the wearer in contact, who lets the arms down; the clock ends when they are.

    Parameters
    ----------
    stepper : Newmark on cloth that lies on the wearer; its contact is with one who lets the arms
        down (`shellform.motion.arm_lowering`), and stands still otherwise
    watch : called with the stages 'sewn', 'lower', 'lowered'

    Returns
    -------
    seconds it took
    """
    dressing = Dressing() if dressing is None else dressing
    watch = unwatched if watch is None else watch
    contact = require_contact(stepper, "dressing")
    begin, end = contact.body.start, contact.body.end
    with borrowed(stepper):
        stepper.time, stepper.drag = begin, STILL
        contact.friction = dressing.slip
        watch("sewn", stepper)
        stepper.advance(begin + RELEASED)
        stepper.drag = dressing.drag
        advance_watched(stepper, end, STEP, lambda: watch("lower", stepper))
        watch("lowered", stepper)
    return float(end - begin)
