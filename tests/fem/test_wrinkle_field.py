# SPDX-License-Identifier: LGPL-3.0-or-later
"""State, crest and wrinkle strain of cells whose strains are known."""

import numpy as np
import pytest
from scipy.linalg import sqrtm

import meshes
from shellform import Fabric, Shell
from shellform.fem.director import rotation_matrix
from shellform.material.wrinkling import SLACK, TAUT, WRINKLED

PLAIN = Fabric.isotropic(1e6, 0.3, 1e-3, 200.0)
WOVEN = Fabric.orthotropic(4e6, 1e6, 0.1, 5e4, 5e4, 5e4, 5e-4, 400.0)
SIZE = 0.1  # of a cell [m]
TURN = rotation_matrix([0.4, -0.9, 0.6])


def strained(E, fabric=PLAIN, turn=TURN, warp=(1.0, 0.0, 0.0), *, comm):
    """Shell of 4 x 3 cells with the strain E (3,) about axes x and y everywhere, then turned."""
    surface = meshes.rectangle(4 * SIZE, 3 * SIZE, (4, 3), warp=warp)
    shell = Shell(surface, fabric, comm, wrinkles="relaxed")
    stretch = np.eye(3)
    stretch[:2, :2] = np.real(sqrtm(np.eye(2) + [[2 * E[0], E[2]], [E[2], 2 * E[1]]]))
    F = turn @ stretch
    points = surface.points[shell.partition.nodes]
    w = shell.w.x.array.reshape(-1, 6)
    w[:, :3] = points @ F.T - points
    w[:, 3:] = turn[:, 2]
    return shell, F


def load(shell):
    """N_c of its cells, all of one size."""
    bending = np.sqrt(shell.fabric.bending[0, 0] * shell.fabric.bending[1, 1])
    return bending * (np.pi / SIZE) ** 2


def along(lines, direction):
    """|cosine| of the angles between lines (m, 3) and a direction (3,)."""
    return np.abs(lines @ direction) / np.linalg.norm(direction)


def test_stretched_and_shortened_across(comm):
    """Wrinkled along the warp: N11 from E11 and N22 = -N_c; across, what A^-1 N leaves of E22."""
    for fabric in (PLAIN, WOVEN):
        shell, F = strained([0.02, -0.05, 0.0], fabric, comm=comm)
        S, N_c = np.linalg.inv(fabric.membrane), load(shell)
        N11 = (0.02 + S[0, 1] * N_c) / S[0, 0]
        found = shell.wrinkling()
        assert found.state.tolist() == [WRINKLED] * 12
        assert found.strain == pytest.approx(S[0, 1] * N11 - S[1, 1] * N_c + 0.05, rel=1e-8)
        assert along(found.crest, F[:, 0]) == pytest.approx(1.0, abs=1e-12)


def test_sheared(comm):
    """Crests at 45 degrees; half the shear less what the tension draws in sideways."""
    shell, F = strained([0.0, 0.0, 0.08], comm=comm)
    S, N_c = np.linalg.inv(PLAIN.membrane), load(shell)
    N1 = (0.04 + S[0, 1] * N_c) / S[0, 0]
    found = shell.wrinkling()
    assert found.state.tolist() == [WRINKLED] * 12
    assert found.strain == pytest.approx(S[0, 1] * N1 - S[1, 1] * N_c + 0.04, rel=1e-8)
    assert along(found.crest, F @ [1.0, 1.0, 0.0]) == pytest.approx(1.0, abs=1e-10)
    assert np.linalg.norm(found.crest, axis=1) == pytest.approx(1.0, abs=1e-12)


def test_warp_across_the_sheet(comm):
    """Directions are told from the warp, wherever it lies: the wrinkles of the turned cloth."""
    turned = rotation_matrix([0.0, 0.0, 0.7])
    E = [0.02, -0.05, 0.01]
    one, F = strained(E, turn=np.eye(3), comm=comm)
    other, _ = strained(E, turn=np.eye(3), warp=turned[:, 0], comm=comm)
    alike = one.wrinkling(), other.wrinkling()
    assert alike[0].strain == pytest.approx(alike[1].strain, rel=1e-9)
    assert np.abs(np.sum(alike[0].crest * alike[1].crest, axis=1)) == pytest.approx(1.0, abs=1e-9)
    # the largest stretch at rest, carried along
    values, axes = np.linalg.eigh([[E[0], E[2] / 2], [E[2] / 2, E[1]]])
    crest = F @ [*axes[:, values.argmax()], 0.0]
    assert along(alike[1].crest, crest) == pytest.approx(1.0, abs=1e-9)


def test_taut_and_slack(comm):
    taut, _ = strained([0.02, 0.01, 0.01], WOVEN, comm=comm)
    found = taut.wrinkling()
    assert found.state.tolist() == [TAUT] * 12
    assert not found.crest.any() and not found.strain.any()
    slack, _ = strained([-0.03, -0.05, 0.01], WOVEN, comm=comm)
    found, N_c = slack.wrinkling(), load(slack)
    assert found.state.tolist() == [SLACK] * 12 and not found.crest.any()
    # what is left of the stress is -N_c both ways
    W = -N_c * np.linalg.inv(WOVEN.membrane)[:2, :2].sum(axis=1) + [0.03, 0.05]
    larger = np.linalg.eigvalsh([[W[0], -0.005], [-0.005, W[1]]]).max()
    assert found.strain == pytest.approx(larger, rel=1e-8)


def test_cells_have_the_numbers_of_the_surface(comm):
    """Columns of cells that are stretched, kept, shortened; all ranks get all cells."""
    shell, _ = strained([0.0, 0.0, 0.0], turn=np.eye(3), comm=comm)
    surface = shell.surface
    w, points = shell.w.x.array.reshape(-1, 6), surface.points[shell.partition.nodes]
    kinds = [(0.05, TAUT), (0.05, TAUT), (-0.04, WRINKLED), (-0.08, WRINKLED)]
    ends = np.cumsum([0.0] + [SIZE * stretch for stretch, _ in kinds])
    w[:, 0] = np.interp(points[:, 0], SIZE * np.arange(5), ends)
    w[:, 1] = 0.05 * points[:, 1]
    found = shell.wrinkling()
    column = (surface.points[surface.cells].mean(axis=1)[:, 0] / SIZE).astype(int)
    assert found.state.tolist() == [kinds[k][1] for k in column]
    assert (np.diff([found.strain[column == k].mean() for k in (1, 2, 3)]) > 0.01).all()
    assert np.ptp(found.strain[column == 3]) < 1e-12
    assert along(found.crest[column > 1], [0.0, 1.0, 0.0]) == pytest.approx(1.0, abs=1e-12)


def test_resolved_sheets_have_none(comm):
    for triangles in (False, True):
        surface = meshes.rectangle(0.2, 0.1, (2, 1), triangles=triangles)
        with pytest.raises(ValueError, match="has no cells that wrinkle: take wrinkles='relaxed'"):
            Shell(surface, PLAIN, comm).wrinkling()
