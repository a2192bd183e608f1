# SPDX-License-Identifier: LGPL-3.0-or-later
"""Frames of a series hold what they should, and nothing that was not asked for."""

import meshio
import numpy as np
import pytest

import meshes
from shellform import Fabric, Shell
from shellform.fem.cell_membrane import CellMembrane
from shellform.results.series import WRINKLES, Series
from shellform.results.stretch import stretch_of_cells


def shortened(wrinkles, comm):
    """A sheet of 3 x 2 cells shortened by 4 % along x."""
    surface = meshes.rectangle(0.3, 0.2, (3, 2))
    shell = Shell(surface, Fabric.isotropic(1e6, 0.3, 1e-3, 200.0), comm, wrinkles=wrinkles)
    points = surface.points[shell.partition.nodes]
    shell.w.x.array.reshape(-1, 6)[:, 0] = -0.04 * points[:, 0]
    return shell


def test_relaxed_sheets_show_their_wrinkles(shared_tmp_path, comm):
    shell = shortened("relaxed", comm)
    Series(shared_tmp_path).write(shell, 0.0)
    expected = shell.wrinkling()
    comm.Barrier()
    frame = meshio.read(shared_tmp_path / "series/0000.vtu")
    found = [frame.cell_data[name][0] for name in WRINKLES]
    assert set(frame.point_data) == {"displacement", "director"}
    assert expected.strain.min() > 0.03
    for one, other in zip(found, expected, strict=True):
        assert np.array_equal(one, other)


def test_resolved_sheets_have_none_computed(shared_tmp_path, comm, monkeypatch):
    def refused(*_):
        raise AssertionError("computed although nobody asked")

    monkeypatch.setattr(CellMembrane, "wrinkling", refused)
    monkeypatch.setattr(Shell, "wrinkling", refused)
    Series(shared_tmp_path).write(shortened("resolved", comm), 0.0)
    comm.Barrier()
    assert meshio.read(shared_tmp_path / "series/0000.vtu").cell_data == {}
    with pytest.raises(AssertionError):
        Series(shared_tmp_path).write(shortened("relaxed", comm), 0.0)


def test_stretch_is_that_of_the_longest_side(shared_tmp_path, comm):
    """A sheet stretched by 3 % along x and 5 % along y, and one that is rolled up: none."""
    surface = meshes.rectangle(0.3, 0.2, (3, 2))
    shell = Shell(surface, Fabric.isotropic(1e6, 0.3, 1e-3, 200.0), comm)
    points = surface.points[shell.partition.nodes]
    shell.w.x.array.reshape(-1, 6)[:, :2] = points[:, :2] * [0.03, 0.05]
    Series(shared_tmp_path).write(shell, 0.0, stretch=True)
    comm.Barrier()
    (found,) = meshio.read(shared_tmp_path / "series/0000.vtu").cell_data["stretch"]
    assert found == pytest.approx(0.05, rel=1e-9)
    angle = surface.points[:, 0] / 0.2
    rolled = np.stack([0.2 * np.sin(angle), surface.points[:, 1], 0.2 - 0.2 * np.cos(angle)], 1)
    directors = np.stack([-np.sin(angle), 0 * angle, np.cos(angle)], 1)
    assert np.abs(stretch_of_cells(rolled, directors, surface)).max() < 1e-3
    # the chords are 1 % shorter
    assert np.linalg.norm(rolled[1] - rolled[0]) < 0.995 * np.linalg.norm(
        surface.points[1] - surface.points[0]
    )
