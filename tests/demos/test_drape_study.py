# SPDX-License-Identifier: LGPL-3.0-or-later
"""The drape studies: what they measure against known curves, and that each command runs."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.special import j0

import meshes
from demos.studies.drape import hanging_folds
from demos.studies.drape.run import verdict
from demos.studies.drape.square import (
    DEEP,
    RIM,
    Scene,
    build,
    difference,
    folds,
    push,
    rim_of,
    states,
)
from tests.ranks import ROOT, outside

pytestmark = pytest.mark.serial


def rim(waves, depth=0.05):
    s = np.arange(RIM) / RIM
    radius = 0.4 + depth * np.cos(2 * np.pi * waves * s + 0.7)
    return np.column_stack(
        [radius * np.cos(2 * np.pi * s), radius * np.sin(2 * np.pi * s), np.cos(6 * s) + s]
    )


@pytest.mark.parametrize("waves", [3, 5, 8])
def test_folds_of_a_waved_rim(waves):
    assert folds(rim(waves)) == waves
    assert folds(rim(waves, depth=0.4 * DEEP)) == 0


def test_rim_runs_around_the_sheet():
    n = 6
    surface = meshes.rectangle(1.0, 1.0, (n, n), parameters=meshes.distorted((n, n), 0.3))
    line = rim_of(surface, surface.points)
    quarter = RIM // 4
    corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    assert np.abs(line[::quarter] - corners).max() < 1e-12
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    assert np.abs(steps - 4 / RIM).max() < 1e-12


def test_states_are_told_apart_up_to_the_symmetry_of_the_scene():
    one, quarter = rim(5), RIM // 4
    mirrored, turned, other = one.copy(), one.copy(), one.copy()
    mirrored[:, 2] = np.roll(one[::-1, 2], 1)
    turned[:, 2] = np.roll(one[:, 2], quarter)
    other[:, 2] += 0.1 * np.cos(20 * np.arange(len(one)) / len(one))
    assert difference(one, mirrored, pinned=True) == 0
    assert difference(one, turned, pinned=True) > 0.02
    assert difference(one, turned, pinned=False) == 0
    rims = [one, other, mirrored, other]
    assert states(rims, pinned=True).tolist() == [0, 1, 0, 1]


def test_a_start_is_the_same_push_on_every_mesh():
    fine = meshes.rectangle(1.0, 1.0, (40, 40)).transform(translation=(-0.5, -0.5, 0)).points
    coarse = meshes.rectangle(1.0, 1.0, (8, 8)).transform(translation=(-0.5, -0.5, 0)).points
    values = push(fine, 3)
    same = [np.flatnonzero(np.linalg.norm(fine - p, axis=1) < 1e-9)[0] for p in coarse]
    assert np.abs(values[same] - push(coarse, 3)).max() < 1e-12
    edge = np.abs(np.abs(fine[:, :2]) - 0.5) < 1e-9
    weight = np.where(edge, 0.5, 1.0).prod(axis=1)  # trapezoids: exact for these waves
    assert np.average(values**2, weights=weight) == pytest.approx(0.02**2, rel=1e-9)
    assert not push(fine, 0).any()


def test_a_push_leaves_the_pin_in_place():
    stepper, _ = build(Scene(cells=4, start=5))
    stepper.advance(0.05)
    assert np.abs(stepper.shell.displacements()[0]).max() == 0
    assert np.abs(stepper.shell.displacements()).max() > 5e-3


def test_the_curtains_edge_keeps_its_length():
    s, psi = np.linspace(0, 1, 2001), hanging_folds.full_turn()
    place = hanging_folds.meander(s, psi) + np.column_stack([s, 0 * s, 0 * s])
    assert np.linalg.norm(np.diff(place, axis=0), axis=1).sum() == pytest.approx(1, rel=1e-4)
    assert np.ptp(place[:, 0]) == pytest.approx(j0(psi), rel=1e-3)
    assert j0(psi) == pytest.approx(1 - hanging_folds.GATHER, rel=1e-9)
    assert hanging_folds.folds(place[:, 1]) == hanging_folds.WAVES


def test_orders_of_what_is_known():
    rows = [
        {"cells": n, "starts": 3, "sure": 1 + n**-2.0, "sure_spread": 1e-6}
        | {"noisy": (-1.0) ** k, "noisy_spread": 0.1}
        for k, n in enumerate((8, 16, 32, 64))
    ]
    assert verdict(rows, "sure")["says"] == "order 2.0"
    assert verdict(rows, "noisy")["says"].startswith("none")


STUDIES = {
    "refinement": ["meshes.csv", "time_steps.csv", "refinement.png"],
    "starts": ["starts.csv", "spread.csv", "starts.png"],
    "membrane": ["folds.csv", "folds_gain.csv", "folds.png"],
    "methods": ["methods.csv", "methods.png"],
}


@pytest.mark.slow
@pytest.mark.parametrize(
    "study",
    [pytest.param(s, marks=() if s == "starts" else pytest.mark.thorough) for s in STUDIES],
)
def test_each_study_runs(study, tmp_path):
    command = [sys.executable, "-m", "demos.studies.drape.run", study, "--quick", "--out", tmp_path]
    command += ["--cells", "4", "6"]
    done = subprocess.run(
        list(map(str, command)),
        cwd=ROOT,
        env=outside(),
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["settings"]["study"] == study
    for name in STUDIES[study]:
        assert Path(tmp_path / name).stat().st_size > 0
    # a row of every mesh, as in the printed table
    header, *rows = (tmp_path / STUDIES[study][0]).read_text().splitlines()
    column = header.split(",").index("cells")
    assert {"4"} <= {row.split(",")[column] for row in rows}
