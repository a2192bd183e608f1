# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where a closed surface of triangles passes through itself: edges that cross triangles.

Every edge goes down the tree of boxes; triangles that share a corner with it do not count.
(T. Moeller and B. Trumbore, J. Graphics Tools 2(1), 1997, for an edge and a triangle.)
"""

from typing import Any

import numpy as np

from contact.kernel import kernel

from .closest import STACK
from .placed import new_placed, refit
from .topology import mesh_of


@kernel(makes_arrays=False)
def _crosses(v, i, j, a, b, c):
    """Whether the edge of vertices i and j crosses the triangle of a, b, c."""
    d0, d1, d2 = v[j, 0] - v[i, 0], v[j, 1] - v[i, 1], v[j, 2] - v[i, 2]
    e0, e1, e2 = v[b, 0] - v[a, 0], v[b, 1] - v[a, 1], v[b, 2] - v[a, 2]
    f0, f1, f2 = v[c, 0] - v[a, 0], v[c, 1] - v[a, 1], v[c, 2] - v[a, 2]
    p0, p1, p2 = d1 * f2 - d2 * f1, d2 * f0 - d0 * f2, d0 * f1 - d1 * f0
    volume = e0 * p0 + e1 * p1 + e2 * p2
    if volume == 0.0:
        return False
    s0, s1, s2 = v[i, 0] - v[a, 0], v[i, 1] - v[a, 1], v[i, 2] - v[a, 2]
    u = (s0 * p0 + s1 * p1 + s2 * p2) / volume
    q0, q1, q2 = s1 * e2 - s2 * e1, s2 * e0 - s0 * e2, s0 * e1 - s1 * e0
    w = (d0 * q0 + d1 * q1 + d2 * q2) / volume
    part = (f0 * q0 + f1 * q1 + f2 * q2) / volume
    return u > 0.0 and w > 0.0 and u + w < 1.0 and 0.0 < part < 1.0


@kernel(makes_arrays=False)
def _count(mesh, placed, stack, first):
    v, boxes, corners = placed.vertices, placed.boxes, mesh.in_order
    starts, leaves, count = mesh.leaf_start, mesh.leaves[0], 0
    for t in range(len(mesh.triangles)):
        for side in range(3):
            i, j = mesh.triangles[t, side], mesh.triangles[t, (side + 1) % 3]
            if i > j:  # as the other triangle of the edge has it
                continue
            depth, stack[0] = 1, 0
            while depth > 0:
                depth -= 1
                k, apart = stack[depth], False
                for c in range(3):
                    low, high = min(v[i, c], v[j, c]), max(v[i, c], v[j, c])
                    apart = apart or low > boxes[k, 3 + c] or high < boxes[k, c]
                if apart:
                    continue
                if k < leaves - 1:
                    stack[depth], stack[depth + 1] = 2 * k + 1, 2 * k + 2
                    depth += 2
                    continue
                leaf = k - (leaves - 1)
                for place in range(starts[leaf], starts[leaf + 1]):
                    a, b, c = corners[place, 0], corners[place, 1], corners[place, 2]
                    if i == a or i == b or i == c or j == a or j == b or j == c:
                        continue
                    if _crosses(v, i, j, a, b, c):
                        if count == 0:
                            first[0], first[1], first[2] = i, j, mesh.order[place]
                        count += 1
    return count


def crossings(vertices: np.ndarray, triangles: np.ndarray) -> tuple[int, Any]:
    """How often edges of closed triangles (nt, 3) cross other ones; the first of them.

    vertices : (nv, 3) [m]. Of the first: the vertices of the edge and the triangle, (3,) int.
    """
    mesh = mesh_of(triangles, vertices)
    placed = new_placed(mesh, len(vertices))
    placed.vertices[:] = vertices
    refit(mesh, placed)
    first = np.full(3, -1)
    return _count(mesh, placed, np.zeros(STACK, np.int64), first), first
