# SPDX-License-Identifier: LGPL-3.0-or-later
"""The study of error against cost: references, budgets, the table that is kept."""

import csv
import json

import numpy as np
import pytest

from demos.studies.accuracy import run as study
from demos.studies.accuracy.rows import reference_of, reference_rows, rms
from demos.studies.accuracy.tables import meshes
from shellform.accuracy import measured
from shellform.accuracy.choice import LEADING

pytestmark = pytest.mark.serial


def test_references_from_meshes():
    """Three meshes of second order extrapolate to the limit; without an order the finest stays."""
    curve = np.sin(np.linspace(0, 3, 20))
    sizes = [0.3, 0.2, 0.1]
    best, doubt = reference_of(sizes, [curve * (1 + h**2) for h in sizes])
    assert np.abs(best - curve).max() < 1e-3
    assert doubt == pytest.approx(0.01 * rms(curve), rel=0.02)
    best, doubt = reference_of(sizes, [1.0, 1.2, 1.1])
    assert best == 1.1 and doubt == pytest.approx(0.1)


def test_a_reference_is_no_better_known_than_starts_repeat():
    """Starts that differ by +-s about exact powers: spread s sqrt(2), errors as they are made."""
    mesh = {"family": "quads", "cells": 1}
    base = {"nodes": 1, "steps": 1, "time_step": 1.0, "core_seconds": 1.0, "memory_mb": 1.0}
    runs, s = [], 0.01
    for h in (0.4, 0.2, 0.1):
        for kind, sign in (("mesh", 1), ("start", -1)):
            found = base | {"ratio": h, "repeats": 1, "values": {"torque": 1 + h**2 + sign * s}}
            runs.append((mesh | {"kind": kind}, found))
    rows = reference_rows(None, runs)
    assert [row["kind"] for row in rows] == ["mesh", "mesh", "mesh", "spread"]
    assert rows[-1]["error"] == pytest.approx(s * np.sqrt(2), rel=1e-6)
    for row, h in zip(rows[:2], (0.4, 0.2), strict=True):
        assert row["error"] == pytest.approx(np.hypot(h**2, s), rel=1e-6) and row["starts"] == 2
    # what is taken off the finest counts as unknown, and two starts are known to s
    assert rows[0]["uncertainty"] == pytest.approx(np.hypot(0.1**2, s), rel=1e-6)
    assert rows[2]["error"] == pytest.approx(np.hypot(0.1**2, s), rel=1e-6)


def test_the_trade_is_measured(tmp_path, monkeypatch):
    """A small ladder: the files, their keys, the front, and a table that can be read again."""
    case = study.CASES["roll_up"]
    small = case._replace(ladder=study.CASES["roll_up"].ladder[1:4])
    monkeypatch.setitem(study.CASES, "roll_up", small)
    monkeypatch.setattr(measured, "TABLE", tmp_path / "kept.csv")
    monkeypatch.setattr(study, "words", lambda name: {})
    study.main(["--case", "roll_up", "--budget", "60", "--write", "--out", str(tmp_path)])
    results = json.loads((tmp_path / "summary.json").read_text())["results"]
    errors = [row["error"] for row in results["front"]]
    assert errors == sorted(errors, reverse=True)
    assert {"settings", "error", "core_seconds", "memory_mb"} <= set(results["front"][0])
    assert list(results["cheapest"]) == ["10 %", "3 %", "1 %", "0.3 %"]
    assert results["cheapest"]["10 %"]["error"] < 0.1
    assert (tmp_path / "error_and_cost.png").read_bytes()[:4] == b"\x89PNG"
    with open(tmp_path / "error_and_cost.csv") as file:
        assert len(list(csv.DictReader(file))) == 3
    law = measured.power_laws("roll_up", tmp_path / "kept.csv")["quads"]["position"]
    assert 5 < law.order < 7
    assert measured.seconds("roll_up", "quads", 26, 20, tmp_path / "kept.csv") > 0


def few(monkeypatch, tmp_path, failing=()):
    """The roll-up's ladder cut to three meshes, a table of its own; some of the runs fail."""
    case = study.CASES["roll_up"]

    def run(settings):
        if settings["cells"] in failing:
            raise RuntimeError("no equilibrium found")
        return case.run(settings)

    small = case._replace(ladder=case.ladder[1:4], run=run)
    monkeypatch.setitem(study.CASES, "roll_up", small)
    monkeypatch.setattr(measured, "TABLE", tmp_path / "kept.csv")
    return ["--case", "roll_up", "--write", "--out", str(tmp_path)]


OTHER = {"case": "capstan", "family": "quads", "quantity": "force", "kind": "mesh", "ratio": 0.5}


STALE = OTHER | {"case": "roll_up", "quantity": "position"}


@pytest.mark.thorough
def test_cases_that_are_not_whole_keep_their_rows(tmp_path, monkeypatch, capsys):
    """A run that fails is told; its case keeps the rows of before, as others do."""
    given = few(monkeypatch, tmp_path, failing=[8])
    table = tmp_path / "kept.csv"
    table.write_text(study.table_text([OTHER, *3 * [STALE]], measured.COLUMNS))
    before = table.read_text()
    study.main([*given, "--budget", "60"])
    said = capsys.readouterr().out
    assert "failed: no equilibrium found" in said
    assert "roll_up: not all settings were run, the rows of before stay" in said
    assert table.read_text() == before
    # what was run is told all the same
    with open(tmp_path / "error_and_cost.csv") as file:
        assert [row["settings"] for row in csv.DictReader(file)] == [
            "quads, cells 6", "quads, cells 10"
        ]  # fmt: skip


def test_a_case_cut_short_counts_if_it_has_as_much(tmp_path, monkeypatch):
    """The finest setting may be left out where the table has it not either."""
    given = few(monkeypatch, tmp_path, failing=[10])
    table = tmp_path / "kept.csv"
    table.write_text(study.table_text([OTHER, *2 * [STALE]], measured.COLUMNS))
    monkeypatch.setattr(study, "words", lambda name: {})
    study.main([*given, "--budget", "60"])
    rows = [row for row in measured.read(table) if row["kind"] == "mesh"]
    assert [row["case"] for row in rows] == ["capstan", "roll_up", "roll_up"]
    assert [row["ratio"] for row in rows[1:]] == pytest.approx(
        [2 * np.pi / n for n in (6, 8)], 1e-4
    )


@pytest.mark.thorough
def test_cases_that_are_whole_take_the_place_of_their_rows(tmp_path, monkeypatch):
    given = few(monkeypatch, tmp_path)
    table = tmp_path / "kept.csv"
    table.write_text(study.table_text([OTHER, STALE], measured.COLUMNS))
    monkeypatch.setattr(study, "words", lambda name: {})
    study.main([*given, "--budget", "60"])
    rows = measured.read(table)
    assert [row["ratio"] for row in rows if row["case"] == "capstan"] == [0.5]
    mine = [row for row in rows if (row["case"], row["kind"]) == ("roll_up", "mesh")]
    assert [row["ratio"] for row in mine] == pytest.approx(
        [2 * np.pi / n for n in (6, 8, 10)], 1e-4
    )
    assert [row["case"] for row in rows if row["kind"] == "machine"] == ["roll_up"]


def test_a_budget_for_nothing_is_told(tmp_path, monkeypatch):
    given = few(monkeypatch, tmp_path, failing=[6, 8, 10])
    with pytest.raises(ValueError, match="no setting of roll_up was run: give a larger --budget"):
        study.main([*given, "--budget", "60"])
    assert not (tmp_path / "kept.csv").exists()


def test_the_tables_of_the_readme_come_from_the_table():
    """Every scene has a line; the cheapest of those that keep the error stands in it."""
    table = meshes()
    assert len(table) == 2 + len(LEADING) + 1  # walks in stiff cloth have a line of their own
    rows = [
        row
        for row in measured.read()
        if (row["case"], row["kind"], row["quantity"]) == ("roll_up", "mesh", "position")
    ]
    good = min((r for r in rows if r["error"] <= 0.01), key=lambda r: r["core_seconds"])
    assert f"{good['ratio']:.2f} l, {good['core_seconds']:.2g} s" in table[2].split("|")[4]
