# SPDX-License-Identifier: LGPL-3.0-or-later
"""Forces of quads that wrinkle below their size: against the scalar law, and its damping."""

import numpy as np
import pytest

from shellform.fem.quad_force import QuadForce
from shellform.material.relaxed_stress import relax
from shellform.material.wrinkling import SLACK, TAUT, WRINKLED, trial_angles
from tests.fem.quad_twin import Twin
from tests.fem.test_quad_force import WOVEN, bent, curved


@pytest.fixture
def sheet():
    """Force, field, cost and arcs of a sheet, taut, wrinkled and slack."""
    given = *curved((7, 6)), WOVEN
    w = bent(*given[:2], size=1e-3)
    w[:, :3] += 0.03 * np.sin(6 * given[0][:, 2:]) * given[0]  # wider here, narrower there
    rng = np.random.default_rng(4)
    count = len(given[2])
    cost, arcs = rng.uniform(0, 10, count), (rng.uniform(size=count) > 0.3).astype(float)
    return given, w, cost, arcs


def law(E, cost):
    """Energy (m,), stress (m, 3) and state (m,) by the scalar law."""
    C = WOVEN.membrane
    energy, stress, tangent = np.empty(len(E)), np.empty((len(E), 3)), np.empty((len(E), 3, 3))
    state, direction = np.empty(len(E), np.int64), np.empty(len(E))
    compliance = np.linalg.inv(C)
    relax(
        E, C, compliance, trial_angles(C), cost, energy, stress, tangent, state, direction
    )  # fmt: skip
    return energy, stress, state


def forces(sheet, quads=None, **options):
    given, w, cost, arcs = sheet
    quads = quads or QuadForce(*given, relaxed=True)
    r = np.zeros_like(w)
    loss = quads(w, r, cost=cost, arcs=arcs, **options)
    return r, loss


def test_forces_are_those_of_the_scalar_law(sheet):
    given, w, cost, arcs = sheet
    E, _ = Twin(*given, arcs=arcs).strains(w)
    _, stress, state = law(E, cost)
    assert {*state} == {TAUT, WRINKLED, SLACK}
    exact = Twin(*given, lambda E: np.sum(stress * E, axis=1), arcs).forces(w)
    r, _ = forces(sheet)
    assert np.abs(r - exact).max() < 1e-9 * np.abs(exact).max()


def test_forces_are_differences_of_the_energy(sheet):
    given, w, cost, arcs = sheet
    twin = Twin(*given, lambda E: law(E, cost)[0], arcs)
    change = np.random.default_rng(5).standard_normal(w.shape)
    step = 1e-7
    more, less = (twin.energies(w + s * step * change).sum() for s in (1, -1))
    assert np.vdot(forces(sheet)[0], change) == pytest.approx((more - less) / (2 * step), rel=1e-5)


def test_where_all_is_taut_nothing_is_relaxed():
    given = *curved(), WOVEN
    w = bent(*given[:2], size=1e-3)
    w[:, :3] += 0.02 * given[0]
    count = len(given[2])
    plain, relaxed = np.zeros_like(w), np.zeros_like(w)
    QuadForce(*given)(w, plain)
    QuadForce(*given, relaxed=True)(w, relaxed, None, np.zeros(count), np.ones(count))
    assert np.abs(relaxed - plain).max() < 1e-12 * np.abs(plain).max()


def test_a_high_cost_keeps_wrinkles_away(sheet):
    given, w, cost, _ = sheet
    plain, ahead = np.zeros_like(w), 1.01 * w
    loss = QuadForce(*given)(w, plain, ahead)
    r, lost = forces((given, w, 1e8 + cost, np.ones_like(cost)), ahead=ahead)
    assert np.abs(r - plain).max() < 1e-6 * np.abs(plain).max()
    assert lost == pytest.approx(loss, rel=1e-6)


def test_damping_only_takes(sheet):
    """Any rates lose what they work against damping, never less than nothing."""
    given, w, *_ = sheet
    quads, rng = QuadForce(*given, relaxed=True), np.random.default_rng(6)
    plain, _ = forces(sheet, quads)
    for size in (1e-8, 1e-5, 1e-2):
        for smooth in (True, False):
            rates = np.cos(3 * given[0] @ rng.standard_normal((3, 6)))
            rates = size * (rates if smooth else rng.standard_normal(w.shape))
            damped, loss = forces(sheet, quads, ahead=w + rates)
            assert loss > 0
            assert np.vdot(damped - plain, rates) == pytest.approx(loss, rel=1e-6)
            less = QuadForce(*given)(w, np.zeros_like(w), w + rates)
            assert loss < less * (1 + 1e-12)  # than the taut sheet


def test_no_more_compression_than_wrinkles_cost():
    """Shortened at any speed, a flat sheet pushes its edge by N_c alone."""
    points = np.array([[0.0, 0, 0], [0.3, 0, 0], [0, 0.2, 0], [0.3, 0.2, 0]])
    directors, cells = np.tile([0.0, 0, 1], (4, 1)), np.array([[0, 1, 2, 3]])
    quads = QuadForce(points, directors, cells, np.array([1.0, 0, 0]), WOVEN, relaxed=True)
    w = np.concatenate([points * [-0.05, 0.0, 0.0], directors], 1)
    cost = np.array([7.0])
    for speed in (0.0, 0.1):
        r = np.zeros_like(w)
        ahead = w - np.concatenate([speed * points * [1, 0, 0], 0 * points], 1)
        quads(w, r, ahead, cost, np.ones(1))
        # per length of the edge at rest, times the stretch that turns stress into force
        assert r[[1, 3], 0].sum() == pytest.approx(-7.0 * 0.2 * 0.95, rel=1e-9)


def test_frozen_stress_is_that_of_the_taut_sheet_about_it(sheet):
    given, w, cost, arcs = sheet
    quads = QuadForce(*given, relaxed=True)
    frozen = quads.freeze(w, cost, arcs)
    r, _ = forces(sheet, quads)
    held, _ = forces(sheet, quads, frozen=frozen)
    assert np.abs(held - r).max() < 1e-12 * np.abs(r).max()
    # elsewhere: the energy of the taut sheet and the stress
    E0, _ = Twin(*given, arcs=arcs).strains(w)
    taut, stress = WOVEN.membrane, law(E0, cost)[1]
    density = lambda E: (  # noqa: E731
        np.sum(stress * E, axis=1) + 0.5 * np.einsum("mi,ij,mj->m", E - E0, taut, E - E0)
    )
    other = w + 1e-3 * np.sin(5 * given[0] @ np.ones((3, 6)))
    exact = Twin(*given, density, arcs).forces(other)
    r, _ = forces((given, other, cost, arcs), quads, frozen=frozen)
    assert np.abs(r - exact).max() < 1e-9 * np.abs(exact).max()


def test_cells_of_a_block_do_not_know_each_other(sheet):
    given, w, cost, arcs = sheet
    points, directors, cells, warp, fabric = given
    parts, ahead = np.zeros_like(w), 1.001 * w
    for m in range(len(cells)):
        one = QuadForce(points, directors, cells[m : m + 1], warp[m : m + 1], fabric, True)
        one(w, parts, ahead, cost[m : m + 1], arcs[m : m + 1])
    assert np.array_equal(forces(sheet, ahead=ahead)[0], parts)


def test_numbers_that_are_none_are_seen(sheet):
    given, w, cost, arcs = sheet
    quads = QuadForce(*given, relaxed=True)
    for k in range(6):
        bad = w.copy()
        bad[7, k] = np.nan
        assert not np.isfinite(forces((given, bad, cost, arcs), quads)[0][7]).any()


def test_lists_of_another_sheet_are_refused(sheet):
    given, w, cost, arcs = sheet
    with pytest.raises(ValueError, match="cost and arcs of 42 cells, not 41, 42"):
        forces((given, w, cost[1:], arcs))
