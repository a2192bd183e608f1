# SPDX-License-Identifier: LGPL-3.0-or-later
"""Skin drawn smooth: places that are means of others, by a matrix that stays the same.

    x <- M x,  rows of M add up to 1

so rigid motions stay what they are, rates are drawn like places, and what acts on the drawn skin
acts on the other as M^T says. Rows of the identity are left out.
"""

import numpy as np

from contact.kernel import kernel

SUMS = 4  # of a row, that do not wait for each other


@kernel(makes_arrays=False, fastmath={"contract"})
def draw_smooth(
    rows: np.ndarray, starts: np.ndarray, columns: np.ndarray, parts: np.ndarray,
    scales: np.ndarray, at: np.ndarray, means: np.ndarray,
) -> None:  # fmt: skip
    """Put the means M x in place of those `rows` (k,) of x = at (n, 3) that are drawn smooth.

    starts (k + 1,), columns, parts : these rows of M, of multiples of SUMS parts, each row to be
        multiplied by its scale (k,)
    means : (k, 3), scratch
    """
    for r in range(len(rows)):
        a0 = a1 = a2 = b0 = b1 = b2 = c0 = c1 = c2 = d0 = d1 = d2 = 0.0
        for k in range(starts[r], starts[r + 1], SUMS):
            j, w = columns[k], np.float64(parts[k])
            a0, a1, a2 = a0 + w * at[j, 0], a1 + w * at[j, 1], a2 + w * at[j, 2]
            j, w = columns[k + 1], np.float64(parts[k + 1])
            b0, b1, b2 = b0 + w * at[j, 0], b1 + w * at[j, 1], b2 + w * at[j, 2]
            j, w = columns[k + 2], np.float64(parts[k + 2])
            c0, c1, c2 = c0 + w * at[j, 0], c1 + w * at[j, 1], c2 + w * at[j, 2]
            j, w = columns[k + 3], np.float64(parts[k + 3])
            d0, d1, d2 = d0 + w * at[j, 0], d1 + w * at[j, 1], d2 + w * at[j, 2]
        scale = scales[r]
        means[r, 0] = scale * ((a0 + b0) + (c0 + d0))
        means[r, 1] = scale * ((a1 + b1) + (c1 + d1))
        means[r, 2] = scale * ((a2 + b2) + (c2 + d2))
    for r in range(len(rows)):
        for c in range(3):
            at[rows[r], c] = means[r, c]


@kernel(makes_arrays=False, fastmath={"contract"})
def spread_smooth(
    row_of: np.ndarray, starts: np.ndarray, columns: np.ndarray, parts: np.ndarray,
    scales: np.ndarray, pushed: np.ndarray, at_vertices: np.ndarray, out: np.ndarray,
    listed: np.ndarray, taken: np.ndarray, before: int,
) -> int:  # fmt: skip
    """Let out (n, 3) be M^T f, f the first three of at_vertices; how many vertices that reaches.

    row_of : (n,) int, number of a vertex among those drawn smooth, or -1
    starts, columns, parts, scales : see `draw_smooth`
    pushed : vertices at which something acts; listed (n,) : filled with those reached; taken
        (n,) bool : whether a vertex is among them; before : how many were the last time
    """
    for m in range(before):
        i = listed[m]
        out[i, 0] = out[i, 1] = out[i, 2] = 0.0
        taken[i] = False
    count = 0
    for m in range(len(pushed)):
        i = pushed[m]
        r, f0, f1, f2 = row_of[i], at_vertices[i, 0], at_vertices[i, 1], at_vertices[i, 2]
        if r < 0:
            out[i, 0], out[i, 1], out[i, 2] = out[i, 0] + f0, out[i, 1] + f1, out[i, 2] + f2
            if not taken[i]:
                taken[i], listed[count] = True, i
                count += 1
            continue
        f0, f1, f2 = scales[r] * f0, scales[r] * f1, scales[r] * f2
        for k in range(starts[r], starts[r + 1]):
            j, w = columns[k], np.float64(parts[k])
            out[j, 0], out[j, 1], out[j, 2] = (
                out[j, 0] + w * f0, out[j, 1] + w * f1, out[j, 2] + w * f2
            )  # fmt: skip
            if not taken[j]:
                taken[j], listed[count] = True, j
                count += 1
    return count


class Smoothing:
    """A matrix (n, n) by which places of vertices are drawn smooth.

    starts (n + 1,), columns, parts : its rows
    """

    def __init__(self, starts: np.ndarray, columns: np.ndarray, parts: np.ndarray):
        starts, columns = np.array(starts, np.int64), np.array(columns, np.int64)
        parts, n = np.array(parts, float), len(starts) - 1
        count = np.diff(starts)
        same = (count == 1) & (columns[np.minimum(starts[:-1], len(columns) - 1)] == np.arange(n))
        rows = np.flatnonzero(~same)
        self._rows, self._row_of = rows, np.full(n, -1)
        self._row_of[rows] = np.arange(len(rows))
        sums = np.add.reduceat(parts, starts[:-1])[rows]
        count, own = count[rows], np.repeat(~same, count)
        full = -(-count // SUMS) * SUMS
        ends = np.cumsum(full)
        # half the size, as this is read in every step; what rounding takes of a sum is given back
        short, places = np.zeros(full.sum(), "f4"), np.zeros(full.sum(), np.uint32)
        into = np.arange(count.sum()) + np.repeat(ends - full - (np.cumsum(count) - count), count)
        short[into], places[into] = parts[own], columns[own]
        rest = np.setdiff1d(np.arange(len(places)), into)
        places[rest] = np.repeat(rows, full - count)  # parts of nothing, of the row's own vertex
        scales = sums / np.add.reduceat(short.astype(float), ends - full)
        # numbers without a sign: those of others could count from the end, which has to be asked
        self._matrix = np.append(0, ends).astype(np.uint64), places, short, scales
        self._means, self._spread = np.zeros((len(rows), 3)), np.zeros((n, 3))
        self._listed, self._taken, self._count = np.zeros(n, np.int64), np.zeros(n, bool), 0

    def draw(self, at: np.ndarray) -> None:
        """Draw places or velocities at (n, 3) smooth."""
        draw_smooth(self._rows, *self._matrix, at, self._means)

    def drawn(self, table: np.ndarray) -> np.ndarray:
        """M times a table (n, m)."""
        starts, columns, parts, scales = self._matrix
        out, first = table.copy(), starts[:-1].astype(np.int64)
        out[self._rows] = np.add.reduceat(parts[:, None] * table[columns], first) * scales[:, None]
        return out

    def spread(self, pushed: np.ndarray, at_vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What acts at vertices pushed (k,) of the drawn skin, on the skin before.

        at_vertices : (n, >= 3), impulses first

        Returns the vertices that it reaches and the impulses (n, 3); valid until the next time.
        """
        self._count = spread_smooth(
            self._row_of, *self._matrix, pushed, at_vertices, self._spread, self._listed,
            self._taken, self._count,
        )  # fmt: skip
        return self._listed[: self._count], self._spread
