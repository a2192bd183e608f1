# SPDX-License-Identifier: LGPL-3.0-or-later
"""A body brought to the standing wearer: each segment by an affine map, blended by the weights.

The map of a thigh or shank sends the centres of its joints to the wearer's, stretches it along
their line and scales it across by the stature. Trunk and feet stay upright, as the wearer stands
upright on flat soles, whatever the markers of a capture say of the tilt of pelvis and shoes. Where
the wearer's hip centres are closer than the body's, the flesh keeps its place: the centre is taken
to be elsewhere in it. Thighs that would pass the middle plane are pressed flat there, by the map of
`contact.body.flesh`.
"""

from collections.abc import Mapping

import numpy as np

from contact.body.flesh import kept_on_side
from contact.body.segment_frame import pose_from_markers
from shellform.motion.proportions import ANKLE, LEG, SIGN, STATURE
from shellform.motion.recording import SEGMENTS, SIDES

from .rigging import weights_of
from .surface import BodySurface

UP = np.array([0.0, 0.0, 1.0])
MIDDLE = 0.006  # from the middle plane, within which thighs are pressed flat [m]
ROOM = 0.003  # from there, that is left of it for cloth [m]


def frame_of(heading: np.ndarray) -> np.ndarray:
    """Rows forward, left, up of one who stands upright and looks along `heading` (3,)."""
    ahead = np.array([heading[0], heading[1], 0.0])
    ahead /= np.linalg.norm(ahead)
    return np.stack([ahead, np.cross(UP, ahead), UP])


def placed(surface: BodySurface, standing: Mapping[str, np.ndarray], stature: float) -> BodySurface:
    """The surface on a standing wearer.

    Parameters
    ----------
    standing : dict, segment -> rows J1, J2, M (3, 3) [m], as `standing_of` gives
    stature : of the wearer [m]

    Returns
    -------
    BodySurface in the world, its landmarks the wearer's
    """
    scale = stature / surface.stature
    hips = {side: standing[f"{side}_thigh"][0] for side in SIDES}
    middle = 0.5 * (hips["right"] + hips["left"])
    body = frame_of(np.cross(hips["left"] - hips["right"], UP))
    weights = weights_of(surface)
    sole = surface.points[:, 2].min()
    marks = dict(surface.landmarks)
    maps = {"pelvis": (surface.middle, middle, scale * body.T)}
    landmarks = {}
    for side in SIDES:
        apart = SIGN[side] * np.linalg.norm(hips[side] - middle) / scale
        marks[f"{side}_hip"] = surface.middle + apart * np.array([0.0, 1.0, 0.0])
        for part, above, below in (("thigh", "hip", "knee"), ("shank", "knee", "ankle")):
            segment = f"{side}_{part}"
            maps[segment] = _limb(
                marks[f"{side}_{above}"], marks[f"{side}_{below}"], standing[segment], side, scale
            )
            landmarks[f"{side}_{above}"] = standing[segment][0]
        landmarks[f"{side}_ankle"] = standing[f"{side}_shank"][1]
        maps[f"{side}_foot"] = _foot(marks[f"{side}_ankle"], sole, side, standing, body, scale)
    points = np.zeros_like(surface.points)
    for k, segment in enumerate(SEGMENTS):
        centre, to, A = maps[segment]
        points += weights[:, [k]] * (to + (surface.points - centre) @ A.T)
    own = (surface.points - surface.middle)[:, 1]
    points = _apart(points, own, surface.points[:, 2] < surface.middle[2], middle, body[1], scale)
    return BodySurface(points, surface.triangles, landmarks, stature, surface.source)


def _limb(top, bottom, points, side, scale):
    """Centre, its image and the linear part (3, 3) of the map of a thigh or shank."""
    outward = np.array([0.0, SIGN[side], 0.0])
    _, own = pose_from_markers(top, bottom, top + outward)
    _, axes = pose_from_markers(*points)
    along = np.linalg.norm(points[1] - points[0]) / np.linalg.norm(bottom - top)
    return top, points[0], axes.T @ np.diag([along, scale, scale]) @ own


def _foot(ankle, sole, side, standing, body, scale):
    """The same of a foot: its sole as far below the ankle as a walker's shoe is."""
    points = standing.get(f"{side}_foot")
    frame = body if points is None else frame_of(points[1] - points[0])
    legs = [standing[f"{s}_{part}"] for s in SIDES for part in ("thigh", "shank")]
    leg = 0.5 * sum(np.linalg.norm(rows[1] - rows[0]) for rows in legs)
    tall = ANKLE / LEG * leg / (ankle[2] - sole)
    return ankle, standing[f"{side}_shank"][1], frame.T @ np.diag([scale, scale, tall])


def apart_points(points: np.ndarray, surface: BodySurface) -> np.ndarray:
    """Points (n, 3) with those below the hips on the side of the middle plane where they were.

    surface : a standing body, with the points as they were
    """
    left = surface.left
    own = (surface.points - surface.middle) @ left
    low = surface.points[:, 2] < surface.middle[2]
    return _apart(points, own, low, surface.middle, left, surface.stature / STATURE)


def _apart(points, own, low, middle, left, scale):
    """How near a point may come unpressed is how near it was, `own` (n,), at most MIDDLE."""
    out = points.copy()
    for sign in (1.0, -1.0):
        which = low & (sign * own > 0)
        margin = np.minimum(0.9 * sign * own[which], MIDDLE) * scale
        room = np.minimum(0.8 * margin, ROOM * scale)
        aside = sign * ((points[which] - middle) @ left)
        rows = zip(aside, margin, room, strict=True)
        pressed = np.array([kept_on_side(*row)[0] for row in rows])
        out[which] += (sign * (pressed - aside))[:, None] * left
    return out
