# SPDX-License-Identifier: LGPL-3.0-or-later
"""What friction inside the cloth does to a walk: torques with and without, and what it costs.

Trousers of one measured cloth, dressed and walked twice: as the card has it, and with its friction
left out. Both have the same elastic stiffness. Of both, from several starts, the torques about the
joints with their standard errors, and their difference with its interval; of the first start the
books; and the processor time of a step, both models advanced in turns from the same dressed cloth.

    python -m demos.studies.cloth_friction.run --out out/cloth_friction
    python -m demos.studies.cloth_friction.run --runs 1 --end 1.2          # a look, a minute

leaves summary.json, and a folder a cloth with the files of a run.
"""

import argparse
import csv
import time
from pathlib import Path

import numpy as np

from demos.studies.drape.figures import print_table
from shellform import console
from shellform.material.card import read_fabric
from shellform.material.sheet import Sheet
from shellform.results.comparison import comparison_lines
from shellform.results.report import Report
from shellform.scene.parts import Garment, Motion, Output, Steps
from shellform.scene.scene import Scene
from shellform.simulation.ensemble import compare_runs, run_all
from shellform.simulation.model import Model

COMM = console.COMM
CARD = Path(__file__).with_name("suiting.toml")
WITH, WITHOUT = "with friction", "without"


def scene_of(options: argparse.Namespace, cloth: Sheet, name: str) -> Scene:
    """A walk in trousers of a cloth."""
    return Scene(
        fabric=cloth,
        motion=Motion(start=options.start, end=options.end, obstacle=0.0),
        garment=Garment(cell_size=options.cell_size),
        steps=Steps(runs=options.runs, dressing=options.dressing),
        output=Output(frames=0.5),
        title=f"{cloth.name} {name}",
    )


def torques(results: dict[str, dict]) -> list[dict]:
    """Rows of the joints: peak and root mean square of both cloths [N m], each with its error."""
    rows = []
    for joint, one in results[WITH]["joints"].items():
        row: dict = {"joint": joint}
        for name in results:
            numbers = results[name]["joints"][joint]
            for kind in ("peak_torque", "rms_torque"):
                row[f"{kind} {name}"] = numbers[kind]
                if numbers.get(f"{kind}_error") is not None:
                    row[f"+- {kind} {name}"] = numbers[f"{kind}_error"]
        rows.append(row | {"rms ratio": one["rms_torque"] / row[f"rms_torque {WITHOUT}"]})
    return rows


def books(folder: Path) -> dict[str, float]:
    """What the ledger of a run tells [J]: losses and the largest residual."""
    with open(folder / "ledger.csv") as file:
        rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
    last = rows[-1]
    losses = ("hysteresis_loss", "drag_loss")
    found = {name: last[name] - rows[0][name] for name in losses if name in last}
    for name in ("friction_loss", "impact_loss", "body_work"):
        found[name] = sum(row[name] for row in rows)
    return found | {"largest residual": max(abs(row["energy_residual"]) for row in rows)}


def step_costs(scenes: dict[str, Scene], dressed: Path, turns: int, steps: int) -> dict:
    """Seconds of a step by cloth, medians over turns, and the ratio of turns: median, quartiles."""
    models = {name: Model(scene, COMM) for name, scene in scenes.items()}
    for model in models.values():
        model.put_on(dressed)
        model.stepper.advance(model.stepper.time + 100 * model.stepper.dt)
    seconds: dict[str, list] = {name: [] for name in models}
    for _ in range(turns):
        for name, model in models.items():
            begin = time.process_time()  # of this process: other programs may be busy beside it
            for _ in range(steps):
                model.stepper.step(model.stepper.dt)
            seconds[name].append((time.process_time() - begin) / steps)
    ratios = np.divide(seconds[WITH], seconds[WITHOUT])
    return {
        "seconds a step": {name: float(np.median(of)) for name, of in seconds.items()},
        "dt": {name: model.stepper.dt for name, model in models.items()},
        "ratio": float(np.median(ratios)),
        "ratio, quartiles": np.quantile(ratios, [0.25, 0.75]).tolist(),
    }


def main(given: list[str] | None = None) -> None:
    positive = console.positive
    parser = argparse.ArgumentParser(allow_abbrev=False, description=__doc__.splitlines()[0])
    parser.add_argument("--card", type=Path, default=CARD, help="of a cloth with friction")
    parser.add_argument("--runs", type=positive(int), default=3, help="starts of each cloth")
    parser.add_argument("--start", type=float, default=1.0, help="of the motion, s")
    parser.add_argument("--end", type=float, default=2.2, help="of the motion, s")
    parser.add_argument("--cell-size", type=positive(float), default=0.04, help="m")
    parser.add_argument("--dressing", choices=("particles", "shell"), default="particles")
    parser.add_argument("--turns", type=positive(int), default=20, help="of the timing")
    parser.add_argument("--steps", type=positive(int), default=100, help="in each turn")
    parser.add_argument("--out", type=Path, default=Path("out/cloth_friction"))
    options = console.parse(parser, given)
    cloth = read_fabric(options.card)
    if cloth.friction is None:
        raise ValueError(f"{options.card}: this cloth has no friction inside: give 2HG, 2HB or RT")
    report = Report(options.out, "cloth_friction", vars(options), COMM)
    cloths = {WITH: cloth, WITHOUT: cloth.with_friction(None)}
    scenes = {name: scene_of(options, cloths[name], name) for name in cloths}
    folders = {name: options.out / name.replace(" ", "_") for name in scenes}
    with report.stage("solve"):
        found = run_all([(scenes[name], folders[name]) for name in scenes], COMM)
    results: dict = dict(zip(scenes, found, strict=True))
    rows = torques(results)
    difference = compare_runs(folders[WITH], folders[WITHOUT])
    tables = {name: books(folders[name]) for name in folders}
    cost = step_costs(scenes, folders[WITH] / "dressed.npz", options.turns, options.steps)
    if COMM.rank == 0:
        print_table("Torque about the joints [N m]", rows, list(rows[0]))
        print("\n" + "\n".join(comparison_lines(difference, WITH, WITHOUT)))
        ledger = [{"cloth": name} | table for name, table in tables.items()]
        print_table("Books of the first start [J]", ledger, list(ledger[0]))
        low, high = cost["ratio, quartiles"]
        print(f"\na step costs {cost['ratio']:.3f} times that without ({low:.3f} to {high:.3f})")
    report.write(
        {"torques": rows, "difference": difference, "books": tables, "step cost": cost},
        fits={name: results[name].get("fit") for name in results},
    )


if __name__ == "__main__":
    console.run(main)
