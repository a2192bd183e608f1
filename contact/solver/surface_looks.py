# SPDX-License-Identifier: LGPL-3.0-or-later
"""What nodes keep from step to step of how far a moving surface of triangles is.

A look says how far a node was from something, in a frame that goes along with the body as cloth
does, so that ways are short: it holds until the node and the surface both have gone as far.

A followed node that is too far from its sheet for this step has room: part of its distance, and
where it is seen from the triangle under it. Until the node has moved, and the triangle turned and
stretched, by that much, looked at from the end of a step, nothing else is asked; and nothing at all
before both may have gone as far as what is left.
"""

from typing import Any

import numpy as np

from contact.kernel import kernel

ROOM = 10  # numbers kept: room [m]; from a corner of the triangle the node and the others (9) [m]


@kernel(makes_arrays=False)
def set_look(
    look: np.ndarray, i: int, x0: float, x1: float, x2: float, left: float, work: Any
) -> None:
    """Let node i be `left` [m] from something at x at the start of the step."""
    o = work.frame
    look[0, i], look[1, i], look[2, i] = x0 - o[0], x1 - o[1], x2 - o[2]
    look[3, i], look[4, i] = left, work.path


@kernel(makes_arrays=False)
def set_look_ahead(
    look: np.ndarray, i: int, x0: float, x1: float, x2: float, left: float, work: Any
) -> None:
    """The same at the end of the step."""
    o, s = work.frame, work.shift
    look[0, i], look[1, i], look[2, i] = x0 - o[0] - s[0], x1 - o[1] - s[1], x2 - o[2] - s[2]
    look[3, i], look[4, i] = left, work.path + work.motion


@kernel(makes_arrays=False)
def still_left(look: np.ndarray, i: int, x0: float, x1: float, x2: float, work: Any) -> float:
    """What a look leaves [m] of node i at x for the step, the surface's motion taken off."""
    o = work.frame
    d0, d1, d2 = x0 - o[0] - look[0, i], x1 - o[1] - look[1, i], x2 - o[2] - look[2, i]
    gone = np.sqrt(d0 * d0 + d1 * d1 + d2 * d2) + (work.path - look[4, i])
    return look[3, i] - gone - work.motion


@kernel(makes_arrays=False)
def keep_room(
    mesh: Any, placed: Any, t: int, x0: float, x1: float, x2: float, room: float, kept: np.ndarray
) -> None:
    """Fill what is kept (ROOM,) of a node at x over triangle t that has `room` [m] before it."""
    v, corners = placed.vertices, mesh.triangles
    i, j, k = corners[t, 0], corners[t, 1], corners[t, 2]
    kept[0] = room
    kept[1], kept[2], kept[3] = x0 - v[i, 0], x1 - v[i, 1], x2 - v[i, 2]
    kept[4], kept[5], kept[6] = v[j, 0] - v[i, 0], v[j, 1] - v[i, 1], v[j, 2] - v[i, 2]
    kept[7], kept[8], kept[9] = v[k, 0] - v[i, 0], v[k, 1] - v[i, 1], v[k, 2] - v[i, 2]


@kernel(makes_arrays=False)
def room_left(
    mesh: Any, placed: Any, t: int, x0: float, x1: float, x2: float, kept: np.ndarray
) -> float:
    """What is left [m] of the room of a node that is at x now, seen from the triangle."""
    v, corners = placed.vertices, mesh.triangles
    i, j, k = corners[t, 0], corners[t, 1], corners[t, 2]
    o0, o1, o2 = v[i, 0], v[i, 1], v[i, 2]
    d0, d1, d2 = x0 - o0 - kept[1], x1 - o1 - kept[2], x2 - o2 - kept[3]
    e0, e1, e2 = v[j, 0] - o0 - kept[4], v[j, 1] - o1 - kept[5], v[j, 2] - o2 - kept[6]
    f0, f1, f2 = v[k, 0] - o0 - kept[7], v[k, 1] - o1 - kept[8], v[k, 2] - o2 - kept[9]
    gone = np.sqrt(d0 * d0 + d1 * d1 + d2 * d2)
    turned = np.sqrt(e0 * e0 + e1 * e1 + e2 * e2) + np.sqrt(f0 * f0 + f1 * f1 + f2 * f2)
    return kept[0] - gone - turned
