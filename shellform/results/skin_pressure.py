# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pressure of the clothing on the wearer's skin, as a map that rides on the ellipsoids.

In each step the impulse J on a node in contact is split at its closest point, with the normal n of
the node's segment, into J . n, which presses, and the rest, which rubs. Both are shared out among
the four nearest patches (contact/geometry/surface_patches.py): forces add up exactly, a peak is
spread over about one patch. Patches smaller than a cell of the cloth show its nodes.

A node in a crease between two ellipsoids presses on the one that `VelocityCorrection.segment`
names, with the part of J along that one's normal; what is left of the push by the other is counted
as rubbing. A patch that another ellipsoid covers in part has its force divided by its whole area.

Where a segment can pass between nodes (contact_coupling/edge_contact.py), edges and cells press on
it at the points where they meet it. They count in the forces, not in the share of the area: a point
of an edge covers none.

Impulses add up over a window between two records. Ranks are added together at a record only.
"""

from typing import Any, Self

import numpy as np

from contact.geometry.ellipsoid import foot_and_normal
from contact.geometry.surface_patches import Patches, four_nearest
from contact.kernel import kernel
from shellform.contact_coupling.contact import require_contact
from shellform.dynamics.explicit import Newmark
from shellform.dynamics.part import Part

from .pressure_map import Map

NORMAL, RUBBED, COVERED, BOOKED = 0, 1, 2, 3


@kernel
def add_pressure(
    points: np.ndarray,
    w: np.ndarray,
    segment: np.ndarray,
    impulse: np.ndarray,
    mass: np.ndarray,
    dt: float,
    centres: np.ndarray,
    axes: np.ndarray,
    radii: np.ndarray,
    heights: np.ndarray,
    sectors: np.ndarray,
    rows: np.ndarray,
    columns: np.ndarray,
    first: np.ndarray,
    which: np.ndarray,
    weights: np.ndarray,
    total: np.ndarray,
) -> None:
    """Add a step's impulses on the wearer to the patches.

    Parameters
    ----------
    points, w : (n, 3), (n, >= 3), reference positions and displacements at the start [m]
    segment : (n,) int, -1 without contact; impulse : (n, 3), on the cloth [N s]; mass : (n,) [kg]
    centres, axes : pose of the ellipsoids at the start; radii ... first : see `Patches`
    which, weights : (4,), scratch
    total : (P, BOOKED), added to: normal impulse, size of the rest [N s], mass x time [kg s]
    """
    for i in range(len(segment)):
        b = segment[i]
        if b < 0:
            continue
        y0 = y1 = y2 = n0 = n1 = n2 = 0.0
        for c in range(3):
            arm = points[i, c] + w[i, c] - centres[b, c]
            y0 += axes[b, 0, c] * arm
            y1 += axes[b, 1, c] * arm
            y2 += axes[b, 2, c] * arm
        _, x0, x1, x2, n0, n1, n2 = foot_and_normal(
            y0, y1, y2, radii[b, 0], radii[b, 1], radii[b, 2]
        )
        four_nearest(
            x0, x1, x2, b, radii, heights, sectors, rows, columns, first, which, weights
        )  # fmt: skip
        normal = square = 0.0
        for c in range(3):
            normal += impulse[i, c] * (n0 * axes[b, 0, c] + n1 * axes[b, 1, c] + n2 * axes[b, 2, c])
            square += impulse[i, c] * impulse[i, c]
        rubbed = np.sqrt(max(square - normal * normal, 0.0))
        for a in range(4):
            total[which[a], NORMAL] += weights[a] * normal
            total[which[a], RUBBED] += weights[a] * rubbed
            total[which[a], COVERED] += weights[a] * mass[i] * dt


class Pressure(Part):
    """Pressure of every step on the patches of the body in contact, averaged between records.

    Parameters
    ----------
    size : float, side of a patch [m]
    resumed : state of a run that is gone on with, see `saved`

    Attributes
    ----------
    patches : Patches; total : (P, BOOKED), the open window on this rank

    Raises
    ------
    ValueError, when it is added, for no contact or one inside cells, patches without a size, a
    state of other patches
    """

    books_contact = True

    def __init__(self, size: float = 0.03, resumed: dict[str, Any] | None = None) -> None:
        self.size, self._resumed = size, resumed

    def attach(self, stepper: Newmark) -> Self:
        """Begin to add up the pressure of a stepper's contact."""
        self.contact = require_contact(stepper, "a pressure map")
        if self.contact.inner is not None:
            raise ValueError(
                "a pressure map is made of contact at nodes: leave out the samples inside cells"
            )
        self.names = self.contact.body.names
        self.patches = patches = Patches(self.contact.body.radii, self.size)
        self._areal_mass, self._comm = stepper.shell.fabric.areal_mass, stepper.shell.comm
        P = len(patches.areas)
        self.total, self.seconds = np.zeros((P, BOOKED)), 0.0
        # of closed windows, over all ranks: sums, peak and its time
        self._sums, self._whole = np.zeros((P, BOOKED)), 0.0
        self._peak, self._peak_time = np.zeros(P), np.full(P, np.nan)
        self._which, self._weights = np.zeros(4, np.int64), np.zeros(4)
        if self._resumed is not None:
            self._resume(self._resumed)
        return super().attach(stepper)

    def __call__(self, stepper: Newmark, dt: float) -> None:
        contact, impulse = self.contact, self.contact.last.impulse
        if contact.edges is not None:
            impulse = impulse - contact.edges.impulse
            pairs = contact.edges.pairs
            given = pairs["push"][:, None] * pairs["normal"] + pairs["friction"]
            owners = np.where(pairs["push"] > 0.0, pairs["owner"], -1)
            places, nothing = pairs["x"].copy(), np.zeros(len(pairs))
            self._add(places, np.zeros_like(places), owners, given, nothing, dt)
        self._add(stepper.points, stepper.owned, contact.segment, impulse, stepper.mass, dt)
        self.seconds += dt

    def _add(self, points, w, segment, impulse, mass, dt):
        """Points of a step to the patches; see `add_pressure`."""
        pose = self.contact.start_pose
        add_pressure(
            points, w, segment, impulse, mass, dt, pose.centres, pose.axes, *self.patches.tables,
            self._which, self._weights, self.total,
        )  # fmt: skip

    def record(self, time: float, counts: bool = True) -> np.ndarray:
        """Close the window that ends at `time` [s], begin a new one; all ranks call.

        Parameters
        ----------
        counts : whether the window enters `result`, or is one of standing

        Returns
        -------
        (P,) float, mean pressure of the window [Pa]
        """
        total = self._comm.allreduce(self.total)
        span, areas = max(self.seconds, 1e-300), self.patches.areas
        mean = total[:, NORMAL] / (areas * span)
        if counts:
            higher = mean > self._peak
            self._peak[higher], self._peak_time[higher] = mean[higher], time
            # cloth that lies double covers no more than all of a patch
            cover = total[:, COVERED] / self._areal_mass
            total[:, COVERED] = np.minimum(cover, areas * self.seconds)
            self._sums += total
            self._whole += self.seconds
        self.total[:], self.seconds = 0.0, 0.0
        return mean

    def result(self) -> Map:
        """Map of all closed windows that count."""
        patches, span = self.patches, max(self._whole, 1e-300)
        mean, rubbing, share = (self._sums / (patches.areas[:, None] * span)).T.copy()
        return Map(
            tuple(self.names), patches.radii, patches.size, patches.owner, patches.centres,
            patches.areas, mean, self._peak.copy(), self._peak_time.copy(), rubbing, share,
            self._whole,
        )  # fmt: skip

    def state(self) -> tuple[np.ndarray, float]:
        """The open window on this rank, for `restore` (copies)."""
        return self.total.copy(), self.seconds

    def restore(self, state: Any) -> None:
        """Continue from `state()`."""
        self.total[:], self.seconds = state

    def saved(self) -> dict[str, np.ndarray]:
        """Open and closed windows over all ranks, for `resumed`; all ranks call."""
        return {
            "pressure_open": self._comm.allreduce(self.total),
            "pressure_sums": self._sums,
            "pressure_peak": np.column_stack([self._peak, self._peak_time]),
            "pressure_seconds": np.array([self.seconds, self._whole]),
            "pressure_size": np.array(self.patches.size),
        }

    def _resume(self, state):
        if "pressure_open" not in state:
            raise ValueError("the checkpoint holds no pressure map: go on without one")
        if state["pressure_open"].shape != self.total.shape:
            raise ValueError(
                f"the checkpoint has a pressure map of {len(state['pressure_open'])} patches of "
                f"{float(state['pressure_size'])} m, not {len(self.total)} of "
                f"{self.patches.size} m: go on with its size"
            )
        self.total[:] = state["pressure_open"] if self._comm.rank == 0 else 0.0
        self._sums[:] = state["pressure_sums"]
        self._peak[:], self._peak_time[:] = state["pressure_peak"].T
        self.seconds, self._whole = state["pressure_seconds"].tolist()
