# SPDX-License-Identifier: LGPL-3.0-or-later
"""More ranks than cells: every element and stepper, with what they write, as on one rank.

Particles run on one rank only, and say so.

This file is also the program that the ranks run: `python -m tests.test_few_cells SHEET FOLDER`.
"""

import sys
from pathlib import Path

import numpy as np
import pytest

import meshes
from tests.ranks import launch, needs_mpirun

# kind of sheet -> options of the surface, of the shell
SHEETS = {
    "quads": ({}, {}),
    "relaxed quads": ({}, {"wrinkles": "relaxed"}),
    "triangles": ({"triangles": True}, {}),
    "nine-node quads": ({"degree": 2}, {}),
}
RANKS = (2, 3, 4)
END = 0.02  # s of motion


def sheet(kind, cells):
    """A sheet held at its left edge, 1 mm above a ball."""
    from shellform import Fabric, Shell

    surface, options = SHEETS[kind]
    shell = Shell(
        meshes.rectangle(0.1 * cells[0], 0.1, cells, **surface),
        Fabric.isotropic(1e5, 0.3, thickness=2e-3, density=300.0),
        **options,
    )
    shell.supports.clamp("left")
    shell.loads.gravity()
    return shell


def ball(surface):
    """A ball whose top is just below a corner of the free end."""
    from shellform import Body, Fixed, Segment

    top = np.array([surface.points[:, 0].max(), 0.0, -0.0011])
    return Body([Segment("ball", (0.5, 0.5, 0.5), Fixed(top - (0, 0, 0.5)))])


def stepped(stepper, folder):
    """What a stepper has come to; contact, ledger, checkpoint and series come with it."""
    from shellform import Contact, Ledger, Newmark
    from shellform.dynamics import checkpoint
    from shellform.results.series import Series
    from shellform.results.skin_pressure import Pressure

    shell, found = stepper.shell, {}
    contact = stepper.add(Contact(ball(shell.surface), 0.3))
    skin = stepper.add(Pressure(0.05)) if isinstance(stepper, Newmark) else None
    ledger = stepper.add(Ledger(folder / "ledger.csv"))
    stepper.advance(END / 2)
    ledger.record()
    if skin is not None:
        checkpoint.save(folder / "checkpoint.npz", stepper)
        stepper.advance(0.6 * END)
        shell.comm.Barrier()
        checkpoint.load(folder / "checkpoint.npz", stepper)
    stepper.advance(END)
    row = ledger.record()
    Series(folder).write(shell, stepper.time, height=shell.positions()[:, 2])
    # not what is zero by symmetry, which is roundoff
    found |= {f"ledger {name}": row[name] for name in ("kinetic", "strain", "momentum_z")}
    # all three components together: one that is small against the others is judged by them
    for kind in ("force", "moment"):
        found[f"ledger {kind}"] = np.array([row[f"{kind}_ball_{axis}"] for axis in "xyz"])
    if skin is not None:
        skin.record(stepper.time, True)
        found["pressure"] = skin.result().mean
    found["deepest"] = max(shell.comm.allgather(contact.max_depth))
    return found | state(shell)


def state(shell):
    found = {
        "positions": shell.positions(),
        "directors": shell.directors(),
        "middle": shell.displacement_at(shell.surface.points.mean(axis=0)),
        "energy": sum(shell.energy().values()),
    }
    if shell.relaxed:
        found["wrinkling"] = shell.wrinkling().strain
    return found


def results(kind, cells, folder):
    """All that is computed on the sheet, by names."""
    from shellform import ImplicitNewmark, Newmark, Statics

    found = {}
    shell = sheet(kind, cells)
    with Statics(shell) as statics:
        statics.solve(2)
        found["rest"] = state(shell) | {"reactions": statics.reactions().sum(axis=0)}
    steppers = {"explicit": Newmark}
    if kind != "relaxed quads":
        steppers["implicit"] = lambda shell: ImplicitNewmark(shell, END / 4)
    for name, make in steppers.items():
        place = folder / name
        if shell.comm.rank == 0:
            place.mkdir(parents=True, exist_ok=True)
        shell.comm.Barrier()
        found[name] = stepped(make(sheet(kind, cells)), place)
    return {f"{name} {key}": np.asarray(v) for name, all in found.items() for key, v in all.items()}


def run(kind, folder):
    """Results of one cell and of two, on the ranks of this program."""
    from mpi4py import MPI

    for cells in ((1, 1), (2, 1)):
        found = results(kind, cells, folder / f"{cells[0]}_cells")
        if MPI.COMM_WORLD.rank == 0:
            np.savez(folder / f"{cells[0]}.npz", **found, ranks=MPI.COMM_WORLD.size)


@needs_mpirun
@pytest.mark.serial
@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "several"),
    [("triangles", (3,)), *(pytest.param(k, RANKS, marks=pytest.mark.thorough) for k in SHEETS)],
)
def test_more_ranks_than_cells(kind, several, tmp_path):
    """One and two cells on one rank and on several: what is found agrees to 1e-9."""
    for ranks in (1, *several):
        folder = tmp_path / str(ranks)
        folder.mkdir()
        done = launch(ranks, "-m", "tests.test_few_cells", kind, folder)
        assert done.returncode == 0, done.stderr[-2000:]
    for cells in (1, 2):
        one = np.load(tmp_path / "1" / f"{cells}.npz")
        assert one["explicit deepest"] >= 0 and one["explicit pressure"].max() > 0  # ball is met
        for ranks in several:
            other = np.load(tmp_path / str(ranks) / f"{cells}.npz")
            assert other["ranks"] == ranks and set(other) == set(one)
            for name in set(one) - {"ranks"}:
                size = np.abs(one[name]).max() + 1e-30
                off = np.abs(other[name] - one[name]).max() / size
                assert off <= 1e-9, (cells, ranks, name, off)


if __name__ == "__main__":
    run(sys.argv[1], Path(sys.argv[2]))
