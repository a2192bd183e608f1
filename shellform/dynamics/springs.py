# SPDX-License-Identifier: LGPL-3.0-or-later
"""Springs of the particle model, Sec. 2.1 and Fig. 1 of the paper: structural, shear, flexion.

Constants from the fabric, exact for rectangular cells h1 x h2 along the yarns (L^2 = h1^2 + h2^2):
diagonals k_d = G t L^2/(2 h1 h2), edges k_1 = (h2/h1) (C11 - G t h1^2/h2^2); on squares
C11 = k_s + k_d, C22 = k_s' + k_d, G t = k_d. Each cell gives half to its edges, so boundary edges
carry half. C12 cannot be chosen: it is G t. Flexion (Provot, Proc. Graphics Interface, 1995) has
no linear bending rigidity: its moment k_f h^4 kappa^3/8 is set to B kappa at one curvature; what it
adds to C11 is taken off the edges below it. Springs that buckle have k_b = B h/2
(spring_kernels.py).
Friction inside the cloth (spring_friction.py) is in the strains of cells that springs measure.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from meshes import Surface
from meshes.topology import directed_edges, unique_edges
from shellform.material.sheet import Sheet

from .explicit_kernels import work_over
from .grid_lines import grid_lines
from .spring_kernels import BEND, DIAGONAL, EDGE, SPRING, buckling_length, energies, forces

if TYPE_CHECKING:
    from .spring_friction import SpringFriction

LEAST = 0.1  # of an edge of a cell from a flat panel, over what it would have without diagonals


class Springs:
    """Springs of a surface of 4-node quads, a ForceModel.

    Parameters
    ----------
    surface : meshes.Surface; cells : (m, 4) int, its cells in the numbering of `points`
    points : (n, 3) [m]; fabric : Fabric
    damping : float [s], of each spring, along it
    bending : 'flexion', 'buckling' or 'none'
    curvature : float [1/m] or None, where flexion has the fabric's B; None: 1/bending length
    friction : SpringFriction of the same cells or None
    flat : (m, 4, 2) or None, corners of the cells in flat panels, see `meshes.Surface`: they give
        the rest lengths, sides of two panels the mean of both; where a cell lies across the yarns
        so that its edges would get a negative constant, they get LEAST, and are too stiff

    Attributes
    ----------
    table : (s,) SPRING, of which the first `limited` are structural and shear springs
    r : (n, 6) [N], last forces; viscous : (n, 3) [N], the part of damping if there is any
    """

    turns_directors = False

    def __init__(
        self,
        surface: Surface,
        cells: np.ndarray,
        points: np.ndarray,
        fabric: Sheet,
        bending: str = "flexion",
        curvature: float | None = None,
        damping: float = 0.0,
        friction: SpringFriction | None = None,
        flat: np.ndarray | None = None,
    ) -> None:
        if bending not in ("flexion", "buckling", "none"):
            raise ValueError(f"bending is one of flexion, buckling, none, not '{bending}'")
        if cells.shape[1] != 4:
            raise ValueError(f"springs need 4-node quads; {surface.source} has other cells")
        self.points, self.damping, self.friction = points, damping, friction
        rows = directed_edges(cells)
        first, number, count = unique_edges(rows, len(points))
        edges = rows[first]
        number = number.reshape(-1, 4)
        if flat is None:
            length = np.linalg.norm(points[edges[:, 1]] - points[edges[:, 0]], axis=1)
            corner, corners = length[number], points[cells]
        else:
            corner = np.linalg.norm(np.roll(flat, -1, axis=1) - flat, axis=2)
            length = np.bincount(number.ravel(), corner.ravel()) / count
            corners = flat
        h1, h2 = 0.5 * (corner[:, 0] + corner[:, 2]), 0.5 * (corner[:, 1] + corner[:, 3])
        A, B = _along_cells(surface, corners, fabric)
        shear = A[:, 2, 2]
        k1 = h2 / h1 * (A[:, 0, 0] - shear * (h1 / h2) ** 2)
        k2 = h1 / h2 * (A[:, 1, 1] - shear * (h2 / h1) ** 2)
        if flat is not None:
            # cells of panels lie at any angle to the yarns, where no springs have their stiffness
            k1, k2 = (
                np.maximum(k1, LEAST * h2 / h1 * A[:, 0, 0]),
                np.maximum(k2, LEAST * h1 / h2 * A[:, 1, 1]),
            )
        if min(k1.min(), k2.min()) <= 0:
            bad = int(np.minimum(k1, k2).argmin())
            raise ValueError(
                f"cell {bad} of {surface.source} is too slender, or the fabric '{fabric.name}' too "
                "stiff in shear, for springs: an edge would get a negative constant"
            )
        k, across, rigidity = (np.zeros(len(edges)) for _ in range(3))
        for side in range(4):
            np.add.at(k, number[:, side], 0.5 * (k2 if side % 2 else k1))
            np.add.at(across, number[:, side], 0.5 * (h1 if side % 2 else h2))
            half = 0.5 * (h1 * B[:, 1, 1] if side % 2 else h2 * B[:, 0, 0])
            np.add.at(rigidity, number[:, side], half)
        diagonals = np.concatenate([cells[:, [0, 2]], cells[:, [1, 3]]])
        k_d = np.tile(shear * (h1**2 + h2**2) / (2 * h1 * h2), 2)
        two, lines, *_ = grid_lines(edges, number, count, len(points))
        if bending == "none":
            two, lines = two[:0], lines[:0]
        if flat is None:
            reach = np.linalg.norm(points[two[:, 1]] - points[two[:, 0]], axis=1)
        else:
            reach = length[lines].sum(axis=1)
        stiff, EI = k[lines].min(axis=1), rigidity[lines].mean(axis=1)  # EI [N m^2]
        if bending == "buckling":
            k_b = 0.5 * EI
            # the ramp must be steep enough to meet the column's force
            k_f = np.maximum(0.05 * stiff, 40 * k_b / reach**3)
        else:
            k_b = np.zeros(len(two))
            bent = 1 / fabric.bending_length() if curvature is None else curvature
            k_f = np.minimum(8 * EI / ((0.5 * reach) ** 5 * bent**2), 0.05 * stiff)
            for side in (0, 1):
                at = lines[:, side]
                np.add.at(k, at, -k_f * length[lines].sum(axis=1) / length[at])
        pairs = np.ascontiguousarray(np.concatenate([edges, diagonals, two]))
        across_cells = np.linalg.norm(corners[:, [2, 3]] - corners[:, [0, 1]], axis=2).T.ravel()
        rest = np.concatenate([length, across_cells, reach])
        sizes = [len(k), len(k_d), len(k_f)]
        kind = np.repeat(np.array([EDGE, DIAGONAL, BEND]), sizes)
        k_b = np.concatenate([np.zeros(len(k) + len(k_d)), k_b])
        k = np.concatenate([k, k_d, k_f])
        turn = np.array([buckling_length(*s) for s in zip(rest, k, k_b, strict=True)])
        self.table = np.zeros(len(pairs), SPRING)
        for name, column in (
            ("ends", pairs), ("rest", rest), ("k", k), ("k_b", k_b), ("turn", turn), ("kind", kind),
        ):  # fmt: skip
            self.table[name] = column
        self.limited = int(sizes[0] + sizes[1])
        self.r, self.viscous = np.zeros((len(points), 6)), np.zeros((len(points), 3))
        self._energy = np.zeros(3)

    def force(self, w: np.ndarray, v: np.ndarray, q: np.ndarray, time: float) -> np.ndarray:
        """See ForceModel."""
        forces(self.points, w, v, self.damping, self.table, False, self.r, self.viscous)
        if self.friction is not None:
            self.friction.add_force(w, self.r)
        return self.r

    def freeze(self, w: np.ndarray) -> None:
        """See ForceModel; nothing to freeze."""

    def elastic(self, w: np.ndarray, frozen: None) -> np.ndarray:
        """See ForceModel; buckling springs with the slope they start with, on both sides."""
        forces(self.points, w, self.points, 0.0, self.table, True, self.r, self.viscous)
        if self.friction is not None:
            self.friction.add_stuck(w, self.r)
        return self.r

    def energy(self, w: np.ndarray) -> dict[str, float]:
        """Strain energy [J] by kind of spring."""
        energies(self.points, w, self.table, self._energy)
        kinds = dict(zip(("structural", "shear", "flexion"), self._energy.tolist(), strict=True))
        return kinds if self.friction is None else kinds | {"friction": self.friction.stored(w)}

    def damping_loss(self, v_old: np.ndarray, v: np.ndarray, dt: float, last: float) -> float:
        """See ForceModel."""
        return work_over(self.viscous, v_old, v, dt) if self.damping else 0.0

    def describe(self) -> dict[str, Any]:
        """See ForceModel."""
        return {"terms": ["springs"] + ["friction inside the cloth"] * (self.friction is not None)}


def _along_cells(surface, corners, fabric):
    """Membrane and bending matrices (m, 3, 3) in axes along the first edge of each cell."""
    m = len(corners)
    # friction, which stands in axes of its own, is not the springs'
    fabric = fabric.with_friction(None)
    if not fabric.directional:
        return np.tile(fabric.membrane, (m, 1, 1)), np.tile(fabric.bending, (m, 1, 1))
    edge = corners[:, 1] - corners[:, 0]
    if corners.shape[2] == 2:  # in a flat panel, whose first axis is the warp
        angle = np.arctan2(edge[:, 1], edge[:, 0])
        return _turned(fabric, angle)
    normal = np.cross(edge, corners[:, 3] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    warp = np.broadcast_to(surface.warp, edge.shape)
    turned = np.cross(normal, warp)
    return _turned(fabric, np.arctan2(np.sum(edge * turned, 1), np.sum(edge * warp, 1)))


def _turned(fabric, angle):
    """Membrane and bending matrices (m, 3, 3) of a fabric turned by angles (m,) [rad]."""
    angle, which = np.unique(np.round(np.degrees(angle), 6), return_inverse=True)
    sheets = [fabric.rotated(a) for a in angle]
    A, B = (np.array([getattr(s, n) for s in sheets]) for n in ("membrane", "bending"))
    return A[which], B[which]
