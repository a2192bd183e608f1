# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a report warns of, and where it says a fabric is known from."""

import copy

import numpy as np
import pytest

import shellform as sf
from shellform.material.card import CARDS
from shellform.report.finished_run import FinishedRun
from shellform.report.markup import bullets, number, safe, table, with_error
from shellform.report.subject import fabric_source, is_measured
from shellform.report.trust import caveats, notes_of, warnings_of
from shellform.results.mean_torque import Course
from shellform.scene.parts import Motion, Person

DASH, MINUS = "\N{EN DASH}", "\N{MINUS SIGN}"
SUMMARY = {
    "accuracy": {
        "asked": "draft", "of": "torque rms", "predicted": 0.08, "promised": True,
        "measured_against_known_to": 0.04,
    },
    "results": {
        "joints": {"right_knee": {"work": -1.0}},
        "dressing": {"settled": True, "stretch": 0.01, "belt_asked": 20.0, "belt_tension": 20.0},
        "max_penetration": 1e-5, "force_balance_error": 1e-10, "notes": ["two gaps filled"],
    },
}  # fmt: skip


def run_of(tmp_path, starts=3, left=0.001, **changes):
    """A run whose summary has changes, as `accuracy__promised=False`."""
    summary = copy.deepcopy(SUMMARY)
    for path, value in changes.items():
        *way, last = path.split("__")
        entry = summary
        for name in way:
            entry = entry[name]
        entry[last] = value
    (tmp_path / "ledger.csv").write_text(f"time,energy_residual\n0.02,9.0\n0.04,{left}\n")
    zeros = np.zeros((starts, 2))
    course = Course(np.array([0.02, 0.04]), np.full(2, 0.02), zeros, zeros)
    courses = {"right_knee": course}
    return FinishedRun("run", tmp_path, sf.Scene(), "compliant", None, None, summary, courses)


def test_a_run_without_fault(tmp_path):
    run = run_of(tmp_path)
    assert warnings_of(run) == []
    assert notes_of(run) == ["two gaps filled"]


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"accuracy__promised": False}, "the error asked for (draft) is not kept: torque rms"),
        ({"accuracy__measured_against_known_to": 0.3}, "itself known to 30 %"),
        ({"starts": 1}, "one start alone"),
        ({"results__dressing__settled": False}, "still moving when the walk began"),
        ({"results__dressing__belt_tension": 18.0}, "18.0 N instead of the 20.0 N"),
        ({"results__dressing__stretch": 0.1}, "stretched by 10 %"),
        ({"results__max_penetration": 2e-3}, "2.00 mm in the body"),
        ({"results__force_balance_error": 1e-3}, "0.10 % of the weight"),
        ({"left": -0.5}, "0.50 J, against 1.0 J"),
    ],
)
def test_each_fault_is_said_once(tmp_path, changes, said):
    (found,) = warnings_of(run_of(tmp_path, **changes))
    assert said in found.replace("\N{MINUS SIGN}", "")


def test_where_a_fabric_is_known_from(tmp_path):
    """Shipped cards by name or as a table are estimates; others say what they hold."""
    assert fabric_source("compliant").startswith("estimated: the shipped card 'compliant'")
    shipped = (CARDS / "stiff.toml").read_text()
    (tmp_path / "stiff.toml").write_text(shipped.replace("3.0e-4", "2.0e-4"))
    assert fabric_source(str(tmp_path / "stiff.toml")).startswith("given stiffness by stiffness")
    assert fabric_source({"isotropic": {}}).startswith("computed from moduli")
    assert is_measured({"name": "suiting", "measured": {}}) and not is_measured("compliant")
    assert fabric_source(str(tmp_path / "gone.toml")).startswith("not known: the card")
    assert fabric_source(None).startswith("not known: made in a program")


def test_caveats_name_what_was_guessed(tmp_path):
    run = run_of(tmp_path)
    text = caveats([run])
    for words in ("estimated: the shipped card", "girths were not measured", "walk is synthetic"):
        assert words in text
    known = run._replace(
        fabric={"measured": {}},
        scene=sf.Scene(person=Person(girths={"waist": 0.9}), motion=Motion("walk.c3d")),
    )
    for words in ("estimated", "girths", "synthetic"):
        assert words not in caveats([known]).replace("an estimate", "")


@pytest.mark.parametrize(
    ("value", "text"),
    [(0, "0"), (None, DASH), (np.nan, DASH), (1.2345, "1.23"), (-0.04, MINUS + "0.0400"),
     (12345, "12345"), (4.7e-9, f"4.70e{MINUS}09")],
)  # fmt: skip
def test_numbers_as_text(value, text):
    assert number(value) == text


def test_errors_set_the_digits():
    assert MINUS + "1.270 <small>± 0.034" in with_error(-1.2704, 0.0339)
    assert "0.0000 <small>± 0.0001" in with_error(1e-6, 2e-7)
    assert ">2.500<" in with_error(2.5, None) and ">2.500<" in with_error(2.5, np.nan)


def test_what_comes_from_files_is_escaped():
    assert safe("<b>&") == "&lt;b&gt;&amp;" and safe(safe("<b>")) == "&lt;b&gt;"
    assert "<i>" not in table(["<i>"], [["<i>", "<i>"]], "<i>") + bullets(["<i>"])
