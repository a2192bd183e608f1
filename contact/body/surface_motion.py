# SPDX-License-Identifier: LGPL-3.0-or-later
"""Closed surfaces of triangles that move: the seam between a body's skin and its segments.

Vertices follow the segments, v = f(q), however the skin is bound to them. Contact pushes vertices;
what that means for the segments is the adjoint of f: for any velocities of the segments

    sum over vertices of impulse . velocity =
        sum over segments of impulse . velocity of the centre + angular impulse . spin.

With a skin that a rigid motion of all segments moves rigidly, linear and angular momentum are then
exact too. `RigidSurface` is bound to one segment, `BlendedSurface` to several.
"""

from typing import Protocol, runtime_checkable

import numpy as np

SHARED = 6  # numbers booked at a vertex: impulse (3) [N s]; work, friction and impact loss [J]


@runtime_checkable
class SurfaceMotion(Protocol):
    """What contact asks of a moving closed surface of triangles.

    triangles : (nt, 3) int, corners counter-clockwise as seen from outside
    vertex_count : int, number of vertices nv
    names : of the m segments that it is bound to
    owners : (nt,) int, segment that each triangle is reported to belong to
    moves : bool, False for one that never moves
    """

    @property
    def triangles(self) -> np.ndarray: ...

    @property
    def vertex_count(self) -> int: ...

    @property
    def names(self) -> tuple[str, ...]: ...

    @property
    def owners(self) -> np.ndarray: ...

    @property
    def moves(self) -> bool: ...

    def positions(self, t: float, out: np.ndarray) -> np.ndarray:
        """Fill the places out (nv, 3) of the vertices at time t [s]; returns it."""

    def centres(self, t: float, out: np.ndarray) -> np.ndarray:
        """Fill the centres out (m, 3) of the segments at time t [s]; returns it."""

    def add_to_segments(
        self,
        t: float,
        at_vertices: np.ndarray,
        book: np.ndarray,
        pushed: np.ndarray | None = None,
    ) -> None:
        """Book what acts at vertices to the segments: the adjoint of the skinning at time t [s].

        Parameters
        ----------
        at_vertices : (nv, SHARED), impulse [N s]; work, friction and impact loss [J], which are
            shared out by the weights of the skin
        book : (m, 9), added to: impulse (3) and its moment about the centre of the segment at time
            t (3) [N m s], and the three energies [J]: a row of a Ledger's table
        pushed : vertices (k,) int, each once, that something acts on; others may be left out; None:
            all count
        """
