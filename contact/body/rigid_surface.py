# SPDX-License-Identifier: LGPL-3.0-or-later
"""A closed surface of triangles on one rigid segment, Eq. 17."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from contact.geometry.triangle_mesh.closed import closed_surface
from contact.kernel import kernel


@kernel(makes_arrays=False)
def _carry(local, centre, axes, out):
    for i in range(len(local)):
        for c in range(3):
            out[i, c] = (
                centre[c]
                + local[i, 0] * axes[0, c]
                + local[i, 1] * axes[1, c]
                + local[i, 2] * axes[2, c]
            )


@kernel(makes_arrays=False)
def _add(local, axes, pushed, at_vertices, row):
    """Add what acts at vertices `pushed` to the row (9,) of the segment."""
    for m in range(len(pushed)):
        i = pushed[m]
        j0, j1, j2 = at_vertices[i, 0], at_vertices[i, 1], at_vertices[i, 2]
        for k in range(3):
            row[6 + k] += at_vertices[i, 3 + k]
        if j0 == 0.0 and j1 == 0.0 and j2 == 0.0:
            continue
        a0, a1, a2 = local[i, 0], local[i, 1], local[i, 2]
        r0 = a0 * axes[0, 0] + a1 * axes[1, 0] + a2 * axes[2, 0]
        r1 = a0 * axes[0, 1] + a1 * axes[1, 1] + a2 * axes[2, 1]
        r2 = a0 * axes[0, 2] + a1 * axes[1, 2] + a2 * axes[2, 2]
        row[0] += j0
        row[1] += j1
        row[2] += j2
        row[3] += r1 * j2 - r2 * j1
        row[4] += r2 * j0 - r0 * j2
        row[5] += r0 * j1 - r1 * j0


class RigidSurface:
    """A closed surface on one segment.

    Parameters
    ----------
    vertices : (nv, 3) float, in the axes of the segment [m]
    triangles : (nt, 3) int; inside-out ones are turned, with a warning
    motion : as of a `Segment`: an object with pose(t), or a function of t, that give (centre, axes,
        velocity, spin)
    name : str, of the segment

    Raises
    ------
    ValueError
        For a surface that is none, see `contact.geometry.triangle_mesh.closed`, or a motion that
        is none.

    Examples
    --------
    >>> import shellform as sf
    >>> corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    >>> triangles = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
    >>> wedge = sf.RigidSurface(corners, triangles, sf.Fixed((0.0, 0.0, -1.0)), "wedge")
    >>> contact = sf.Contact(wedge, smooth=False)
    >>> wedge.positions(0.0, np.empty((4, 3)))[3].tolist()
    [0.0, 0.0, 0.0]
    """

    def __init__(self, vertices: ArrayLike, triangles: ArrayLike, motion: Any, name: str):
        if not (isinstance(name, str) and name):
            raise ValueError(f"a surface of triangles needs a name, not {name!r}")
        if not callable(motion) and not callable(getattr(motion, "pose", None)):
            raise ValueError(
                f"surface '{name}' moves by a motion as Fixed((0, 0, 0)), or by a function of the "
                f"time, not by {motion!r}"
            )
        self.local, self.triangles = closed_surface(vertices, triangles, name)
        self.names, self.motion = (name,), motion
        self._every = np.arange(len(self.local))
        self.owners = np.zeros(len(self.triangles), np.int64)
        self.pose = motion if callable(motion) else motion.pose
        self.moves = bool(getattr(motion, "moves", True))

    @property
    def vertex_count(self) -> int:
        return len(self.local)

    def _placed(self, t):
        centre, axes = (np.ascontiguousarray(part, float) for part in self.pose(t)[:2])
        if not np.abs(axes @ axes.T - np.eye(3)).max() < 1e-9 or not np.isfinite(centre).all():
            raise ValueError(
                f"the motion of surface '{self.names[0]}' at t = {t:.6g} s gives no finite centre "
                "with orthonormal axes e1, e2, e3: mend that function"
            )
        return centre, axes

    def positions(self, t: float, out: np.ndarray) -> np.ndarray:
        """See `SurfaceMotion`."""
        _carry(self.local, *self._placed(t), out)
        return out

    def centres(self, t: float, out: np.ndarray) -> np.ndarray:
        """See `SurfaceMotion`."""
        out[0] = self._placed(t)[0]
        return out

    def add_to_segments(
        self,
        t: float,
        at_vertices: np.ndarray,
        book: np.ndarray,
        pushed: np.ndarray | None = None,
    ) -> None:
        """See `SurfaceMotion`."""
        reached = self._every if pushed is None else pushed
        _add(self.local, self._placed(t)[1], reached, at_vertices, book[0])
