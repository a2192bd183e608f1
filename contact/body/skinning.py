# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Vertices of a skin carried by several segments: where they are, how fast, and the adjoint.

A vertex is placed by the blended dual quaternions of its segments (`dual_quaternions`), then, near
a joint that bends, kept on its side of the plane that halves the bend (`flesh`):

    s = side n . (x - c),   x <- x + part side (g(s) - s) n,   n = (u_a - u_b) / |u_a - u_b|

c is the joint's centre, in the mean of where both segments carry it; u_a points from it along the
segment above, u_b along the one below, both unit vectors fixed in their segments. All is linear in
the twists of the segments, and `add_skin` is the transpose of `skin_rates` to the last digit, so
virtual power, momentum and angular momentum are exact.
"""

import numpy as np

from contact.kernel import kernel

from .dual_quaternions import (
    blend,
    gradients,
    moved,
    moving,
    set_motion,
    sign,
    times_conjugate,
)
from .flesh import kept_on_side

BENDS = [
    ("above", np.int64),
    ("below", np.int64),
    ("centre_above", float, 3),  # of the joint, in the axes of the segments [m]
    ("centre_below", float, 3),
    ("along_above", float, 3),  # u_a, u_b in the axes of the segments
    ("along_below", float, 3),
]
SKIN = [
    ("point", float, 3),  # where it was bound [m]
    ("bend", np.int64),  # joint that presses it, -1 for none
    ("side", float),  # 1 above that joint, -1 below
    ("margin", float),  # m of `flesh` [m]
    ("room", float),  # r of `flesh` [m]
    ("part", float),  # of the press that it feels, 0 to 1
]


@kernel(makes_arrays=False, fastmath={"contract"})
def _turned(axes, y, out):
    """out (3,) = vector y in the axes (rows) of a segment, in the world's."""
    for c in range(3):
        out[c] = y[0] * axes[0, c] + y[1] * axes[1, c] + y[2] * axes[2, c]


@kernel(makes_arrays=False, fastmath={"contract"})
def set_motions(
    centres: np.ndarray, axes: np.ndarray, at: np.ndarray, along: np.ndarray,
    motions: np.ndarray, matrices: np.ndarray,
) -> None:  # fmt: skip
    """Fill motions (m, 8) and matrices (m, 3, 4), R and t, of segments from where skin was bound.

    centres (m, 3), axes (m, 3, 3) : now; at, along : the same at binding
    """
    for j in range(len(motions)):
        set_motion(motions[j], centres[j], axes[j], at[j], along[j])
        for r in range(3):
            shift = centres[j, r]
            for c in range(3):
                R = 0.0
                for k in range(3):
                    R += axes[j, k, r] * along[j, k, c]
                matrices[j, r, c] = R
                shift -= R * at[j, c]
            matrices[j, r, 3] = shift


@kernel(makes_arrays=False, fastmath={"contract"})
def _on_one(weights, i):
    """Whether vertex i is bound to one segment."""
    return weights.shape[1] == 1 or weights[i, 1] == 0.0


@kernel(makes_arrays=False, fastmath={"contract"})
def set_planes(
    bends: np.ndarray, centres: np.ndarray, axes: np.ndarray, planes: np.ndarray
) -> None:
    """Fill planes (k, 7, 3): arms of c in both segments, u_a, u_b, c, n; the last row is free.

    bends (k,) BENDS; centres (m, 3), axes (m, 3, 3) of the segments; planes[:, 6, 0] = |u_a - u_b|
    """
    for k in range(len(bends)):
        a, b, at = bends[k].above, bends[k].below, planes[k]
        _turned(axes[a], bends[k].centre_above, at[0])
        _turned(axes[b], bends[k].centre_below, at[1])
        _turned(axes[a], bends[k].along_above, at[2])
        _turned(axes[b], bends[k].along_below, at[3])
        size = 0.0
        for c in range(3):
            at[4, c] = 0.5 * (centres[a, c] + at[0, c] + centres[b, c] + at[1, c])
            at[5, c] = at[2, c] - at[3, c]
            size += at[5, c] ** 2
        # only a leg folded back on itself has none; it is not pressed then
        size = np.sqrt(max(size, 1e-12))
        at[6, 0] = size
        for c in range(3):
            at[5, c] /= size


@kernel(makes_arrays=False, fastmath={"contract"})
def place_skin(
    skin: np.ndarray, which: np.ndarray, weights: np.ndarray, motions: np.ndarray,
    matrices: np.ndarray, planes: np.ndarray, out: np.ndarray,
) -> None:  # fmt: skip
    """Fill the places out (n, 3) [m] of the vertices.

    skin : (n,) SKIN; which, weights : (n, k), segments and weights, the largest first
    motions, matrices : of `set_motions`; planes : of `set_planes`
    """
    for i in range(len(skin)):
        k, p = skin[i].bend, skin[i].point
        if _on_one(weights, i):
            R = matrices[which[i, 0]]
            x0 = R[0, 3] + R[0, 0] * p[0] + R[0, 1] * p[1] + R[0, 2] * p[2]
            x1 = R[1, 3] + R[1, 0] * p[0] + R[1, 1] * p[1] + R[1, 2] * p[2]
            x2 = R[2, 3] + R[2, 0] * p[0] + R[2, 1] * p[1] + R[2, 2] * p[2]
        else:
            b, d = blend(motions, motions, which[i], weights[i])
            x0, x1, x2 = moved(b, d, (0.0, p[0], p[1], p[2]))
        if k >= 0:
            at, side = planes[k], skin[i].side
            s = side * (
                at[5, 0] * (x0 - at[4, 0]) + at[5, 1] * (x1 - at[4, 1]) + at[5, 2] * (x2 - at[4, 2])
            )
            push = skin[i].part * side * (kept_on_side(s, skin[i].margin, skin[i].room)[0] - s)
            x0, x1, x2 = x0 + push * at[5, 0], x1 + push * at[5, 1], x2 + push * at[5, 2]
        out[i, 0], out[i, 1], out[i, 2] = x0, x1, x2


@kernel(makes_arrays=False, fastmath={"contract"})
def plane_rates(
    bends: np.ndarray, planes: np.ndarray, velocities: np.ndarray, spins: np.ndarray,
    out: np.ndarray,
) -> None:  # fmt: skip
    """Fill out (k, 2, 3): c' and n' of the planes."""
    for k in range(len(bends)):
        a, b, at = bends[k].above, bends[k].below, planes[k]
        along = 0.0
        for c in range(3):
            d, e = (c + 1) % 3, (c + 2) % 3
            out[k, 0, c] = 0.5 * (
                velocities[a, c] + spins[a, d] * at[0, e] - spins[a, e] * at[0, d]
                + velocities[b, c] + spins[b, d] * at[1, e] - spins[b, e] * at[1, d]
            )  # fmt: skip
            out[k, 1, c] = (
                spins[a, d] * at[2, e] - spins[a, e] * at[2, d]
                - spins[b, d] * at[3, e] + spins[b, e] * at[3, d]
            ) / at[6, 0]  # fmt: skip
            along += out[k, 1, c] * at[5, c]
        for c in range(3):
            out[k, 1, c] -= along * at[5, c]


@kernel(makes_arrays=False, fastmath={"contract"})
def skin_rates(
    skin: np.ndarray, which: np.ndarray, weights: np.ndarray, motions: np.ndarray,
    rates: np.ndarray, planes: np.ndarray, of_planes: np.ndarray, out: np.ndarray,
) -> None:  # fmt: skip
    """Fill the velocities out (n, 3) [m/s]: the derivative of `place_skin`.

    rates (m, 8) : of the motions; of_planes : of `plane_rates`
    """
    for i in range(len(skin)):
        p = (0.0, skin[i].point[0], skin[i].point[1], skin[i].point[2])
        b, d = blend(motions, motions, which[i], weights[i])
        db, dd = blend(motions, rates, which[i], weights[i])
        x = moved(b, d, p)
        v = moving(b, d, p, db, dd, x)
        for c in range(3):
            out[i, c] = v[c]
        k = skin[i].bend
        if k < 0:
            continue
        at, side, s, ds = planes[k], skin[i].side, 0.0, 0.0
        for c in range(3):
            arm = x[c] - at[4, c]
            s += at[5, c] * arm
            ds += at[5, c] * (v[c] - of_planes[k, 0, c]) + of_planes[k, 1, c] * arm
        g, slope = kept_on_side(side * s, skin[i].margin, skin[i].room)
        push, h = skin[i].part * (slope - 1.0) * ds, skin[i].part * (side * g - s)
        for c in range(3):
            out[i, c] += push * at[5, c] + h * of_planes[k, 1, c]


@kernel(makes_arrays=False, fastmath={"contract"})
def add_skin(
    skin: np.ndarray, which: np.ndarray, weights: np.ndarray, motions: np.ndarray,
    bends: np.ndarray, planes: np.ndarray, centres: np.ndarray,
    pushed: np.ndarray, at_vertices: np.ndarray, book: np.ndarray,
) -> None:  # fmt: skip
    """Book what acts at vertices to segments, see `surface_motion.SurfaceMotion.add_to_segments`.

    centres : (m, 3) of the segments [m], about which moments are taken
    pushed : vertices that count; at_vertices : (n, 6), impulses and three energies
    book : (m, 9), added to
    """
    for m in range(len(pushed)):
        i = pushed[m]
        idle = True
        for c in range(6):
            idle = idle and at_vertices[i, c] == 0.0
        if idle:
            continue
        p = (0.0, skin[i].point[0], skin[i].point[1], skin[i].point[2])
        b, d = blend(motions, motions, which[i], weights[i])
        x = moved(b, d, p)
        f0, f1, f2 = at_vertices[i, 0], at_vertices[i, 1], at_vertices[i, 2]
        k = skin[i].bend
        if k >= 0:
            at, side = planes[k], skin[i].side
            n0, n1, n2 = at[5, 0], at[5, 1], at[5, 2]
            r0, r1, r2 = x[0] - at[4, 0], x[1] - at[4, 1], x[2] - at[4, 2]
            s = n0 * r0 + n1 * r1 + n2 * r2
            g, slope = kept_on_side(side * s, skin[i].margin, skin[i].room)
            along = f0 * n0 + f1 * n1 + f2 * n2
            push, h = skin[i].part * (slope - 1.0) * along, skin[i].part * (side * g - s)
            if h != 0.0:
                # what acts on the joint's centre, and on n, of which the part along n does nothing
                q0, q1, q2 = push * r0 + h * f0, push * r1 + h * f1, push * r2 + h * f2
                o = q0 * n0 + q1 * n1 + q2 * n2
                q0, q1, q2 = (
                    (q0 - o * n0) / at[6, 0], (q1 - o * n1) / at[6, 0], (q2 - o * n2) / at[6, 0]
                )  # fmt: skip
                c0, c1, c2 = -0.5 * push * n0, -0.5 * push * n1, -0.5 * push * n2
                for end in range(2):
                    j = bends[k].above if end == 0 else bends[k].below
                    u, arm, way = at[2 + end], at[end], 1.0 - 2.0 * end
                    book[j, 0] += c0
                    book[j, 1] += c1
                    book[j, 2] += c2
                    book[j, 3] += arm[1] * c2 - arm[2] * c1 + way * (u[1] * q2 - u[2] * q1)
                    book[j, 4] += arm[2] * c0 - arm[0] * c2 + way * (u[2] * q0 - u[0] * q2)
                    book[j, 5] += arm[0] * c1 - arm[1] * c0 + way * (u[0] * q1 - u[1] * q0)
                f0, f1, f2 = f0 + push * n0, f1 + push * n1, f2 + push * n2
        G_r, G_d = gradients(b, d, p, (0.0, f0, f1, f2), x)
        first = which[i, 0]
        for a in range(which.shape[1]):
            w, j = weights[i, a], which[i, a]
            if w == 0.0:
                continue
            half = 0.5 * w * sign(motions, first, j)
            r = (motions[j, 0], motions[j, 1], motions[j, 2], motions[j, 3])
            F = times_conjugate(G_d, r)
            M = times_conjugate(G_r, r)
            L = times_conjugate(G_d, (motions[j, 4], motions[j, 5], motions[j, 6], motions[j, 7]))
            F0, F1, F2 = half * F[1], half * F[2], half * F[3]
            z = centres[j]
            book[j, 0] += F0
            book[j, 1] += F1
            book[j, 2] += F2
            book[j, 3] += half * (M[1] + L[1]) - z[1] * F2 + z[2] * F1
            book[j, 4] += half * (M[2] + L[2]) - z[2] * F0 + z[0] * F2
            book[j, 5] += half * (M[3] + L[3]) - z[0] * F1 + z[1] * F0
            for c in range(3):
                book[j, 6 + c] += w * at_vertices[i, 3 + c]


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
