# SPDX-License-Identifier: LGPL-3.0-or-later
"""The walks of the study of error against cost: level and over an obstacle, in two fabrics.

Folds choose among many states, so runs whose starts differ by next to nothing go courses of their
own: each walk is an ensemble of starts (shellform/simulation/members.py), its numbers are those of
the ensemble (walk_numbers.py), and what they are held against is the ensemble with the finest
cells. Of numbers that two ensembles differ by, chance has its part: with scatter s of a single run
and n runs of each

    E (difference^2) = error of the cells^2 + s^2 / n + s_ref^2 / n_ref,

and the error of a single run is that of its cells and s. The finest is known to its standard error
and to what it differs from the next coarser by more than chance. All are root mean squares over the
four walks. A walk that is complete in its folder is not run again.
"""

from dataclasses import replace
from functools import partial
from pathlib import Path

from mpi4py import MPI

import numpy as np

from demos.studies.accuracy.cases import MESH, Case
from demos.studies.accuracy.walk_numbers import QUANTITIES, apart, numbers_of, scatter_of, walked
from shellform.accuracy.choice import cloth_family, garment_length
from shellform.material.card import fabric_of
from shellform.scene.parts import Garment, Motion, Output, Steps
from shellform.scene.scene import Scene
from shellform.simulation.ensemble import complete_of, run
from shellform.simulation.summary import summary_of

COMM = MPI.COMM_WORLD
OBSTACLES = {"level": 0.0, "obstacle": 0.5}  # m
WALKS = [(fabric, ground) for fabric in ("compliant", "stiff") for ground in OBSTACLES]
# size of the cells [m]: starts
STARTS = {0.04: 2, 0.035: 6, 0.0245: 2, 0.0175: 1}
COST = ("nodes", "steps", "time_step", "core_seconds")  # of one start, in `costs`
CHANGED = 0.035  # m, cells of the runs that change something else


def walk_case(folder, starts=None, walks=WALKS):
    """Case of the walks; runs leave their files in `folder`."""
    starts = starts or STARTS
    ladder = [MESH | {"cell_size": size, "starts": n} for size, n in starts.items()]
    at = list(starts).index(CHANGED) + 1 if CHANGED in starts else len(ladder)
    changed = MESH | {"cell_size": CHANGED, "starts": 3}
    ladder[at:at] = [
        changed | {"kind": "step", "factor": 0.45},
        changed | {"kind": "trick", "name": "dressed by particles", "dressing": "particles"},
        changed | {"kind": "trick", "name": "mass 4", "mass": 4.0},
    ]
    length = garment_length(fabric_of("compliant"))
    play = partial(played, Path(folder) / "walk", length=length, walks=walks)
    return Case("walk", ladder, play, length, walk_rows)


def played(folder, settings, length, walks=WALKS):
    """All walks with the settings of a run: their ensembles and what they cost, one start each."""
    size = settings["cell_size"]
    name = settings.get("name", settings["kind"]).replace(" ", "_")
    runs, costs = {}, {}
    for fabric, ground in walks:
        out = folder_of(folder, fabric, ground, name, size)
        if not (out / "summary.json").is_file():
            run(scene_of(settings, fabric, OBSTACLES[ground]), out, COMM)
        COMM.Barrier()  # rank 0's files are there
        runs[fabric, ground] = walked(out)
        found = [summary_of(member.out) for member in complete_of(out)]
        told = [{key: one.get(key, np.nan) for key in COST} for one in found]
        costs.setdefault(fabric, []).extend(told)
    spent = [one["core_seconds"] for own in costs.values() for one in own]
    return {
        "ratio": size / length,
        "runs": runs,
        "costs": {fabric: mean_cost(own) for fabric, own in costs.items()},
        "core_seconds": float(np.nansum(spent)),
    }


def mean_cost(found):
    """Cost of one start, mean over summaries that tell it; NaN where none does."""
    means = {}
    for key in COST:
        told = [one[key] for one in found if not np.isnan(one[key])]
        means[key] = float(np.mean(told)) if told else np.nan
    return means


def folder_of(folder, fabric, ground, name, size):
    """Folder of a walk with cells of a size [m]."""
    return folder / f"{ground}_{fabric}_{name}_{1e3 * size:g}_mm"


def scene_of(settings, fabric, obstacle):
    """Scene of a walk with the settings of a run."""
    mass, cloth = settings.get("mass", 1.0), fabric_of(fabric)
    return Scene(
        fabric=replace(cloth, areal_mass=mass * cloth.areal_mass) if mass != 1 else fabric,
        gravity=9.81 / mass,
        motion=Motion(obstacle=obstacle),
        garment=Garment(cell_size=settings["cell_size"]),
        steps=Steps(
            runs=settings["starts"],
            time_step_factor=settings.get("factor", 0.9),
            dressing=settings.get("dressing", "shell"),
        ),
        output=Output(frames=2.0, pressure=0.0),
    )


def walk_rows(case, runs):
    """Rows of the table from the ensembles of all settings, a family a fabric; see the header."""
    rows = []
    for fabric in dict.fromkeys(fabric for _, found in runs for fabric, _ in found["runs"]):
        own = []
        for settings, found in runs:
            some = {walk: one for walk, one in found["runs"].items() if walk[0] == fabric}
            if some:
                own.append((settings, found | found["costs"][fabric] | {"runs": some}))
        if any(settings["kind"] == "mesh" for settings, _ in own):
            rows += _rows_of_fabric(cloth_family(fabric_of(fabric)), own)
    return rows


def _rows_of_fabric(family, runs):
    meshes = sorted(
        ((settings, found) for settings, found in runs if settings["kind"] == "mesh"),
        key=lambda one: -one[1]["ratio"],
    )
    rows = []
    for quantity in QUANTITIES:
        finest = meshes[-1][1]["runs"]
        spread = spread_of([found["runs"] for _, found in meshes], quantity)
        known = spread / np.sqrt(fewest(finest))
        beyond = 0.0
        if len(meshes) > 1:
            beyond = beyond_chance(meshes[-2][1]["runs"], finest, quantity, spread)
        doubt = float(np.hypot(known, beyond))
        same = {"quantity": quantity, "reference": "finest ensemble", "uncertainty": doubt}
        for settings, found in meshes:
            cells = beyond_chance(found["runs"], finest, quantity, spread)
            if found["runs"] is finest:
                cells = doubt
            one = _row(settings, found, family) | same | {"starts": fewest(found["runs"])}
            rows.append(one | {"error": float(np.hypot(cells, spread))})
        for settings, found in runs:
            base = next((f for s, f in meshes if s["cell_size"] == settings["cell_size"]), None)
            if settings["kind"] == "mesh" or base is None:
                continue
            changed = beyond_chance(found["runs"], base["runs"], quantity, spread)
            cost = found["core_seconds"] / base["core_seconds"]
            one = _row(settings, found, settings.get("name", family)) | same
            rows.append(one | {"error": changed, "relative_cost": cost})
        if spread:
            one = _row(*meshes[0], family) | same | {"kind": "spread", "settings": "other starts"}
            rows.append(one | {"error": spread})
    return rows


def fewest(runs):
    """Runs of the smallest ensemble."""
    return min(len(one.curves) for one in runs.values())


def spread_of(ensembles, quantity):
    """Scatter of a single run, root mean square over all ensembles by their degrees of freedom."""
    squares, freedom = 0.0, 0
    for one in (walk for runs in ensembles for walk in runs.values()):
        n = len(one.curves) - 1
        if n:
            squares += n * scatter_of(one)[quantity] ** 2
            freedom += n
    return float(np.sqrt(squares / freedom)) if freedom else 0.0


def beyond_chance(runs, reference, quantity, spread):
    """What walks differ from others by, less what chance makes of it: see the header."""
    squares = [
        apart(numbers_of(runs[walk])[quantity], numbers_of(reference[walk])[quantity]) ** 2
        - spread**2 * (1 / len(runs[walk].curves) + 1 / len(reference[walk].curves))
        for walk in reference.keys() & runs.keys()
    ]
    return float(np.sqrt(max(np.mean(squares), 0.0)))


def _row(settings, found, family):
    said = f"cells {1e3 * settings['cell_size']:g} mm, {settings['starts']} starts"
    keys = ("ratio", "core_seconds", "nodes", "steps", "time_step", "memory_mb", "repeats")
    return {
        "family": family,
        "kind": settings["kind"],
        "settings": f"{family}, {said}",
        **{key: found[key] for key in keys},
    }
