# SPDX-License-Identifier: LGPL-3.0-or-later
"""Internal force of the 4-node quad with arcs and turning angles, by segments: Eq. 14.

The same energy as element.py writes in UFL, which is its test. There every quadrature point works
out its own derivatives; but all strains at the corners come from six segments, four sides and two
diagonals, and all curvatures along an axis from two. Sharing them makes the force several times
cheaper, which is what explicit steps need.

Nodes of a cell run in tensor order (0,0), (1,0), (0,1), (1,1). Segments: 0 = 01, 1 = 23 along axis
1; 2 = 02, 3 = 13 along axis 2; diagonals 4 = 21, 5 = 03.
"""

import numba
import numpy as np

from .element import GAUSS2

FIRST = np.array([0, 2, 0, 1, 2, 0])
SECOND = np.array([1, 3, 2, 3, 1, 3])
LINE = np.array([p for p, _ in GAUSS2])


def baked(points, directors, cells, warp, fabric):
    """Stiffness at corners and Gauss points and the strains at rest, cell by cell.

    Parameters
    ----------
    points, directors : (n, 3), reference state; cells : (m, 4) in tensor order
    warp : (3,), (m, 3) or None; fabric : Fabric

    Returns
    -------
    stiffness : (m, 4, 15), at corner k: membrane (6), shear (3); at Gauss point k: bending (6); all
        covariant, times the area of the point; symmetric matrices as upper triangles
    rest : (m, 18), strains at rest: 6 segments, 4 sides' shear, 2 + 2 curvatures, 4 twists
    """
    X, D = points[cells], directors[cells]
    stiffness = np.empty((len(cells), 4, 15))
    triangle = np.triu_indices(3)
    for k in range(4):
        i, j = k % 2, k // 2
        M, area = _lamina(X[:, 1 + 2 * j] - X[:, 2 * j], X[:, 2 + i] - X[:, i], warp)
        V = _voigt(M)
        A = np.einsum("mki,kl,mlj->mij", V, fabric.membrane, V) * area[:, None, None] / 4
        S = np.einsum("mki,kl,mlj->mij", M, fabric.shear, M) * area[:, None, None] / 4
        stiffness[:, k, :6] = A[:, triangle[0], triangle[1]]
        stiffness[:, k, 6:9] = S[:, [0, 0, 1], [0, 1, 1]]
        p, q = LINE[i], LINE[j]
        G1 = (1 - q) * (X[:, 1] - X[:, 0]) + q * (X[:, 3] - X[:, 2])
        G2 = (1 - p) * (X[:, 2] - X[:, 0]) + p * (X[:, 3] - X[:, 1])
        M, area = _lamina(G1, G2, warp)
        V = _voigt(M)
        B = np.einsum("mki,kl,mlj->mij", V, fabric.bending, V) * area[:, None, None] / 4
        stiffness[:, k, 9:] = B[:, triangle[0], triangle[1]]
    rest = np.zeros((len(cells), 18))
    _strains_at_rest(X, D, rest)
    return stiffness, rest


def _lamina(G1, G2, warp):
    """strains.lamina on arrays: M (m, 2, 2) and the area |G1 x G2| (m,)."""
    dot = lambda a, b: np.sum(a * b, axis=-1)  # noqa: E731
    a11, a12, a22 = dot(G1, G1), dot(G1, G2), dot(G2, G2)
    area = np.sqrt(a11 * a22 - a12 * a12)
    warp = G1 if warp is None else np.broadcast_to(warp, G1.shape)
    p, q = dot(warp, G1), dot(warp, G2)
    c1, c2 = a22 * p - a12 * q, a11 * q - a12 * p
    length = np.sqrt(c1 * p + c2 * q)
    M = np.stack([c1 / area, c2 / area, -q, p], axis=1).reshape(-1, 2, 2)
    return M / length[:, None, None], area


def _voigt(M):
    (a, b), (c, d) = np.moveaxis(M, 0, -1)
    rows = [[a * a, b * b, 2 * a * b], [c * c, d * d, 2 * c * d]]
    rows.append([2 * a * c, 2 * b * d, 2 * (a * d + b * c)])
    return np.moveaxis(np.array(rows), -1, 0)


compiled = numba.njit(
    # not finite stays not finite: no assumption that NaN or infinity do not occur
    cache=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz", "arcp"}
)  # fmt: skip


@compiled
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def _half_length_squared(dx, dd):
    b = _dot(dx, dd)
    return 0.5 * _dot(dx, dx) + b * b * (1.0 + 2.0 / 15.0 * _dot(dd, dd)) / 24.0


@compiled
def _turning(dx, dd):
    c = _dot(dd, dd)
    return _dot(dx, dd) * (1.0 + c / 12.0 + c * c / 90.0)


@compiled
def _turning_rate(b, c, rate_b, rate_c):
    """Rate of b (1 + c/12 + c^2/90)."""
    return rate_b * (1.0 + c / 12.0 + c * c / 90.0) + b * (1.0 / 12.0 + c / 45.0) * rate_c


@compiled
def _strains_at_rest(X, D, rest):
    g, h = np.empty((4, 3)), np.empty((4, 3))
    for m in range(X.shape[0]):
        for s in range(6):
            i, j = FIRST[s], SECOND[s]
            dx, dd = X[m, j] - X[m, i], D[m, j] - D[m, i]
            rest[m, s] = _half_length_squared(dx, dd)
            if s < 4:
                rest[m, 6 + s] = 0.5 * _dot(dx, D[m, i] + D[m, j])
        for k in range(2):
            p = LINE[k]
            for c in range(3):
                g[k, c] = (1 - p) * (X[m, 1, c] - X[m, 0, c]) + p * (X[m, 3, c] - X[m, 2, c])
                h[k, c] = (1 - p) * (D[m, 1, c] - D[m, 0, c]) + p * (D[m, 3, c] - D[m, 2, c])
                g[2 + k, c] = (1 - p) * (X[m, 2, c] - X[m, 0, c]) + p * (X[m, 3, c] - X[m, 1, c])
                h[2 + k, c] = (1 - p) * (D[m, 2, c] - D[m, 0, c]) + p * (D[m, 3, c] - D[m, 1, c])
        for k in range(4):
            rest[m, 10 + k] = _turning(g[k], h[k])
            i, j = k % 2, k // 2
            plus = _turning(g[j] + g[2 + i], h[j] + h[2 + i])
            minus = _turning(g[j] - g[2 + i], h[j] - h[2 + i])
            rest[m, 14 + k] = 0.25 * (plus - minus)


@compiled
def add_force(w, ahead, damped, points, cells, stiffness, rest, r):
    """Add the internal forces of all cells.

    Damped, the stress is that of the strains plus their rates times a time tau, in the present
    configuration: it resists every change of strain, whatever stress there is, and no rigid motion.

    Parameters
    ----------
    w : (n, 6), (u, d); ahead : (n, 6), w + tau times its rates, used if `damped`
    points : (n, 3), reference positions
    cells : (m, 4) int in tensor order; stiffness, rest : see `baked`
    r : (n, 6), added to [N, N m]

    Returns
    -------
    Twice what the rates would store as strains [J]: over tau, the power of damping; 0 undamped
    """
    loss = 0.0
    speed, slide, flex = np.zeros(6), np.zeros(4), np.zeros(4)
    x, d = np.empty((4, 3)), np.empty((4, 3))
    dx, dd, dm = np.empty((6, 3)), np.empty((6, 3)), np.empty((4, 3))
    b, c, strain, pull = np.empty(6), np.empty(6), np.empty(6), np.empty(6)
    gamma, tau = np.empty(4), np.empty(4)
    g, h = np.empty((4, 3)), np.empty((4, 3))
    fg, fh = np.empty((4, 3)), np.empty((4, 3))
    gb, gc, axis, moment = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    fx, fd = np.empty((4, 3)), np.empty((4, 3))
    p, q = np.empty(3), np.empty(3)
    way, turn = np.zeros((4, 3)), np.zeros((4, 3))
    vx, vd = np.zeros((6, 3)), np.zeros((6, 3))
    vg, vh = np.zeros((4, 3)), np.zeros((4, 3))
    vb, vc = np.zeros(4), np.zeros(4)
    for m in range(cells.shape[0]):
        for i in range(4):
            node = cells[m, i]
            for k in range(3):
                x[i, k] = points[node, k] + w[node, k]
                d[i, k] = w[node, 3 + k]
        for s in range(6):
            i, j = FIRST[s], SECOND[s]
            for k in range(3):
                dx[s, k] = x[j, k] - x[i, k]
                dd[s, k] = d[j, k] - d[i, k]
            b[s], c[s] = _dot(dx[s], dd[s]), _dot(dd[s], dd[s])
            arc = b[s] * b[s] * (1.0 + 2.0 / 15.0 * c[s]) / 24.0
            strain[s] = 0.5 * _dot(dx[s], dx[s]) + arc - rest[m, s]
            pull[s] = 0.0
        if damped:
            for i in range(4):
                node = cells[m, i]
                for k in range(3):
                    way[i, k] = ahead[node, k] - w[node, k]
                    turn[i, k] = ahead[node, 3 + k] - w[node, 3 + k]
            for s in range(6):
                i, j = FIRST[s], SECOND[s]
                for k in range(3):
                    vx[s, k] = way[j, k] - way[i, k]
                    vd[s, k] = turn[j, k] - turn[i, k]
                change = _dot(vx[s], dd[s]) + _dot(dx[s], vd[s])
                bend = b[s] * _dot(dd[s], vd[s]) * (2.0 / 15.0)
                speed[s] = _dot(dx[s], vx[s])
                speed[s] += b[s] * (change * (1.0 + 2.0 / 15.0 * c[s]) + bend) / 12.0
                strain[s] += speed[s]
        for s in range(4):
            i, j = FIRST[s], SECOND[s]
            for k in range(3):
                dm[s, k] = 0.5 * (d[i, k] + d[j, k])
            gamma[s] = _dot(dx[s], dm[s]) - rest[m, 6 + s]
            if damped:
                slide[s] = _dot(vx[s], dm[s])
                slide[s] += 0.5 * (_dot(dx[s], turn[i]) + _dot(dx[s], turn[j]))
                gamma[s] += slide[s]
            tau[s] = 0.0
        # corners: membrane and shear
        for k in range(4):
            one, two = k // 2, 2 + k % 2
            diagonal, sign = (4, 0.5) if k == 0 or k == 3 else (5, -0.5)
            e1, e2 = strain[one], strain[two]
            e3 = sign * (e1 + e2 - strain[diagonal])
            C = stiffness[m, k]
            n1 = C[0] * e1 + C[1] * e2 + C[2] * e3
            n2 = C[1] * e1 + C[3] * e2 + C[4] * e3
            n3 = sign * (C[2] * e1 + C[4] * e2 + C[5] * e3)
            pull[one] += n1 + n3
            pull[two] += n2 + n3
            pull[diagonal] -= n3
            tau[one] += C[6] * gamma[one] + C[7] * gamma[two]
            tau[two] += C[7] * gamma[one] + C[8] * gamma[two]
            if damped:
                e1, e2 = speed[one], speed[two]
                e3 = sign * (e1 + e2 - speed[diagonal])
                loss += C[0] * e1 * e1 + C[3] * e2 * e2 + C[5] * e3 * e3
                loss += 2.0 * (C[1] * e1 * e2 + C[2] * e1 * e3 + C[4] * e2 * e3)
                e1, e2 = slide[one], slide[two]
                loss += C[6] * e1 * e1 + 2.0 * C[7] * e1 * e2 + C[8] * e2 * e2
        for i in range(4):
            for k in range(3):
                fx[i, k] = fd[i, k] = 0.0
        for s in range(6):
            i, j = FIRST[s], SECOND[s]
            along = pull[s] * b[s] * (1.0 + 2.0 / 15.0 * c[s]) / 12.0
            across = pull[s] * b[s] * b[s] / 90.0
            for k in range(3):
                force = pull[s] * dx[s, k] + along * dd[s, k]
                couple = along * dx[s, k] + across * dd[s, k]
                if s < 4:
                    force += tau[s] * dm[s, k]
                    half = 0.5 * tau[s] * dx[s, k]
                    fd[i, k] += half
                    fd[j, k] += half
                fx[i, k] -= force
                fx[j, k] += force
                fd[i, k] -= couple
                fd[j, k] += couple
        # Gauss points: bending; g and h hold x,1 and d,1 on two lines, then x,2 and d,2
        for k in range(2):
            z = LINE[k]
            for t in range(3):
                g[k, t] = (1.0 - z) * dx[0, t] + z * dx[1, t]
                h[k, t] = (1.0 - z) * dd[0, t] + z * dd[1, t]
                g[2 + k, t] = (1.0 - z) * dx[2, t] + z * dx[3, t]
                h[2 + k, t] = (1.0 - z) * dd[2, t] + z * dd[3, t]
        if damped:
            for k in range(2):
                z = LINE[k]
                for t in range(3):
                    vg[k, t] = (1.0 - z) * vx[0, t] + z * vx[1, t]
                    vh[k, t] = (1.0 - z) * vd[0, t] + z * vd[1, t]
                    vg[2 + k, t] = (1.0 - z) * vx[2, t] + z * vx[3, t]
                    vh[2 + k, t] = (1.0 - z) * vd[2, t] + z * vd[3, t]
        for k in range(4):
            gb[k], gc[k] = _dot(g[k], h[k]), _dot(h[k], h[k])
            axis[k] = gb[k] * (1.0 + gc[k] / 12.0 + gc[k] * gc[k] / 90.0) - rest[m, 10 + k]
            if damped:
                vb[k] = _dot(vg[k], h[k]) + _dot(g[k], vh[k])
                vc[k] = 2.0 * _dot(h[k], vh[k])
                flex[k] = _turning_rate(gb[k], gc[k], vb[k], vc[k])
                axis[k] += flex[k]
            moment[k] = 0.0
            for t in range(3):
                fg[k, t] = fh[k, t] = 0.0
        for k in range(4):
            one, two = k // 2, 2 + k % 2
            # turning along x,1 + x,2 and x,1 - x,2
            cross_b = _dot(g[one], h[two]) + _dot(g[two], h[one])
            cross_c = 2.0 * _dot(h[one], h[two])
            plus_b, minus_b = gb[one] + gb[two] + cross_b, gb[one] + gb[two] - cross_b
            plus_c, minus_c = gc[one] + gc[two] + cross_c, gc[one] + gc[two] - cross_c
            plus = 1.0 + plus_c / 12.0 + plus_c * plus_c / 90.0
            minus = 1.0 + minus_c / 12.0 + minus_c * minus_c / 90.0
            twist = 0.25 * (plus_b * plus - minus_b * minus) - rest[m, 14 + k]
            C = stiffness[m, k]
            if damped:
                rate_b = _dot(vg[one], h[two]) + _dot(vg[two], h[one])
                rate_b += _dot(g[one], vh[two]) + _dot(g[two], vh[one])
                rate_c = 2.0 * (_dot(vh[one], h[two]) + _dot(h[one], vh[two]))
                sum_b, sum_c = vb[one] + vb[two], vc[one] + vc[two]
                more = _turning_rate(plus_b, plus_c, sum_b + rate_b, sum_c + rate_c)
                less = _turning_rate(minus_b, minus_c, sum_b - rate_b, sum_c - rate_c)
                e1, e2, e3 = flex[one], flex[two], 0.25 * (more - less)
                twist += e3
                loss += C[9] * e1 * e1 + C[12] * e2 * e2 + C[14] * e3 * e3
                loss += 2.0 * (C[10] * e1 * e2 + C[11] * e1 * e3 + C[13] * e2 * e3)
            k1, k2 = axis[one], axis[two]
            moment[one] += C[9] * k1 + C[10] * k2 + C[11] * twist
            moment[two] += C[10] * k1 + C[12] * k2 + C[13] * twist
            m3 = 0.25 * (C[11] * k1 + C[13] * k2 + C[14] * twist)
            plus_d = m3 * plus_b * (1.0 / 6.0 + plus_c * (2.0 / 45.0))
            minus_d = m3 * minus_b * (1.0 / 6.0 + minus_c * (2.0 / 45.0))
            plus, minus = m3 * plus, m3 * minus
            for t in range(3):
                hp, hm = h[one, t] + h[two, t], h[one, t] - h[two, t]
                gp, gm = g[one, t] + g[two, t], g[one, t] - g[two, t]
                p[t], q[t] = plus * hp, minus * hm
                fg[one, t] += p[t] - q[t]
                fg[two, t] += p[t] + q[t]
                p[t], q[t] = plus * gp + plus_d * hp, minus * gm + minus_d * hm
                fh[one, t] += p[t] - q[t]
                fh[two, t] += p[t] + q[t]
        for k in range(4):
            straight = moment[k] * (1.0 + gc[k] / 12.0 + gc[k] * gc[k] / 90.0)
            bent = moment[k] * gb[k] * (1.0 / 6.0 + gc[k] * (2.0 / 45.0))
            for t in range(3):
                fg[k, t] += straight * h[k, t]
                fh[k, t] += straight * g[k, t] + bent * h[k, t]
        for k in range(2):
            z = LINE[k]
            for t in range(3):
                near, far = (1.0 - z) * fg[k, t], z * fg[k, t]
                fx[0, t] -= near
                fx[1, t] += near
                fx[2, t] -= far
                fx[3, t] += far
                near, far = (1.0 - z) * fh[k, t], z * fh[k, t]
                fd[0, t] -= near
                fd[1, t] += near
                fd[2, t] -= far
                fd[3, t] += far
                near, far = (1.0 - z) * fg[2 + k, t], z * fg[2 + k, t]
                fx[0, t] -= near
                fx[2, t] += near
                fx[1, t] -= far
                fx[3, t] += far
                near, far = (1.0 - z) * fh[2 + k, t], z * fh[2 + k, t]
                fd[0, t] -= near
                fd[2, t] += near
                fd[1, t] -= far
                fd[3, t] += far
        for i in range(4):
            node = cells[m, i]
            for t in range(3):
                r[node, t] += fx[i, t]
                r[node, 3 + t] += fd[i, t]
    return loss
