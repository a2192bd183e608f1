# SPDX-License-Identifier: LGPL-3.0-or-later
"""Friction inside the cloth for masses and springs (Fig. 3's loops): sliders in strains of cells.

Elements and state are those of the shell (material/friction.py): in each cell and strain along warp
and weft some springs k, each with a slider that yields at Y = m + g |e|, whose state is its slip p,

    stress = clip(k (e - p), -Y, Y),    p = e - stress/k.

Strains are those that edges, diagonals and grid lines tell (spring_strains.py). Forces at nodes are
area times stress times the derivative of the strain: sliders neither push nor turn the sheet as a
whole, and what they store and lose is what their forces take, exactly where strains go one way in a
step. It is made only for fabrics that name friction.
"""

import numpy as np

from contact.kernel import kernel
from shellform.fem.six_lengths import FIRST, SECOND
from shellform.material.sheet import Sheet

from .spring_strains import LINES, TURN, cells_of, measure, push, strain, turns_of


@kernel
def slide(e: float, p: float, k: float, m: float, g: float) -> tuple[float, float, float]:
    """Stress of a slider at the strain e and the slip p, by how much it slips, and what that takes.

    The last is the integral of the yield stress over the slip, from the strain where it began on.
    """
    free, most = k * (e - p), m + g * abs(e)
    if abs(free) <= most:
        return free, 0.0, 0.0
    up = 1.0 if free > 0.0 else -1.0
    slip = (free - up * most) / k
    begun = p + up * m / k
    early = 1.0 - g / k if begun * up >= 0.0 else 1.0 + g / k
    late = 1.0 - g / k if e * up >= 0.0 else 1.0 + g / k
    begun /= early
    if begun * e >= 0.0:
        return up * most, slip, (m + 0.5 * g * (abs(e) + abs(begun))) * abs(slip)
    lost = (m + 0.5 * g * abs(begun)) * abs(begun) * early
    return up * most, slip, lost + (m + 0.5 * g * abs(e)) * abs(e) * late


@kernel
def rub(
    points: np.ndarray,
    w: np.ndarray,
    cells: np.ndarray,
    turns: np.ndarray,
    values: np.ndarray,
    slopes: np.ndarray,
    moments: np.ndarray,
    springs: np.ndarray,
    many: np.ndarray,
    slips: np.ndarray,
    stuck: bool,
    keep: bool,
    r: np.ndarray,
    sums: np.ndarray,
) -> None:
    """Add the forces of the sliders to r (n, >= 3) [N], what they store and lose to sums (2,) [J].

    Parameters
    ----------
    points (n, 3), w (n, >= 3) [m]; cells : (m,) CELL; turns : (f,) TURN, none where nothing bends
    values (f,), slopes (f, 3, 3), moments (f,) : scratch
    springs : (s, 3), k, m, g, strain by strain; many : (6,), how many each has
    slips : (m, s), changed if `keep`; stuck : sliders hold whatever they bear
    """
    measure(points, w, turns, values, slopes)
    moments[:] = 0.0
    in_plane = many[:3].sum() > 0
    stored = gone = 0.0
    sides, e, stress = np.empty((6, 3)), np.empty(6), np.empty(6)
    for cell in range(len(cells)):
        own, at = cells[cell], 0
        strain(points, w, own, values, sides, e)
        for j in range(6):
            total, area = 0.0, own.areas[j // 3]
            for _ in range(many[j]):
                k, m, g = springs[at, 0], springs[at, 1], springs[at, 2]
                if stuck:
                    f, slip, lost = k * (e[j] - slips[cell, at]), 0.0, 0.0
                else:
                    f, slip, lost = slide(e[j], slips[cell, at], k, m, g)
                if keep:
                    slips[cell, at] += slip
                total += f
                stored += area * 0.5 * f * f / k
                gone += area * lost
                at += 1
            stress[j] = area * total
        if in_plane:
            nodes, B = own.nodes, own.B
            for i in range(6):
                a, b = nodes[FIRST[i]], nodes[SECOND[i]]
                pull = B[0, i] * stress[0] + B[1, i] * stress[1] + B[2, i] * stress[2]
                for c in range(3):
                    r[a, c] -= pull * sides[i, c]
                    r[b, c] += pull * sides[i, c]
        if len(turns):
            C, lines = own.C, own.turns
            for i in range(2 * LINES + 1):
                bent = C[0, i] * stress[3] + C[1, i] * stress[4] + C[2, i] * stress[5]
                moments[lines[i]] += bent
    push(turns, slopes, moments, r)
    sums[0] += stored
    sums[1] += gone


class SpringFriction:
    """Sliders in the cells of a surface of 4-node quads, for masses and springs; an InnerFriction.

    Parameters
    ----------
    points, directors : (n, 3), reference state; cells : (m, 4) int in tensor order
    warp : (3,), (m, 3) or None; fabric : Sheet with friction

    Attributes
    ----------
    slips, state, lost : see InnerFriction; in the order of `cells`
    """

    def __init__(
        self,
        points: np.ndarray,
        directors: np.ndarray,
        cells: np.ndarray,
        warp: np.ndarray | None,
        fabric: Sheet,
        flat: np.ndarray | None = None,
    ) -> None:
        if fabric.friction is None:
            raise ValueError(f"'{fabric.name}' has no friction inside")
        self._friction, self._points = fabric.friction, points
        self._springs, many = fabric.friction.table(), fabric.friction.counts()
        self._many = np.array(many, np.int64)
        self._turns, places = np.zeros(0, TURN), None
        if sum(many[3:]):
            self._turns, places = turns_of(points, directors, cells)
            if flat is not None:
                self._turns["rest"] = 0.0
        self._cells = cells_of(points, cells, warp, fabric, places, flat)
        count = len(self._turns)
        scratch = np.zeros(count), np.zeros((count, 3, 3)), np.zeros(count)
        self._values, self._slopes, self._moments = scratch
        self._slips, self._lost = np.zeros((len(cells), len(self._springs))), np.zeros(1)
        self._sums, self._aside = np.zeros(2), np.zeros((len(points), 3))

    def add_force(self, w: np.ndarray, r: np.ndarray) -> None:
        """Add forces at w (n, >= 3) to r (n, >= 3) [N]; sliders stay where they have slipped to."""
        self._call(w, r, False, True)
        self._lost += self._sums[1]

    def add_stuck(self, w: np.ndarray, r: np.ndarray) -> None:
        """Add to r the forces of sliders that hold whatever they bear."""
        self._call(w, r, True, False)

    def stored(self, w: np.ndarray) -> float:
        """Energy [J] of the springs behind the sliders at w (n, >= 3); nothing slips."""
        self._aside[:] = 0.0  # forces that nobody asks for
        self._call(w, self._aside, False, False)
        return float(self._sums[0])

    def strains(self, w: np.ndarray) -> np.ndarray:
        """Strains (m, 6) of the cells at w: E11, E22, 2 E12; K11, K22, 2 K12 [1/m]."""
        out, sides = np.empty((len(self._cells), 6)), np.empty((6, 3))
        measure(self._points, w, self._turns, self._values, self._slopes)
        for cell, e in zip(self._cells, out, strict=True):
            strain(self._points, w, cell, self._values, sides, e)
        return out

    def borne(self, w: np.ndarray) -> np.ndarray:
        """Stresses (m, s) that the sliders bear at w."""
        return self._friction.stresses(self.strains(w), self._slips)

    @property
    def slips(self) -> np.ndarray:
        """Slips (m, s) of the sliders, copied."""
        return self._slips.copy()

    def set_slips(self, slips: np.ndarray) -> None:
        """Take over slips (m, s)."""
        self._slips[:] = slips

    @property
    def state(self) -> list[np.ndarray]:
        """Arrays that steps change, for a copy and its return."""
        return [self._slips, self._lost]

    @property
    def lost(self) -> float:
        """Energy [J] that sliders have lost since the start."""
        return float(self._lost[0])

    @lost.setter
    def lost(self, value: float) -> None:
        self._lost[0] = value

    def _call(self, w, r, stuck, keep):
        self._sums[:] = 0.0
        rub(
            self._points, w, self._cells, self._turns, self._values, self._slopes, self._moments,
            self._springs, self._many, self._slips, stuck, keep, r, self._sums,
        )  # fmt: skip
