# SPDX-License-Identifier: LGPL-3.0-or-later
"""Segments of a body that can pass between the nodes of a cell, where nodes alone are met.

A segment that holds a ball of radius r is convex, so the ball cannot pass a cell without its centre
passing through it. Nodes stay outside the ball, grown by the offset. They let its centre through if
the smallest circle around them is larger, of diameter

    s: of 4 or 3 nodes the largest of three of them, that is the circle through a, b, c or, where
    the triangle is obtuse, the one on its longest side.

So nodes alone suffice where 2 (r + offset) >= s, whatever the segment's shape and the alignment; a
rod passes an edge from 2 (r + offset) = its length on, a ball or the end of a rod already passes a
square cell at sqrt(2) times that. Cloth stretches: s is taken larger by STRETCH.
"""

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from contact.geometry.shape import Shape

STRETCH = 1.1  # beyond it a dressed garment is warned of (dressing)


def spans(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Diameters (m,) [m] of the smallest circles around the nodes of cells (m, 3 | 4).

    points : (n, 3) [m]
    """
    widest = np.zeros(len(cells))
    for three in combinations(range(cells.shape[1]), 3):
        a, b, c = (points[cells[:, k]] for k in three)
        sides = np.sort([((b - c) ** 2).sum(1), ((c - a) ** 2).sum(1), ((a - b) ** 2).sum(1)], 0)
        twice = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        acute = sides[2] < sides[0] + sides[1]
        around = np.sqrt(sides.prod(0)) / np.where(acute, twice, 1.0)
        widest = np.maximum(widest, np.where(acute, around, np.sqrt(sides[2])))
    return widest


def thin_segments(shapes: Sequence[Shape], span: float, offset: float) -> list[int]:
    """Numbers of the segments that pass between nodes of a cell of the span [m]; offset [m]."""
    return [
        k for k, s in enumerate(shapes) if 2.0 * (s.inner_radius + offset) < STRETCH * span
    ]  # fmt: skip


def refusal(
    names: Sequence[str], shapes: Sequence[Shape], span: float, cell_size: float, offset: float
) -> str | None:
    """A sentence on the segments that steps which meet nodes alone would let through, or None.

    names, shapes : of the segments; span, cell_size, offset : [m], the largest span of the cells
    """
    thin = thin_segments(shapes, span, offset)
    if not thin:
        return None
    thick = [2e3 * shapes[k].inner_radius for k in thin]
    first = f"'{names[thin[0]]}'" + (f" and {len(thin) - 1} more" if len(thin) > 1 else "")
    size = cell_size * (min(thick) + 2e3 * offset) / (STRETCH * 1e3 * span)
    return (
        f"segment {first}, {min(thick):.3g} mm thick, can pass between nodes of cells "
        f"{1e3 * span:.3g} mm across, and implicit steps meet nodes alone: take Newmark, which "
        f"meets edges of cells as well, or cells below {np.floor(1e4 * size) / 10:g} mm"
    )
