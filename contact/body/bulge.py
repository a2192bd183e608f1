# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Flesh that bulges as joints bend: points of a skin move along fixed lines before it is bound.

Flesh that is pressed flat behind a joint, or turned into it, goes elsewhere. A bound point p of the
field k becomes

    p + beta_k d,   beta_k = sum_j P_kj(c_j - c_j0),   c_j = u_a . u_b,   P(0) = 0

d is a vector of the point, beta_k [m] one number for all points of the field. u_a and u_b are unit
vectors fixed in the two segments of joint j, so c_j is the cosine of an angle that follows its
bend, c_j0 that at binding, where nothing bulges. P is a cubic on each of some pieces of equal
width, with a continuous derivative, and goes on straight beyond them. With the spins w_a, w_b

    beta_k' = sum_j P_kj' (u_a x u_b) . (w_a - w_b)

and what acts along d with a sum Q_k = sum d . f over the field is a moment Q_k P_kj' (u_a x u_b) on
segment a and the opposite one on b: power is exact, and there is no force or moment in all.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from contact.kernel import kernel

SWELLS = [
    ("field", np.int64),
    ("above", np.int64),
    ("below", np.int64),
    ("along_above", float, 3),  # u_a, u_b in the axes of the segments
    ("along_below", float, 3),
    ("first", float),  # cosine at which the first piece begins
    ("width", float),  # of a piece
    ("pieces", np.int64),
]


class Swell(NamedTuple):
    """How much a field bulges by the bend of one joint.

    field : its number
    above, below : segments of the joint
    along_above, along_below : (3,), u_a and u_b at binding
    cosines : of the first and the last end of the pieces of P
    amounts : (pieces, 4), of P + constant: powers 0 to 3 of the cosine less the start of the piece
    """

    field: int
    above: str
    below: str
    along_above: np.ndarray
    along_below: np.ndarray
    cosines: tuple[float, float]
    amounts: np.ndarray


class Bulge(NamedTuple):
    """What bulges, and how.

    fields : (n,) int, of the vertices, -1 for none
    directions : (n, 3), d in the axes of the world at binding
    swells : of all fields and joints
    """

    fields: np.ndarray
    directions: np.ndarray
    swells: Sequence[Swell]


NO_BULGE = Bulge(np.zeros(0, np.int64), np.zeros((0, 3)), ())


@kernel(makes_arrays=False, fastmath={"contract"})
def amount(
    first: float, width: float, pieces: int, amounts: np.ndarray, cosine: float
) -> tuple[float, float]:
    """P [m] and its derivative; amounts (>= pieces, 4), see `Swell`."""
    inside = min(max(cosine, first), first + width * pieces)
    k = min(int((inside - first) / width), pieces - 1)
    y, p = inside - first - k * width, amounts[k]
    slope = p[1] + y * (2.0 * p[2] + y * 3.0 * p[3])
    return p[0] + y * (p[1] + y * (p[2] + y * p[3])) + slope * (cosine - inside), slope


@kernel(makes_arrays=False, fastmath={"contract"})
def set_bulge(
    swells: np.ndarray, table: np.ndarray, axes: np.ndarray, rows: np.ndarray,
    fields: np.ndarray, directions: np.ndarray, bound: np.ndarray, amounts: np.ndarray,
    turns: np.ndarray, points: np.ndarray,
) -> None:  # fmt: skip
    """Fill amounts (k,) beta of the fields [m], turns (s, 3) and the points (n, 3) that bulge [m].

    swells (s,) SWELLS, table (s, pieces, 4) : of P, see `amount`; turns : P' (u_a x u_b) of each
    axes (m, 3, 3) : of the segments
    rows : vertices in a field; fields (n,), directions, bound (n, 3) : see `Bulge`
    """
    for k in range(len(amounts)):
        amounts[k] = 0.0
    for s in range(len(swells)):
        one, a, b = swells[s], axes[swells[s].above], axes[swells[s].below]
        u, v = one.along_above, one.along_below
        u0 = u[0] * a[0, 0] + u[1] * a[1, 0] + u[2] * a[2, 0]
        u1 = u[0] * a[0, 1] + u[1] * a[1, 1] + u[2] * a[2, 1]
        u2 = u[0] * a[0, 2] + u[1] * a[1, 2] + u[2] * a[2, 2]
        v0 = v[0] * b[0, 0] + v[1] * b[1, 0] + v[2] * b[2, 0]
        v1 = v[0] * b[0, 1] + v[1] * b[1, 1] + v[2] * b[2, 1]
        v2 = v[0] * b[0, 2] + v[1] * b[1, 2] + v[2] * b[2, 2]
        value, slope = amount(
            one.first, one.width, one.pieces, table[s], u0 * v0 + u1 * v1 + u2 * v2
        )
        amounts[one.field] += value
        turns[s, 0] = slope * (u1 * v2 - u2 * v1)
        turns[s, 1] = slope * (u2 * v0 - u0 * v2)
        turns[s, 2] = slope * (u0 * v1 - u1 * v0)
    for r in range(len(rows)):
        i = rows[r]
        beta = amounts[fields[i]]
        for c in range(3):
            points[i, c] = bound[i, c] + beta * directions[i, c]


@kernel(makes_arrays=False, fastmath={"contract"})
def bulge_rates(
    swells: np.ndarray, turns: np.ndarray, spins: np.ndarray, rates: np.ndarray
) -> None:
    """Fill rates (k,), beta' of the fields [m/s], from the spins (m, 3) of the segments."""
    for k in range(len(rates)):
        rates[k] = 0.0
    for s in range(len(swells)):
        a, b = swells[s].above, swells[s].below
        for c in range(3):
            rates[swells[s].field] += turns[s, c] * (spins[a, c] - spins[b, c])


@kernel(makes_arrays=False, fastmath={"contract"})
def add_bulge(swells: np.ndarray, turns: np.ndarray, along: np.ndarray, book: np.ndarray) -> None:
    """Add the moments of along (k,), Q of the fields [N m s / m], to book (m, 9); clear Q."""
    for s in range(len(swells)):
        a, b = swells[s].above, swells[s].below
        for c in range(3):
            moment = along[swells[s].field] * turns[s, c]
            book[a, 3 + c] += moment
            book[b, 3 + c] -= moment
    for k in range(len(along)):
        along[k] = 0.0


class BulgeState(NamedTuple):
    """A bulge at a time: amounts (k,), turns (s, 3) and points (n, 3), see `set_bulge`."""

    amounts: np.ndarray
    turns: np.ndarray
    points: np.ndarray


class Bulging:
    """The bulge of a skin whose vertices are bound at points (n, 3) [m]; None: it has none.

    names, axes : of the segments (m,), at binding (m, 3, 3)
    """

    def __init__(
        self, bulge: Bulge | None, names: Sequence[str], axes: np.ndarray, points: np.ndarray
    ):
        given = NO_BULGE if bulge is None else bulge
        self.fields = np.array(given.fields, np.int64)
        self.directions = np.array(given.directions, float, order="C")
        self._count = 1 + int(np.max(self.fields, initial=-1))
        self._swells = np.zeros(len(given.swells), SWELLS)
        longest = max((len(swell.amounts) for swell in given.swells), default=0)
        self._table = np.zeros((len(given.swells), longest, 4))
        for s, swell in enumerate(given.swells):
            a, b = names.index(swell.above), names.index(swell.below)
            u, v = np.array(swell.along_above, float), np.array(swell.along_below, float)
            first, last, pieces = *swell.cosines, len(swell.amounts)
            row, part = self._swells[s], self._table[s, :pieces]
            row["field"], row["above"], row["below"] = swell.field, a, b
            row["along_above"], row["along_below"] = axes[a] @ u, axes[b] @ v
            row["first"], row["width"], row["pieces"] = first, (last - first) / pieces, pieces
            part[:] = swell.amounts
            part[:, 0] -= amount(first, row["width"], pieces, part, u @ v)[0]
        self._rows = np.flatnonzero(self.fields >= 0)
        self._points, self.rates = points, np.zeros(self._count)
        self.along = np.zeros(self._count)  # Q of the fields

    def new_state(self) -> BulgeState:
        """Arrays of a state; where nothing bulges, its points are those at binding themselves."""
        points = self._points.copy() if len(self._swells) else self._points
        return BulgeState(np.zeros(self._count), np.zeros((len(self._swells), 3)), points)

    def set(self, state: BulgeState, axes: np.ndarray) -> None:
        """Fill a state from the axes (m, 3, 3) of the segments."""
        if len(self._swells):
            set_bulge(
                self._swells, self._table, axes, self._rows, self.fields, self.directions,
                self._points, *state,
            )  # fmt: skip

    def set_rates(self, state: BulgeState, spins: np.ndarray) -> None:
        """Fill `rates` (k,), beta' [m/s], from the spins (m, 3) of the segments [1/s]."""
        if len(self._swells):
            bulge_rates(self._swells, state.turns, spins, self.rates)

    def add_to(self, book: np.ndarray, state: BulgeState) -> None:
        """Book (m, 9) what `along` (k,) has gathered, and clear it."""
        if len(self._swells):
            add_bulge(self._swells, state.turns, self.along, book)
