# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tables of the joints: numbers of each run, and what differs between two runs."""

import numpy as np

from shellform.results.comparison import NUMBERS
from shellform.results.verdict import UNITS, verdict, verdict_sentence
from shellform.simulation.ensemble import compare_runs

from .curves import mean_and_band
from .finished_run import FinishedRun
from .markup import Markup, number, paragraph, table, with_error

HEAD = ("joint", "run", "mean [N m]", "band [N m]", "peak [N m]", "rms [N m]", "work [J]",
        "resisted [J]")  # fmt: skip
ABOUT = "torque of the clothing about the axis of flexion, flexion positive"


def joint_words(joint: str) -> str:
    """Name of a joint for a person."""
    return joint.replace("_", " ")


def joint_table(runs: list[FinishedRun]) -> Markup:
    """Mean, band, peak, root mean square, work and resistance of every joint of every run.

    Peak, root mean square, work and resistance are those of summary.json; mean and band are of what
    counts of the motion, see `curves.mean_and_band`.
    """
    joints = list(dict.fromkeys(joint for run in runs for joint in run.courses))
    rows = []
    for joint in joints:
        own = [run for run in runs if joint in run.courses]
        for k, run in enumerate(own):
            rows.append([joint_words(joint) if k == 0 else "", run.label, *_numbers(run, joint)])
    several = max(len(next(iter(run.courses.values())).torque) for run in runs)
    what = f"Joints: {ABOUT}"
    if several > 1:
        what += "; \N{PLUS-MINUS SIGN} standard error of the mean of the starts"
    return table(HEAD, rows, what, "joints")


def _numbers(run, joint):
    entry = run.results["joints"][joint]
    mean, error, wide = mean_and_band(run.courses[joint], tuple(run.results["counted_s"]))
    cells = [with_error(mean, error), number(wide, 2)]
    for name in ("peak_torque", "rms_torque", "work", "resistance"):
        cells.append(with_error(entry[name], entry.get(f"{name}_error")))
    return cells


def comparison_sections(runs: list[FinishedRun]) -> tuple[list[str], Markup]:
    """Each run against the first: sentences that say whether they differ, and the tables."""
    first, *others = runs
    sentences, sections = [], []
    for run in others:
        found = compare_runs(run.out, first.out)
        sentences.append(verdict_sentence(found, run.label, first.label))
        sections.append(_section(found, run.label, first.label))
    return sentences, Markup("".join(sections))


def _section(found, one, other):
    answer = verdict(found)
    rows = []
    for joint, entries in found.items():
        cells = []
        for name in NUMBERS:
            sure = (joint, name) in answer.apart
            cells.append(_difference(entries[name], sure))
        rows.append([joint_words(joint), *cells])
    head = ["joint", *(f"{name.replace('_', ' ')} [{UNITS[name]}]" for name in NUMBERS)]
    runs = next(iter(found.values()))[NUMBERS[0]]["runs"]
    what = f"{one} less {other}"
    what += f", {runs} pairs of runs, 95 % interval" if runs > 1 else ", one run each: no interval"
    said = paragraph(verdict_sentence(found, one, other), "verdict")
    return said + table(head, rows, what, "differences")


def _difference(entry, sure):
    shown = number(entry["difference"])
    if entry["low"] is None or not np.isfinite(entry["low"]):
        return Markup(shown)
    span = f"{number(entry['low'])} to {number(entry['high'])}"
    mark = ' <b title="differs, judged with all numbers together">\N{BLACK DIAMOND}</b>'
    if not sure:
        outside = entry["differ"]
        mark = ' <b title="zero lies outside of its own interval">\N{WHITE DIAMOND}</b>'
        mark = mark if outside else ""
    return Markup(
        f'<span data-value="{entry["difference"]!r}">{shown}</span> <small>({span})</small>{mark}'
    )
