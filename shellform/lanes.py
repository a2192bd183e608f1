# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rows of LANES numbers, one of each cell of a batch, and vectors of three made of them.

A processor adds four or eight pairs of numbers in the time of one, if they are neighbours in
memory. A loop over the lanes of a batch, without a branch or another loop in it, is turned into
such vector instructions by the compiler, all of a cell's arithmetic at once. Two things would keep
it from doing so: fewer than 16 lanes, for which it makes no tests whether arrays overlap; and small
functions that it has packed already when it compiled them one by one (LLVM's SLP, which
shellform/__init__.py and contact/__init__.py turn off before numba is loaded). Loops then stay
scalar and take two to three times as long, with the same results.
"""

import numba
import numpy as np

LANES = 16
# unsigned: such an index needs no test for counting from the end
COUNT = np.uint64(LANES)

compiled = numba.njit(
    # not finite stays not finite: no assumption that NaN or infinity do not occur
    cache=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz", "arcp"}
)  # fmt: skip


@compiled
def at(rows, k, lane):
    return rows[np.uint64(k) * COUNT + lane]


@compiled
def vector(rows, k, lane):
    return at(rows, k, lane), at(rows, k + 1, lane), at(rows, k + 2, lane)


@compiled
def put(rows, k, lane, a):
    rows[np.uint64(k) * COUNT + lane] = a[0]
    rows[np.uint64(k + 1) * COUNT + lane] = a[1]
    rows[np.uint64(k + 2) * COUNT + lane] = a[2]


@compiled
def less(a, b):
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@compiled
def plus(a, b):
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@compiled
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def mix(s, a, t, b):
    return s * a[0] + t * b[0], s * a[1] + t * b[1], s * a[2] + t * b[2]


@compiled
def mix3(s, a, t, b, u, c):
    return (
        s * a[0] + t * b[0] + u * c[0],
        s * a[1] + t * b[1] + u * c[1],
        s * a[2] + t * b[2] + u * c[2],
    )
