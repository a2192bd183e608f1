# SPDX-License-Identifier: LGPL-3.0-or-later
"""Membrane strain of a 4-node quad from the lengths of its four sides and two diagonals: Eq. 12.

Nodes of a cell run in tensor order (0,0), (1,0), (0,1), (1,1). Segments: 01 and 23 along axis 1, 02
and 13 along axis 2, the diagonals 21 and 03. The datum of each is s = |arc|^2/2 less its value at
rest (arc.py). A constant strain E = (E11, E22, 2 E12) in the axes (warp, weft) gives s = R E, a row
of R being (a^2, b^2, a b) for a segment (a, b). Three segments meet in a corner and determine E
there; B is the mean over the corners, by area, of the inverses of their rows, so that B R = I and a
constant strain is exact in any quad.

Two more modes carry bending of the cell in its own plane: the difference of opposite sides less
what B makes of it, with a third of the uniaxial stiffness along these sides, which is exact in a
rectangle. The energy of a cell is

    area psi(B s) + sum over k of (m_k . s)^2/2.

Strains at the corners, integrated there, cost more and bend four times too stiffly in plane.
"""

import numpy as np

FIRST = np.array([0, 2, 0, 1, 2, 0])
SECOND = np.array([1, 3, 2, 3, 1, 3])
# of the three segments of a corner; its node and the two others
CORNERS = (
    ((0, 2, 4), (0, 1, 2)),
    ((0, 3, 5), (1, 0, 3)),
    ((1, 2, 5), (2, 3, 0)),
    ((1, 3, 4), (3, 2, 1)),
)


def six_lengths(
    points: np.ndarray, warp: np.ndarray | None, membrane: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What makes strain and energy of lengths, cell by cell.

    Parameters
    ----------
    points : (m, 4, 3), corners at rest in tensor order [m]
    warp : (3,), (m, 3), or None for sheets without a direction
    membrane : (3, 3), stiffness A of the sheet [N/m]

    Returns
    -------
    B : (m, 3, 6), strain from lengths [1/m^2]
    modes : (m, 2, 6), bending in plane [sqrt(J)/m^2]
    area : (m,) [m^2]
    """
    first, second = lamina_axes(points, warp)
    segments = points[:, SECOND] - points[:, FIRST]
    a, b = (np.einsum("msk,mk->ms", segments, axis) for axis in (first, second))
    # a warped cell: directions as seen along its normal, lengths as they are
    stretch = np.linalg.norm(segments, axis=2) / np.hypot(a, b)
    a, b = a * stretch, b * stretch
    rows = np.stack([a * a, b * b, a * b], axis=2)
    B, total = np.zeros((len(points), 3, 6)), np.zeros(len(points))
    for seen, (corner, one, two) in CORNERS:
        sides = points[:, [one, two]] - points[:, [corner]]
        area = 0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
        B[:, :, seen] += area[:, None, None] * np.linalg.inv(rows[:, seen])
        total += area
    B /= total[:, None, None]
    area = 0.5 * total
    return B, _bending_in_plane(a, b, rows, B, area, np.linalg.inv(membrane)), area


def lamina_axes(points: np.ndarray, warp: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors (m, 3) along warp and weft in the middle of cells (m, 4, 3)."""
    G1 = 0.5 * (points[:, 1] - points[:, 0] + points[:, 3] - points[:, 2])
    G2 = 0.5 * (points[:, 2] - points[:, 0] + points[:, 3] - points[:, 1])
    normal = np.cross(G1, G2)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    first = np.broadcast_to(G1 if warp is None else warp, G1.shape)
    first = first - np.sum(first * normal, axis=1, keepdims=True) * normal
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return first, np.cross(normal, first)


def _bending_in_plane(a, b, rows, B, area, compliance):
    modes = np.empty((len(a), 2, 6))
    constant = np.eye(6) - rows @ B
    for k in range(2):
        along = 0.5 * np.stack([a[:, 2 * k] + a[:, 2 * k + 1], b[:, 2 * k] + b[:, 2 * k + 1]], 1)
        squared = np.sum(along**2, axis=1)
        difference = np.zeros((len(a), 6))
        difference[:, 2 * k + 1] = 0.5 / squared
        difference[:, 2 * k] = -0.5 / squared
        c, s = along.T / np.sqrt(squared)
        v = np.stack([c * c, s * s, c * s], axis=1)
        uniaxial = 1.0 / np.einsum("mi,ij,mj->m", v, compliance, v)
        mode = np.einsum("mi,mij->mj", difference, constant)
        modes[:, k] = np.sqrt(area * uniaxial / 3.0)[:, None] * mode
    return modes
