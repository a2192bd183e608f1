# SPDX-License-Identifier: LGPL-3.0-or-later
"""Impulses of a sheet on itself: momenta, cone, least energy, and that nothing is missed."""

import numpy as np
import pytest
from scipy.optimize import nnls

from contact.self_contact.relaxation import Relaxation
from contact.self_contact.row_impulses import speed_up
from contact.self_contact.rows import ROW
from contact.self_contact.solver import SelfContactSolver
from contact.solver.friction import Friction
from tests.contact.self_contact.meshes_of_triangles import crossings, featured, sheet, together

THICKNESS, DT = 0.01, 1e-3


def solver_of(points, cells, friction=0.0, mass=None, held=None):
    n = len(points)
    mass = np.full(n, 1e-3) if mass is None else mass
    held = np.zeros((n, 3), bool) if held is None else held
    return SelfContactSolver(
        featured(points, cells), points, mass, held, THICKNESS, Friction(friction), 0.1, 0.2,
        slice(0, n),
    )  # fmt: skip


def solve(solver, x, v, dt=DT):
    """Velocities after a step's impulses; those of the step before were the same."""
    solver.region.measure(x, v)
    if solver.needs(dt) and solver.solve(x, v, v, dt):
        return v + np.einsum("ijk,ik->ij", solver.relaxation.mobility, solver.impulse)
    return v.copy()


def two_sheets(seed=0, gap=1.002 * THICKNESS):
    """Two sheets a little apart that come together, with masses of all kinds."""
    points, cells = together(sheet(4), sheet(5, 0.8, gap, 0.4))
    rng = np.random.default_rng(seed)
    v = rng.normal(size=points.shape)
    v[:, 2] -= 4.0 * (points[:, 2] > 0)
    return points, cells, v, rng.uniform(0.5, 2.0, len(points)) * 1e-3


@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_momenta_and_cone(friction):
    x, cells, v, mass = two_sheets()
    solver = solver_of(x, cells, friction, mass)
    after, rows = solve(solver, x, v), solver.rows
    impulse = solver.impulse
    size = np.abs(impulse).sum()
    assert size > 0
    assert np.abs(impulse.sum(axis=0)).max() < 1e-14 * size
    assert np.abs(np.cross(x, impulse).sum(axis=0)).max() < 1e-14 * size
    assert mass @ np.sum(after**2, axis=1) < mass @ np.sum(v**2, axis=1)
    assert (rows["push"] >= 0).all()
    rub = np.linalg.norm(rows["rub"], axis=1)
    assert (rub <= friction * rows["push"] * (1 + 1e-12)).all()
    assert (rub > 0).any() == (friction > 0)
    speed = np.einsum("ra,ri,rai->r", rows["weights"], rows["normal"], after[rows["nodes"]])
    assert (speed - rows["bound"]).min() > -2e-3 * (rows["push"] / rows["mass"]).max()
    losses = np.zeros(2)
    solver.book(v, after, losses)
    pressed, rubbed = losses
    lost = 0.5 * mass @ np.sum(v**2 - after**2, axis=1)
    assert pressed + rubbed == pytest.approx(lost, rel=1e-12)
    assert pressed > 0 and (rubbed > 0) == (friction > 0)


def test_velocities_of_least_change():
    """Without friction: of all velocities that rows admit the nearest, by a solver of that problem.

    min (u - v) M (u - v) / 2 with A u >= b: its dual is least squares with pushes that do not pull.
    """
    x, cells, v, mass = two_sheets(1)
    solver = solver_of(x, cells, 0.0, mass)
    for _ in range(6):  # pushes are kept: each call goes on where the last one stopped
        after = solve(solver, x, v)
    rows, n = solver.rows, len(x)
    A = np.zeros((len(rows), n, 3))
    for k, row in enumerate(rows):
        for node, w in zip(row["nodes"], row["weights"], strict=True):
            A[k, node] += w * row["normal"]
    root = np.repeat(np.sqrt(mass), 3)
    scaled = A.reshape(len(rows), -1) / root
    # least |L + Bt p|, p >= 0, with [B; e] and a row that carries the bounds
    lack = rows["bound"] - np.einsum("rni,ni->r", A, v)
    E = np.vstack([scaled.T, lack])
    f = np.append(np.zeros(3 * n), 1.0)
    p, rest = nnls(E, f)
    r = E @ p - f
    exact = v.ravel() - r[:-1] / r[-1] / root
    assert rest > 0
    scale = np.abs(exact - v.ravel()).max()
    assert np.abs(after.ravel() - exact).max() < 5e-3 * scale


def test_what_turns_as_one_does_not_slip():
    x, cells, _, mass = two_sheets(gap=0.9 * THICKNESS)
    solver = solver_of(x, cells, 0.5, mass)
    spin = np.array([0.3, -0.2, 0.5])
    v = np.cross(spin, x) + [1.0, 2.0, 3.0]
    solve(solver, x, v)
    rows = solver.rows
    slip = np.einsum("rkai,rai->rk", rows["sliding"], v[rows["nodes"]])
    assert len(rows) and np.abs(slip).max() < 1e-13
    naive = np.einsum("ra,rki,rai->rk", rows["weights"], rows["tangents"], v[rows["nodes"]])
    assert np.abs(naive).max() > 1e-3


def test_held_nodes_do_not_move():
    x, cells, v, mass = two_sheets()
    held = np.zeros(x.shape, bool)
    held[x[:, 2] == 0] = True
    v[held] = 0.0
    solver = solver_of(x, cells, 0.3, mass, held)
    after = solve(solver, x, v)
    assert not after[held].any() and np.abs(after - v).max() > 1.0


def test_nothing_is_missed():
    """Two sheets thrown at each other: the rows of each step are those of a search made anew.

    Lists, pairs near and distances are used for many steps in between, and no edge passes.
    """
    x, cells, v, mass = two_sheets(gap=0.06)
    x[:, 2] += 0.01 * np.sin(13 * x[:, 0])
    v = 0.3 * v + [5.0, 0.0, 0.0]  # what all share takes no part
    solver, met, last = solver_of(x, cells, 0.3, mass), 0, v
    for _ in range(120):
        fresh = solver_of(x, cells, 0.3, mass)
        fresh._rest = solver._rest
        for one in (solver, fresh):
            one.region.measure(x, last)
            looked = one.needs(DT) and one.solve(x, v, last, DT)
            if one is solver:
                pushed = looked
        assert np.array_equal(solver.rows["key"], fresh.rows["key"])
        met += len(solver.rows)
        last = v
        if pushed:
            v = v + solver.impulse / mass[:, None]
        x = x + DT * v
        last = v
    assert met > 300 and solver.listings < 60
    assert solver.closest > 0.5 * THICKNESS  # steps are of 0.4 of it
    assert crossings(x, cells) == 0


def test_neighbours_at_rest_do_not_push():
    """Cells finer than the thickness: nothing at rest, and no closer than half of that."""
    points, cells = sheet(12, 0.06)
    solver = solver_of(points, cells)
    v = np.zeros_like(points)
    assert not solver.impulse.any() and np.array_equal(solve(solver, points, v), v)
    assert len(solver.rows) == 0 or (solver.rows["bound"] < 0).all()
    folded = points.copy()
    folded[:, 0] = np.abs(folded[:, 0])
    folded[:, 2] = np.where(points[:, 0] < 0, 1e-3, 0.0)
    solve(solver, folded, v)
    assert (solver.rows["push"] > 0).any()


def test_gone_on_with():
    """Rows alone take a step to its last bit; without them it ends elsewhere."""
    x, cells, v, mass = two_sheets(gap=0.999 * THICKNESS)
    one, other, bare = (solver_of(x, cells, 0.3, mass) for _ in range(3))
    v = solve(one, x, v)
    other.restore(one.rows.copy())
    pull = v - [0.0, 0.0, 1e-2] * (x[:, 2:] > 0)
    after = solve(one, x, pull)
    assert np.array_equal(solve(other, x, pull), after)
    assert not np.array_equal(solve(bare, x, pull), after)


def test_rows_that_contradict_each_other_do_not_run_away():
    """A cell pressed to nothing, turned over, asks two nodes to part and to close at once.

    No impulses fulfil both. Kept from step to step they grew without an end, and friction with
    them.
    """
    rows = np.zeros(2, ROW)
    rows["nodes"], rows["weights"] = np.arange(4), [1.0, 0.0, -1.0, 0.0]
    rows["normal"], rows["bound"] = [[0, 0, 1.0], [0, 0, -1.0]], [0.1, 0.05]
    for k, along in enumerate(np.eye(3)[:2]):
        rows["sliding"][:, k] = rows["weights"][:, :, None] * along
    mass = np.full(4, 1e-3)
    relaxation = Relaxation(mass, np.zeros((4, 3), bool), Friction(0.4))
    v = np.zeros((4, 3))
    v[0] = [0.5, 0.0, -0.2]
    after = np.empty_like(v)
    for _ in range(60):
        rows["bound"] = [0.1, 0.05]
        relaxation.relax(rows, v, None)
        # a hundred times the greatest speed
        assert (rows["push"] / rows["mass"]).max() < 50.0
    speed_up(rows, relaxation.mobility, v, after)
    assert np.sum(after**2) < np.sum(v**2) and relaxation.limited == 60
