# SPDX-License-Identifier: LGPL-3.0-or-later
"""How far a report can be trusted: errors, warnings, notes, and what would make it wrong."""

import csv

from shellform.dressing.fit import stretch_warning

from .finished_run import FinishedRun
from .markup import Markup, bullets, number, table
from .subject import fabric_source, is_measured

DEEP, UNBALANCED, LOOSE = 1e-3, 1e-6, 0.02  # m; of the weight; of the belt's tension
LEFT_OVER = 0.1  # of the work of the joints


def percent(part: float | None) -> str:
    """A part as a percentage."""
    return "\N{EN DASH}" if part is None else f"{number(100 * part, 2)} %"


def error_table(runs: list[FinishedRun]) -> Markup:
    """Errors predicted and reached, and what the steps have left over."""
    entries = [run.summary["accuracy"] for run in runs]
    names = list(dict.fromkeys(name for entry in entries for name in entry["predicted_all"]))
    rows = [["accuracy asked for", *(_asked(entry) for entry in entries)]]
    rows += [
        [f"{name}: predicted", *(percent(entry["predicted_all"].get(name)) for entry in entries)]
        for name in names
    ]
    rows.append(
        [
            "reached",
            *(
                f"{entry['of']} {percent(entry.get('estimated'))}, {entry.get('how', 'not known')}"
                for entry in entries
            ),
        ]
    )
    rows.append(["another start changes", *(percent(e["another_start_changes"]) for e in entries)])
    results = [run.results for run in runs]
    rows.append(
        ["forces balance, of the weight", *(percent(r["force_balance_error"]) for r in results)]
    )
    rows.append(["energy left over at the end", *(_left_over_words(run) for run in runs)])
    rows.append(
        [
            "deepest point in the body",
            *(f"{number(1e3 * r['max_penetration'])} mm" for r in results),
        ]
    )
    rows.append(
        [
            "cloth pressed between segments",
            *(f"{number(1e3 * r['pinched_depth'])} mm, {r['pinched_most']} nodes" for r in results),
        ]
    )
    return table(["", *(run.label for run in runs)], rows, "Errors, predicted and reached", "facts")


def _asked(accuracy):
    """The accuracy asked for, in words."""
    asked = accuracy["asked"]
    if asked is None:
        return "cells as given"
    return asked if isinstance(asked, str) else percent(asked)


def _left_over(run):
    """Energy that the steps have left over at the end [J]; None without a ledger."""
    path = run.out / "ledger.csv"
    if not path.is_file():
        return None
    last = None
    with open(path) as file:
        for last in csv.DictReader(file):
            pass
    return None if last is None else float(last["energy_residual"])


def _left_over_words(run):
    found = _left_over(run)
    return "\N{EN DASH}" if found is None else f"{number(found, 2)} J"


def warnings_of(run: FinishedRun) -> list[str]:
    """What is unusual about a run, in sentences; empty for one without fault."""
    accuracy, results, fit = run.summary["accuracy"], run.results, run.results["dressing"]
    found = []
    if accuracy["promised"] is False:
        found.append(
            f"the error asked for ({_asked(accuracy)}) is not kept: {accuracy['of']} is predicted "
            f"to be {percent(accuracy['predicted'])} off"
        )
    known = accuracy.get("measured_against_known_to")
    if known and known > 0.1:
        found.append(
            f"errors of this kind of walk were measured against a value that is itself known to "
            f"{percent(known)}: take the predictions for a guess"
        )
    if len(next(iter(run.courses.values())).torque) < 2:
        found.append("one start alone: there is no band, and differences cannot be judged")
    if not fit.get("settled", True):
        found.append("the garment was still moving when the walk began")
    asked, belt = fit.get("belt_asked") or 0.0, fit.get("belt_tension") or 0.0
    if asked and abs(belt - asked) > LOOSE * asked:
        found.append(f"the belt has {number(belt)} N instead of the {number(asked)} N asked for")
    said = stretch_warning(fit["stretch"], max(run.scene.garment.max_elongation, fit["stretch"]),
                           "the garment")  # fmt: skip
    if said:
        found.append(said.removeprefix("warning: "))
    if results["max_penetration"] > DEEP:
        found.append(f"cloth was up to {number(1e3 * results['max_penetration'])} mm in the body")
    if results["force_balance_error"] > UNBALANCED:
        found.append(f"forces balance to {percent(results['force_balance_error'])} of the weight")
    left, work = _left_over(run), sum(abs(j["work"]) for j in results["joints"].values())
    if left is not None and work and abs(left) > LEFT_OVER * work:
        found.append(
            f"the steps have left over {number(left, 2)} J, against {number(work, 2)} J that the "
            "clothing exchanges with the joints: take a smaller time_step_factor"
        )
    return found


def notes_of(run: FinishedRun) -> list[str]:
    """What was chosen or mended in the capture and in the garment's file."""
    return [str(note) for note in run.results.get("notes", [])]


def by_run(runs: list[FinishedRun], items: dict[str, list[str]], otherwise: str) -> Markup:
    """Sentences of all runs as one list: those of all once, others with the run's name."""
    said = list(dict.fromkeys(text for own in items.values() for text in own))
    lines = []
    for text in said:
        who = [label for label, own in items.items() if text in own]
        lines.append(text if len(who) == len(runs) else f"{', '.join(who)}: {text}")
    return bullets(lines, otherwise)


def caveats(runs: list[FinishedRun]) -> Markup:
    """What would make the figures wrong, of these runs."""
    scenes = [run.scene for run in runs]
    guessed = [run.label for run in runs if not is_measured(run.fabric)]
    found = []
    if guessed:
        sources = {run.label: fabric_source(run.fabric) for run in runs}
        words = "; ".join(f"{label} ({sources[label]})" for label in guessed)
        found.append(f"The fabric, if the real one is another: {words}.")
    found += _body_caveats(scenes)
    found.append(
        "Cells do not show folds smaller than themselves; relaxed cells let them go, and are too "
        "soft where friction holds coarse ones in a bent knee. The errors above are of cells, "
        "steps and starts alone, not of fabric, body or motion."
    )
    found.append(
        "Folds are chaotic: a curve repeats in its course, not in its detail; single peaks may be "
        "off by more than their standard error where starts fall into two groups."
    )
    found.append(
        f"Friction of {scenes[0].contact.friction:g} between cloth and skin is an assumption "
        "unless it was measured, and the wearer moves the same whatever the clothing resists."
    )
    if any(not scene.person.girths for scene in scenes):
        found.append("The wearer's girths were not measured; they are those of a median build.")
    if any(scene.motion.file == "synthetic" for scene in scenes):
        found.append("The walk is synthetic: a model of gait, not a person's capture.")
    return bullets(found)


def _body_caveats(scenes: list) -> list[str]:
    """What was left out of the bodies of these scenes and of cloth against cloth."""
    found, hard = (
        [],
        [s for s in scenes if s.person.body == "ellipsoids" and not s.contact.flesh_bed],
    )
    if hard:
        found.append(
            "Bodies are ellipsoids, rigid but where two parts press cloth against each other: "
            f"flesh gives way with {number(hard[0].contact.flesh_stiffness, 2)} Pa/m there, an "
            "estimate. In strongly bent joints this softness sets the torque."
        )
    if any(scene.contact.flesh_bed for scene in scenes):
        found.append("The stiffness of the flesh under the skin is an assumption.")
    if any(scene.person.body != "ellipsoids" for scene in scenes):
        found.append(
            "The body of triangles is that of a person of the same girths, not the wearer's own, "
            "unless it was scanned; it is rigid but for its joints."
        )
    if not all(scene.contact.self_contact for scene in scenes):
        found.append(
            "Cloth does not touch cloth: one trouser leg does not rub on the other, and layers do "
            "not press through each other."
        )
    return found


def cost_table(runs: list[FinishedRun]) -> Markup:
    """Versions and cost of the runs."""
    summaries = [run.summary for run in runs]
    names = list(dict.fromkeys(name for summary in summaries for name in summary["versions"]))
    rows = [[name, *(s["versions"].get(name, "\N{EN DASH}") for s in summaries)] for name in names]
    rows.append(["ranks", *(s["ranks"] for s in summaries)])
    rows.append(
        ["time step", *(f"{number(1e6 * s['time_step'])} \N{MICRO SIGN}s" for s in summaries)]
    )
    rows.append(["steps of the first run", *(s["steps"] for s in summaries)])
    rows.append(["seconds of the first run", *(number(s["seconds"]["total"]) for s in summaries)])
    return table(["", *(run.label for run in runs)], rows, "Versions and cost", "facts")
