# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pressure of the clothing on a body of triangles, at its vertices.

Contact books every push at the vertices of the triangle that it acts on, by barycentric weights
(contact/solver/surface_correction.py). With the unit normal n of a vertex the impulse J there is
split into J . n, which presses, and the rest, which rubs. The pressure is the sum of J . n over the
time of a window and over the area of the vertex, a third of its triangles' at the first record.
What presses sums up to the normal force but for the angle between normals of one triangle, which
is of second order in its size. Vertices finer than the nodes of the cloth show its nodes. The share
of time and area in contact is that of the cloth that touches, at the same vertices; it is over 1
where cloth lies double, and where a node of it covers more than the vertex under it.

Impulses add up over a window between two records. Ranks are added together at a record only.
"""

from typing import Any, Self

import numpy as np

from contact.geometry.triangle_mesh.placed import know_normal
from contact.kernel import kernel
from contact.solver.surface_correction import SurfaceCorrection
from contact.solver.union_correction import UnionCorrection
from shellform.contact_coupling.contact import require_contact
from shellform.dynamics.explicit import Newmark
from shellform.dynamics.part import Part

from .pressure_map import VertexPressure

NORMAL, RUBBED, COVERED, BOOKED = 0, 1, 2, 3


@kernel
def flat_weights(
    vertices: np.ndarray, corners: np.ndarray, point: np.ndarray, shift: np.ndarray
) -> tuple[float, float, float]:
    """Barycentric weights of point + shift over a triangle, those below zero set to it."""
    a, b, c = vertices[corners[0]], vertices[corners[1]], vertices[corners[2]]
    uu = uv = vv = pu = pv = 0.0
    for k in range(3):
        u, v, p = b[k] - a[k], c[k] - a[k], point[k] + shift[k] - a[k]
        uu, uv, vv, pu, pv = uu + u * u, uv + u * v, vv + v * v, pu + p * u, pv + p * v
    area = uu * vv - uv * uv
    two, three = max((vv * pu - uv * pv) / area, 0.0), max((uu * pv - uv * pu) / area, 0.0)
    one = max(1.0 - two - three, 0.0)
    whole = one + two + three
    return one / whole, two / whole, three / whole


@kernel
def add_pressure(
    mesh: Any, placed: Any, at_vertices: np.ndarray, segment: np.ndarray, nearest: np.ndarray,
    points: np.ndarray, w: np.ndarray, mass: np.ndarray, dt: float, total: np.ndarray,
) -> None:  # fmt: skip
    """Add what a step presses, rubs and covers to total (nv, BOOKED) [N s, N s, kg s].

    at_vertices : (nv, >= 3), impulses on the cloth [N s]
    segment, nearest : (n,) int, of nodes: -1 without contact; triangle last found
    points, w : (n, 3), (n, >= 3), reference positions and displacements [m]; mass : (n,) [kg]
    """
    for k in range(len(segment)):
        t = nearest[k]
        if segment[k] < 0 or t < 0:
            continue
        weights = flat_weights(placed.vertices, mesh.triangles[t], points[k], w[k])
        for c in range(3):
            total[mesh.triangles[t, c], COVERED] += weights[c] * mass[k] * dt
    for i in range(len(total)):
        j0, j1, j2 = at_vertices[i, 0], at_vertices[i, 1], at_vertices[i, 2]
        if j0 == 0.0 and j1 == 0.0 and j2 == 0.0:
            continue
        know_normal(mesh, placed, i)
        n = placed.normals[i]
        along = j0 * n[0] + j1 * n[1] + j2 * n[2]
        square = j0 * j0 + j1 * j1 + j2 * j2
        total[i, NORMAL] += along
        total[i, RUBBED] += np.sqrt(max(square - along * along, 0.0))


def vertex_areas(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Area (nv,) [m^2] of every vertex: a third of its triangles'."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    third = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6.0
    return np.bincount(triangles.ravel(), np.repeat(third, 3), len(vertices))


def vertex_owners(owners: np.ndarray, triangles: np.ndarray, vertices: np.ndarray) -> np.ndarray:
    """Owner (nv,) int of every vertex: of most of the area around it; owners (nt,) of triangles."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    area = np.repeat(np.linalg.norm(np.cross(b - a, c - a), axis=1), 3)
    table = np.zeros((len(vertices), owners.max() + 1))
    np.add.at(table, (triangles.ravel(), np.repeat(owners, 3)), area)
    return table.argmax(axis=1)


class SurfacePressure(Part):
    """Pressure of every step at the vertices of a surface in contact, averaged between records.

    Parameters
    ----------
    resumed : state of a run that is gone on with, see `saved`

    Raises
    ------
    ValueError, when it is added, for no contact, one without a surface of triangles, a state of
    another surface
    """

    books_contact = True

    def __init__(self, resumed: dict[str, Any] | None = None) -> None:
        self._resumed = resumed

    def attach(self, stepper: Newmark) -> Self:
        """Begin to add up the pressure of a stepper's contact."""
        correction = require_contact(stepper, "pressure on a surface").correction
        if isinstance(correction, UnionCorrection):
            correction = correction.surface
        if not isinstance(correction, SurfaceCorrection):
            raise ValueError(
                "pressure at vertices is that of a body of triangles: give the contact a surface, "
                "or take `Pressure` for ellipsoids"
            )
        self._correction, self._comm = correction, stepper.shell.comm
        self._areal_mass = stepper.shell.fabric.areal_mass
        count = correction.surface.vertex_count
        self.total, self.seconds = np.zeros((count, BOOKED)), 0.0
        self._sums, self._whole = np.zeros((count, BOOKED)), 0.0
        self._peak, self._peak_time = np.zeros(count), np.full(count, np.nan)
        self._areas: np.ndarray | None = None
        self._places = np.zeros((count, 3))
        if self._resumed is not None:
            self._resume(self._resumed)
        return super().attach(stepper)

    def __call__(self, stepper: Newmark, dt: float) -> None:
        found = self._correction
        if found.active:
            add_pressure(
                *found.placed, found.at_vertices, found.segment, found.nearest, stepper.points,
                stepper.owned, stepper.mass, dt, self.total,
            )  # fmt: skip
        self.seconds += dt

    def record(self, time: float, counts: bool = True) -> np.ndarray:
        """Close the window that ends at `time` [s], begin a new one; all ranks call.

        Parameters
        ----------
        counts : whether the window enters `result`, or is one of standing

        Returns
        -------
        (nv,) float, mean pressure of the window [Pa]
        """
        surface = self._correction.surface
        if self._areas is None:
            surface.positions(time, self._places)
            self._areas = vertex_areas(self._places, surface.triangles)
        total = self._comm.allreduce(self.total)
        mean = total[:, NORMAL] / (self._areas * max(self.seconds, 1e-300))
        if counts:
            higher = mean > self._peak
            self._peak[higher], self._peak_time[higher] = mean[higher], time
            total[:, COVERED] /= self._areal_mass
            self._sums += total
            self._whole += self.seconds
        self.total[:], self.seconds = 0.0, 0.0
        return mean

    def result(self) -> VertexPressure:
        """What all closed windows that count have pressed; ValueError before the first record."""
        if self._areas is None:
            raise ValueError("there is no pressure before a window is closed: record(time) first")
        surface, span = self._correction.surface, self._areas[:, None] * max(self._whole, 1e-300)
        mean, rubbing, share = (self._sums / span).T.copy()
        return VertexPressure(
            tuple(surface.names), vertex_owners(surface.owners, surface.triangles, self._places),
            self._places.copy(), surface.triangles, self._areas.copy(), mean, self._peak.copy(),
            self._peak_time.copy(), rubbing, share, self._whole,
        )  # fmt: skip

    def state(self) -> tuple[np.ndarray, float]:
        """The open window on this rank, for `restore` (copies)."""
        return self.total.copy(), self.seconds

    def restore(self, state: Any) -> None:
        """Continue from `state()`."""
        self.total[:], self.seconds = state

    def saved(self) -> dict[str, np.ndarray]:
        """Open and closed windows over all ranks, for `resumed`; all ranks call."""
        areas, places = np.zeros(0), np.zeros((0, 3))
        if self._areas is not None:
            areas, places = self._areas, self._places
        return {
            "surface_pressure_open": self._comm.allreduce(self.total),
            "surface_pressure_sums": self._sums,
            "surface_pressure_peak": np.column_stack([self._peak, self._peak_time]),
            "surface_pressure_areas": areas,
            "surface_pressure_places": places,
            "surface_pressure_seconds": np.array([self.seconds, self._whole]),
        }

    def _resume(self, state):
        if "surface_pressure_open" not in state:
            raise ValueError("the checkpoint holds no pressure at vertices: go on without it")
        held = state["surface_pressure_open"]
        if held.shape != self.total.shape:
            raise ValueError(
                f"the checkpoint has the pressure of a surface of {len(held)} vertices, not of "
                f"{len(self.total)}: go on with that surface"
            )
        self.total[:] = held if self._comm.rank == 0 else 0.0
        self._sums[:] = state["surface_pressure_sums"]
        self._peak[:], self._peak_time[:] = state["surface_pressure_peak"].T
        if len(state["surface_pressure_areas"]):
            self._areas = np.array(state["surface_pressure_areas"])
            self._places[:] = state["surface_pressure_places"]
        self.seconds, self._whole = state["surface_pressure_seconds"].tolist()
