# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Rigid motions as dual quaternions, and the point that a blend of them makes of another.

A motion x -> R p + t is r + eps d: r the unit quaternion of R, d = 1/2 t r (t without a real part).
A blend b = b_r + eps b_d = sum_j w_j (r_j + eps d_j), every r_j on the side of the first, is made
a rigid motion by its length (Kavan, Collins, Zara, O'Sullivan, ACM Trans. Graphics 27,
2008, 105), so flesh around a bent joint neither thins out nor folds as under blended matrices:

    x = vec(b_r p b_r* + 2 b_d b_r*) / |b_r|^2

With velocity v of what is at the origin and spin o, r' = 1/2 o r and d' = 1/2 (o d + v r). For a
force f on x the power f . x' is that of

    G_d = 2 f b_r / |b_r|^2       G_r = -2 (f b_r p + f b_d + (f . x) b_r) / |b_r|^2

on b, hence of the force 1/2 w_j vec(G_d r_j*) at the origin and the moment 1/2 w_j vec(G_r r_j* +
G_d d_j*) about it, on segment j: the adjoint of the velocities, to the last digit.
"""

import numpy as np

from contact.kernel import kernel

Quaternion = tuple[float, float, float, float]  # real part first
NOWHERE = (0.0, 0.0, 0.0, 0.0)  # b_d of a rotation about the origin


@kernel(makes_arrays=False, fastmath={"contract"})
def product(a: Quaternion, b: Quaternion) -> Quaternion:
    """a b."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


@kernel(makes_arrays=False, fastmath={"contract"})
def times_conjugate(a: Quaternion, b: Quaternion) -> Quaternion:
    """a b*."""
    return product(a, (b[0], -b[1], -b[2], -b[3]))


@kernel(makes_arrays=False, fastmath={"contract"})
def set_motion(
    out: np.ndarray, centre: np.ndarray, axes: np.ndarray, at: np.ndarray, along: np.ndarray
) -> None:
    """out (8,) = r, d of the motion of a segment from pose `at`, `along` to `centre`, `axes`.

    Axes are rows e1, e2, e3; the sign of r is free.
    """
    R00 = axes[0, 0] * along[0, 0] + axes[1, 0] * along[1, 0] + axes[2, 0] * along[2, 0]
    R11 = axes[0, 1] * along[0, 1] + axes[1, 1] * along[1, 1] + axes[2, 1] * along[2, 1]
    R22 = axes[0, 2] * along[0, 2] + axes[1, 2] * along[1, 2] + axes[2, 2] * along[2, 2]
    R01 = axes[0, 0] * along[0, 1] + axes[1, 0] * along[1, 1] + axes[2, 0] * along[2, 1]
    R10 = axes[0, 1] * along[0, 0] + axes[1, 1] * along[1, 0] + axes[2, 1] * along[2, 0]
    R02 = axes[0, 0] * along[0, 2] + axes[1, 0] * along[1, 2] + axes[2, 0] * along[2, 2]
    R20 = axes[0, 2] * along[0, 0] + axes[1, 2] * along[1, 0] + axes[2, 2] * along[2, 0]
    R12 = axes[0, 1] * along[0, 2] + axes[1, 1] * along[1, 2] + axes[2, 1] * along[2, 2]
    R21 = axes[0, 2] * along[0, 1] + axes[1, 2] * along[1, 1] + axes[2, 2] * along[2, 1]
    # the largest of the four squares loses no digits (Shepperd, J. Guidance 1, 1978, 223)
    trace = R00 + R11 + R22
    if trace >= max(R00, R11, R22):
        w, x, y, z = 1.0 + trace, R21 - R12, R02 - R20, R10 - R01
    elif R00 >= R11 and R00 >= R22:
        w, x, y, z = R21 - R12, 1.0 + R00 - R11 - R22, R10 + R01, R20 + R02
    elif R11 >= R22:
        w, x, y, z = R02 - R20, R10 + R01, 1.0 + R11 - R00 - R22, R21 + R12
    else:
        w, x, y, z = R10 - R01, R20 + R02, R21 + R12, 1.0 + R22 - R00 - R11
    size = np.sqrt(w * w + x * x + y * y + z * z)
    r = (w / size, x / size, y / size, z / size)
    t0 = centre[0] - R00 * at[0] - R01 * at[1] - R02 * at[2]
    t1 = centre[1] - R10 * at[0] - R11 * at[1] - R12 * at[2]
    t2 = centre[2] - R20 * at[0] - R21 * at[1] - R22 * at[2]
    d = product((0.0, 0.5 * t0, 0.5 * t1, 0.5 * t2), r)
    for i in range(4):
        out[i], out[4 + i] = r[i], d[i]


@kernel(makes_arrays=False, fastmath={"contract"})
def set_rate(
    out: np.ndarray, motion: np.ndarray, centre: np.ndarray, velocity: np.ndarray, spin: np.ndarray
) -> None:
    """out (8,) = r', d' of a motion (8,) from velocity at `centre` and spin, all (3,)."""
    o = (0.0, 0.5 * spin[0], 0.5 * spin[1], 0.5 * spin[2])
    v = (
        0.0,
        0.5 * (velocity[0] - spin[1] * centre[2] + spin[2] * centre[1]),
        0.5 * (velocity[1] - spin[2] * centre[0] + spin[0] * centre[2]),
        0.5 * (velocity[2] - spin[0] * centre[1] + spin[1] * centre[0]),
    )
    r = (motion[0], motion[1], motion[2], motion[3])
    rate, first = product(o, r), product(v, r)
    second = product(o, (motion[4], motion[5], motion[6], motion[7]))
    for i in range(4):
        out[i], out[4 + i] = rate[i], first[i] + second[i]


@kernel(makes_arrays=False, fastmath={"contract"})
def blend(
    motions: np.ndarray, rates: np.ndarray, which: np.ndarray, weights: np.ndarray
) -> tuple[Quaternion, Quaternion]:
    """b_r, b_d of motions `which` (k,) with `weights` (k,), of `rates` instead where these differ.

    rates : (m, 8), the motions themselves or their rates; signs are those of the motions
    """
    first = which[0]
    b0 = b1 = b2 = b3 = d0 = d1 = d2 = d3 = 0.0
    for k in range(len(which)):
        w, j = weights[k], which[k]
        if w == 0.0:
            continue
        if k > 0 and sign(motions, first, j) < 0.0:
            w = -w
        b0, b1, b2, b3 = (
            b0 + w * rates[j, 0], b1 + w * rates[j, 1], b2 + w * rates[j, 2], b3 + w * rates[j, 3]
        )  # fmt: skip
        d0, d1, d2, d3 = (
            d0 + w * rates[j, 4], d1 + w * rates[j, 5], d2 + w * rates[j, 6], d3 + w * rates[j, 7]
        )  # fmt: skip
    return (b0, b1, b2, b3), (d0, d1, d2, d3)


@kernel(makes_arrays=False, fastmath={"contract"})
def sign(motions: np.ndarray, first: int, other: int) -> float:
    """1 if the quaternions of two motions are on one side, -1 if not."""
    dot = 0.0
    for i in range(4):
        dot += motions[first, i] * motions[other, i]
    return 1.0 if dot >= 0.0 else -1.0


@kernel(makes_arrays=False, fastmath={"contract"})
def moved(b: Quaternion, d: Quaternion, p: Quaternion) -> tuple[float, float, float]:
    """x of a point p (real part 0)."""
    # with b = (w, v) and d = (e, u): x = p + 2 (v x (v x p + w p + u) + w u - e v)/N
    w, v0, v1, v2 = b
    e, u0, u1, u2 = d
    q0 = v1 * p[3] - v2 * p[2] + w * p[1] + u0
    q1 = v2 * p[1] - v0 * p[3] + w * p[2] + u1
    q2 = v0 * p[2] - v1 * p[1] + w * p[3] + u2
    scale = 2.0 / (w * w + v0 * v0 + v1 * v1 + v2 * v2)
    return (
        p[1] + scale * (v1 * q2 - v2 * q1 + w * u0 - e * v0),
        p[2] + scale * (v2 * q0 - v0 * q2 + w * u1 - e * v1),
        p[3] + scale * (v0 * q1 - v1 * q0 + w * u2 - e * v2),
    )


@kernel(makes_arrays=False, fastmath={"contract"})
def moving(
    b: Quaternion, d: Quaternion, p: Quaternion,
    db: Quaternion, dd: Quaternion, x: tuple[float, float, float],
) -> tuple[float, float, float]:  # fmt: skip
    """x' of a point from the rates db, dd of b, d; x as `moved` gives it."""
    N = b[0] ** 2 + b[1] ** 2 + b[2] ** 2 + b[3] ** 2
    dN = 2.0 * (b[0] * db[0] + b[1] * db[1] + b[2] * db[2] + b[3] * db[3])
    q, dq = product(b, p), product(db, p)
    one = times_conjugate(
        (dq[0] + 2.0 * dd[0], dq[1] + 2.0 * dd[1], dq[2] + 2.0 * dd[2], dq[3] + 2.0 * dd[3]), b
    )
    two = times_conjugate(
        (q[0] + 2.0 * d[0], q[1] + 2.0 * d[1], q[2] + 2.0 * d[2], q[3] + 2.0 * d[3]), db
    )
    return (
        (one[1] + two[1] - x[0] * dN) / N,
        (one[2] + two[2] - x[1] * dN) / N,
        (one[3] + two[3] - x[2] * dN) / N,
    )


@kernel(makes_arrays=False, fastmath={"contract"})
def gradients(
    b: Quaternion, d: Quaternion, p: Quaternion, f: Quaternion, x: tuple[float, float, float]
) -> tuple[Quaternion, Quaternion]:
    """G_r, G_d of f . x (f with real part 0)."""
    N = b[0] ** 2 + b[1] ** 2 + b[2] ** 2 + b[3] ** 2
    power = f[1] * x[0] + f[2] * x[1] + f[3] * x[2]
    fb, fd = product(f, b), product(f, d)
    fbp = product(fb, p)
    c = -2.0 / N
    G_r = (
        c * (fbp[0] + fd[0] + power * b[0]), c * (fbp[1] + fd[1] + power * b[1]),
        c * (fbp[2] + fd[2] + power * b[2]), c * (fbp[3] + fd[3] + power * b[3]),
    )  # fmt: skip
    return G_r, (-c * fb[0], -c * fb[1], -c * fb[2], -c * fb[3])
