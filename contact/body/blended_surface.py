# SPDX-License-Identifier: LGPL-3.0-or-later
"""A closed surface of triangles bound to several segments by linear blending.

A vertex is the weighted mean of where its segments carry it,

    v_i = sum_s w_is y_is,  y_is = c_s + X_is axes_s,  sum_s w_is = 1,

with X_is its constant place in the axes of segment s. The adjoint: of an impulse J at v_i segment s
gets w_is J at y_is. Sums are exact, as sum_s w_is J = J and sum_s y_is x w_is J = v_i x J, and so
is the power, sum_s w_is J . dy_is/dt = J . dv_i/dt.
"""

import numpy as np
from numpy.typing import ArrayLike

from contact.geometry.triangle_mesh.closed import closed_surface
from contact.kernel import kernel

from .segments import Body, Pose

SUM = 1e-6  # that weights of a vertex may differ from one


@kernel(makes_arrays=False)
def blend(
    local: np.ndarray,
    bound: np.ndarray,
    weights: np.ndarray,
    centres: np.ndarray,
    axes: np.ndarray,
    out: np.ndarray,
) -> None:
    """Fill the places out (nv, 3) [m] of vertices bound to segments.

    Parameters
    ----------
    local : (nv, k, 3), in the axes of the segments [m]; bound : (nv, k) int, the segments
    weights : (nv, k); centres (m, 3), axes (m, 3, 3) : of the segments
    """
    for i in range(len(out)):
        for c in range(3):
            out[i, c] = 0.0
        for a in range(weights.shape[1]):
            w, s = weights[i, a], bound[i, a]
            if w == 0.0:
                continue
            for c in range(3):
                out[i, c] += w * (
                    centres[s, c]
                    + local[i, a, 0] * axes[s, 0, c]
                    + local[i, a, 1] * axes[s, 1, c]
                    + local[i, a, 2] * axes[s, 2, c]
                )


@kernel(makes_arrays=False)
def add_blended(
    local: np.ndarray,
    bound: np.ndarray,
    weights: np.ndarray,
    axes: np.ndarray,
    pushed: np.ndarray,
    at_vertices: np.ndarray,
    book: np.ndarray,
) -> None:
    """The adjoint of `blend`, see `SurfaceMotion.add_to_segments`."""
    for m in range(len(pushed)):
        i = pushed[m]
        j0, j1, j2 = at_vertices[i, 0], at_vertices[i, 1], at_vertices[i, 2]
        e0, e1, e2 = at_vertices[i, 3], at_vertices[i, 4], at_vertices[i, 5]
        if j0 == 0.0 and j1 == 0.0 and j2 == 0.0 and e0 == 0.0 and e1 == 0.0 and e2 == 0.0:
            continue
        for a in range(weights.shape[1]):
            w, s = weights[i, a], bound[i, a]
            if w == 0.0:
                continue
            a0, a1, a2 = local[i, a, 0], local[i, a, 1], local[i, a, 2]
            r0 = a0 * axes[s, 0, 0] + a1 * axes[s, 1, 0] + a2 * axes[s, 2, 0]
            r1 = a0 * axes[s, 0, 1] + a1 * axes[s, 1, 1] + a2 * axes[s, 2, 1]
            r2 = a0 * axes[s, 0, 2] + a1 * axes[s, 1, 2] + a2 * axes[s, 2, 2]
            book[s, 0] += w * j0
            book[s, 1] += w * j1
            book[s, 2] += w * j2
            book[s, 3] += w * (r1 * j2 - r2 * j1)
            book[s, 4] += w * (r2 * j0 - r0 * j2)
            book[s, 5] += w * (r0 * j1 - r1 * j0)
            book[s, 6] += w * e0
            book[s, 7] += w * e1
            book[s, 8] += w * e2


def few_weights(weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Segments (nv, k) and weights (nv, k) of the vertices from a full table (nv, m).

    k is the greatest number of segments that a vertex is bound to; others have a weight of zero.
    """
    k = max(1, int((weights != 0.0).sum(axis=1).max()))
    bound = np.argsort(-weights, axis=1, kind="stable")[:, :k]
    return bound.astype(np.int64), np.ascontiguousarray(np.take_along_axis(weights, bound, axis=1))


class BlendedSurface:
    """A closed surface bound to the segments of a body.

    Parameters
    ----------
    vertices : (nv, 3) float, where they are when the body is in its pose at `time` [m]
    triangles : (nt, 3) int; inside-out ones are turned, with a warning
    weights : (nv, m) float, of every segment of the body; not negative, with sums of one
    body : Body
    time : float [s]
    name : str, for messages

    Raises
    ------
    ValueError
        For a surface that is none, see `contact.geometry.triangle_mesh.closed`, and for weights
        of a wrong shape, negative ones or sums other than one.

    Examples
    --------
    >>> import shellform as sf
    >>> corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    >>> triangles = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
    >>> rising = lambda t: ((0.0, 0.0, t), np.eye(3), (0.0, 0.0, 1.0), np.zeros(3))
    >>> body = sf.Body(
    ...     [sf.Segment("a", [0.1] * 3, sf.Fixed()), sf.Segment("b", [0.1] * 3, rising)]
    ... )
    >>> weights = [(1, 0), (1, 0), (1, 0), (0.5, 0.5)]
    >>> skin = sf.BlendedSurface(corners, triangles, weights, body)
    >>> skin.positions(0.2, np.empty((4, 3)))[3].tolist()
    [0.0, 0.0, 1.1]
    >>> contact = sf.Contact(body, surface=skin)
    """

    def __init__(
        self,
        vertices: ArrayLike,
        triangles: ArrayLike,
        weights: ArrayLike,
        body: Body,
        time: float = 0.0,
        name: str = "skin",
    ):
        points, self.triangles = closed_surface(vertices, triangles, name)
        table = np.array(weights, float)
        if table.shape != (len(points), len(body.names)):
            raise ValueError(
                f"weights of surface '{name}' have the shape {table.shape}, not one row for each "
                f"of {len(points)} vertices with a number for each of {len(body.names)} segments"
            )
        bad = ~(np.abs(table.sum(axis=1) - 1.0) < SUM) | (table < 0.0).any(axis=1)
        if bad.any():
            i = int(bad.argmax())
            raise ValueError(
                f"weights of vertex {i} of surface '{name}' are {table[i].tolist()}: give numbers "
                ">= 0 that add up to 1"
            )
        table /= table.sum(axis=1, keepdims=True)
        self.body, self.names = body, body.names
        self.bound, self.weights = few_weights(table)
        self.owners = table[self.triangles].sum(axis=1).argmax(axis=1)
        self.moves = True
        self._pose = body.new_pose(time)
        arm = points[:, None, :] - self._pose.centres[self.bound]
        self.local = np.einsum("iakc,iac->iak", self._pose.axes[self.bound], arm)
        self._time, self._every = time, np.arange(len(points))

    @property
    def vertex_count(self) -> int:
        return len(self.weights)

    def _at(self, t: float) -> Pose:
        if t != self._time:
            self.body.pose(t, self._pose)
            self._time = t
        return self._pose

    def positions(self, t: float, out: np.ndarray) -> np.ndarray:
        """See `SurfaceMotion`."""
        pose = self._at(t)
        blend(self.local, self.bound, self.weights, pose.centres, pose.axes, out)
        return out

    def centres(self, t: float, out: np.ndarray) -> np.ndarray:
        """See `SurfaceMotion`."""
        out[:] = self._at(t).centres
        return out

    def add_to_segments(
        self,
        t: float,
        at_vertices: np.ndarray,
        book: np.ndarray,
        pushed: np.ndarray | None = None,
    ) -> None:
        """See `SurfaceMotion`."""
        axes, reached = self._at(t).axes, self._every if pushed is None else pushed
        add_blended(self.local, self.bound, self.weights, axes, reached, at_vertices, book)
