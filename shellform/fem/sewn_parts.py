# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cells of a branching surface shared out over ranks so that no seam is cut.

dolfinx finds what ranks share by the sides that only one cell of a rank has. At a side of three
cells two may be on one rank and the third on another: to the first it looks like an inner side, the
ranks disagree, and dolfinx 0.5.2 stops (newer ones lose the third cell's neighbours). So all cells
of a seam's side are kept together, as are those that meet in a point alone, and these clusters are
bisected along their longest extent, as often as there are ranks (recursive coordinate bisection,
Berger and Bokhari, IEEE Trans. Comput. 36, 1987).

dolfinx renumbers the cells of a rank by their graph, in which it links the first of the cells at a
side to the others. Two cells linked over two sides, as a pocket's corner and the cell behind it,
may break its renumbering (0.5.2: "Data size mismatch", also on one rank); where another cell comes
first, they are not.
"""

import numpy as np

from meshes import Surface
from meshes.geometry import cell_centres
from meshes.sheets import components, seams
from meshes.topology import corner_count, directed_edges, edge_keys, neighbours, unique_edges

TRIALS = 200  # of an order of the cells


def ranks_of_cells(surface: Surface, ranks: int) -> np.ndarray:
    """Rank (m,) int32 of each cell of a surface that branches.

    Parameters
    ----------
    ranks : how many there are; some stay empty where there are fewer clusters than ranks
    """
    cluster = clusters(surface.cells)
    size = np.bincount(cluster)
    centres = cell_centres(surface.points, surface.cells)
    middle = np.stack([np.bincount(cluster, x) / size for x in centres.T], axis=1)
    out = np.zeros(len(size), np.int32)
    _bisect(out, np.arange(len(size)), middle, size, 0, ranks)
    return out[cluster]


def order_of_cells(surface: Surface) -> np.ndarray:
    """Order (m,) in which no cell is linked to another over two sides.

    Cells at the sides of such a pair get other places at random until there is no pair left
    (Moser and Tardos, J. ACM 57, 2010). ValueError where there is no such order: two cells that
    share two sides without a third.
    """
    cells = surface.cells
    crowded, count = [rows // corner_count(cells) for rows in seams(cells)], len(cells)
    place = np.arange(count, dtype=float)
    random = np.random.default_rng(0)
    plain = [neighbours(cells)[0]]
    for _ in range(TRIALS):
        at_sides = [at[np.argsort(place[at], kind="stable")] for at in crowded]
        pairs = [_star(at) for at in at_sides]
        linked = np.sort(np.concatenate(plain + pairs), axis=1)
        pair, often = np.unique(linked, axis=0, return_counts=True)
        twice = pair[often > 1]
        if not len(twice):
            return np.argsort(place, kind="stable")
        for one, other in twice.tolist():
            moved = [at for at in crowded if one in at and other in at]
            if not moved:
                break
            moved = np.unique(np.concatenate(moved))
            place[moved] = random.uniform(0, count, len(moved))
    one, other = twice[0]
    raise ValueError(
        f"{surface.source}: cells {one} and {other} share two sides, and dolfinx cannot number "
        "such cells of a surface that branches: cut one of them in two, or give the corner of "
        "what is sewn on a point of its own"
    )


def sharing_ranks(cells: np.ndarray, ranks: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ranks of each cell and, after its own, those that have a cell with a side of it.

    Returns `data` int32 and `offsets` (m + 1,) int32: data[offsets[k]] is the rank of cell k.
    """
    count = corner_count(cells)
    edges = directed_edges(cells)
    _, number, _ = unique_edges(edges, int(cells.max()) + 1)
    cell = np.arange(len(edges)) // count
    at_side = np.unique(np.stack([number, ranks[cell]], axis=1), axis=0)
    # every side meets the ranks at it: one row for each pair of a cell and such a rank
    starts = np.searchsorted(at_side[:, 0], np.arange(int(number.max()) + 2))
    many = np.diff(starts)[number]
    rows = np.repeat(np.arange(len(edges)), many)
    place = np.arange(len(rows)) - np.repeat(np.cumsum(many) - many, many)
    pairs = np.unique(
        np.stack([cell[rows], at_side[starts[number[rows]] + place, 1]], axis=1), axis=0
    )
    own = pairs[:, 1] == ranks[pairs[:, 0]]
    pairs = pairs[np.lexsort((pairs[:, 1], ~own, pairs[:, 0]))]
    offsets = np.searchsorted(pairs[:, 0], np.arange(len(cells) + 1))
    return pairs[:, 1].astype(np.int32), offsets.astype(np.int32)


def clusters(cells: np.ndarray) -> np.ndarray:
    """Number (m,) of the cluster of each cell that no border of ranks may cut.

    Cells at one side of three or more are together, and so are all at a point whose cells do not
    hang together by sides.
    """
    count = corner_count(cells)
    pairs = [np.empty((0, 2), np.int64)]
    for rows in seams(cells):
        pairs.append(_star(rows // count))
    for at in _pinched(cells):
        pairs.append(_star(at))
    return components(np.concatenate(pairs), len(cells))


def _star(at):
    """Pairs (k - 1, 2) of the first of some cells with each of the others."""
    return np.stack([np.repeat(at[0], len(at) - 1), at[1:]], axis=1)


def _pinched(cells):
    """Cells at each point where two fans of cells meet that have no side in common."""
    count, size = corner_count(cells), int(cells.max()) + 1
    edges = directed_edges(cells)[:, :2]
    # the fans: corners of cells at a point, joined over the sides which they share
    corner = np.arange(len(edges))
    after = corner - corner % count + (corner + 1) % count
    keys = edge_keys(edges, size)
    order = np.argsort(keys, kind="stable")
    same = keys[order[1:]] == keys[order[:-1]]
    one, other = order[:-1][same], order[1:][same]
    turned = edges[one, 0] != edges[other, 0]
    tails = np.stack([one, np.where(turned, after[other], other)], axis=1)
    heads = np.stack([after[one], np.where(turned, other, after[other])], axis=1)
    fan = components(np.concatenate([tails, heads]), len(edges))
    point = edges[:, 0]
    _, first = np.unique(fan, return_index=True)
    fans_at = np.bincount(point[first], minlength=size)
    for where in np.flatnonzero(fans_at > 1):
        yield np.flatnonzero(point == where) // count


def _bisect(out, which, middle, size, first, ranks):
    """Give the clusters `which` to the ranks from `first` on."""
    if ranks == 1 or len(which) == 0:
        out[which] = first
        return
    axis = int(np.argmax(np.ptp(middle[which], axis=0)))
    order = which[np.argsort(middle[which, axis], kind="stable")]
    half = ranks // 2
    filled = np.cumsum(size[order]) - 0.5 * size[order]
    cut = int(np.searchsorted(filled, filled[-1] * half / ranks, side="right"))
    _bisect(out, order[:cut], middle, size, first, half)
    _bisect(out, order[cut:], middle, size, first + half, ranks - half)
