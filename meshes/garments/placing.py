# SPDX-License-Identifier: LGPL-3.0-or-later
"""How a garment from a file is turned, read off its shape: waist, up, left and right, front.

x is forward, y to the wearer's left, z up, the floor z = 0. The waist is the opening unlike the two
others, or the smaller of two; it is above the hems, the legs are beside each other, and the back of
the waist is higher than its front, as trousers are cut.
"""

from __future__ import annotations

import numpy as np

from meshes.repair import boundary_loops
from meshes.surface import Surface
from meshes.validity import MeshError

from .ring import names_of, polygon_length

_OPENING = 0.2  # of the largest girth; smaller loops are buttonholes
_UNLIKE = 1.05  # ratio of two girths that tells a waist from a hem
_UPRIGHT = np.cos(np.radians(40.0))
_BESIDE = np.radians(20.0)  # legs turned by less are left as they are
_BACK_RISE = 0.008  # m by which the back of a waist is higher than its front, at least


def openings(surface: Surface) -> list[np.ndarray]:
    """Boundary loops that a limb or a waist goes through."""
    loops = boundary_loops(surface)
    girths = [polygon_length(surface.points[np.append(loop, loop[0])]) for loop in loops]
    return [loop for loop, girth in zip(loops, girths) if girth > _OPENING * max(girths)]


def waist_by_shape(surface: Surface) -> np.ndarray:
    """The loop (k,) of points that can only be the waist.

    Raises
    ------
    MeshError : if no opening or several could be.
    """
    loops = openings(surface)
    girths = np.array([polygon_length(surface.points[np.append(loop, loop[0])]) for loop in loops])
    if len(loops) == 1:
        return loops[0]
    if len(loops) == 2 and girths.max() > _UNLIKE * girths.min():
        return loops[int(girths.argmin())]
    if len(loops) == 3:
        # the hems are the two that are most alike
        unlike = [abs(np.log(girths[k - 2] / girths[k - 1])) for k in range(3)]
        return loops[int(np.argmin(unlike))]
    known = names_of(surface.edges)
    shirt = ""
    if len(loops) > 3:
        shirt = (
            ", as a shirt has, which hangs on the shoulders: of these sewing patterns alone are "
            "put on, with hangs = 'shoulders' under [garment]. For others"
        )
    raise MeshError(
        f"{surface.source}: there is no edge 'waist' (edges: {known}), and its {len(loops)} "
        f"openings do not tell which is the waist{shirt}: name it or give waist='highest', the "
        "name of an edge or a locator."
    )


def upright(surface: Surface, waist: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """Rotation (3, 3) that stands the garment up, its front forward, and what was found, in words.

    waist : (k,) points of the waist's loop. MeshError if the garment leans too far to tell.
    """
    points = surface.points
    hems = [loop for loop in openings(surface) if not np.array_equal(np.sort(loop), np.sort(waist))]
    turn = np.eye(3)
    found: list[str] = []
    if not hems:
        return turn, found
    middles = [points[loop].mean(axis=0) for loop in hems]
    up = points[waist].mean(axis=0) - np.mean(middles, axis=0)
    axis = int(np.abs(up).argmax())
    if abs(up[axis]) < _UPRIGHT * np.linalg.norm(up):
        raise MeshError(
            f"{surface.source}: the way from hems to waist, {np.round(up, 2).tolist()} m, leans "
            "too far from all axes to tell what is up; turn the garment, by turn_deg under "
            "[garment] or surface.transform(rotation=...)."
        )
    if axis != 2 or up[2] < 0.0:
        # axes change places in a circle, so that the front of a drawing with y up is its z
        turn = np.eye(3)[[(axis + 1) % 3, (axis + 2) % 3, axis]]
        if up[axis] < 0.0:
            turn = np.diag([1.0, -1.0, -1.0]) @ turn
        found.append(f"{'-' if up[axis] < 0.0 else ''}{'xyz'[axis]} is up")
    if len(hems) != 2:
        return turn, found
    names = [f"{side}_hem" for side in ("left", "right")]
    named = all(name in surface.edges for name in names)
    if named:
        left, right = (points[np.unique(surface.edges[name])].mean(axis=0) for name in names)
    else:
        left, right = middles
    across = turn @ (left - right)
    if not named and across[1] < 0.0:
        across = -across
    angle = np.arctan2(across[0], across[1])  # about z, from the legs' line to y
    quarter = np.radians(90.0) * np.round(angle / np.radians(90.0))
    if abs(angle) > _BESIDE:
        turn = _about_z(quarter if abs(angle - quarter) < 0.5 * _BESIDE else angle) @ turn
        found.append(f"the legs lie side by side after {np.degrees(angle):.0f} degrees about z")
    if not named:
        line = (points[waist] - points[waist].mean(axis=0)) @ turn.T
        rise = 2.0 * np.abs(line[:, 0]).max() * (line[:, 0] @ line[:, 2]) / np.sum(line[:, 0] ** 2)
        if rise > _BACK_RISE:
            turn = _about_z(np.pi) @ turn
            found.append("the higher side of the waist is the back")
        elif found and rise > -_BACK_RISE:
            found.append("front and back look alike and are taken as they come")
    return turn, found


def _about_z(angle: float) -> np.ndarray:
    c, s = np.round([np.cos(angle), np.sin(angle)], 15)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
