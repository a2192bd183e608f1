# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the body gave to nodes and took from them: impulses, work, friction and impact losses.

A row of the table holds for one segment, all as acting on the cloth: impulse (3) [N s], its moment
about the segment's centre (3) [N m s], work done by the moving segment, friction loss, impact
loss [J].
"""

from typing import Self

import numpy as np

from contact.kernel import kernel

WORK, FRICTION, IMPACT, BOOKED = 6, 7, 8, 9  # places in a row, and its length


class Ledger:
    """What contact did to n nodes and m segments, as acting on the cloth.

    Attributes
    ----------
    impulse : (n, 3) float, on every node [N s]
    table : (m, BOOKED) float, all that follows as one array
    segment_impulse : (m, 3) float, by every segment [N s]
    segment_moment : (m, 3) float, about the segment's centre at the start of each step [N m s]
    work : (m,) float, work of the segment's motion on the cloth [J]
    friction_loss, impact_loss : (m,) float, energy taken by friction and by normal impulses [J];
        the latter is negative where a node that starts inside is moved out, and holds what soft
        segments have stored and not yet given back
    seconds : float, time covered [s]
    """

    def __init__(self, n: int, m: int):
        self.impulse, self.table, self.seconds = np.zeros((n, 3)), np.zeros((m, BOOKED)), 0.0
        self.segment_impulse, self.segment_moment = self.table[:, :3], self.table[:, 3:6]
        self.work = self.table[:, WORK]
        self.friction_loss, self.impact_loss = self.table[:, FRICTION], self.table[:, IMPACT]

    def clear(self) -> None:
        """Set everything to zero."""
        self.impulse[:] = 0.0
        self.table[:] = 0.0
        self.seconds = 0.0

    def add(self, other: Self) -> None:
        """Add what another ledger of the same nodes and segments holds."""
        self.impulse += other.impulse
        self.table += other.table
        self.seconds += other.seconds


@kernel(makes_arrays=False)
def book_impulse(
    row: np.ndarray,
    centre: np.ndarray,
    x: np.ndarray,
    impulse: np.ndarray,
    work: float,
    friction: float,
    impact: float,
) -> None:
    """Add an impulse (3,) [N s] of a segment on a node at x (3,), with its energies [J].

    row : (BOOKED,), of the segment; centre : (3,), its centre [m]
    """
    for c in range(3):
        d, e = (c + 1) % 3, (c + 2) % 3
        row[c] += impulse[c]
        row[3 + c] += (x[d] - centre[d]) * impulse[e] - (x[e] - centre[e]) * impulse[d]
    row[WORK] += work
    row[FRICTION] += friction
    row[IMPACT] += impact


@kernel(makes_arrays=False)
def book_loss(
    impulse: np.ndarray, met: np.ndarray, after: np.ndarray, segment: np.ndarray, table: np.ndarray
) -> None:
    """Add what is lost beyond what a node's own meeting was booked with to `table`.

    Parameters
    ----------
    impulse : (k, 3) [N s]; met, after : (k, 3), velocity it was booked with and the real one [m/s]
    segment : (k,) int, -1 without contact; table : (segments, BOOKED)
    """
    for i in range(len(segment)):
        if segment[i] >= 0:
            for c in range(3):
                loss = 0.5 * impulse[i, c] * (met[i, c] - after[i, c])
                table[segment[i], IMPACT] += loss


@kernel(makes_arrays=False)
def take_book(book: np.ndarray, rows: np.ndarray, last: np.ndarray, window: np.ndarray) -> None:
    """Let last (m, BOOKED) be book (k, BOOKED), in its rows (k,); add it to window; clear book."""
    for j in range(len(last)):
        for c in range(BOOKED):
            last[j, c] = 0.0
    for k in range(len(rows)):
        for c in range(BOOKED):
            last[rows[k], c] += book[k, c]
            window[rows[k], c] += book[k, c]
            book[k, c] = 0.0
