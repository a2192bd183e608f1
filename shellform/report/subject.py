# SPDX-License-Identifier: LGPL-3.0-or-later
"""What was worn, by whom, doing what: a table with a column for each run."""

import tomllib
from pathlib import Path
from typing import Any

from shellform.material.card import CARDS

from .finished_run import FinishedRun
from .markup import Markup, number, table

TABLES = {
    "measured": "measured: tests of the cloth itself, in the card's table [measured]",
    "kes": "given stiffness by stiffness; the card does not say whether they were measured",
    "stiffness": "given as stiffness of the sheet; the card does not say whether it was measured",
    "isotropic": "computed from moduli of the material, not measured as cloth",
    "orthotropic": "computed from moduli of the material, not measured as cloth",
    "ply": "computed from the plies of a laminate, not measured as cloth",
}


def fabric_source(given: Any) -> str:
    """Whether a scene's fabric, a name, a path or a table, was measured or estimated."""
    name = given.get("name") if isinstance(given, dict) else given
    shipped = CARDS / f"{name}.toml"
    if shipped.is_file() and given in (name, _card_in(shipped)):
        return f"estimated: the shipped card '{name}' is of its kind of cloth, not of one cloth"
    card = given
    if isinstance(given, str | Path):
        try:
            card = _card_in(Path(given))
        except (OSError, ValueError):
            return f"not known: the card {given} is no longer there"
    kinds = [words for kind, words in TABLES.items() if kind in (card or {})]
    return kinds[0] if kinds else "not known: made in a program, without a card"


def _card_in(path):
    return tomllib.loads(path.read_text(encoding="utf-8"))


def is_measured(given: Any) -> bool:
    """Whether a scene's fabric comes from tests of the cloth itself."""
    return fabric_source(given).startswith("measured")


def subject_table(runs: list[FinishedRun]) -> Markup:
    """What was worn, by whom, doing what."""
    columns = [_rows(run) for run in runs]
    names = list(dict.fromkeys(name for column in columns for name in column))
    rows = [[name, *(column.get(name, "\N{EN DASH}") for column in columns)] for name in names]
    return table(["", *(run.label for run in runs)], rows, "Garment, wearer and motion", "facts")


def _rows(run):
    scene, results, summary = run.scene, run.results, run.summary
    recording, fit = run.wearer.recording, results["dressing"]
    facts, begin_end = recording.facts, results["counted_s"]
    rows = {
        "scene": scene.title,
        "garment": _garment(scene.garment, summary),
        "fabric": run.summary["settings"]["fabric"]["summary"]
        .partition("\n")[0]
        .replace("^2", "\N{SUPERSCRIPT TWO}"),
        "fabric known from": fabric_source(run.fabric),
        "weight": f"{number(results['weight'])} N",
    }
    if "belt_tension" in fit and scene.belt:
        rows["belt"] = (
            f"{number(fit['belt_tension'])} N, of it on the body {number(fit['belt_pressed'])} N"
        )
    rows["wearer"] = _wearer(scene.person, facts)
    rows["motion"] = _motion(scene, recording)
    if results.get("stride_length"):
        rows["gait"] = (
            f"stride {number(results['stride_length'])} m, cadence {number(results['cadence'], 4)}"
            " steps/min"
        )
    rows["counted"] = (
        f"{begin_end[0]:.2f} to {begin_end[1]:.2f} s of it, in windows of {results['window']:g} s"
    )
    rows["starts"] = f"{len(next(iter(run.courses.values())).torque)}, each with its own folds"
    return rows


def _garment(garment, summary):
    what = garment.kind if garment.file is None else f"{Path(garment.file).name} (file)"
    size = f", size {garment.size}" if garment.size else ""
    if garment.measures:
        named = ", ".join(f"{name} {number(value)} m" for name, value in garment.measures.items())
        size += f", {named}"
    cell = summary["accuracy"].get("cell_size")
    cells = f", {summary['cells']} cells"
    return what + size + cells + (f" of {1e3 * cell:.0f} mm" if cell else "")


def _wearer(person, facts):
    stature = person.stature or facts.get("stature")
    words = [f"stature {number(stature, 4)} m" if stature else "stature by the motion"]
    words.append(f"mass {number(person.mass)} kg" if person.mass else "median build")
    if person.girths:
        words.append(
            "girths " + ", ".join(f"{name} {number(g)} m" for name, g in person.girths.items())
        )
    else:
        words.append("girths not measured")
    return ", ".join(words)


def _motion(scene, recording):
    motion, times = scene.motion, recording.times
    what = recording.source if motion.file == "synthetic" else Path(str(motion.file)).name
    words = f"{what}, {times[0]:.2f} to {times[-1]:.2f} s"
    if recording.facts.get("obstacle"):
        words += f", over an obstacle of {number(recording.facts['obstacle']['height'], 2)} m"
    return words
