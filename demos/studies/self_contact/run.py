# SPDX-License-Identifier: LGPL-3.0-or-later
"""What contact of cloth with cloth costs on a walk, in processor time.

    python -m demos.studies.self_contact.run --seconds 1.5 --out out/self_contact

dresses a walker with self-contact, walks from that state with it and without, in turns of a tenth
of the time each, and prints both times a step, pairs, limits and crossings. Leaves summary.json.
One rank.
"""

import argparse
import json
import time
from pathlib import Path

from mpi4py import MPI

import numpy as np

from shellform.console import parse, positive, run
from shellform.dressing.saved_state import save
from shellform.scene.parts import Contact, Motion, Output, Steps
from shellform.scene.scene import Scene
from shellform.simulation.model import Model

COMM = MPI.COMM_SELF


def arguments(given=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=positive(float), default=1.5, help="of the walk")
    parser.add_argument("--turns", type=positive(int), default=10)
    parser.add_argument("--out", type=Path, default=Path("out/self_contact"))
    return parse(parser, given)


def model_of(seconds, self_contact):
    """The default walk in draft cells, ready to be stepped."""
    return Model(
        Scene(
            motion=Motion(end=seconds),
            contact=Contact(self_contact=self_contact),
            steps=Steps(runs=1),
            output=Output(pressure=0.0),
        ),
        COMM,
    )


def main(given=None):
    options = arguments(given)
    options.out.mkdir(parents=True, exist_ok=True)
    state = options.out / "dressed.npz"
    first = model_of(options.seconds, True)
    first.dress()
    save(state, first.stepper, first.wearer)
    models = {name: model_of(options.seconds, name == "with") for name in ("with", "without")}
    for model in models.values():
        model.put_on(state)
        model.stepper.advance(model.wearer.start + 0.01)  # kernels are loaded
    spent = {name: np.zeros(options.turns) for name in models}
    crossed, cloth = 0, models["with"].contact.cloth
    for k in range(options.turns):
        for name, model in models.items():
            start, steps = time.process_time(), model.stepper.steps
            until = model.wearer.start + 0.01 + options.seconds * (k + 1) / options.turns
            model.stepper.advance(until)
            spent[name][k] = (time.process_time() - start) / (model.stepper.steps - steps)
        crossed = max(crossed, cloth.intersections())
    means = {name: 1e6 * float(value.mean()) for name, value in spent.items()}
    results = {
        "nodes": len(first.surface.points),
        "us_per_step": means,
        "ratio": means["with"] / means["without"],
        "pairs_most": cloth.most_pairs,
        "closest": cloth.closest,
        "thickness": cloth.thickness,
        "steps": models["with"].stepper.steps,
        "steps_at_limit": cloth.limited,
        "searches": cloth.listings,
        "intersections": crossed,
        "intersections_without": first_crossings(models["without"], cloth),
    }
    for name, value in results.items():
        print(f"{name:>22} {value}")
    (options.out / "summary.json").write_text(json.dumps(results, indent=1))


def first_crossings(model, cloth):
    """Edges through triangles of a sheet that does not meet itself, by another's features."""
    from contact.self_contact.intersections import count_intersections

    stepper = model.stepper
    x = np.ascontiguousarray(stepper.points + stepper.owned[:, :3])
    return count_intersections(x, *cloth.solver.features[:4])


if __name__ == "__main__":
    run(main)
