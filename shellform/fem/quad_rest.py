# SPDX-License-Identifier: LGPL-3.0-or-later
"""What steps do not change in the force of 4-node quads: stiffness and strains at rest, Eq. 14.

Numbers of a cell as quad_force.c reads them; it says what lies where in a cell.
"""

import numpy as np

from shellform.material.sheet import Sheet

from .arc import half_length_squared, turning
from .element import GAUSS2
from .six_lengths import FIRST, SECOND, six_lengths
from .strains import voigt_rows

LINE = np.array([p for p, _ in GAUSS2])
TRIANGLE, PAIR = np.triu_indices(3), np.triu_indices(2)


def at_rest(
    points: np.ndarray,
    directors: np.ndarray,
    cells: np.ndarray,
    warp: np.ndarray | None,
    fabric: Sheet,
    relaxed: bool = False,
    flat: np.ndarray | None = None,
    stiffer: np.ndarray | None = None,
) -> np.ndarray:
    """Numbers of the cells of a sheet.

    Parameters
    ----------
    points, directors : (n, 3), reference state; cells : (m, 4) in tensor order
    warp : (3,), (m, 3) or None
    relaxed : bool, for the membrane relaxed by wrinkles
    flat : (m, 4, 3), corners of cells that are flat without stress, see `corners_at_rest`
    stiffer : (m,), bending stiffness of each cell over that of the fabric; None: 1

    Returns
    -------
    (m, 75), or (m, 91) if relaxed: transverse shear at the corners (12), bending at the Gauss
    points (24), the strains at rest, shear of 4 sides, 4 curvatures, 4 twists; of the membrane the
    matrix of the six lengths (21) and their values at rest; if relaxed strain (18), modes (12),
    area, chords and arcs at rest (6 + 6). Symmetric matrices are upper triangles.
    """
    X, D = corners_at_rest(points, directors, cells, flat)
    dx, dd = (a[:, SECOND] - a[:, FIRST] for a in (X, D))
    shear, bending = _stiffness(X, warp, fabric)
    if stiffer is not None:
        bending *= stiffer[:, None]
    parts = [shear, bending, *_shear_and_curvature(dx, dd, D)]
    B, modes, area = six_lengths(X, warp, fabric.membrane)
    measures = _dot(dx, dx), _dot(dx, dd), _dot(dd, dd)
    lengths = half_length_squared(*measures)
    if relaxed:
        chords = 0.5 * measures[0]
        parts += [B.reshape(-1, 18), modes.reshape(-1, 12), area[:, None]]
        parts += [chords, lengths - chords]
    else:
        matrix = np.einsum("mki,kl,mlj,m->mij", B, fabric.membrane, B, area)
        matrix += np.einsum("mki,mkj->mij", modes, modes)
        parts += [matrix[:, *np.triu_indices(6)], lengths]
    return np.concatenate(parts, axis=1)


def corners_at_rest(
    points: np.ndarray, directors: np.ndarray, cells: np.ndarray, flat: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    """Corners and directors (m, k, 3) of cells without stress.

    Those of the points (n, 3) and directors (n, 3), or of `flat` (m, k, 3): cells cut from flat
    panels, in a plane z = 0 of their own each, so that what is sewn bends the cloth.
    """
    if flat is None:
        return points[cells], directors[cells]
    return flat, np.broadcast_to([0.0, 0.0, 1.0], flat.shape)


def _dot(a, b):
    return np.sum(a * b, axis=-1)


def _stiffness(X, warp, fabric):
    """Covariant stiffness times area: (m, 12) of shear at corners, (m, 24) of bending at points."""
    shear, bending = [], []
    for k in range(4):
        i, j = k % 2, k // 2
        M, area = lamina(X[:, 1 + 2 * j] - X[:, 2 * j], X[:, 2 + i] - X[:, i], warp)
        S = np.einsum("mki,kl,mlj,m->mij", M, fabric.shear, M, area / 4)
        shear.append(S[:, *PAIR])
        p, q = LINE[i], LINE[j]
        G1 = (1 - q) * (X[:, 1] - X[:, 0]) + q * (X[:, 3] - X[:, 2])
        G2 = (1 - p) * (X[:, 2] - X[:, 0]) + p * (X[:, 3] - X[:, 1])
        M, area = lamina(G1, G2, warp)
        V = _voigt(M)
        bending.append(np.einsum("mki,kl,mlj,m->mij", V, fabric.bending, V, area / 4))
    return (
        np.concatenate(shear, axis=1),
        np.concatenate([b[:, *TRIANGLE] for b in bending], axis=1),
    )


def lamina(
    G1: np.ndarray, G2: np.ndarray, warp: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    """strains.lamina on arrays: M (m, 2, 2) and the area |G1 x G2| (m,)."""
    a11, a12, a22 = _dot(G1, G1), _dot(G1, G2), _dot(G2, G2)
    area = np.sqrt(a11 * a22 - a12 * a12)
    warp = G1 if warp is None else np.broadcast_to(warp, G1.shape)
    p, q = _dot(warp, G1), _dot(warp, G2)
    c1, c2 = a22 * p - a12 * q, a11 * q - a12 * p
    length = np.sqrt(c1 * p + c2 * q)
    M = np.stack([c1 / area, c2 / area, -q, p], axis=1).reshape(-1, 2, 2)
    return M / length[:, None, None], area


def _voigt(M):
    (a, b), (c, d) = np.moveaxis(M, 0, -1)
    return np.moveaxis(np.array(voigt_rows(a, b, c, d)), -1, 0)


def _shear_and_curvature(dx, dd, D):
    """Strains at rest (m, 4) each: shear of the sides, curvature of the lines, twist."""
    middle = 0.5 * (D[:, FIRST[:4]] + D[:, SECOND[:4]])
    near, far = 1.0 - LINE[0], LINE[0]
    weights = np.array([[near, far, 0, 0], [far, near, 0, 0], [0, 0, near, far], [0, 0, far, near]])
    g, h = (np.einsum("ks,msi->mki", weights, a[:, :4]) for a in (dx, dd))

    def turn(g, h):
        return turning(_dot(g, h), _dot(h, h))

    one, two = [0, 0, 1, 1], [2, 3, 2, 3]
    plus, minus = (turn(g[:, one] + s * g[:, two], h[:, one] + s * h[:, two]) for s in (1, -1))
    return _dot(dx[:, :4], middle), turn(g, h), 0.25 * (plus - minus)
