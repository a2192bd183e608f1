# SPDX-License-Identifier: LGPL-3.0-or-later
"""Branching surfaces on any number of ranks: no seam is cut, nothing is lost or there twice."""

from itertools import pairwise

import numpy as np
import pytest

import meshes
from meshes.sheets import seams
from shellform.fem.partition import Partition
from shellform.fem.sewn_parts import clusters, order_of_cells, ranks_of_cells, sharing_ranks
from tests.meshes.sewn import pocketed_trousers, with_patch


def patched(first, width):
    """A tube with a patch over some of its columns and rows, sewn on all around."""
    tube = meshes.cylinder(0.15, 0.6, (24, 10), angle=2 * np.pi)
    row, column = np.divmod(np.arange(240), 24)
    chosen = (column >= first) & (column < first + width) & (row > 1) & (row < 2 + width)
    return with_patch(tube, chosen).replace(verify=True)


@pytest.fixture(scope="module", params=["square", "wide", "trousers"])
def sewn(request):
    if request.param == "trousers":
        return meshes.orient(pocketed_trousers(), majority=True).replace(verify=True)
    return patched(3, {"square": 2, "wide": 6}[request.param])


def test_every_rank_has_its_part_and_the_whole_comes_back(sewn):
    part = Partition(sewn)
    assert part.comm.allreduce(part.n_owned) == len(sewn.points)
    assert part.comm.allreduce(len(part.cells)) == len(sewn.cells)
    assert np.array_equal(part.gather(sewn.points[part.owned_nodes]), sewn.points)
    assert np.array_equal(part.gather_cells(sewn.cells[part.cells]), sewn.cells)


def links(cells):
    """Pairs of cells as dolfinx links them: the first at a side with each of the others."""
    at_side = {}
    for cell, row in enumerate(cells.tolist()):
        for side in zip(row, row[1:] + row[:1]):
            at_side.setdefault(frozenset(side), []).append(cell)
    return [(at[0], other) for at in at_side.values() for other in at[1:]]


@pytest.mark.serial
def test_no_two_cells_are_linked_twice(sewn):
    order = order_of_cells(sewn)
    assert sorted(order) == list(range(len(order)))
    found = links(sewn.cells[order])
    assert len(set(found)) == len(found)


@pytest.mark.serial
def test_an_order_is_needed():
    """The corners of a patch are linked twice to the cells behind them as they come."""
    found = links(patched(3, 6).cells)
    assert len(set(found)) < len(found)


@pytest.mark.serial
@pytest.mark.parametrize("ranks", [2, 3, 7])
def test_no_seam_is_cut(sewn, ranks):
    """Nearly even shares; cells that share a side know of each other's rank."""
    rank = ranks_of_cells(sewn, ranks)
    for rows in seams(sewn.cells):
        assert len(set(rank[rows // 4])) == 1
    share = np.bincount(rank, minlength=ranks) * ranks / len(rank)
    largest = np.bincount(clusters(sewn.cells)).max() * ranks / len(rank)
    assert np.abs(share - 1).max() < 0.1 + 2 * largest
    data, offsets = sharing_ranks(sewn.cells, rank)
    assert np.array_equal(data[offsets[:-1]], rank)
    wanted = [{r} for r in rank.tolist()]
    for one, other in links(sewn.cells):
        wanted[one].add(rank[other])
        wanted[other].add(rank[one])
    assert [set(data[a:b]) for a, b in pairwise(offsets)] == wanted


@pytest.mark.serial
def test_cells_that_meet_in_a_point_stay_together():
    """Two squares with one common corner; two with a common side need not stay together."""
    assert clusters(np.array([[0, 1, 2, 3], [2, 4, 5, 6]])).tolist() == [0, 0]
    assert len(set(clusters(np.array([[0, 1, 2, 3], [3, 2, 4, 5]])))) == 2
