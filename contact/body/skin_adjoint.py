# SPDX-License-Identifier: LGPL-3.0-or-later
"""What acts on a skin, booked to the segments that carry it: the adjoint of `skinning`.

`add_skin` is the transpose of `skin_rates` to the last digit: an impulse at a vertex acts, where a
bend presses it, on the plane of that bend too, on how far the skin bulges (`bulge`), and is shared
out by the derivatives of the blended motion (`dual_quaternions`). With the motions r_j, d_j of the
segments, b = sum_j w_ij r_j of vertex i and its gradients G of f . x, what acts on segment j is

    F_j = g_d r_j* / 2,   M_j = (g_r r_j* + g_d d_j*) / 2,   g = sum_i w_ij G_i,

the vector parts, M_j about the origin: gradients are added up first.
"""

import numpy as np

from contact.kernel import kernel

from .dual_quaternions import NOWHERE, blend, gradients, moved, sign, times_conjugate
from .flesh import kept_on_side


@kernel(makes_arrays=False, fastmath={"contract"})
def add_skin(
    skin: np.ndarray, points: np.ndarray, which: np.ndarray, weights: np.ndarray,
    motions: np.ndarray, bends: np.ndarray, planes: np.ndarray, centres: np.ndarray,
    fields: np.ndarray, directions: np.ndarray, along_fields: np.ndarray, shares: np.ndarray,
    pushed: np.ndarray, at_vertices: np.ndarray, reached: np.ndarray, impulses: np.ndarray,
    sums: np.ndarray, book: np.ndarray,
) -> None:  # fmt: skip
    """Book what acts at vertices to segments, see `surface_motion.SurfaceMotion.add_to_segments`.

    centres : (m, 3) of the segments [m], about which moments are taken
    fields (n,), directions (n, 3), along_fields (k,) : of `bulge`, Q is added; none without one
    pushed : vertices that count; at_vertices : (n, 6), impulses and three energies, these shared
        out by shares (n, m)
    reached, impulses (n, >= 3) : the same of impulses, at the skin before it is drawn smooth
    sums : (m, 8), scratch, zero; book : (m, 9), added to
    """
    for m in range(len(pushed)):
        i = pushed[m]
        for j in range(len(book)):
            for c in range(3):
                book[j, 6 + c] += shares[i, j] * at_vertices[i, 3 + c]
    for m in range(len(reached)):
        i = reached[m]
        f0, f1, f2 = impulses[i, 0], impulses[i, 1], impulses[i, 2]
        if f0 == 0.0 and f1 == 0.0 and f2 == 0.0:
            continue
        p = (0.0, points[i, 0], points[i, 1], points[i, 2])
        b, d = blend(motions, motions, which[i], weights[i])
        x = moved(b, d, p)
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
        if len(fields) > 0 and fields[i] >= 0:
            y = moved(b, NOWHERE, (0.0, directions[i, 0], directions[i, 1], directions[i, 2]))
            along_fields[fields[i]] += f0 * y[0] + f1 * y[1] + f2 * y[2]
        G_r, G_d = gradients(b, d, p, (0.0, f0, f1, f2), x)
        first = which[i, 0]
        for a in range(which.shape[1]):
            w, j = weights[i, a], which[i, a]
            if w == 0.0:
                continue
            if a > 0:
                w *= sign(motions, first, j)
            for c in range(4):
                sums[j, c] += w * G_r[c]
                sums[j, 4 + c] += w * G_d[c]
    for j in range(len(sums)):
        g_r = (0.5 * sums[j, 0], 0.5 * sums[j, 1], 0.5 * sums[j, 2], 0.5 * sums[j, 3])
        g_d = (0.5 * sums[j, 4], 0.5 * sums[j, 5], 0.5 * sums[j, 6], 0.5 * sums[j, 7])
        r = (motions[j, 0], motions[j, 1], motions[j, 2], motions[j, 3])
        F, M = times_conjugate(g_d, r), times_conjugate(g_r, r)
        L = times_conjugate(g_d, (motions[j, 4], motions[j, 5], motions[j, 6], motions[j, 7]))
        z = centres[j]
        book[j, 0] += F[1]
        book[j, 1] += F[2]
        book[j, 2] += F[3]
        book[j, 3] += M[1] + L[1] - z[1] * F[3] + z[2] * F[2]
        book[j, 4] += M[2] + L[2] - z[2] * F[1] + z[0] * F[3]
        book[j, 5] += M[3] + L[3] - z[0] * F[2] + z[1] * F[1]
        for c in range(8):
            sums[j, c] = 0.0
