# SPDX-License-Identifier: LGPL-3.0-or-later
"""One run of an ensemble in a process of its own, whatever number of runs its scene asks for.

    python -m shellform.simulation.one_run OUT [--dressed FILE]

plays scene.toml of the folder OUT, or goes on from the checkpoint there. `shellform run` would play
the other runs too, which somebody else is playing.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

from mpi4py import MPI

from shellform import console
from shellform.scene.scene_file import read_scene

from .run import resume, run


def main(given: Sequence[str] | None = None) -> None:
    """Play the run; `given` is a list of arguments or None for the program's own."""
    parser = argparse.ArgumentParser(prog="shellform", description=__doc__, allow_abbrev=False)
    parser.add_argument("out", type=Path, help="folder of the run, with scene.toml")
    parser.add_argument("--dressed", type=Path, help="file of a dressed state to start from")
    options = console.parse(parser, given)
    out = options.out
    if (out / "checkpoint.npz").is_file():
        resume(out, MPI.COMM_WORLD)
    else:
        scene = read_scene(out / "scene.toml")
        run(scene, out, MPI.COMM_WORLD, options.dressed, lines=False)


if __name__ == "__main__":
    console.run(main)
