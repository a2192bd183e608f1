"""The fork of a pair of trousers: where one ring about the torso becomes two rings about the legs.

On the left half (y >= 0) the rings of the torso are half rings, front to back. The last of them,
the groin line, and the bridge, which runs in the plane y = 0 from its back end through the fork to
its front end, make the first ring of the leg. Six cells meet at either end of the bridge and four
everywhere else, so corners are near 60 degrees there and square elsewhere; one point in the middle
of the fork would have eight.

The surface is a loft of the given rings, waist to hem, by cubic Hermite curves with the slopes of
monotone cubics. At the bridge it starts horizontally to the side, so that the two legs join in a
rounded edge. Constants below are proportions of a draft chosen for good cells, not measures.
"""
# SPDX-License-Identifier: LGPL-3.0-or-later

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from .ring import bezier, count_cells, polygon_length, spread

# Ends of the bridge: distance from the fork over the depth of the hip ring, height above the fork
# over the height of the hip line above it; front, then back, which is longer on a person.
_REACH, _HEIGHT = (0.73, 0.82), (0.33, 0.43)
_GROIN_HEIGHT = 0.57  # of the groin line at the side seam, over the height of the hip line
_STEEPNESS = np.radians(62.0)  # of the front and back seam where the bridge begins
_SWING = np.radians(30.0)  # of the leg's rows there, downwards from the sideways direction
_REACH_OF_ENDS = 0.4  # part of the groin line, from each end, that the ends of the bridge pull in
_START = 0.8  # length of the slopes at the bridge over the distance to the thigh
_FINER = 1.15  # number of cells along the bridge over that of equal cells
_ROUNDING = (0.3, 0.4)  # handles of the bridge's Bezier curves at its end and at the fork


class Loft(NamedTuple):
    """Rows of points on the left half of the trousers.

    torso (rows, half + 1, 3) front to back, leg (rows, half + bridge, 3); the first ring of the leg
    is the last half ring of the torso followed by the inner points of the bridge, back to front.
    """

    torso: np.ndarray
    leg: np.ndarray


def bridge_ends(hip_depth: float, hip_height: float, fork_height: float) -> np.ndarray:
    """Front and back end of the bridge and the fork, (3, 3) in m."""
    rise = hip_height - fork_height
    front, back = (
        (sign * reach * hip_depth, 0.0, fork_height + height * rise)
        for sign, reach, height in zip((1.0, -1.0), _REACH, _HEIGHT)
    )
    return np.array([front, back, (0.0, 0.0, fork_height)])


def _upward(sign):
    """Direction up the front (+1) or back (-1) seam at the end of the bridge."""
    return np.array([sign * np.cos(_STEEPNESS), 0.0, np.sin(_STEEPNESS)])


def _half_bridge(end, fork, sign):
    reach = np.linalg.norm(end - fork)
    first, last = (part * reach for part in _ROUNDING)
    side = np.array([sign, 0.0, 0.0])
    return bezier([end, end - first * _upward(sign), fork + last * side, fork])


def bridge_cells(ends: np.ndarray, cell_size: float) -> int:
    """Number of segments of the bridge, an even number, so that the fork is a point of the mesh."""
    front, back, fork = ends
    halves = [_half_bridge(end, fork, sign)[0] for end, sign in ((front, 1.0), (back, -1.0))]
    length = sum(polygon_length(half(np.linspace(0.0, 1.0, 201))) for half in halves)
    return 2 * count_cells(_FINER * 0.5 * length, cell_size)


def _bridge(ends, count):
    """Points and unit tangents of the bridge from back to front, two of (count + 1, 3)."""
    points, tangents = [], []
    for end, sign in ((ends[1], -1.0), (ends[0], 1.0)):
        curve, slope = _half_bridge(end, ends[2], sign)
        t = spread(curve, count // 2)
        points.append(curve(t)[:: -int(sign)])
        tangents.append(-sign * slope(t)[:: -int(sign)])
    points, tangents = (np.concatenate([back, front[1:]]) for back, front in (points, tangents))
    return points, tangents / np.linalg.norm(tangents, axis=1, keepdims=True)


def _evenly(columns, count):
    """Rows (count + 1, k, 3) at equal arc lengths along each of k columns, a spline of one piece.

    Columns that leave the fork sideways turn down at once: equal steps of the spline's parameter
    would put the first row so close below the bridge that it bounds the explicit step.
    """
    start, end = columns.x
    out = np.empty((count + 1, *columns(start).shape))
    for k in range(out.shape[1]):

        def column(share, k=k):
            return columns(start + share * (end - start))[:, k]

        out[:, k] = column(spread(column, count))
    return out


def loft(
    waist: np.ndarray,
    hip: np.ndarray,
    thigh: np.ndarray,
    knee: np.ndarray,
    hem: np.ndarray,
    ends: np.ndarray,
    cell_size: float,
) -> Loft:
    """Rows of points through five rings and the fork.

    Parameters
    ----------
    waist, hip : (half + 1, 3) left halves of rings, front to back, in m.
    thigh, knee, hem : (half + bridge, 3) rings of the left leg, in m; the first half + 1 points
        continue the columns of the hip, the others belong to the bridge, back to front.
    ends : (3, 3) from `bridge_ends`.
    cell_size : along the columns, in m.

    Returns
    -------
    Loft, with a row on each of the five rings.
    """
    from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

    half = len(hip) - 1
    bridge, along = _bridge(ends, len(thigh) - half)
    fork_height = ends[2, 2]
    groin = fork_height + _GROIN_HEIGHT * (hip[0, 2] - fork_height)
    levels = -np.array([waist[0, 2], hip[0, 2], groin, thigh[0, 2], knee[0, 2], hem[0, 2]])
    column = np.stack([waist, hip, thigh[: half + 1], knee[: half + 1], hem[: half + 1]])
    smooth = PchipInterpolator(np.delete(levels, 2), column)
    slopes = smooth.derivative()

    pull, free = _pull_of_ends(half)
    groin_line = smooth(levels[2])
    groin_line += pull[0] ** 3 * (ends[0] - groin_line[0])
    groin_line += pull[1] ** 3 * (ends[1] - groin_line[-1])
    top = np.concatenate([groin_line, bridge[1:-1]])
    distance = np.linalg.norm(thigh - top, axis=1, keepdims=True) / (levels[3] - levels[2])
    groin_slope = free * slopes(levels[2])
    start = _bridge_slopes(along, np.concatenate([distance[half:], distance[:1]]))

    # Slopes above the groin line: of the smooth loft, turning into the seams at the ends.
    drop = levels[2] - levels[1]
    above = groin_slope.copy()
    for weight, sign, end, corner in zip(pull, (1.0, -1.0), ends, hip[[0, -1]]):
        above -= weight**2 * _upward(sign) * np.linalg.norm(end - corner) / drop
    below = groin_slope + pull[0] ** 2 * start[-1] + pull[1] ** 2 * start[0]
    below = np.concatenate([below, start[1:-1]])

    # At the thigh the columns of the bridge know nothing of the torso.
    down = PchipInterpolator(levels[3:], np.stack([thigh, knee, hem])).derivative()(levels[3:])
    weight = np.concatenate([free, np.zeros((len(bridge) - 2, 1))])
    torso_slope = np.concatenate([slopes(levels[3]), down[0, half + 1 :]])
    down[0] = weight * torso_slope + (1.0 - weight) * down[0]
    # Shorter columns arrive more slowly, which keeps their rows evenly spaced.
    arrival = down[0] / np.linalg.norm(down[0], axis=1, keepdims=True) * distance

    lengths = -np.diff([waist[0, 2], hip[0, 2]])[0], 0.5 * (drop + np.linalg.norm(ends[0] - hip[0]))
    torso = _rows(
        levels[:3],
        np.stack([waist, hip, groin_line]),
        np.stack([*slopes(levels[:2]), above]),
        [count_cells(length, cell_size) for length in lengths],
    )
    middle = 0.5 * (distance.max() + distance.min()) * (levels[3] - levels[2])
    crotch = _evenly(
        CubicHermiteSpline(levels[2:4], np.stack([top, thigh]), np.stack([below, arrival])),
        count_cells(middle, cell_size, least=2),
    )
    leg = _rows(
        levels[3:],
        np.stack([thigh, knee, hem]),
        down,
        [count_cells(length, cell_size) for length in np.diff(levels[3:])],
    )
    torso[:, [0, -1], 1] = 0.0
    crotch[0, half:, 1] = 0.0
    crotch[0, 0, 1] = 0.0
    return Loft(torso, np.concatenate([crotch, leg[1:]]))


def _pull_of_ends(half):
    """How much each end of the bridge pulls on the groin line, 0 to 1, and what is left free.

    Columns (half + 1, 1) along the groin line: two of pull, one of the rest, in squares.
    """
    place = np.linspace(0.0, 1.0, half + 1)[:, None]
    pull = [np.clip(1.0 - s / _REACH_OF_ENDS, 0.0, 1.0) for s in (place, 1.0 - place)]
    return pull, 1.0 - pull[0] ** 2 - pull[1] ** 2


def _bridge_slopes(along, distance):
    """Slopes (n, 3) of the leg's columns at the bridge: sideways, and down along it to its ends.

    along : (n, 3) unit tangents of the bridge; distance : (n, 1) to the thigh, over the drop
    """
    lean = np.cos(np.pi * np.linspace(0.0, 1.0, len(along)))[:, None]
    start = np.cos(_SWING) * np.array([0.0, 1.0, 0.0]) + np.sin(_SWING) * lean * along
    start *= _START * distance
    return start


def _rows(spans, points, tangents, counts):
    """Rows on the cubic Hermite curves through `points`, counts[i] steps in the i-th span."""
    from scipy.interpolate import CubicHermiteSpline

    parts = [np.linspace(*span, n + 1)[:-1] for span, n in zip(pairwise(spans), counts)]
    return CubicHermiteSpline(spans, points, tangents)(np.append(np.concatenate(parts), spans[-1]))
