# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cells chosen by the error asked for, and predictions kept on scenes that were held out."""

from dataclasses import replace

import pytest

from demos.studies.accuracy import run as study
from demos.studies.accuracy.held_out import SCENES, measure
from shellform.accuracy import measured
from shellform.accuracy.asked import WALK_WORDS, relative_error
from shellform.accuracy.choice import GARMENT, accuracy_line, choose
from shellform.accuracy.ensemble_size import runs_needed
from shellform.scene.parts import Steps
from shellform.scene.scene import Scene
from shellform.simulation.prediction import tricks

pytestmark = pytest.mark.serial


@pytest.mark.parametrize("case", ["roll_up", "capstan", "strip", "sleeve", "drape"])
def test_less_error_takes_finer_cells(case):
    """Sizes fall with the error asked for; what is promised is also predicted."""
    choices = [choose(case, error, 0.1) for error in (0.1, 0.03, 0.01, 0.003, 0.001)]
    sizes = [choice.size for choice in choices]
    assert sizes == sorted(sizes, reverse=True) and sizes[0] > sizes[-1]
    for choice in choices:
        assert not choice.kept or choice.error <= choice.asked * (1 + 1e-9)
    longer = choose(case, 0.03, 0.2)
    assert longer.size == pytest.approx(2 * choose(case, 0.03, 0.1).size)


def test_the_cheaper_family_is_chosen():
    cost = {"quads": 1.0, "nine-node quads": 2.0}
    for wins in cost:
        cost = dict.fromkeys(cost, 2.0) | {wins: 1.0}
        found = choose(
            "roll_up", 0.01, 1.0, families=list(cost), work=lambda family, _: cost[family]
        )
        assert found.family == wins


def test_what_cannot_be_promised_is_told():
    """A walk repeats to some percent only: 0.1 % is refused in words, with what it leaves."""
    choice = choose("walk", "0.1%", 0.0175)
    assert not choice.kept and choice.promised is False
    assert "0.1% of torque rms cannot be promised" in choice.lines()[-1]


def test_cells_and_runs_of_a_walk_are_chosen_together():
    """Both grow with what is asked; what runs take off is the scatter of one, over their root."""
    wishes = ("20%", "10%", "8%", "5%")
    choices = [choose("walk", asked, 0.0175) for asked in wishes]
    assert [c.runs for c in choices] == [runs_needed(asked) for asked in wishes]
    assert choices[0].runs < choices[-1].runs
    sizes = [choice.size for choice in choices]
    assert sizes == sorted(sizes, reverse=True)
    assert max(sizes) <= GARMENT["draft"] * 0.0175 * (1 + 1e-12)
    for choice in choices:
        assert not choice.kept or choice.error <= relative_error(choice.asked) * (1 + 1e-9)
        more = replace(choice, runs=4 * choice.runs)
        for name, law in choice.power_laws.items():
            cells = law.factor * choice.ratio**law.order
            once, again = choice.predicted[name], more.predicted[name]
            assert once**2 - cells**2 == pytest.approx(
                4 * (again**2 - cells**2), rel=1e-6, abs=1e-12
            )


def test_words_of_a_walk_are_promised():
    """Each word fixes the cells and says whether they leave what it stands for."""
    for word, ratio in GARMENT.items():
        choice = choose("walk", word, 0.0175)
        assert choice.ratio == ratio and choice.runs == runs_needed(word)
        assert choice.promised is (choice.error <= WALK_WORDS[word])
        assert f"mean of {choice.runs} runs" in choice.lines()[0]
        entry = choice.summary(None, "as measured")
        assert f"torque rms, mean of {choice.runs} runs: predicted" in accuracy_line(entry)
    assert choose("walk", "draft", 0.0175).promised and choose("walk", "10%", 0.0175).promised


@pytest.mark.parametrize("wrong", ["0%", "banana", "100%", "-3%", "3", "", "nan%", 0.0, 2, None])
def test_errors_that_are_none(wrong):
    with pytest.raises(ValueError, match="draft, standard, fine or a percentage"):
        relative_error(wrong)


def test_words_are_errors():
    words = [relative_error(word) for word in ("draft", "standard", "fine")]
    assert words == [relative_error(text) for text in ("3%", "1%", "0.1%")]


LONG = {"drape", "sleeve"}  # of which a mesh of about half the size takes more than ten seconds


@pytest.mark.parametrize(
    "scene",
    [
        pytest.param(one, id=one[0], marks=[pytest.mark.slow] if one[1] in LONG else [])
        for one in SCENES
    ],
)
def test_predictions_hold_on_scenes_held_out(scene):
    row = measure(*scene)
    assert row["promised"] and row["asked_kept"]
    assert row["within"]


def test_tricks_are_named_with_what_they_change(tmp_path):
    """As measured; of one that was not measured nothing is said."""
    row = {"case": "sleeve", "family": "mass 4", "kind": "trick", "relative_cost": 0.5}
    rows = [
        row | {"quantity": name, "error": e} for name, e in (("torque", 0.02), ("energy", 0.01))
    ]
    table = tmp_path / "table.csv"
    table.write_text(study.table_text(rows, measured.COLUMNS))
    assert measured.tricks("sleeve", ["mass 4", "rotary 9"], table) == {
        "mass 4": {"torque": 0.02, "energy": 0.01, "cost": 0.5}, "rotary 9": {}
    }  # fmt: skip
    particles = tricks(Scene(steps=Steps(dressing="particles")))
    assert set(particles) == {"dressed by particles"} and tricks(Scene()) == {}
