# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which parts of the body a garment can come to: the others are not built, or not asked.

A garment hangs on its belt, so what is farther from the waist than its cloth is long is out of
reach: the feet under shorts, unless a step lifts them to where the hem can be. The whole motion is
looked at, with more stretch and slip than a garment has.
"""

import numpy as np

import meshes
from contact.geometry.ellipsoid import foot_and_normal
from shellform.motion.recording import SIDES
from shellform.motion.wearer import Wearer

STRETCHED, SLIPPED = 0.2, 0.1  # of cloth; of a belt [m]


def reachable(wearer: Wearer, surface: meshes.Surface, belt: float) -> np.ndarray:
    """Ellipsoids (m,) bool that a garment held by its belt can come to in the whole motion.

    No point of the garment gets farther from the waist edge than along the cloth, stretched by
    STRETCHED; the edge stays where it was put on the pelvis, or within SLIPPED of that. Without a
    belt (tension `belt` [N]) a garment may fall off, and all ellipsoids count; what hangs on the
    shoulders stays on the thorax, by its edge 'neck'.
    """
    edge, name = ("neck", "thorax") if "thorax" in wearer.names else ("waist", "pelvis")
    if belt == 0 and edge == "waist":
        return np.ones(len(wearer.names), bool)
    k = wearer.index(name)
    pose = wearer.new_pose(wearer.start)
    held = surface.points[np.unique(surface.edges[edge])]
    held = (held - pose.centres[k]) @ pose.axes[k].T
    limit = (1 + STRETCHED) * along_cloth(surface, edge).max() + SLIPPED
    near = np.zeros(len(wearer.names), bool)
    for time in wearer.recording.times:
        pose = wearer.pose(time, pose)
        at = pose.centres[k] + held @ pose.axes[k]
        for b in np.flatnonzero(~near):
            y = (at - pose.centres[b]) @ pose.axes[b].T
            radii = wearer.radii[b]
            # neither is more than the distance: to the ball around, to the scaled unit sphere
            ball = np.linalg.norm(y, axis=1) - radii.max()
            scaled = (np.linalg.norm(y / radii, axis=1) - 1) * radii.min()
            if np.maximum(ball, scaled).min() <= limit:
                near[b] = any(foot_and_normal(*point, *radii)[0] <= limit for point in y)
    return near


def along_cloth(surface: meshes.Surface, edge: str) -> np.ndarray:
    """Length (n,) [m] from a named edge to every point, along sides and diagonals of the cells.

    Never less than the length along the surface itself; infinite on pieces without the edge.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import dijkstra

    n, width = len(surface.points), surface.cells.shape[1]
    pairs = [surface.cells[:, [i, j]] for i in range(width) for j in range(i)]
    pairs = np.unique(np.sort(np.concatenate(pairs), axis=1), axis=0)
    long = np.linalg.norm(np.diff(surface.points[pairs], axis=1)[:, 0], axis=1)
    graph = coo_matrix((long, pairs.T), shape=(n, n)).tocsr()
    return dijkstra(graph, False, indices=np.unique(surface.edges[edge]), min_only=True)


def reach_of(surface: meshes.Surface, wearer: Wearer) -> np.ndarray:
    """Ellipsoids that every node can touch, (n,) int for `VelocityCorrection(allowed=...)`.

    A trouser leg does not meet the other leg of the wearer: between them is the other trouser leg,
    and cloth does not meet cloth here.
    """
    allowed = np.full(len(surface.points), wearer.mask(wearer.names))
    if not {"right_hem", "left_hem"} <= set(surface.edges):
        return allowed
    parts = meshes.regions(surface)
    for side, other in (SIDES, SIDES[::-1]):
        far = [n for n, s in zip(wearer.names, wearer.carriers, strict=True) if other in s]
        allowed[parts[f"{side}_leg"]] &= ~wearer.mask(far)
    return allowed
