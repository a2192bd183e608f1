# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stress in the middle of cells: measured curves and friction inside the cloth, Eq. 14.

What a sheet has beyond the quadratic energy is taken once a cell, for 4-node quads and triangles:
cell_stress.c computes it, here are the arrays it reads. Strains along warp and weft are

    quads       E of the six lengths (six_lengths.py); K of the turning angles in the middle, along
                the two lines through it and both diagonals
    triangles   E and K of the lengths and turning angles of the three sides

It is made only for sheets whose fabric names a curve or friction.
"""

from pathlib import Path

import numpy as np

from shellform.material.curve import Curve
from shellform.material.friction import ClothFriction
from shellform.material.sheet import Sheet

from .arc import half_length_squared, turning
from .c_library import library
from .quad_force import in_blocks
from .quad_rest import corners_at_rest, lamina
from .six_lengths import FIRST, SECOND, six_lengths
from .strains import voigt_rows

SOURCE = Path(__file__).with_name("cell_stress.c")
DECLARATIONS = """
int lanes(void);
struct sums { double stored, lost; };
struct sums cell_stress(ptrdiff_t count, const int *nodes, const double *points,
                        const double *numbers, const double *curves, const double *stiffness,
                        const double *springs, const int *many, double *slips, const double *w,
                        const double *about, double *strains, int keep, double *r);
"""
# covariant components (11, 22, 12) of what lines measure: quads, triangles
LINES = {
    4: np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0.25, -0.25]]),
    3: np.array([[1, 0, 0], [0, 1, 0], [0.5, 0.5, -0.5]]),
}
SIDES = np.array([0, 0, 2]), np.array([1, 2, 1])  # of a triangle, ends


class CellStress:
    """Stress of all cells of this rank beyond the quadratic energy.

    Parameters
    ----------
    points, directors : (n, 3), reference state; cells : (m, 4) int in tensor order, or (m, 3)
    warp : (3,), (m, 3) or None; fabric : Sheet
    curves : six Curve or None, in the order of `Measured.curves`; or None
    friction : ClothFriction or None
    flat : (m, 4 or 3, 3), corners of cells whose rest shape is that of flat panels, or None

    Attributes
    ----------
    slips : (m, s) float, of all sliders; `set_slips` changes them
    """

    def __init__(
        self,
        points: np.ndarray,
        directors: np.ndarray,
        cells: np.ndarray,
        warp: np.ndarray | None,
        fabric: Sheet,
        curves: tuple[Curve | None, ...] | None = None,
        friction: ClothFriction | None = None,
        flat: np.ndarray | None = None,
    ) -> None:
        corners = cells.shape[1]
        self._ffi, self._library = library(SOURCE, DECLARATIONS, f"-DNODES={corners}")
        self._width = width = self._library.lanes()
        self.count, self._n = len(cells), len(points)
        padded = np.concatenate([cells, np.repeat(cells[-1:], -len(cells) % width, axis=0)])
        blocks = padded.reshape(-1, width, corners).transpose(0, 2, 1)
        numbers = at_rest(points, directors, cells, warp, fabric, flat)
        self._friction = friction
        springs = np.zeros((0, 3)) if friction is None else friction.table()
        many = [0] * 6 if friction is None else friction.counts()
        self._slips = (
            None if friction is None else in_blocks(np.zeros((self.count, len(springs))), width)
        )
        table = None if curves is None else np.concatenate([_row(curve) for curve in curves])
        stiffness = np.concatenate([fabric.membrane.ravel(), fabric.bending.ravel()])
        arrays = [
            np.ascontiguousarray(blocks, np.int32),
            np.ascontiguousarray(points, float),
            in_blocks(numbers, width),
            table,
            stiffness,
            np.ascontiguousarray(springs, float),
            np.array(many, np.int32),
            self._slips,
        ]
        kinds = ["int[]", *["double[]"] * 5, "int[]", "double[]"]
        self._fixed = [self._view(k, a) for k, a in zip(kinds, arrays, strict=True)]
        self._lost = np.zeros(1)

    def add_force(self, w: np.ndarray, r: np.ndarray, keep: bool = True) -> float:
        """Add the forces of all cells at w (n, 6) to r (n, 6) [N, N m]; returns the stored energy.

        `keep`: sliders stay where they have slipped to, and what that took is added to `lost`.
        The energy [J] is that of the springs behind the sliders.
        """
        return self._call(w, r, None, None, keep)

    def keep(self, w: np.ndarray) -> float:
        """Let the sliders slip to where w (n, 6) takes them; returns the stored energy [J]."""
        return self._call(w, None, None, None, True)

    def stored(self, w: np.ndarray) -> float:
        """Energy [J] of the springs behind the sliders at w (n, 6); nothing slips."""
        return self._call(w, None, None, None, False)

    def strains(self, w: np.ndarray) -> np.ndarray:
        """Strains (m, 6) of the cells at w (n, 6): E11, E22, 2 E12; K11, K22, 2 K12 [1/m]."""
        strains = np.empty((self.count, 6))
        self._call(w, None, None, strains, False)
        return strains

    def add_straightened(self, w: np.ndarray, r: np.ndarray, about: np.ndarray) -> None:
        """Add to r the forces of sliders that stick and curves as lines of their steepest slopes.

        about : (m, 6), strains through whose loads the lines go
        """
        self._call(w, r, about, None, False)

    @property
    def slips(self) -> np.ndarray:
        """Slips (m, s) of the sliders, copied."""
        if self._slips is None:
            return np.zeros((self.count, 0))
        return self._slips.transpose(0, 2, 1).reshape(-1, self._slips.shape[1])[: self.count].copy()

    def set_slips(self, slips: np.ndarray) -> None:
        """Take over slips (m, s)."""
        if self._slips is not None:
            self._slips[:] = in_blocks(np.asarray(slips, float), self._width)

    def borne(self, w: np.ndarray) -> np.ndarray:
        """Stresses (m, s) that the sliders bear at w (n, 6)."""
        if self._friction is None:
            return np.zeros((self.count, 0))
        return self._friction.stresses(self.strains(w), self.slips)

    def bear(self, w: np.ndarray, stresses: np.ndarray | None, lost: float = 0.0) -> None:
        """Let the sliders bear stresses (m, s) at w (n, 6), None: none; `lost`: energy before."""
        if self._friction is not None:
            stresses = np.zeros_like(self.slips) if stresses is None else stresses
            self.set_slips(self._friction.slips_that_bear(self.strains(w), stresses))
            self.lost = lost

    def forget(self) -> None:
        """Take all slips back, and what they have lost."""
        for array in self.state:
            array[:] = 0.0

    @property
    def state(self) -> list[np.ndarray]:
        """Arrays that steps change, for a copy and its return."""
        return [self._lost] if self._slips is None else [self._slips, self._lost]

    @property
    def lost(self) -> float:
        """Energy [J] that sliders of this rank have lost since the start."""
        return float(self._lost[0])

    @lost.setter
    def lost(self, value: float) -> None:
        self._lost[0] = value

    def _view(self, kind, array):
        return self._ffi.NULL if array is None else self._ffi.from_buffer(kind, array)

    def _call(self, w, r, about, strains, keep):
        arrays = [np.ascontiguousarray(w, float), about, strains]
        w, about, strains = (self._view("double[]", a) for a in arrays)
        result = None if r is None else r.reshape(-1)
        sums = self._library.cell_stress(
            self.count, *self._fixed, w, about, strains, keep, self._view("double[]", result)
        )
        if keep:
            self._lost += sums.lost
        return float(sums.stored)


def at_rest(
    points: np.ndarray,
    directors: np.ndarray,
    cells: np.ndarray,
    warp: np.ndarray | None,
    fabric: Sheet,
    flat: np.ndarray | None = None,
) -> np.ndarray:
    """Numbers of the cells as cell_stress.c reads them: (m, 42) of quads, (m, 26) of triangles.

    B, rest lengths, C, rest turning angles, areas of membrane and bending.
    """
    X, D = corners_at_rest(points, directors, cells, flat)
    corners = cells.shape[1]
    first, second = (FIRST, SECOND) if corners == 4 else SIDES
    dx, dd = (a[:, second] - a[:, first] for a in (X, D))
    lengths = half_length_squared(_dot(dx, dx), _dot(dx, dd), _dot(dd, dd))
    if corners == 4:
        G1, G2 = 0.5 * (dx[:, 0] + dx[:, 1]), 0.5 * (dx[:, 2] + dx[:, 3])
        middle = [0.5 * (a[:, [0, 2]] + a[:, [1, 3]]) for a in (dx, dd)]
        along = [np.concatenate(p, axis=1) for p in zip(middle, (dx[:, [5, 4]], dd[:, [5, 4]]))]
        B, _, stretched = six_lengths(X, warp, fabric.membrane)
    else:
        G1, G2, along = dx[:, 0], dx[:, 1], [dx, dd]
    M, area = lamina(G1, G2, warp)
    V = np.moveaxis(np.array(voigt_rows(*np.moveaxis(M.reshape(-1, 4), -1, 0))), -1, 0)
    C = V @ LINES[corners]
    if corners == 3:
        B, area = C, 0.5 * area
        stretched = area
    angles = turning(_dot(along[0], along[1]), _dot(along[1], along[1]))
    # a rank may have no cells, so -1 would not do
    rows = [matrix.reshape(len(cells), 3 * matrix.shape[2]) for matrix in (B, C)]
    parts = [rows[0], lengths, rows[1], angles]
    return np.concatenate([*parts, stretched[:, None], area[:, None]], axis=1)


def _row(curve):
    if curve is None:
        return np.zeros(4)
    head = [len(curve.x), curve.mirrored, curve.at_rest, curve.steepest]
    return np.concatenate([head, curve.x, curve.pieces.ravel()])


def _dot(a, b):
    return np.sum(a * b, axis=-1)
