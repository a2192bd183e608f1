# SPDX-License-Identifier: LGPL-3.0-or-later
"""Putting a garment on a body of triangles, which grows inside it (growing.py).

(a) The garment hangs as it was made around a thin body, held by its waist edge, and what sewing has
stretched comes to rest. (b) The body grows. (c) A belt draws the waist together while the hands let
go. Cloth meets cloth all the time where the scene asks for it, and has no layer to pass.
"""

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from contact.body.skinned_surface import SkinnedSurface
from shellform.dynamics.explicit import Newmark
from shellform.motion.wearer import Wearer

from .belt import Belt
from .dress import change_hands, hands_at_waist
from .growing import Growing, shrunk_for
from .procedure import Dressing, Watch, unwatched
from .settings import borrowed
from .settle import advance_watched
from .shoulders import RELEASED, STILL

GROWN = 0.8  # s, in which a body grows


def dress_skin(
    stepper: Newmark,
    skin: SkinnedSurface,
    wearer: Wearer,
    tension: float,
    meet: Callable[[Any], Any],
    dressing: Dressing | None = None,
    watch: Watch | None = None,
) -> tuple[Belt, float]:
    """Dress a body of triangles; its contact, with the grown body, is removed at the end.

    Parameters
    ----------
    stepper : on a surface that lies as it was made, around the wearer, with the edge 'waist'; it
        has no contact
    skin : of the wearer, who starts from rest; tension : of the belt [N]
    meet : adds the contact with a surface to the stepper; returns it
    dressing : Dressing or None
    watch : called with the stages 'laid', 'grow', 'grown', 'belt', 'belted'

    Returns
    -------
    belt : Belt, which stays; seconds it took

    Raises
    ------
    ValueError for a garment that does not go around the body
    """
    dressing = Dressing() if dressing is None else dressing
    watch = unwatched if watch is None else watch
    shrunk = shrunk_for(skin, wearer, stepper.shell.surface)
    seconds = RELEASED + GROWN + dressing.belt + dressing.release
    begin = wearer.start - seconds
    grows = begin + RELEASED
    contact = meet(Growing(skin, wearer, grows, GROWN, shrunk))
    friction = contact.friction
    try:
        with borrowed(stepper), warnings.catch_warnings():
            # feet pressed flat are no shape that anyone could mend
            warnings.filterwarnings("ignore", "over .* the normal turns by more than 60 degrees")
            stepper.time, stepper.drag = begin, STILL
            contact.friction = dressing.slip
            hands = hands_at_waist(stepper, dressing, lambda time: (np.zeros(3), np.zeros(3)))
            watch("laid", stepper)
            stepper.advance(grows)
            stepper.drag = dressing.drag
            advance_watched(stepper, grows + GROWN, 0.05, lambda: watch("grow", stepper))
            watch("grown", stepper)
            contact.friction = friction
            belt = stepper.add(Belt("waist"))
            change_hands(stepper, belt, hands, tension, dressing, watch)
            watch("belted", stepper)
    finally:
        stepper.remove(contact)
    return belt, seconds
