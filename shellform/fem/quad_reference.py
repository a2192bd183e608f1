# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the force of the 4-node quad needs of the state at rest: stiffness and strains: Eqs. 12, 14.

Stiffness is that of the lamina at the corners and Gauss points, in the cell's own axes; strains at
rest are those of `quad_membrane` and `quad_bending`.
"""

import numpy as np

from shellform.material.sheet import Sheet

from .element import GAUSS2
from .quad_bending import FAR, NEAR, crossing, turning, twist
from .quad_membrane import half_length_squared, segment
from .strains import voigt_rows
from .vector3 import add, compiled, dot, mix, row, sub

FIRST = np.array([0, 2, 0, 1, 2, 0])  # ends of the segments, see quad_kernel.py
SECOND = np.array([1, 3, 2, 3, 1, 3])
LINE = np.array([p for p, _ in GAUSS2])


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
            line = segment(_line(X[m], k), _line(D[m], k))
            rest[m, 10 + k] = turning(line.b, line.c)
            one, two = k // 2, 2 + k % 2
            p = segment(_line(X[m], one), _line(D[m], one))
            q = segment(_line(X[m], two), _line(D[m], two))
            rest[m, 14 + k] = twist(crossing(p, q))


@compiled
def _line(X, k):
    """Derivative along line k of a cell: 0, 1 along axis 1, 2, 3 along axis 2."""
    one, two = (1, 2) if k < 2 else (2, 1)
    far = FAR if k % 2 == 0 else NEAR
    first = sub(row(X, one, 0), row(X, 0, 0))
    second = sub(row(X, 3, 0), row(X, two, 0))
    return mix(1.0 - far, first, far, second)
