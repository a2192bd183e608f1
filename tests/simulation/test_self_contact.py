# SPDX-License-Identifier: LGPL-3.0-or-later
"""A walk in which cloth meets cloth: what is planned, booked and told."""

import json
from dataclasses import replace

import pytest

from shellform.scene.parts import Contact, Motion
from shellform.simulation.plan import plan_lines, plan_of
from shellform.simulation.run import run
from shellform.simulation.summary import summary_lines
from tests.dressing.test_dress import dressed
from tests.simulation.short_walk import WALK, table

SCENE = replace(
    WALK,
    motion=Motion(start=1.5, end=1.51, initiation=0.05),
    contact=Contact(self_contact=True),
)


@pytest.mark.thorough
@pytest.mark.slow
def test_what_is_told_of_cloth_on_cloth(shared_tmp_path, comm):
    """From a state dressed without it, in which cloth passes through itself: that is told."""
    results = run(SCENE, shared_tmp_path, comm, dressed("compliant").path)
    comm.Barrier()
    told = json.loads((shared_tmp_path / "summary.json").read_text())
    assert told["results"]["intersections"] == results["intersections"] > 0
    found = results["self_contact"]
    assert found["pairs_most"] > 0 and 0 <= found["closest"] <= 1.2 * found["thickness"]
    assert told["plan"]["self_contact"] is True
    rows = table(shared_tmp_path / "ledger.csv")
    assert rows[-1]["self_impact_loss"] == pytest.approx(found["impact_loss"], rel=1e-9)
    assert max(row["momentum_residual"] for row in rows) < 1e-12
    line = next(line for line in summary_lines(results) if line.startswith("cloth on cloth:"))
    assert f"{results['intersections']} edges through triangles" in line and "dressed" in line


@pytest.mark.thorough
def test_nothing_passes_in_a_walk(shared_tmp_path, comm):
    """Dressed with it too, no edge passes through a triangle at any output."""
    results = run(replace(SCENE, motion=Motion(end=1.0)), shared_tmp_path, comm)
    assert results["intersections"] == 0
    assert results["self_contact"]["closest"] > 0.2 * results["self_contact"]["thickness"]


def test_plan_says_it():
    assert "cloth meets cloth" in "\n".join(plan_lines(plan_of(SCENE)))
    assert "no contact of cloth with cloth" in "\n".join(plan_lines(plan_of(WALK)))
