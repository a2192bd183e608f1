# SPDX-License-Identifier: LGPL-3.0-or-later
"""The table of measured errors and costs, measured.csv, and the power laws that follow.

`demos/studies/accuracy/run.py --write` makes the table. A row is a run of one kind:

    mesh     relative error of a quantity with cells of size `ratio` (over the length that matters)
    spread   half the range of a quantity over slightly different starts, relative
    step     what half the time step changes, relative
    trick    what a trick, named by `family`, changes; `relative_cost` over that without
    machine  seconds of `machine()` where and when a case was measured
"""

import csv
import math
import time
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from .convergence import PowerLaw, fit

TABLE = Path(__file__).with_name("measured.csv")
COLUMNS = (
    "case", "family", "quantity", "kind", "ratio", "length", "error", "uncertainty",
    "core_seconds", "relative_cost", "nodes", "steps", "time_step", "memory_mb",
)  # fmt: skip


@lru_cache
def read(path: Path = TABLE) -> list[dict]:
    """Rows of a table: case, family, quantity, kind as text, the rest numbers."""
    with open(path) as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    words = ("case", "family", "quantity", "kind")
    return [{k: v if k in words else float(v or "nan") for k, v in row.items()} for row in rows]


@lru_cache
def power_laws(
    case: str, path: Path = TABLE, needed: bool = True
) -> dict[str, dict[str, PowerLaw]]:
    """{family: {quantity: PowerLaw}} of a case; ValueError if it is `needed` and not measured."""
    found: dict = {}
    mine = [row for row in read(path) if row["case"] == case]
    for row in mine:
        if row["kind"] == "mesh":
            found.setdefault(row["family"], {}).setdefault(row["quantity"], []).append(row)
    if not found and needed:
        raise ValueError(
            f"no errors of '{case}' in {path}: demos/studies/accuracy/run.py --write measures it"
        )
    spreads = [row for row in mine if row["kind"] == "spread"]
    # a family without a spread of its own has that of the first
    spread = {row["quantity"]: row["error"] for row in reversed(spreads)}
    own = {(row["family"], row["quantity"]): row["error"] for row in spreads}
    for name, family in found.items():
        for quantity, rows in family.items():
            ratios, errors, unsure = (
                [row[k] for row in rows] for k in ("ratio", "error", "uncertainty")
            )
            law = fit(ratios, errors, unsure, own.get((name, quantity), spread.get(quantity, 0.0)))
            # an ensemble in finer cells is no exact value: how it is known counts as an error
            family[quantity] = replace(law, floor=law.doubt) if case == "walk" else law
    return found


@lru_cache
def cost(case: str, family: str, path: Path = TABLE) -> tuple[float, float, float, float]:
    """Core-seconds a step (at no nodes, a node), MB (at no nodes, a node), by least squares."""
    from scipy.optimize import nnls

    rows = [
        r
        for r in read(path)
        if (r["case"], r["family"], r["kind"]) == (case, family, "mesh") and r["core_seconds"] > 0
    ]
    nodes = np.array([row["nodes"] for row in rows])
    per_step = np.array([row["core_seconds"] / row["steps"] for row in rows])
    A = np.column_stack([np.ones_like(nodes), nodes])
    # relative errors count alike for small and large meshes
    time_of, _ = nnls(A / per_step[:, None], np.ones_like(nodes))
    memory, _ = nnls(A, np.array([row["memory_mb"] for row in rows]))
    return (*time_of, *memory)


def tricks(case: str, names: Sequence[str], path: Path = TABLE) -> dict[str, dict]:
    """{name: {quantity: relative change, 'cost': over that without}} of tricks in use, as measured.

    A trick that was not measured in this case stands there with nothing.
    """
    found: dict[str, dict] = {name: {} for name in names}
    for row in read(path):
        if (row["case"], row["kind"]) == (case, "trick") and row["family"] in found:
            found[row["family"]] |= {row["quantity"]: row["error"], "cost": row["relative_cost"]}
    return found


def machine() -> float:
    """Seconds of a fixed piece of numpy's work, the best of five: how fast this machine is."""
    a, b = np.linspace(1, 2, 6000).reshape(1000, 6), np.ones((1000, 6))
    best = math.inf
    for _ in range(5):
        start = time.perf_counter()
        for _ in range(200):
            b = 0.5 * (b + a / b)
        best = min(best, time.perf_counter() - start)
    return best


def step_of(case: str, size: float, path: Path = TABLE) -> float:
    """Explicit time step [s] of the fabric measured with cells of a size [m]: it goes with it."""
    rows = [
        r for r in read(path) if (r["case"], r["kind"]) == (case, "mesh") and r["time_step"] > 0
    ]
    return size * float(np.median([r["time_step"] / (r["ratio"] * r["length"]) for r in rows]))


def seconds(case: str, family: str, nodes: float, steps: float, path: Path = TABLE) -> float:
    """Core-seconds of a run here and now, from those measured and the speed of this machine."""
    fixed, each, *_ = cost(case, family, path)
    mine = (case, "machine")
    then = [row["core_seconds"] for row in read(path) if (row["case"], row["kind"]) == mine]
    return steps * (fixed + each * nodes) * (machine() / then[0] if then else 1.0)


def memory(case: str, family: str, nodes: float, path: Path = TABLE) -> float:
    """Peak memory [MB] of a run."""
    *_, fixed, each = cost(case, family, path)
    return fixed + each * nodes
