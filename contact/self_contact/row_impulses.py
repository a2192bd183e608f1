# SPDX-License-Identifier: LGPL-3.0-or-later
"""What impulses of rows do to nodes, supports and books, and which rows want any; see `rows`."""

from typing import Any

import numpy as np

from contact.kernel import kernel


@kernel(makes_arrays=False)
def impulse_of(row: Any, a: int, c: int) -> float:
    """Component c of what a row gives to its node a [N s]."""
    return (
        row.push * row.weights[a] * row.normal[c]
        + row.rub[0] * row.sliding[0, a, c]
        + row.rub[1] * row.sliding[1, a, c]
    )


@kernel(makes_arrays=False)
def wake(rows: np.ndarray, v: np.ndarray, before: np.ndarray, live: np.ndarray) -> int:
    """How many rows (k,) ROW pushed in the last step or lack speed; live (n,) bool: their nodes.

    v, before : (n, 3), velocities by all forces and those of the step before, in which a body may
        have moved nodes [m/s]
    """
    count = 0
    live[:] = False
    for k in range(len(rows)):
        row = rows[k]
        one = other = 0.0
        for a in range(4):
            for c in range(3):
                one += row.weights[a] * row.normal[c] * v[row.nodes[a], c]
                other += row.weights[a] * row.normal[c] * before[row.nodes[a], c]
        if row.push > 0.0 or min(one, other) < row.bound:
            count += 1
            for a in range(4):
                live[row.nodes[a]] = True
    return count


@kernel(makes_arrays=False)
def spread(rows: np.ndarray, impulse: np.ndarray) -> None:
    """Add what rows (k,) ROW give to the nodes to impulse (n, 3) [N s]."""
    for k in range(len(rows)):
        row = rows[k]
        for a in range(4):
            for c in range(3):
                impulse[row.nodes[a], c] += impulse_of(row, a, c)


@kernel(makes_arrays=False)
def speed_up(rows: np.ndarray, mobility: np.ndarray, v: np.ndarray, after: np.ndarray) -> None:
    """Fill after (n, 3) with velocities v (n, 3) and what rows (k,) ROW change of them [m/s].

    mobility : (n, 3, 3) [1/kg]
    """
    for i in range(len(v)):
        for c in range(3):
            after[i, c] = v[i, c]
    for k in range(len(rows)):
        row = rows[k]
        for a in range(4):
            i = row.nodes[a]
            for c in range(3):
                given = impulse_of(row, a, c)
                after[i, c] += mobility[i, c, c] * given


@kernel(makes_arrays=False)
def give(
    rows: np.ndarray,
    begin: int,
    held: np.ndarray,
    mass: np.ndarray,
    v: np.ndarray,
    support: np.ndarray,
) -> None:
    """Add what rows (k,) ROW give to the nodes of a rank to their velocities or to their supports.

    begin : int, the first of these nodes; held : (m, 3) bool, components that supports hold
    mass : (m,) [kg]; v, support : (m, 3) [m/s, N s], the impulse of supports on the nodes
    """
    for k in range(len(rows)):
        row = rows[k]
        for a in range(4):
            i = row.nodes[a] - begin
            if i < 0 or i >= len(mass):
                continue
            for c in range(3):
                given = impulse_of(row, a, c)
                if held[i, c]:
                    support[i, c] -= given
                else:
                    v[i, c] += given / mass[i]


@kernel(makes_arrays=False)
def book(rows: np.ndarray, before: np.ndarray, after: np.ndarray, losses: np.ndarray) -> None:
    """Add what rows (k,) ROW took by pushes and by friction to losses (2,) [J].

    before, after : (n, 3), velocities before the forces and when all have had their say [m/s]
    """
    pressed = rubbed = 0.0
    for k in range(len(rows)):
        row = rows[k]
        for a in range(4):
            i = row.nodes[a]
            for c in range(3):
                mean = 0.5 * (before[i, c] + after[i, c])
                pressed -= row.push * row.weights[a] * row.normal[c] * mean
                rubbed -= row.rub[0] * row.sliding[0, a, c] * mean
                rubbed -= row.rub[1] * row.sliding[1, a, c] * mean
    losses[0] += pressed
    losses[1] += rubbed
