# SPDX-License-Identifier: LGPL-3.0-or-later
"""The same bits: one scene run many times, each in a process of its own, and files compared.

Each process is given another environment: its size moves the stack, malloc settings and a block of
odd size move arrays against lines of the cache, another seed of Python's hashes reorders sets. On
one machine, one build and one number of ranks none of this may change a byte of torque.csv and
ledger.csv. With `--cold` each process compiles its kernels into an empty cache of its own: the
code itself must then not depend on the process that compiled it.

    python demos/studies/repeatability/run.py --runs 10 --out out/repeatability
    python demos/studies/repeatability/run.py --runs 3 --seconds 2.0 --cold
"""

import argparse
import hashlib
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

from shellform import console
from shellform.scene.parts import Motion, Output
from shellform.scene.scene import Scene
from shellform.scene.scene_file import write_scene

FILES = ("torque.csv", "ledger.csv")

# a block of odd size is held for the whole run: what is allocated after it lies elsewhere
PROGRAM = """
import sys
from mpi4py import MPI
import numpy as np

held = [bytearray(16 * k + int(sys.argv[1])) for k in range(64)]
kept = np.zeros(int(sys.argv[1]), np.uint8)
from shellform import console
from shellform.scene.scene_file import read_scene
from shellform.simulation.run import run

scene, out, dressed = sys.argv[2:5]
console.run(lambda _: run(read_scene(scene), out, MPI.COMM_WORLD, dressed or None))
"""


def environment(k: int, cold: Path | None = None) -> dict[str, str]:
    """Environment of the run k: another size, other malloc settings, another seed of hashes."""
    more = {
        "OMP_NUM_THREADS": "1",
        "PYTHONHASHSEED": str(k),
        "PADDING": "x" * (16 * (37 * k % 256) + k),
        "MALLOC_PERTURB_": str(17 * k % 256),
        "MALLOC_TOP_PAD_": str(4096 * k),
    }
    if k % 2:
        # every array by mmap: 16 bytes behind the begin of a page
        more["MALLOC_MMAP_THRESHOLD_"] = "4096"
    if cold is not None:
        more["NUMBA_CACHE_DIR"] = str(cold)
        more["XDG_CACHE_HOME"] = str(cold)
    return dict(os.environ) | more


def repeat(
    scene: Path, out: Path, runs: int, dressed: Path | str = "", cold: bool = False
) -> list[dict[str, str]]:
    """Run a scene file many times; hashes of FILES of each run.

    Raises
    ------
    ChildProcessError where a run fails, with what it said
    """
    found = []
    for k in range(runs):
        folder = out / f"run_{k}"
        folder.mkdir(parents=True, exist_ok=True)
        words = [sys.executable, "-c", PROGRAM, 8 + 40 * k, scene, folder, dressed]
        cache = folder / "cache" if cold else None
        done = subprocess.run(
            [*map(str, words)], env=environment(k, cache), capture_output=True, text=True
        )
        if done.returncode:
            raise ChildProcessError(f"run {k} failed: {done.stderr}")
        found.append({name: digest(folder / name) for name in FILES})
    return found


def digest(path: Path) -> str:
    """Hash of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()[:16]


def main(given=None):
    parser = argparse.ArgumentParser(allow_abbrev=False, description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=console.positive(int), default=10)
    parser.add_argument("--fabric", default="compliant")
    parser.add_argument("--obstacle", type=float, default=0.5, help="height, m; 0 for none")
    parser.add_argument("--seconds", type=console.positive(float), help="of the motion")
    parser.add_argument("--cold", action="store_true", help="each run compiles for itself")
    parser.add_argument("--out", type=Path, default=Path("out/repeatability"))
    options = console.parse(parser, given)
    options.out.mkdir(parents=True, exist_ok=True)
    scene = Scene(
        fabric=options.fabric, motion=Motion(obstacle=options.obstacle, end=options.seconds)
    )
    scene = replace(scene, output=Output(frames=0.5))
    path = options.out / "scene.toml"
    write_scene(scene, path)
    found = repeat(path, options.out, options.runs, cold=options.cold)
    for k, hashes in enumerate(found):
        print(f"run {k}: " + ", ".join(f"{name} {value}" for name, value in hashes.items()))
    different = sum(hashes != found[0] for hashes in found)
    print(f"{different} of {options.runs} runs differ from the first")
    sys.exit(bool(different))


if __name__ == "__main__":
    console.run(main)
