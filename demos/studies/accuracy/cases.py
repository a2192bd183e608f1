# SPDX-License-Identifier: LGPL-3.0-or-later
"""The scenes on which error against cost is measured, from the demos.

Each is a Case: settings in order of rising cost, and a function that runs one of them and says what
it found and what it took. Where the exact value is known a run knows its errors itself; where not,
`run.py` takes the finest runs for it.
"""

import argparse
import time
from typing import NamedTuple

from mpi4py import MPI

import numpy as np

from demos import capstan, hinge_sleeve, roll_up, strip_over_cylinder
from demos.studies.drape import square
from shellform import Statics

COMM = MPI.COMM_WORLD
QUADS, NINE = roll_up.FAMILIES
# a mesh of one family; what else a run of the same mesh may change is a kind of its own
MESH = {"kind": "mesh", "family": QUADS}


class Case(NamedTuple):
    """A scene.

    name : str; ladder : list of dict of settings; run : function (settings) -> dict with `ratio`,
    `nodes`, `steps`, `time_step`, `core_seconds` and either `errors` {quantity: relative error} or
    `values` {quantity: number or (k,) curve}; length : l [m]; rows : function (case, runs) -> list
    of dict that makes rows of what `run` found, None: that of rows.py
    """

    name: str
    ladder: list
    run: object
    length: float
    rows: object = None


class Timer:
    """Seconds of all ranks' processors in a block."""

    def __enter__(self):
        self.start = time.process_time()
        return self

    def __exit__(self, *_):
        self.seconds = COMM.allreduce(time.process_time() - self.start)


def rolled(settings):
    """One turn; position of the tip over the length, strain energy."""
    given = {"turns": 1.0, "length": 12.0, "thickness": 0.01, "steps": 20, "degree": 1}
    given |= {key: value for key, value in settings.items() if key in (*given, "cells")}
    given["degree"] = 1 + (settings["family"] == NINE)
    options = argparse.Namespace(**given)
    shell, kappa = roll_up.strip(options)
    shell.forms()
    with Statics(shell) as statics:
        if "tolerance" in settings:
            statics.newton.snes.setTolerances(rtol=settings["tolerance"])
        with Timer() as timer:
            for _ in statics.march(options.steps):
                pass
        tip = shell.displacement_at((options.length, 0, 0)) + (options.length, 0, 0)
    exact = roll_up.circle(kappa, np.array([options.length]))[0]
    own = roll_up.stretch(options.turns, options.length, options.thickness)
    return {
        "ratio": 2 * np.pi * options.turns / options.cells,
        "errors": {"position": float(np.linalg.norm(tip - exact) / options.length)},
        "uncertainty": own,
        "nodes": len(shell.surface.points),
        "steps": options.steps,
        "time_step": np.nan,
        "core_seconds": timer.seconds,
    }


def pulled(settings):
    """A belt over half a cylinder; force at its end."""
    mu, radius, angle = 0.3, 0.1, np.pi
    arc = radius * angle
    stepper, out = capstan.belt(settings["cells"], mu, radius, angle, settings.get("factor", 0.9))
    with Timer() as timer:
        found = capstan.ratios(stepper, out, arc / settings["cells"])
    # the law is of a scene with the sensitivity 1
    error = capstan.deviation(found, capstan.exact(mu, angle)) / capstan.sensitivity(mu, angle)
    return _stepped(stepper, timer, angle / settings["cells"]) | {"errors": {"force": error}}


def hung(settings):
    """A strip over a cylinder; position of its tip over its length, normal forces.

    The errors go with where between two nodes the strip lifts off, from next to nothing to twice
    the mean: they are root mean squares over meshes of one cell less, of as many, and of one more.
    """
    scene, runs = strip_over_cylinder.Scene(), []
    exact = strip_over_cylinder.elastica(scene)
    for cells in neighbours(settings["cells"]):
        stepper, touch = strip_over_cylinder.strip(scene, cells, settings.get("samples", 0))
        with Timer() as timer:
            found = strip_over_cylinder.measure(exact, stepper, touch)
        ratio = scene.length / cells / min(scene.radius, scene.bending_length)
        errors = found["tip"], found["normal"]
        runs.append((_stepped(stepper, timer, ratio), errors))
    errors = np.sqrt(np.mean(np.square([errors for _, errors in runs]), axis=0))
    names = "position", "force"
    return runs[1][0] | {"errors": {n: float(e) for n, e in zip(names, errors, strict=True)}}


def neighbours(cells):
    """Numbers of cells over which an error is averaged."""
    return cells - 1, cells, cells + 1


def bent(settings):
    """A sleeve on a bending knee; course of the torque, mean strain energy."""
    given = {"friction": [0.0], "angle": hinge_sleeve.MEASURED_AT, "period": 0.3, "cycles": 1}
    given |= {"radius": 0.06}
    given |= {"time_step_factor": 0.9, "rotary_scale": hinge_sleeve.ROTARY_SCALE}
    given |= {"mass_scale": 1.0}
    given |= {key: value for key, value in settings.items() if key in (*given, "around")}
    options = argparse.Namespace(**given)
    found = hinge_sleeve.cycles(options, 0.0)
    until = hinge_sleeve.STILL + options.cycles * options.period
    return {
        "ratio": 2 * np.pi / options.around,
        "values": {"torque": found["torque"], "energy": float(found["strain"].mean())},
        "time_step": until / found["steps"],
    } | {key: found[key] for key in ("nodes", "steps", "core_seconds")}


def draped(settings):
    """A square on a sphere; mean height, force of the body, strain energy."""
    names = ("cells", "start", "factor", "model", "seconds")
    scene = square.Scene(**{k: v for k, v in settings.items() if k in names})
    found = square.run(scene)
    values = {"shape": found["height"], "force": found["force_up"], "energy": found["strain"]}
    return {
        "ratio": 1 / scene.cells / draped_length(),
        "values": values,
        "nodes": len(found["positions"]),
        "steps": found["steps"],
        "time_step": found["dt"],
        "core_seconds": found["seconds"],
    }


def draped_length():
    """(D/(m g))^(1/3) [m] of the square, as drape.py has it."""
    scene = square.Scene()
    return (scene.bending / (0.2 * square.G)) ** (1 / 3)


def _stepped(stepper, timer, ratio):
    return {
        "ratio": ratio,
        "nodes": len(stepper.shell.surface.points),
        "steps": stepper.steps,
        "time_step": stepper.dt,
        "core_seconds": timer.seconds,
    }


def meshes_of(key, counts, **more):
    """Settings of a ladder of meshes."""
    return [MESH | more | {key: n} for n in counts]


def starts(counts, numbers=(1, 2)):
    """Settings of runs from other starts, see square.push."""
    return [MESH | {"kind": "start", "cells": n, "start": k} for n in counts for k in numbers]


CASES = {
    case.name: case
    for case in (
        Case(
            "roll_up",
            [
                *meshes_of("cells", (5, 6, 8, 10, 12, 16, 24, 32)),
                *meshes_of("cells", (4, 6, 8, 12, 16, 24), family=NINE),
                MESH | {"kind": "trick", "name": "10 load steps", "cells": 12, "steps": 10},
                MESH | {"kind": "trick", "name": "5 load steps", "cells": 12, "steps": 5},
                MESH | {"kind": "trick", "name": "tolerance 1e-3", "cells": 12, "tolerance": 1e-3},
            ],
            rolled,
            12 / (2 * np.pi),
        ),
        Case(
            "capstan",
            [
                *meshes_of("cells", (6, 8, 12, 16, 24, 32)),
                MESH | {"kind": "step", "cells": 12, "factor": 0.45},
            ],
            pulled,
            0.1,
        ),
        Case(
            "strip",
            [
                *meshes_of("cells", (7, 10, 14, 20, 28, 40)),
                MESH | {"kind": "trick", "name": "contact inside cells", "cells": 14, "samples": 1},
            ],
            hung,
            0.03,
        ),
        Case(
            "sleeve",
            [
                *meshes_of("around", (12, 16, 20, 24, 32, 40, 48, 64)),
                MESH | {"kind": "step", "around": 24, "time_step_factor": 0.45},
                MESH | {"kind": "trick", "name": "rotary 4", "around": 24, "rotary_scale": 4.0},
                MESH | {"kind": "trick", "name": "rotary 0.5", "around": 24, "rotary_scale": 0.5},
                MESH | {"kind": "trick", "name": "mass 4", "around": 24, "mass_scale": 4.0},
                MESH | {"kind": "trick", "name": "mass 16", "around": 24, "mass_scale": 16.0},
            ],
            bent,
            0.06,
        ),
        Case(
            "drape",
            [
                *meshes_of("cells", (12, 16, 20, 24)),
                *starts((12, 16, 24)),
                MESH | {"kind": "step", "cells": 16, "factor": 0.45},
                *meshes_of("cells", (12, 16, 24), family="particles", model="particles"),
                *meshes_of("cells", (32,)),
                *starts((32,)),
                *meshes_of("cells", (48,)),
            ],
            draped,
            draped_length(),
        ),
    )
}
