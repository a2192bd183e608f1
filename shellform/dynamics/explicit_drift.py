# SPDX-License-Identifier: LGPL-3.0-or-later
"""The drift of the explicit Newmark step: x(n+1) = x(n) + dt v(n+1/2), Sec. 3.1.3, Eq. 13.

Positions move along straight lines, directors along great circles with their velocity carried
parallel. A director d with the velocity q across it goes in dt to

    c d + s dt q,   its velocity to   c q - s dt q^2 d,   c = cos a,  s = sin(a)/a,  a = |q| dt.
"""

import numpy as np

from contact.kernel import kernel

NEAR = 0.01  # of an angle squared: the first term left out of the series is below 1e-20


@kernel
def near_cosine(square: float) -> float:
    """Cosine of an angle whose square is below NEAR: the series, to roundoff."""
    x = square  # Horner's scheme; products, as quotients take ten times as long
    return 1.0 - x * (1 / 2) * (
        1.0 - x * (1 / 12) * (1.0 - x * (1 / 30) * (1.0 - x * (1 / 56) * (1.0 - x * (1 / 90))))
    )


@kernel
def near_sine(square: float) -> float:
    """Sine of an angle over the angle, whose square is below NEAR: the series, to roundoff."""
    x = square
    return 1.0 - x * (1 / 6) * (
        1.0 - x * (1 / 20) * (1.0 - x * (1 / 42) * (1.0 - x * (1 / 72) * (1.0 - x * (1 / 110))))
    )


@kernel
def turn(
    w: np.ndarray, q: np.ndarray, i: int, square: float, c: float, s: float, dt: float
) -> None:
    """Turn the director of node i, at q^2 = square, by an angle of cosine c and sine s angle.

    w : (6 n,), q : (3 n,), changed
    """
    d0, d1, d2 = w[6 * i + 3], w[6 * i + 4], w[6 * i + 5]
    q0, q1, q2 = q[3 * i], q[3 * i + 1], q[3 * i + 2]
    on, back = s * dt, s * dt * square
    e0, e1, e2 = c * d0 + on * q0, c * d1 + on * q1, c * d2 + on * q2
    length = 1.0 / np.sqrt(e0 * e0 + e1 * e1 + e2 * e2)
    w[6 * i + 3], w[6 * i + 4], w[6 * i + 5] = e0 * length, e1 * length, e2 * length
    q[3 * i], q[3 * i + 1] = c * q0 - back * d0, c * q1 - back * d1
    q[3 * i + 2] = c * q2 - back * d2


@kernel
def tangential(w: np.ndarray, q: np.ndarray, i: int) -> float:
    """Take off q (3 n,) of node i what is along its director in w (6 n,); returns its square."""
    d0, d1, d2 = w[6 * i + 3], w[6 * i + 4], w[6 * i + 5]
    q0, q1, q2 = q[3 * i], q[3 * i + 1], q[3 * i + 2]
    along = q0 * d0 + q1 * d1 + q2 * d2
    q0, q1, q2 = q0 - along * d0, q1 - along * d1, q2 - along * d2
    q[3 * i], q[3 * i + 1], q[3 * i + 2] = q0, q1, q2
    return q0 * q0 + q1 * q1 + q2 * q2


@kernel
def drift(w: np.ndarray, v: np.ndarray, q: np.ndarray, dt: float) -> float:
    """Move nodes and directors by their velocities over dt.

    w : (n, 6), (u, d), changed; v : (n, 3); q : (n, 3), changed: carried along; all contiguous.
    Returns the sum of all moved coordinates: not finite if any of them is not.

    The loop of small turns has no branch and strides that the compiler knows: it runs in vector
    registers.
    """
    places, speeds, turns = w.reshape(w.size), v.reshape(v.size), q.reshape(q.size)
    fastest = total = 0.0
    for i in range(w.shape[0]):
        fastest = max(fastest, q[i, 0] * q[i, 0] + q[i, 1] * q[i, 1] + q[i, 2] * q[i, 2])
    if fastest * dt * dt < 0.99 * NEAR:  # a step turns a director by far less
        for i in range(w.shape[0]):
            square = tangential(places, turns, i)
            angle = square * dt * dt
            turn(places, turns, i, square, near_cosine(angle), near_sine(angle), dt)
            places[6 * i] += dt * speeds[3 * i]
            places[6 * i + 1] += dt * speeds[3 * i + 1]
            places[6 * i + 2] += dt * speeds[3 * i + 2]
    else:
        for i in range(w.shape[0]):
            square = tangential(places, turns, i)
            angle = square * dt * dt
            if angle < NEAR:
                c, s = near_cosine(angle), near_sine(angle)
            else:
                angle = np.sqrt(angle)
                c, s = np.cos(angle), np.sin(angle) / angle
            turn(places, turns, i, square, c, s, dt)
            for k in range(3):
                w[i, k] += dt * v[i, k]
    for i in range(w.shape[0]):
        total += (w[i, 0] + w[i, 1] + w[i, 2]) + (w[i, 3] + w[i, 4] + w[i, 5])
    return total
