# SPDX-License-Identifier: LGPL-3.0-or-later
"""How far cloth is stretched: the largest elongation along the edges of each cell.

Of lengths along the arcs that nodes and directors define, not of chords: a fold that opens moves
its ends apart without any strain.
"""

import numpy as np

from meshes import Surface
from shellform.fem.arc import arc_lengths, sides_at_rest


def stretch_of_cells(
    positions: np.ndarray,
    directors: np.ndarray,
    surface: Surface,
    at_rest: np.ndarray | None = None,
) -> np.ndarray:
    """Largest elongation (m,) of the edges of the cells (m, c) of a surface.

    positions, directors : (n, 3); at_rest : `sides_at_rest(surface)`, where it is asked for often
    """
    corners = surface.cells[:, : 4 if surface.cells.shape[1] > 3 else 3]
    pairs = np.stack([corners, np.roll(corners, -1, axis=1)], 2).reshape(-1, 2)
    rest = (sides_at_rest(surface) if at_rest is None else at_rest).ravel()
    elongation = arc_lengths(positions[pairs], directors[pairs]) / rest - 1
    return elongation.reshape(corners.shape).max(axis=1)
