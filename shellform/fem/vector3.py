# SPDX-License-Identifier: LGPL-3.0-or-later
"""Vectors of three numbers for compiled code: tuples, so that they stay in registers.

Arrays would make the kernels that are built on these twice as slow. `stage` is for the steps of
such a kernel: numba writes their statements where they are called, so a step costs no call and its
tuples are never stored.
"""

import numpy as np

from contact.kernel import kernel

Vector = tuple[float, float, float]

# not finite stays not finite: no assumption that NaN or infinity do not occur
FASTMATH = {"contract", "reassoc", "nsz", "arcp"}
compiled = kernel(fastmath=FASTMATH)
stage = kernel(fastmath=FASTMATH, inline="always")


@compiled
def dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def add(a: Vector, b: Vector) -> Vector:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@compiled
def sub(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@compiled
def mix(s: float, a: Vector, t: float, b: Vector) -> Vector:
    """s a + t b."""
    return s * a[0] + t * b[0], s * a[1] + t * b[1], s * a[2] + t * b[2]


@compiled
def plus(a: Vector, s: float, b: Vector) -> Vector:
    """a + s b."""
    return a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]


@compiled
def row(a: np.ndarray, i: int, k: int) -> Vector:
    """Numbers k, k + 1, k + 2 of row i."""
    return a[i, k], a[i, k + 1], a[i, k + 2]


@compiled
def add_to(r: np.ndarray, i: int, k: int, a: Vector) -> None:
    """Add a to numbers k, k + 1, k + 2 of row i."""
    r[i, k] += a[0]
    r[i, k + 1] += a[1]
    r[i, k + 2] += a[2]
