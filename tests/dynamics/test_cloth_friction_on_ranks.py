# SPDX-License-Identifier: LGPL-3.0-or-later
"""Friction inside the cloth on 1, 2 and 3 ranks: the same forces, slips and losses; stop and go on.

This file is also the program that the ranks run: `python -m ... FOLDER`.
"""

import sys
from pathlib import Path

import numpy as np
import pytest

from tests.ranks import launch, needs_mpirun

STEPS, DT = 200, 2e-4


def play(folder):
    """Explicit steps of a falling sheet, and half of them once more from a checkpoint."""
    from mpi4py import MPI

    from shellform.dynamics import checkpoint
    from shellform.dynamics.explicit import Newmark
    from tests.dynamics.test_cloth_friction import FRICTION, flag

    comm, middle, found = MPI.COMM_WORLD, folder / "middle.npz", {}
    for kind, triangles in (("quads", False), ("triangles", True)):
        first = Newmark(flag(triangles=triangles))
        assert first.critical_dt > DT
        # thrown upwards, so that sliders slip to and fro
        first.v[:, 2] = 20.0 * first.points[:, 0]
        for step in range(STEPS):
            if step == STEPS // 2:
                checkpoint.save(middle, first)
                comm.Barrier()
            first.step(DT)
        again = Newmark(flag(triangles=triangles))
        checkpoint.load(middle, again)
        for _ in range(STEPS // 2):
            again.step(DT)
        same = np.array_equal(first.owned, again.owned) and np.array_equal(
            first.shell.cell_stress.slips, again.shell.cell_stress.slips
        )
        partition, (k, m, _) = first.shell.partition, FRICTION.table().T
        slips = partition.gather_cells(first.shell.cell_stress.slips)
        force = partition.gather(first.internal_force(), root=0)
        found |= {
            f"{kind} bit for bit": np.array(comm.allreduce(int(not same)) == 0),
            f"{kind} loss": np.array(first.shell.friction_loss()),
            f"{kind} slips": slips * k / m,
        }
        if comm.rank == 0:
            found[f"{kind} force"] = force
    if comm.rank == 0:
        np.savez(folder / "found.npz", ranks=comm.size, **found)


@needs_mpirun
@pytest.mark.serial
def test_ranks_agree(tmp_path):
    """To 1e-9 after 200 steps, and each number of ranks goes on bit for bit."""
    results = []
    for ranks in (1, 2, 3):
        folder = tmp_path / str(ranks)
        folder.mkdir()
        done = launch(ranks, "-m", "tests.dynamics.test_cloth_friction_on_ranks", folder)
        assert done.returncode == 0, done.stderr
        results.append(dict(np.load(folder / "found.npz")))
        assert results[-1].pop("ranks") == ranks
    for kind in ("quads", "triangles"):
        assert results[0][f"{kind} loss"] > 1e-4
        assert all(found[f"{kind} bit for bit"] for found in results)
    for found in results[1:]:
        for name, wanted in results[0].items():
            gap = np.abs(found[name].astype(float) - wanted).max()
            assert gap < 1e-9 * np.abs(wanted).max(), (name, gap)


if __name__ == "__main__":
    play(Path(sys.argv[1]))
