# SPDX-License-Identifier: LGPL-3.0-or-later
"""Folders of runs to report: one is computed, others are made from it with other torques."""

import csv
import shutil
from dataclasses import replace

from mpi4py import MPI

import numpy as np
import pytest

from shellform.report import plotly_library
from shellform.report.page import write_report
from shellform.results.joint_torque import COLUMNS, line
from shellform.scene.scene_file import write_scene
from shellform.simulation.ensemble import resume
from shellform.simulation.run import run
from tests.dressing.test_dress import dressed
from tests.simulation.short_walk import WALK

SHORT = replace(WALK, motion=replace(WALK.motion, end=1.6), steps=replace(WALK.steps, runs=3))


@pytest.fixture(scope="session")
def one_run(tmp_path_factory):
    """Folder of a short walk, computed once: its first start alone."""
    out = tmp_path_factory.mktemp("first") / "run"
    run(SHORT, out, MPI.COMM_SELF, dressed("compliant").path)
    return out


@pytest.fixture(scope="session")
def ensembles(one_run, tmp_path_factory):
    """Function: folder of three starts, of the run's torques times a factor, with a scatter."""

    def made(name, factor, scatter, seed):
        out = tmp_path_factory.mktemp("ensemble") / name
        shutil.copytree(one_run, out)
        draw = np.random.default_rng(seed)
        with open(one_run / "torque.csv") as file:
            rows = [
                {key: v if key == "joint" else float(v) for key, v in row.items()}
                for row in csv.DictReader(file)
            ]
        for k in range(3):
            folder = out if k == 0 else out / f"run_{k}"
            if k:
                folder.mkdir()
                shutil.copy(one_run / "summary.json", folder)
                write_scene(SHORT, folder / "scene.toml")
            start = factor * (1 + scatter * draw.standard_normal())
            noise = 1 + scatter * draw.standard_normal(len(rows))
            text = ",".join(COLUMNS) + "\n"
            for row, own in zip(rows, noise, strict=True):
                more = {key: row[key] * start * own for key in COLUMNS[2:]}
                text += line(row | more)
            (folder / "torque.csv").write_text(text)
        resume(out, MPI.COMM_SELF)
        return out

    return made


@pytest.fixture(scope="session")
def two_runs(ensembles):
    """Folders of two ensembles that differ by half."""
    return [ensembles("light", 1.0, 0.02, 1), ensembles("heavy", 1.5, 0.02, 2)]


@pytest.fixture(scope="session")
def written(two_runs, tmp_path_factory):
    """The page of two runs, the first of which the second is compared with."""
    if not plotly_library.is_there():
        pytest.skip("plotly, an option, is not installed")
    return write_report(two_runs, tmp_path_factory.mktemp("page") / "report.html")
