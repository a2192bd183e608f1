# SPDX-License-Identifier: LGPL-3.0-or-later
"""Measured bending, a roof by arc length, and a strip laid on a table, each against its oracle."""

import numpy as np
import pytest

from demos.studies.reviewed import eischen, penalty_contact
from demos.studies.reviewed.cusick_drape import SUITING
from shellform.material.measurements import measured_fabric

pytestmark = [
    pytest.mark.serial,
    pytest.mark.thorough,
    pytest.mark.filterwarnings("ignore::shellform.material.fabric.UnitWarning"),
]


def test_the_curve_comes_back():
    """To 0.5 %, where a constant stiffness would miss it by a fifth and more."""
    rows = eischen.bending_rows(cells=8)
    assert max(abs(row["off %"]) for row in rows) < 0.5
    assert rows[-1]["with a constant B, off %"] < -20


def test_the_roof():
    """Half the cells: the whole path with its snap-back within 2 %."""
    row = eischen.roof_row(8)
    assert row["off %"] < 2.0
    assert row["lowest"] < 0 < row["limit"]


def test_the_exact_strip():
    """A low table: the linear beam, s*^4 = 72 B h/q and R = q s*/3."""
    B, q, h = 1e-5, 2.0, 1e-4
    found = penalty_contact.exact(B, q, h)
    assert found["s"] == pytest.approx((72 * B * h / q) ** 0.25, rel=1e-3)
    assert found["R"] == pytest.approx(q * found["s"] / 3, rel=1e-3)


def test_contact_by_penalty():
    """What the table gives way falls as its stiffness grows, and so does the error of the clamp."""
    fabric = measured_fabric(SUITING)
    B, q = fabric.bending[0, 0], fabric.areal_mass * penalty_contact.G
    exact = penalty_contact.exact(B, q, eischen.HEIGHT)
    laid = [penalty_contact.by_penalty(fabric, eischen.HEIGHT, k, 50) for k in (1e3, 2e4)]
    off = [abs(one.clamp / exact["clamp"] - 1) for one in laid]
    assert off[1] < 0.005 < off[0] < 0.05
    assert laid[1].depth < 0.2 * laid[0].depth
    # nothing but clamp and table carries the strip
    weight = q * penalty_contact.LENGTH
    assert [one.clamp + one.table for one in laid] == pytest.approx([weight] * 2, rel=1e-6)
    assert np.all([one.depth > 0.9 * q / k for one, k in zip(laid, (1e3, 2e4), strict=True)])


def test_an_augmented_lagrangian():
    """At the same stiffness the strip lies a tenth as deep and the clamp bears what it should."""
    fabric = measured_fabric(SUITING)
    B, q = fabric.bending[0, 0], fabric.areal_mass * penalty_contact.G
    exact = penalty_contact.exact(B, q, eischen.HEIGHT)
    once, more = (
        penalty_contact.by_penalty(fabric, eischen.HEIGHT, 1e3, 50, augmented=n) for n in (0, 6)
    )
    assert more.depth < 0.1 * once.depth
    assert abs(more.clamp / exact["clamp"] - 1) < 0.5 * abs(once.clamp / exact["clamp"] - 1)
    assert more.clamp + more.table == pytest.approx(q * penalty_contact.LENGTH, rel=1e-6)
