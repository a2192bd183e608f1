# SPDX-License-Identifier: LGPL-3.0-or-later
"""The tables of docs/accuracy.md from shellform/accuracy/measured.csv; nothing is run.

`python -m demos.studies.accuracy.run --table` prints them.
"""

import math

from shellform.accuracy.asked import WORDS, percent, relative_error
from shellform.accuracy.choice import LEADING, STIFF_CLOTH, choose
from shellform.accuracy.convergence import cheapest
from shellform.accuracy.measured import power_laws, read

ERRORS = (0.1, 0.03, 0.01, 0.003)
KINDS = ("spread", "step", "trick")
CALLED = {"spread": "another start", "step": "half the time step"}


def table_lines():
    """The three tables in Markdown."""
    return [*meshes(), "", *words(), "", *changes()]


def meshes():
    """Cheapest cells for an error, cost; what was measured."""
    said = ["| scene, error of | 10 % | 3 % | 1 % | 0.3 % |", "|---|---|---|---|---|"]
    for case, quantity in LEADING.items():
        rows = [
            row
            for row in read()
            if (row["case"], row["quantity"], row["kind"]) == (case, quantity, "mesh")
        ]
        for name, own in _by_cloth(case, rows):
            cells = [_cheapest(own, error) for error in ERRORS]
            doubt = own[0]["uncertainty"]
            known = f" (known to {percent(doubt)})" if doubt > 1e-4 else ""
            said.append(f"| {name}, {quantity}{known} | {' | '.join(cells)} |")
    return said


def _by_cloth(case, rows):
    """Rows by what they are called: those of walks by their cloth."""
    name = case.replace("_", " ")
    parts = {
        name: [row for row in rows if row["family"] != STIFF_CLOTH],
        f"{name} in stiff cloth": [row for row in rows if row["family"] == STIFF_CLOTH],
    }
    return [(name, own) for name, own in parts.items() if own]


def _cheapest(rows, error):
    # a row that does not tell its time is cheaper than none
    timed = [
        row | {"core_seconds": math.inf} if math.isnan(row["core_seconds"]) else row for row in rows
    ]
    best = cheapest(timed, error)
    if best is None:
        return f"- (best {percent(min(row['error'] for row in rows))})"
    family = f"{best['family']}, " if best["family"] in ("particles", "nine-node quads") else ""
    time = f", {best['core_seconds']:.2g} s" if best["core_seconds"] < math.inf else ""
    return f"{family}{best['ratio']:.2f} l{time}"


def changes():
    """What another start, half the step and tricks change, and what they cost."""
    said = ["| scene | what | changes | time over that without |", "|---|---|---|---|"]
    rows = [row for row in read() if row["kind"] in KINDS]
    for case in LEADING:
        for called, mine in _by_cloth(case, [row for row in rows if row["case"] == case]):
            for kind, family in dict.fromkeys((row["kind"], row["family"]) for row in mine):
                some = [row for row in mine if (row["kind"], row["family"]) == (kind, family)]
                what = ", ".join(f"{row['quantity']} {short(row['error'])}" for row in some)
                cost = some[0]["relative_cost"]
                name, cost = CALLED.get(kind, family), "" if math.isnan(cost) else f"{cost:.2f}"
                said.append(f"| {called} | {name} | {what} | {cost} |")
    return said


def words():
    """What the words choose in each scene: size of the cells, error; a star: not what was asked."""
    said = ["| scene | draft | standard | fine |", "|---|---|---|---|"]
    for case in LEADING:
        known = power_laws(case, needed=False)
        for family in [name for name in (next(iter(known), None), STIFF_CLOTH) if name in known]:
            found = [choose(case, word, 1.0, families=[family]) for word in WORDS]
            cells = (
                f"{choice.ratio:.2f} l, "
                + (f"{choice.runs} runs, " if choice.runs > 1 else "")
                + percent(choice.error)
                + ("" if choice.error <= relative_error(choice.asked, case) else " *")
                for choice in found
            )
            cloth = " in stiff cloth" if family == STIFF_CLOTH else ""
            said.append(f"| {case.replace('_', ' ')}{cloth} | {' | '.join(cells)} |")
    return said


def short(error):
    """An error as a text, 0 for what is none."""
    return percent(error) if error >= 1e-5 else "0"
