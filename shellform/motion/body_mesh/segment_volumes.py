# SPDX-License-Identifier: LGPL-3.0-or-later
"""Volumes of the segments of a skin, whose cuts through the flesh are carried with the skin.

Where a segment ends is a matter of definition. Here a cut is a disk of flesh that keeps its
material: at rest a cone from the rim, where owners of triangles change, to the middle of that rim;
its inner points have weights between those of rim and middle, and move as skin of these weights
does. Where the rim is pressed flat, what is pressed away fades towards the middle. The first
segment, the trunk, has what the others leave of the whole.
"""

from collections.abc import Callable

import numpy as np

from contact.body.segments import Pose
from contact.body.skinned_surface import SkinnedSurface
from meshes.topology import boundary_segments, chain

RINGS = 4  # of a cut


class SegmentVolumes:
    """What the volumes of a skin's segments are measured with.

    Parameters
    ----------
    skin : SkinnedSurface
    rest : (n, 3), places of its vertices where it was bound, standing [m]
    pose : function (t, out Pose) of its segments, as the skin has it
    """

    def __init__(self, skin: SkinnedSurface, rest: np.ndarray, pose: Callable[[float, Pose], Pose]):
        self.skin = skin
        self._cuts: list[tuple[int, np.ndarray, int]] = []
        m = len(skin.names)
        table = np.zeros((len(rest), m))
        np.put_along_axis(table, skin.which, skin.weights, axis=1)
        points, weights, count = [], [], 0
        for segment in range(1, m):
            for rim in _rims(skin.triangles[skin.owners == segment]):
                long = np.linalg.norm(rest[rim] - np.roll(rest[rim], -1, axis=0), axis=1)
                share = (long + np.roll(long, 1)) / (2.0 * long.sum())
                middle, follow = share @ rest[rim], share @ table[rim]
                for k in range(RINGS + 1):
                    part = k / RINGS
                    points.append((1.0 - part) * rest[rim] + part * middle)
                    weights.append((1.0 - part) * table[rim] + part * follow)
                self._cuts.append((segment, rim, count))
                count += (RINGS + 1) * len(rim)
        none = np.zeros((0, 3), np.int64)
        self._inner = SkinnedSurface(
            np.concatenate(points), none, np.concatenate(weights), skin.names, pose, skin.bound
        )
        self._places = np.empty((count, 3))

    def __call__(self, t: float, x: np.ndarray) -> np.ndarray:
        """Volumes (m,) [m^3] at time t [s], where the vertices of the skin are at x (n, 3) [m]."""
        skin, carried = self.skin, self._inner.positions(t, self._places)
        out = np.zeros(len(skin.names))
        for segment in range(1, len(out)):
            out[segment] = _under(x, skin.triangles[skin.owners == segment])
        for segment, rim, first in self._cuts:
            n = len(rim)
            rings = carried[first : first + (RINGS + 1) * n].reshape(RINGS + 1, n, 3)
            fading = np.linspace(1.0, 0.0, RINGS + 1)[:, None, None]
            disk = (rings + fading * (x[rim] - rings[0])).reshape(-1, 3)
            out[segment] -= _under(disk, _disk(n))
        out[0] = _under(x, skin.triangles) - out[1:].sum()
        return out


def _under(x, triangles):
    """Signed volume [m^3] between triangles and the origin."""
    a, b, c = (x[triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def _rims(triangles):
    """Closed lines of vertices around triangles, these on their left."""
    edges = chain(boundary_segments(triangles))
    ends = np.flatnonzero(edges[1:, 0] != edges[:-1, 1]) + 1
    return [loop[:, 0] for loop in np.split(edges, ends)] if len(edges) else []


def _disk(n):
    """Triangles of RINGS rings of n points each and the middle, the rim running as given."""
    i = np.arange(n)
    following = (i + 1) % n
    rows = []
    for k in range(RINGS):
        a, b, c, d = k * n + i, k * n + following, (k + 1) * n + following, (k + 1) * n + i
        rows += [np.column_stack([a, b, c]), np.column_stack([a, c, d])]
    return np.concatenate(rows)
