# SPDX-License-Identifier: LGPL-3.0-or-later
"""The study's numbers of walks: against ensembles made of known curves, errors and scatter."""

import numpy as np
import pytest

from demos.studies.accuracy.held_out_walks import WALKS, Reached, lines, scenes
from demos.studies.accuracy.walk_case import beyond_chance, spread_of, walk_case, walk_rows
from demos.studies.accuracy.walk_numbers import QUANTITIES, Walked, apart, numbers_of, scatter_of
from shellform.accuracy.choice import LEADING, STIFF_CLOTH

pytestmark = pytest.mark.serial
PLACES = np.linspace(0, 2 * np.pi, 400, endpoint=False)
SIZES = np.array([1.0, -0.4, 2.0, 0.7])  # of the four joints


def ensemble(factor=1.0, scatter=0.0, runs=1, seed=0):
    """Walks whose curves are sines times a factor, each run with sizes of its own."""
    each = 1 + scatter * np.random.default_rng(seed).standard_normal((runs, 4))
    curves = factor * each[:, :, None] * SIZES[:, None] * np.sin(PLACES)
    mean = factor * each.mean(axis=1)
    return Walked(curves, np.full(len(PLACES), 0.02), mean, 5.0 * mean)


def test_numbers_of_sines():
    """Root mean square 1/sqrt(2), peak 1; a factor on all is the relative difference of all."""
    one = numbers_of(ensemble(runs=3))
    assert one["torque rms"] == pytest.approx(np.abs(SIZES) / np.sqrt(2), rel=1e-12)
    assert one["torque peak"] == pytest.approx(np.abs(SIZES), rel=1e-4)
    other = numbers_of(ensemble(1.07))
    for quantity in QUANTITIES:
        assert apart(other[quantity], one[quantity]) == pytest.approx(0.07, rel=1e-9)


def test_a_peak_is_that_of_the_mean_curve():
    """Runs whose peaks come at other times: the mean curve is lower than its runs are."""
    late = ensemble(runs=2)
    late.curves[1] = np.roll(late.curves[1], len(PLACES) // 4, axis=-1)
    found = numbers_of(late)
    assert found["torque peak"] == pytest.approx(np.abs(SIZES) / np.sqrt(2), rel=1e-3)
    assert found["torque rms"] == pytest.approx(np.abs(SIZES) / np.sqrt(2), rel=1e-12)


def test_scatter_of_a_single_run():
    """That of the runs made, within what a sample of 40 x 4 tells (6 % at one sigma)."""
    found = scatter_of(ensemble(scatter=0.05, runs=40, seed=1))
    for quantity in ("torque rms", "torque peak", "torque curve"):
        assert found[quantity] == pytest.approx(0.05, rel=0.25)
    # means of four joints that scatter apart have half of it
    assert found["energy"] == pytest.approx(0.025, rel=0.4)
    with pytest.raises(ValueError, match="one run alone shows no scatter"):
        scatter_of(ensemble())


def test_chance_is_no_error_of_cells():
    """Of ensembles that differ by chance alone nothing is left in the mean; a bias stays."""
    bias, scatter = 0.06, 0.03
    walks = range(200)
    reference = {k: ensemble(scatter=scatter, runs=2, seed=k) for k in walks}
    same = {k: ensemble(scatter=scatter, runs=3, seed=1000 + k) for k in walks}
    other = {k: ensemble(1 + bias, scatter, runs=3, seed=2000 + k) for k in walks}
    spread = spread_of([reference, same, other], "torque rms")
    assert spread == pytest.approx(scatter, rel=0.05)
    # 800 numbers of variance s^2 (1/2 + 1/3): their mean square is known to 5 % of it
    noise = scatter * np.sqrt(5 / 6)
    assert beyond_chance(same, reference, "torque rms", spread) < noise * np.sqrt(3 * 0.05)
    assert beyond_chance(other, reference, "torque rms", spread) == pytest.approx(bias, rel=0.1)


def test_rows_of_walks_give_their_errors_back(tmp_path):
    """Errors of h^2 in all numbers: each mesh's, the scatter, a trick against its mesh."""
    case = walk_case(tmp_path)
    cost = {"nodes": 1, "steps": 1, "time_step": 1.0, "core_seconds": 2.0}

    def costs_of(ratio, runs, costs):
        return {"ratio": ratio, "runs": runs, "costs": costs, "memory_mb": 1.0, "repeats": 1}

    scatter, runs = 1e-3, []
    for k, (size, starts) in enumerate({0.04: 3, 0.02: 6, 0.001: 4}.items()):
        settings = {"kind": "mesh", "family": "quads", "cell_size": size, "starts": starts}
        made = {
            (fabric, walk): ensemble(1 + (factor * size) ** 2, scatter, starts, 10 * k + walk)
            for fabric, factor in (("compliant", 10), ("stiff", 20))
            for walk in (0, 1)
        }
        costs = dict.fromkeys(("compliant", "stiff"), cost)
        runs.append((settings, costs_of(size / case.length, made, costs)))
    trick = runs[0][0] | {"kind": "trick", "name": "heavier"}
    heavier = {("compliant", 0): ensemble(1.16 * 1.1, scatter, 3, 99)}
    half = {"compliant": cost | {"core_seconds": 1.0}}
    runs.append((trick, costs_of(runs[0][1]["ratio"], heavier, half)))
    all_rows = [row for row in walk_rows(case, runs) if row["quantity"] == LEADING["walk"]]
    stiff = [row for row in all_rows if row["family"] == STIFF_CLOTH and row["kind"] == "mesh"]
    assert stiff[0]["error"] == pytest.approx(400 * 0.04**2, rel=0.03)
    rows = [row for row in all_rows if row["family"] != STIFF_CLOTH]
    meshes = [row for row in rows if row["kind"] == "mesh"]
    assert [row["starts"] for row in meshes] == [3, 6, 4]
    for row, size in zip(meshes[:2], (0.04, 0.02), strict=True):
        assert row["error"] == pytest.approx(100 * size**2, rel=0.03)
    # the finest is no better known than it differs from the one before
    assert meshes[2]["error"] == pytest.approx(meshes[1]["error"], rel=0.05)
    found = {row["kind"]: row for row in rows}
    assert found["spread"]["error"] == pytest.approx(scatter, rel=0.3)
    assert found["trick"]["error"] == pytest.approx(0.1, rel=0.03)
    assert found["trick"]["family"] == "heavier" and found["trick"]["relative_cost"] == 0.5


@pytest.mark.parametrize("name", WALKS)
def test_walks_held_out_are_not_those_of_the_fit(name, tmp_path):
    """Their references have finer cells, all else alike."""
    chosen, finer = scenes(name, tmp_path)
    assert finer.cell_size < 0.75 * chosen.cell_size
    assert (chosen.motion, chosen.fabric, chosen.person) == (
        finer.motion, finer.fabric, finer.person
    )  # fmt: skip
    fitted = [("compliant", h) for h in (0.0, 0.5)] + [("stiff", h) for h in (0.0, 0.5)]
    same = (chosen.fabric, chosen.motion.obstacle) in fitted
    assert not (
        same
        and chosen.motion.file == "synthetic"
        and chosen.person.stature is None
        and chosen.garment.size is None
    )


def test_what_is_kept_is_counted():
    """Kept is what lies within what was asked; a ratio of 2 is not within a factor 1.5."""
    other = dict.fromkeys(QUANTITIES, 0.02)

    def row(reached):
        numbers = dict.fromkeys(QUANTITIES, reached)
        return Reached("a walk", 0.035, 3, True, dict.fromkeys(QUANTITIES, 0.08), numbers, other)

    said = lines([row(0.08), row(0.16), row(0.02)])
    assert len(said) == 2 + 3 + 1
    assert "10 % kept by 2 of 3" in said[-1]
    assert "by 2, within a factor 1.5 both ways by 1" in said[-1]
    assert "| 8 % | 16 % | 2 % | 2.00 |" in said[3]
