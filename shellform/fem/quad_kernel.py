# SPDX-License-Identifier: LGPL-3.0-or-later
"""Internal force of the 4-node quad with arcs and turning angles, by segments: Eq. 14.

The same energy as element.py writes in UFL, which is its test. There every quadrature point works
out its own derivatives; but all strains at the corners come from six segments, four sides and two
diagonals, and all curvatures along an axis from two. Sharing them makes the force several times
cheaper, which is what explicit steps need.

Nodes of a cell run in tensor order (0,0), (1,0), (0,1), (1,1). Segments: 0 = 01, 1 = 23 along axis
1; 2 = 02, 3 = 13 along axis 2; diagonals 4 = 21, 5 = 03.
"""

import numpy as np

from shellform.material.sheet import Sheet

from .element import GAUSS2
from .quad_kernel_parts import (
    add,
    add_to,
    bent,
    compiled,
    corner,
    corner_loss,
    diagonals,
    dot,
    half_length_squared,
    length_rate,
    line_rate,
    mix,
    moments,
    plus,
    point_loss,
    row,
    segment,
    shear_rate,
    sub,
    turning,
    twist_rate,
    twisted,
)
from .strains import voigt_rows

FIRST = np.array([0, 2, 0, 1, 2, 0])
SECOND = np.array([1, 3, 2, 3, 1, 3])
LINE = np.array([p for p, _ in GAUSS2])
NEAR, FAR = 1.0 - GAUSS2[0][0], GAUSS2[0][0]


def baked(
    points: np.ndarray,
    directors: np.ndarray,
    cells: np.ndarray,
    warp: np.ndarray | None,
    fabric: Sheet,
) -> tuple[np.ndarray, np.ndarray]:
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
    return np.moveaxis(np.array(voigt_rows(a, b, c, d)), -1, 0)


@compiled
def _strains_at_rest(X, D, rest):
    for m in range(X.shape[0]):
        for s in range(6):
            i, j = FIRST[s], SECOND[s]
            dx, dd = sub(row(X[m], j, 0), row(X[m], i, 0)), sub(row(D[m], j, 0), row(D[m], i, 0))
            rest[m, s] = half_length_squared(dx, dot(dx, dd), dot(dd, dd))
            if s < 4:
                rest[m, 6 + s] = 0.5 * dot(dx, add(row(D[m], i, 0), row(D[m], j, 0)))
        for k in range(4):
            g, h = _line(X[m], k), _line(D[m], k)
            rest[m, 10 + k] = turning(dot(g, h), dot(h, h))
            one, two = k // 2, 2 + k % 2
            g, h = _line(X[m], one), _line(D[m], one)
            G, H = _line(X[m], two), _line(D[m], two)
            pb, mb, pc, mc = diagonals(
                g, h, dot(g, h), dot(h, h), G, H, dot(G, H), dot(H, H)
            )  # fmt: skip
            rest[m, 14 + k] = 0.25 * (turning(pb, pc) - turning(mb, mc))


@compiled
def _line(X, k):
    """Derivative along line k of a cell: 0, 1 along axis 1, 2, 3 along axis 2."""
    one, two = (1, 2) if k < 2 else (2, 1)
    far = FAR if k % 2 == 0 else NEAR
    first = sub(row(X, one, 0), row(X, 0, 0))
    second = sub(row(X, 3, 0), row(X, two, 0))
    return mix(1.0 - far, first, far, second)


@compiled
def add_force(
    w: np.ndarray,
    ahead: np.ndarray,
    damped: bool,
    points: np.ndarray,
    cells: np.ndarray,
    stiffness: np.ndarray,
    rest: np.ndarray,
    r: np.ndarray,
) -> float:
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
    for m in range(cells.shape[0]):
        i0, i1, i2, i3 = cells[m, 0], cells[m, 1], cells[m, 2], cells[m, 3]
        C, at_rest = stiffness[m], rest[m]
        x0, x1 = add(row(points, i0, 0), row(w, i0, 0)), add(row(points, i1, 0), row(w, i1, 0))
        x2, x3 = add(row(points, i2, 0), row(w, i2, 0)), add(row(points, i3, 0), row(w, i3, 0))
        d0, d1, d2, d3 = row(w, i0, 3), row(w, i1, 3), row(w, i2, 3), row(w, i3, 3)
        X0, X1, X2, X3 = sub(x1, x0), sub(x3, x2), sub(x2, x0), sub(x3, x1)
        D0, D1, D2, D3 = sub(d1, d0), sub(d3, d2), sub(d2, d0), sub(d3, d1)
        X4, X5, D4, D5 = sub(x1, x2), sub(x3, x0), sub(d1, d2), sub(d3, d0)

        # stretch of the segments, shear of the sides
        b0, b1, b2, b3 = dot(X0, D0), dot(X1, D1), dot(X2, D2), dot(X3, D3)
        c0, c1, c2, c3 = dot(D0, D0), dot(D1, D1), dot(D2, D2), dot(D3, D3)
        b4, b5, c4, c5 = dot(X4, D4), dot(X5, D5), dot(D4, D4), dot(D5, D5)
        s0 = half_length_squared(X0, b0, c0) - at_rest[0]
        s1 = half_length_squared(X1, b1, c1) - at_rest[1]
        s2 = half_length_squared(X2, b2, c2) - at_rest[2]
        s3 = half_length_squared(X3, b3, c3) - at_rest[3]
        s4 = half_length_squared(X4, b4, c4) - at_rest[4]
        s5 = half_length_squared(X5, b5, c5) - at_rest[5]
        m0, m1 = mix(0.5, d0, 0.5, d1), mix(0.5, d2, 0.5, d3)
        m2, m3 = mix(0.5, d0, 0.5, d2), mix(0.5, d1, 0.5, d3)
        y0, y1 = dot(X0, m0) - at_rest[6], dot(X1, m1) - at_rest[7]
        y2, y3 = dot(X2, m2) - at_rest[8], dot(X3, m3) - at_rest[9]

        # curvature on two lines along each axis, twist where they cross
        g0, h0 = mix(NEAR, X0, FAR, X1), mix(NEAR, D0, FAR, D1)
        g1, h1 = mix(FAR, X0, NEAR, X1), mix(FAR, D0, NEAR, D1)
        g2, h2 = mix(NEAR, X2, FAR, X3), mix(NEAR, D2, FAR, D3)
        g3, h3 = mix(FAR, X2, NEAR, X3), mix(FAR, D2, NEAR, D3)
        e0, e1, e2, e3 = dot(g0, h0), dot(g1, h1), dot(g2, h2), dot(g3, h3)
        f0, f1, f2, f3 = dot(h0, h0), dot(h1, h1), dot(h2, h2), dot(h3, h3)
        k0, k1 = turning(e0, f0) - at_rest[10], turning(e1, f1) - at_rest[11]
        k2, k3 = turning(e2, f2) - at_rest[12], turning(e3, f3) - at_rest[13]
        pb0, mb0, pc0, mc0 = diagonals(g0, h0, e0, f0, g2, h2, e2, f2)
        pb1, mb1, pc1, mc1 = diagonals(g0, h0, e0, f0, g3, h3, e3, f3)
        pb2, mb2, pc2, mc2 = diagonals(g1, h1, e1, f1, g2, h2, e2, f2)
        pb3, mb3, pc3, mc3 = diagonals(g1, h1, e1, f1, g3, h3, e3, f3)
        t0 = 0.25 * (turning(pb0, pc0) - turning(mb0, mc0)) - at_rest[14]
        t1 = 0.25 * (turning(pb1, pc1) - turning(mb1, mc1)) - at_rest[15]
        t2 = 0.25 * (turning(pb2, pc2) - turning(mb2, mc2)) - at_rest[16]
        t3 = 0.25 * (turning(pb3, pc3) - turning(mb3, mc3)) - at_rest[17]

        if damped:
            v0, v1 = sub(row(ahead, i0, 0), row(w, i0, 0)), sub(row(ahead, i1, 0), row(w, i1, 0))
            v2, v3 = sub(row(ahead, i2, 0), row(w, i2, 0)), sub(row(ahead, i3, 0), row(w, i3, 0))
            o0, o1 = sub(row(ahead, i0, 3), d0), sub(row(ahead, i1, 3), d1)
            o2, o3 = sub(row(ahead, i2, 3), d2), sub(row(ahead, i3, 3), d3)
            V0, V1, V2, V3 = sub(v1, v0), sub(v3, v2), sub(v2, v0), sub(v3, v1)
            O0, O1, O2, O3 = sub(o1, o0), sub(o3, o2), sub(o2, o0), sub(o3, o1)
            r0, r1 = length_rate(X0, D0, b0, c0, V0, O0), length_rate(X1, D1, b1, c1, V1, O1)
            r2, r3 = length_rate(X2, D2, b2, c2, V2, O2), length_rate(X3, D3, b3, c3, V3, O3)
            r4 = length_rate(X4, D4, b4, c4, sub(v1, v2), sub(o1, o2))
            r5 = length_rate(X5, D5, b5, c5, sub(v3, v0), sub(o3, o0))
            s0, s1, s2, s3, s4, s5 = s0 + r0, s1 + r1, s2 + r2, s3 + r3, s4 + r4, s5 + r5
            z0, z1 = shear_rate(X0, V0, m0, o0, o1), shear_rate(X1, V1, m1, o2, o3)
            z2, z3 = shear_rate(X2, V2, m2, o0, o2), shear_rate(X3, V3, m3, o1, o3)
            y0, y1, y2, y3 = y0 + z0, y1 + z1, y2 + z2, y3 + z3
            loss += corner_loss(C, 0, 0.5, r0, r2, r4, z0, z2)
            loss += corner_loss(C, 1, -0.5, r0, r3, r5, z0, z3)
            loss += corner_loss(C, 2, -0.5, r1, r2, r5, z1, z2)
            loss += corner_loss(C, 3, 0.5, r1, r3, r4, z1, z3)
            v0, o0 = mix(NEAR, V0, FAR, V1), mix(NEAR, O0, FAR, O1)
            v1, o1 = mix(FAR, V0, NEAR, V1), mix(FAR, O0, NEAR, O1)
            v2, o2 = mix(NEAR, V2, FAR, V3), mix(NEAR, O2, FAR, O3)
            v3, o3 = mix(FAR, V2, NEAR, V3), mix(FAR, O2, NEAR, O3)
            vb0, vc0, r0 = line_rate(g0, h0, e0, f0, v0, o0)
            vb1, vc1, r1 = line_rate(g1, h1, e1, f1, v1, o1)
            vb2, vc2, r2 = line_rate(g2, h2, e2, f2, v2, o2)
            vb3, vc3, r3 = line_rate(g3, h3, e3, f3, v3, o3)
            k0, k1, k2, k3 = k0 + r0, k1 + r1, k2 + r2, k3 + r3
            z0 = twist_rate(g0, h0, v0, o0, vb0, vc0, g2, h2, v2, o2, vb2, vc2, pb0, mb0, pc0, mc0)
            z1 = twist_rate(g0, h0, v0, o0, vb0, vc0, g3, h3, v3, o3, vb3, vc3, pb1, mb1, pc1, mc1)
            z2 = twist_rate(g1, h1, v1, o1, vb1, vc1, g2, h2, v2, o2, vb2, vc2, pb2, mb2, pc2, mc2)
            z3 = twist_rate(g1, h1, v1, o1, vb1, vc1, g3, h3, v3, o3, vb3, vc3, pb3, mb3, pc3, mc3)
            t0, t1, t2, t3 = t0 + z0, t1 + z1, t2 + z2, t3 + z3
            loss += point_loss(C, 0, r0, r2, z0) + point_loss(C, 1, r0, r3, z1)
            loss += point_loss(C, 2, r1, r2, z2) + point_loss(C, 3, r1, r3, z3)

        # corners: pulls of the segments, shear forces of the sides
        p0, p2, n0 = corner(C, 0, 0.5, s0, s2, s4)
        q0, p3, n1 = corner(C, 1, -0.5, s0, s3, s5)
        p1, q2, n2 = corner(C, 2, -0.5, s1, s2, s5)
        q1, q3, n3 = corner(C, 3, 0.5, s1, s3, s4)
        F0, M0 = segment(p0 + q0, X0, D0, b0, c0)
        F1, M1 = segment(p1 + q1, X1, D1, b1, c1)
        F2, M2 = segment(p2 + q2, X2, D2, b2, c2)
        F3, M3 = segment(p3 + q3, X3, D3, b3, c3)
        F4, M4 = segment(-n0 - n3, X4, D4, b4, c4)
        F5, M5 = segment(-n1 - n2, X5, D5, b5, c5)
        q0 = C[0, 6] * y0 + C[0, 7] * y2 + C[1, 6] * y0 + C[1, 7] * y3
        q1 = C[2, 6] * y1 + C[2, 7] * y2 + C[3, 6] * y1 + C[3, 7] * y3
        q2 = C[0, 7] * y0 + C[0, 8] * y2 + C[2, 7] * y1 + C[2, 8] * y2
        q3 = C[1, 7] * y0 + C[1, 8] * y3 + C[3, 7] * y1 + C[3, 8] * y3
        F0, F1, F2, F3 = plus(F0, q0, m0), plus(F1, q1, m1), plus(F2, q2, m2), plus(F3, q3, m3)

        # Gauss points: moments, and what they do to lines and segments
        l0, l2, n = moments(C, 0, k0, k2, t0)
        u0, u2, w0, w2 = twisted(n, g0, h0, g2, h2, pb0, mb0, pc0, mc0)
        p0, l3, n = moments(C, 1, k0, k3, t1)
        a0, u3, a1, w3 = twisted(n, g0, h0, g3, h3, pb1, mb1, pc1, mc1)
        u0, w0, l0 = add(u0, a0), add(w0, a1), l0 + p0
        l1, p2, n = moments(C, 2, k1, k2, t2)
        u1, a0, w1, a1 = twisted(n, g1, h1, g2, h2, pb2, mb2, pc2, mc2)
        u2, w2, l2 = add(u2, a0), add(w2, a1), l2 + p2
        p1, p3, n = moments(C, 3, k1, k3, t3)
        a0, a1, a2, a3 = twisted(n, g1, h1, g3, h3, pb3, mb3, pc3, mc3)
        u1, u3, w1, w3 = add(u1, a0), add(u3, a1), add(w1, a2), add(w3, a3)
        u0, w0 = bent(l0, g0, h0, e0, f0, u0, w0)
        u1, w1 = bent(l1 + p1, g1, h1, e1, f1, u1, w1)
        u2, w2 = bent(l2, g2, h2, e2, f2, u2, w2)
        u3, w3 = bent(l3 + p3, g3, h3, e3, f3, u3, w3)
        F0, M0 = add(F0, mix(NEAR, u0, FAR, u1)), add(M0, mix(NEAR, w0, FAR, w1))
        F1, M1 = add(F1, mix(FAR, u0, NEAR, u1)), add(M1, mix(FAR, w0, NEAR, w1))
        F2, M2 = add(F2, mix(NEAR, u2, FAR, u3)), add(M2, mix(NEAR, w2, FAR, w3))
        F3, M3 = add(F3, mix(FAR, u2, NEAR, u3)), add(M3, mix(FAR, w2, NEAR, w3))

        # to the nodes: segments 01, 23, 02, 13, 21, 03; shear turns both directors of a side
        half_0, half_1 = mix(0.5 * q0, X0, 0.5 * q2, X2), mix(0.5 * q0, X0, 0.5 * q3, X3)
        half_2, half_3 = mix(0.5 * q1, X1, 0.5 * q2, X2), mix(0.5 * q1, X1, 0.5 * q3, X3)
        add_to(r, i0, 0, mix(-1.0, add(F0, F2), -1.0, F5))
        add_to(r, i1, 0, add(sub(F0, F3), F4))
        add_to(r, i2, 0, sub(sub(F2, F1), F4))
        add_to(r, i3, 0, add(add(F1, F3), F5))
        add_to(r, i0, 3, sub(sub(half_0, M0), add(M2, M5)))
        add_to(r, i1, 3, add(add(half_1, M0), sub(M4, M3)))
        add_to(r, i2, 3, add(sub(half_2, M1), sub(M2, M4)))
        add_to(r, i3, 3, add(add(half_3, M1), add(M3, M5)))
    return loss
