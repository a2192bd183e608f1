# SPDX-License-Identifier: LGPL-3.0-or-later
"""What an error costs in a scene of one's own, and the error of a run from a companion run.

`shellform trade scene.toml` prints `cost_table`: cells follow from the errors measured
(accuracy/choice.py), nodes and steps from the scene built once: nodes go with h^-2, the stable step
with h. With `--measure` the two cheapest settings are run and compared. `shellform run --estimate`
adds a run with other cells and extrapolates from the difference (Richardson).
"""

import json
from dataclasses import replace
from pathlib import Path

from mpi4py import MPI

import numpy as np

from shellform.accuracy import measured
from shellform.accuracy.choice import GARMENT, LEADING
from shellform.accuracy.convergence import FLAT, companion_error
from shellform.results.files import write_atomically
from shellform.scene.scene import Scene

from .ensemble import run
from .model import Model
from .prediction import DRESSED
from .summary import summary_of

PERCENT = ("10%", "3%", "1%", "0.3%")
COARSEST = 0.04  # m, of cells that still make trousers
FLEXED = ("hip", "knee")  # joints whose torques count, where a wearer has them


def table_rows(scene: Scene, model: Model, seconds: float) -> list[dict]:
    """Rows of a table: what is asked, cells, errors, step, time, memory; coarse words first.

    Parameters
    ----------
    scene : Scene; model : Model of it; seconds : motion and dressing [s]
    """
    size, dt = scene.cell_size, model.stepper.dt
    nodes, rows = len(model.surface.points), []
    for asked in (*GARMENT, *PERCENT):
        choice = replace(
            scene,
            garment=replace(scene.garment, cell_size=None),
            steps=replace(scene.steps, accuracy=asked),
        ).choice
        many = nodes * (size / choice.size) ** 2
        step = dt * choice.size / size
        row = {"asked": asked, "choice": choice, "nodes": many, "time_step": step}
        if choice.power_laws:
            work = choice.case, choice.family, many
            row["core_seconds"] = choice.runs * measured.seconds(*work, seconds / step)
            row["memory_mb"] = measured.memory(*work)
        rows.append(row)
    return rows


def table_lines(scene: Scene, rows: list[dict], ranks: int) -> list[str]:
    """Lines of the table for a person."""
    said = [
        f"{scene.title}: error of {LEADING['walk']} (of hips and knees, each relative to itself)",
        f"{'asked':>9}  {'error':>6}  {'kept':>4}  {'runs':>4}  {'cells mm':>8}  {'nodes':>6}  "
        f"{'step s':>8}  "
        f"{'minutes':>7}  {'MB':>5}   on {ranks} {'rank' if ranks == 1 else 'ranks'}",
    ]
    for row in rows:
        choice = row["choice"]
        kept = "yes" if choice.promised else "no"
        minutes = row.get("core_seconds", np.nan) / 60 / ranks
        said.append(
            f"{row['asked']:>9}  {100 * choice.error:5.0f}%  {kept:>4}  {choice.runs:>4}  "
            f"{1e3 * choice.size:8.1f}  {row['nodes']:6.0f}  {row['time_step']:8.1e}  "
            f"{minutes:7.1f}  {row.get('memory_mb', np.nan):5.0f}"
        )
    known = rows[0]["choice"].power_laws
    if known:
        spreads = ", ".join(f"{name} {100 * law.spread:.2g} %" for name, law in known.items())
        said.append(f"another start alone changes: {spreads}")
        law = known[LEADING["walk"]]
        said.append(f"errors were measured against a torque known to {100 * law.doubt:.2g} %")
    broken = [row["choice"] for row in rows if not row["choice"].kept]
    return said + (broken[0].lines()[-1:] if broken else [])


def cost_table(
    scene: Scene, comm: MPI.Comm = MPI.COMM_WORLD, out: str | Path | None = None
) -> list[str]:
    """Lines of the table of a scene; all ranks call; with `out` the two cheapest are run there.

    Raises
    ------
    as `run`
    """
    check_cells(scene, "a table of what errors cost")
    model = Model(scene, comm)
    seconds = model.wearer.end - model.wearer.start + DRESSED
    rows = table_rows(scene, model, seconds)
    said = table_lines(scene, rows, comm.size)
    if out is None:
        return said
    del model
    sizes = sorted({round(row["choice"].size, 6) for row in rows}, reverse=True)[:2]
    runs = []
    for size in sizes:
        folder = Path(out) / f"cells_{1e3 * size:.3g}_mm"
        one = replace(scene, garment=replace(scene.garment, cell_size=size))
        run(one, folder, comm)
        comm.Barrier()
        runs.append((size, folder))
    said.append("measured: cells mm, minutes, torques differ from those of the next finer by")
    for (size, folder), after in zip(runs, [*runs[1:], None], strict=True):
        summary = summary_of(folder)
        apart = f"{100 * difference(after[1], folder):.0f} %" if after else ""
        minutes = summary["seconds"]["total"] / 60
        said.append(f"{1e3 * size:12.1f}  {minutes:7.1f}  {apart}")
    return said


def root_mean_squares(folder: str | Path) -> np.ndarray:
    """Root mean squares (j,) of the torques [N m] about hips and knees of an ensemble.

    Of all joints on which the clothing acts, where the wearer has neither.
    """
    joints = summary_of(folder)["results"]["joints"]
    found = {joint: row["rms_torque"] for joint, row in joints.items() if row["rms_torque"] > 0}
    flexed = [value for joint, value in found.items() if joint.endswith(FLEXED)]
    return np.array(flexed or list(found.values()))


def difference(one: str | Path, other: str | Path) -> float:
    """Relative differences of the torques' root mean squares of two ensembles, rms over joints."""
    a, b = root_mean_squares(one), root_mean_squares(other)
    return float(np.sqrt(np.mean(((a - b) / a) ** 2)))


def companion_scene(scene: Scene) -> Scene:
    """The scene to compare with: cells of twice the size, or as large as still makes trousers.

    Where the scene's own are nearly that large, cells of four fifths of the size.
    """
    size = min(2 * scene.cell_size, COARSEST)
    if size < 1.1 * scene.cell_size:
        size = 0.8 * scene.cell_size
    return replace(scene, garment=replace(scene.garment, cell_size=size))


def check_cells(scene: Scene, what: str) -> None:
    """ValueError if the cells of a scene cannot be chosen; what : str, that needs others."""
    if scene.garment.file:
        raise ValueError(
            f"{what} needs cells of other sizes, and garment.file = {scene.garment.file} has its "
            "own: leave it out, or compare runs of your own meshes"
        )


def estimate(scene: Scene, out: str | Path, comm: MPI.Comm = MPI.COMM_WORLD) -> dict:
    """Run the scene with other cells too, in `out`/beside, and enter the error into summary.json.

    It takes an eighth to a half of the cost, twice it with the coarsest cells. All ranks call;
    returns the entry.

    Raises
    ------
    as `run`; ValueError for a garment from a file
    """
    check_cells(scene, "an estimate")
    out, choice, other = Path(out), scene.choice, companion_scene(scene)
    run(other, out / "beside", comm)
    comm.Barrier()
    apart, how = difference(out, out / "beside"), f"cells of {1e3 * other.cell_size:.3g} mm"
    if choice.order < FLAT:
        # what two runs differ by then is what either is off by
        error, how = apart, f"difference from a run with {how}, as errors show no order in the size"
    else:
        size = companion_error(apart, 1 / scene.cell_size, 1 / other.cell_size, choice.order)
        error = float(np.hypot(size, choice.power_law.spread))
        how = f"run with {how}; what another start changes added"
    entry = choice.summary(error, how)
    comm.Barrier()
    if comm.rank == 0:
        summary = summary_of(out) | {"accuracy": entry}
        write_atomically(out / "summary.json", json.dumps(summary, indent=2) + "\n")
    comm.Barrier()
    return entry
