# SPDX-License-Identifier: LGPL-3.0-or-later
"""A moving closed surface of triangles at the start and at the end of a step.

The end of one step usually is the start of the next. Both share the boxes of the tree, which are
fitted anew when the surface has gone farther than they may be grown.
"""

import warnings
from typing import Any

import numpy as np

from contact.body.surface_motion import SurfaceMotion
from contact.geometry.triangle_mesh.placed import greatest_move, new_placed, refit
from contact.geometry.triangle_mesh.smooth import most_raised
from contact.geometry.triangle_mesh.topology import mesh_of

JUMP = 0.02, 200.0  # m and m/s: a surface that moves farther in a step and faster is set anew
SHARP = 0.5  # cosine between normals of one triangle
GROWN = 1.2e-3  # m, that boxes are grown before they are fitted anew
AMONG = 0.02  # m, around the nodes: triangles that they may touch
RAISED = 1.5  # times the greatest height of the smooth surface at first: room for bent joints


class SurfacePlaces:
    """Where a surface is at the two times of a step.

    Parameters
    ----------
    surface : SurfaceMotion
    sets : (nt,) int, bits of what the triangles belong to
    smooth : bool, whether normals of vertices are asked for

    Attributes
    ----------
    mesh : Mesh, None before `begin`; start, end : Placed at the two times
    time : float, that of the start [s]; to the last bit the end of the step before, where that was
        placed already
    highest : bound of the smooth surface over the flat one [m]
    """

    def __init__(self, surface: SurfaceMotion, sets: np.ndarray, smooth: bool):
        self._surface, self._sets, self._smooth = surface, sets, smooth
        self.mesh: Any = None
        self.start: Any = None
        self.end: Any = None
        self.highest, self.time, self._end_time = 0.0, 0.0, 0.0
        self._sharp = np.zeros(0, np.int64)

    def begin(self, t: float) -> None:
        """Tree and places at the first time."""
        surface = self._surface
        vertices = surface.positions(t, np.zeros((surface.vertex_count, 3)))
        self.mesh = mesh_of(surface.triangles, vertices, self._sets)
        self.start = new_placed(self.mesh, surface.vertex_count)
        self.restart(t)
        self.end = self.start
        if surface.moves:
            self.end = new_placed(self.mesh, surface.vertex_count, self.start.boxes)
        if self._smooth:
            self.highest = RAISED * most_raised(self.mesh, self.start)
            self._sharp = self._find_sharp()
            self.start.known[:] = False

    def restart(self, t: float) -> None:
        """Place the start of a step anew."""
        self._surface.positions(t, self.start.vertices)
        refit(self.mesh, self.start)
        self.time = t

    def resume(self, t: float, highest: float) -> None:
        """Place the end of a step anew, for the next one to go on from; `highest` as it was."""
        if self.mesh is None:
            self.begin(t)
        self.highest = highest
        if self._surface.moves:
            self._surface.positions(t, self.end.vertices)
            refit(self.mesh, self.end)
            self._end_time = t

    def turn_over(self) -> None:
        """Let the end of a step be the start of the next."""
        self.start, self.end, self.time = self.end, self.start, self._end_time

    def go_on(self, start: float, end: float, shift: np.ndarray) -> float:
        """Place the end of a step, in the boxes of its start as long as that does.

        Returns the greatest way [m] of a vertex as seen from a frame that goes along with the
        body, by shift (3,) [m], which is filled.

        Raises
        ------
        ValueError
            For a surface that jumps or has no finite places.
        """
        placed, before = self.end, self.start
        self._surface.positions(end, placed.vertices)
        self._end_time = end
        way, motion = greatest_move(before.vertices, placed.vertices, shift)
        placed.known[:] = False
        placed.grown[0] = before.grown[0] + way
        if not placed.grown[0] <= GROWN:
            refit(self.mesh, placed)
            before.grown[0] = way
        if not way <= max(JUMP[0], JUMP[1] * (end - start)):
            names = ", ".join(self._surface.names[:3])
            raise ValueError(
                f"the surface of {names} jumps by {way:.3g} m between t = {start:.6g} and "
                f"{end:.6g} s; give it a motion that goes there, or place it before the first step"
            )
        return motion

    def _find_sharp(self):
        """Triangles over which normals turn too far to be those of a smooth surface."""
        a, b, c = (self.start.normals[self.mesh.triangles[:, k]] for k in range(3))
        cosine = np.min([np.sum(p * q, axis=1) for p, q in ((a, b), (b, c), (c, a))], axis=0)
        return np.flatnonzero(cosine < SHARP)

    def warn_of_sharp(self, x: np.ndarray) -> None:
        """Warn, once, of triangles that are too sharp among nodes x (n, 3) [m], which touch."""
        sharp = self._sharp
        if not len(sharp) or not len(x):
            return
        corners = self.start.vertices[self.mesh.triangles[sharp]]
        low, high = x.min(axis=0) - AMONG, x.max(axis=0) + AMONG
        met = ((corners.max(axis=1) > low) & (corners.min(axis=1) < high)).all(axis=1)
        if met.any():
            self._sharp = np.zeros(0, np.int64)
            k = int(met.argmax())
            place = ", ".join(f"{c:.4g}" for c in corners[k, 0])
            warnings.warn(
                f"over {met.sum()} of {len(self.mesh.triangles)} triangles of the surface of "
                f"{', '.join(self._surface.names[:3])} the normal turns by more than 60 degrees, "
                f"first over triangle {sharp[k]} at ({place}) m: it is met as a smooth surface, so "
                "take smaller triangles there, or smooth=False if its edges are sharp",
                stacklevel=3,
            )
