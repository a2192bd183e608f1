# SPDX-License-Identifier: LGPL-3.0-or-later
"""Skin drawn smooth: places that are means of others, by a matrix that stays the same.

    x <- M x,  rows of M add up to 1

so rigid motions stay what they are, rates are drawn like places, and what acts on the drawn skin
acts on the other as M^T says. Rows of the identity are left out.
"""

import numpy as np

from contact.kernel import kernel


@kernel(makes_arrays=False, fastmath={"contract"})
def draw_smooth(
    rows: np.ndarray, starts: np.ndarray, columns: np.ndarray, parts: np.ndarray,
    scales: np.ndarray, at: np.ndarray, means: np.ndarray,
) -> None:  # fmt: skip
    """Put the means M x in place of those `rows` (k,) of x = at (n, 3) that are drawn smooth.

    starts (k + 1,), columns, parts : these rows of M, each to be multiplied by its scale (k,)
    means : (k, 3), scratch
    """
    for r in range(len(rows)):
        x0 = x1 = x2 = y0 = y1 = y2 = 0.0
        first, end = starts[r], starts[r + 1]
        if (end - first) % 2 == 1:
            j, w = columns[first], parts[first]
            x0, x1, x2, first = w * at[j, 0], w * at[j, 1], w * at[j, 2], first + 1
        # two sums that do not wait for each other
        for k in range(first, end, 2):
            j, w = columns[k], parts[k]
            x0, x1, x2 = x0 + w * at[j, 0], x1 + w * at[j, 1], x2 + w * at[j, 2]
            j, w = columns[k + 1], parts[k + 1]
            y0, y1, y2 = y0 + w * at[j, 0], y1 + w * at[j, 1], y2 + w * at[j, 2]
        scale = scales[r]
        means[r, 0], means[r, 1], means[r, 2] = (
            scale * (x0 + y0), scale * (x1 + y1), scale * (x2 + y2)
        )  # fmt: skip
    for r in range(len(rows)):
        for c in range(3):
            at[rows[r], c] = means[r, c]


@kernel(makes_arrays=False, fastmath={"contract"})
def _reach(j, w, i, at_vertices, out, listed, taken, count):
    """Add what acts at vertex i times w to vertex j; the number of vertices reached then."""
    if not taken[j]:
        taken[j], listed[count] = True, j
        count += 1
    for c in range(6):
        out[j, c] += w * at_vertices[i, c]
    return count


@kernel(makes_arrays=False, fastmath={"contract"})
def spread_smooth(
    row_of: np.ndarray, starts: np.ndarray, columns: np.ndarray, parts: np.ndarray,
    scales: np.ndarray, pushed: np.ndarray, at_vertices: np.ndarray, out: np.ndarray,
    listed: np.ndarray, taken: np.ndarray,
) -> int:  # fmt: skip
    """Add M^T at_vertices to out (n, 6); the number of vertices that it reaches.

    row_of : (n,) int, number of a vertex among those drawn smooth, or -1
    starts, columns, parts, scales : see `draw_smooth`
    pushed : vertices at which something acts; listed (n,) : filled with those reached; taken
        (n,) bool : whether a vertex is among them, False before
    """
    count = 0
    for m in range(len(pushed)):
        i = pushed[m]
        r = row_of[i]
        if r < 0:
            count = _reach(i, 1.0, i, at_vertices, out, listed, taken, count)
            continue
        for k in range(starts[r], starts[r + 1]):
            w = scales[r] * parts[k]
            count = _reach(columns[k], w, i, at_vertices, out, listed, taken, count)
    return count


@kernel(makes_arrays=False, fastmath={"contract"})
def clear_rows(rows: np.ndarray, table: np.ndarray, taken: np.ndarray) -> None:
    """Set rows of a table (n, k) to zero, and of taken (n,) to False."""
    for m in range(len(rows)):
        taken[rows[m]] = False
        for c in range(table.shape[1]):
            table[rows[m], c] = 0.0


class Smoothing:
    """A matrix (n, n) by which places of vertices are drawn smooth.

    starts (n + 1,), columns, parts : its rows
    """

    def __init__(self, starts: np.ndarray, columns: np.ndarray, parts: np.ndarray):
        starts, columns = np.array(starts, np.int64), np.array(columns, np.int64)
        parts, n = np.array(parts, float), len(starts) - 1
        count = np.diff(starts)
        same = (count == 1) & (columns[np.minimum(starts[:-1], len(columns) - 1)] == np.arange(n))
        rows, entries = np.flatnonzero(~same), np.repeat(~same, count)
        self._rows, self._row_of = rows, np.full(n, -1)
        self._row_of[rows] = np.arange(len(rows))
        # half the size, as this is read in every step; what rounding takes of a sum is given back
        starts, short = np.concatenate([[0], np.cumsum(count[rows])]), parts[entries].astype("f4")
        scales = np.add.reduceat(parts[entries], starts[:-1])
        scales /= np.add.reduceat(short.astype(float), starts[:-1])
        self._matrix = starts, columns[entries].astype(np.int32), short, scales
        self._means, self._spread = np.zeros((len(rows), 3)), np.zeros((n, 6))
        self._listed, self._taken = np.zeros(n, np.int64), np.zeros(n, bool)

    def draw(self, at: np.ndarray) -> None:
        """Draw places or velocities at (n, 3) smooth."""
        draw_smooth(self._rows, *self._matrix, at, self._means)

    def spread(self, pushed: np.ndarray, at_vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What acts at vertices pushed (k,) of the drawn skin, table (n, 6), on the skin before.

        Returns the vertices that it reaches and their table; valid until `forget`.
        """
        count = spread_smooth(
            self._row_of, *self._matrix, pushed, at_vertices, self._spread, self._listed,
            self._taken,
        )  # fmt: skip
        return self._listed[:count], self._spread

    def forget(self, reached: np.ndarray) -> None:
        """Nothing acts any more at the vertices that `spread` has reached."""
        clear_rows(reached, self._spread, self._taken)
