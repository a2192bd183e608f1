# SPDX-License-Identifier: LGPL-3.0-or-later
"""The blocked force of 4-node quads: against its slow twin, and what no sheet may do."""

import numpy as np
import pytest

import meshes
from shellform import Fabric
from shellform.fem.quad_force import QuadForce
from tests.fem.quad_twin import Twin

WOVEN = Fabric.orthotropic(2e7, 5e6, 0.1, 2e5, 2e5, 1e5, 5e-4, 400.0)
TENSOR = [0, 1, 3, 2]  # from nodes in cyclic order
FABRICS = {"isotropic": Fabric.isotropic(1e6, 0.3, 1e-3, 400.0), "woven": WOVEN}


def curved(cells=(5, 3), seed=5):
    """Arguments of a force: a distorted piece of a cylinder; its warp turns from cell to cell."""
    surface = meshes.cylinder(
        0.5, 1.0, cells, angle=1.5, parameters=meshes.distorted(cells, 0.2, seed=seed)
    )
    middle = surface.points[surface.cells].mean(axis=1)
    warp = np.cross([0, 0, 1.0], middle) + [0, 0, 0.3]
    return surface.points, surface.directors, surface.cells[:, TENSOR], warp


def bent(points, directors, size=0.1, seed=0):
    """A field (n, 6) well away from rest, directors of any length."""
    w = np.zeros((len(points), 6))
    w[:, :3] = size * np.sin(3 * points[:, [1, 2, 0]] + seed)
    w[:, 3:] = directors + size * np.cos(4 * points + seed)
    return w


def force(given, w, **options):
    r = np.zeros_like(w)
    given = QuadForce(*given) if isinstance(given, tuple) else given
    loss = given(w, r, **options)
    return r, loss


@pytest.mark.parametrize("fabric", FABRICS)
def test_forces_are_the_derivative_of_the_energy(fabric):
    sheet = *curved(), FABRICS[fabric]
    w = bent(*sheet[:2])
    r, loss = force(sheet, w)
    exact = Twin(*sheet).forces(w)
    assert np.abs(r - exact).max() < 1e-12 * np.abs(exact).max() and loss == 0.0


def test_damping_is_that_of_the_strain_rates():
    """Its power is twice what the rates would store as strains, and its forces are conjugate."""
    sheet = *curved(), FABRICS["woven"]
    w = bent(*sheet[:2])
    rates = np.random.default_rng(1).standard_normal(w.shape) * 1e-3
    quads, twin = QuadForce(*sheet), Twin(*sheet)
    plain, damped = force(quads, w)[0], force(quads, w, ahead=w + rates)
    viscous = damped[0] - plain
    stored = twin.stored_by_rates(w, rates).sum()
    assert damped[1] == pytest.approx(2 * stored, rel=1e-10)
    assert np.vdot(viscous, rates) == pytest.approx(damped[1], rel=1e-10)
    # linear and symmetric in the rates
    others = np.random.default_rng(2).standard_normal(w.shape) * 1e-3
    other = force(quads, w, ahead=w + others)[0] - plain
    assert np.vdot(viscous, others) == pytest.approx(np.vdot(other, rates), rel=1e-9)


@pytest.mark.parametrize("layout", [np.ascontiguousarray, np.asfortranarray])
def test_arrays_given_again_are_read_anew(layout):
    """The arrays of the last call, changed in place, copied where they must be, and others."""
    sheet = *curved(), WOVEN
    quads, w, r = QuadForce(*sheet), layout(bent(*sheet[:2])), np.zeros((len(sheet[0]), 6))
    for seed in range(3):
        w[:], r[:] = bent(*sheet[:2], seed=seed), 0.0
        quads(w, r)
        other = w.copy()
        assert np.array_equal(r, force(sheet, other)[0])
        assert np.array_equal(r, force(quads, other)[0])


def test_rigid_motion_gives_no_force():
    points, directors, cells, warp = curved()
    sheet = points, directors, cells, warp, WOVEN
    w = bent(points, directors)
    r, _ = force(sheet, w)
    turn = np.linalg.qr(np.random.default_rng(3).standard_normal((3, 3)))[0]
    turn *= np.linalg.det(turn)
    moved = np.concatenate(
        [(points + w[:, :3]) @ turn.T + [0.3, -2, 1] - points, w[:, 3:] @ turn.T], 1
    )
    turned, _ = force(sheet, moved)
    largest = np.abs(r).max()
    exact = np.concatenate([r[:, :3] @ turn.T, r[:, 3:] @ turn.T], 1)
    assert np.abs(turned - exact).max() < 1e-11 * largest
    # force and moment of the whole vanish, and so do all forces at rest
    x, d = points + w[:, :3], w[:, 3:]
    moment = np.cross(x, r[:, :3]) + np.cross(d, r[:, 3:])
    assert np.abs(r[:, :3].sum(axis=0)).max() < 1e-11 * largest
    assert np.abs(moment.sum(axis=0)).max() < 1e-11 * largest
    still = np.concatenate([0 * points, directors], 1)
    assert np.abs(force(sheet, still)[0]).max() < 1e-11 * largest


def test_spin_is_not_damped():
    """A rigid spin about any axis changes no strain: no loss, no force but the elastic one."""
    points, directors, cells, warp = curved()
    quads = QuadForce(points, directors, cells, warp, WOVEN)
    w = bent(points, directors)
    spin = np.array([1.0, -2.0, 0.5])
    ahead = w + np.concatenate([np.cross(spin, points + w[:, :3]), np.cross(spin, w[:, 3:])], 1)
    (plain, _), (damped, loss) = force(quads, w), force(quads, w, ahead=ahead)
    stiff = force(quads, w, ahead=2 * w)[1]
    assert np.abs(damped - plain).max() < 1e-10 * np.abs(plain).max()
    assert abs(loss) < 1e-12 * stiff


def test_constant_strain_of_a_flat_sheet():
    """Patch: a stretched and sheared sheet of leaning cells has forces at its edge alone."""
    cells = (4, 4)
    surface = meshes.rectangle(1.0, 1.0, cells, parameters=meshes.distorted(cells, 0.25, seed=1))
    stretch = np.array([[1.02, 0.03, 0.0], [0.01, 0.99, 0.0], [0.0, 0.0, 1.0]])
    w = np.concatenate([surface.points @ (stretch.T - np.eye(3)), surface.directors], 1)
    cells = surface.cells[:, TENSOR]
    sheet = surface.points, surface.directors, cells, np.array([1.0, 0.2, 0.0]), WOVEN
    r, _ = force(sheet, w)
    inside = np.all((surface.points[:, :2] > 1e-6) & (surface.points[:, :2] < 1 - 1e-6), axis=1)
    assert inside.sum() == 9 and np.abs(r[inside, :3]).max() < 1e-12 * np.abs(r).max()


@pytest.mark.parametrize("count", [1, 3, 4, 5, 8, 9, 15])
def test_blocks_that_are_not_full(count):
    """The sheet is the sum of its cells, bit for bit the same whatever block they are in."""
    points, directors, cells, warp = curved()
    w = bent(points, directors)
    ahead = w + 0.01 * np.cos(points @ np.ones((3, 6)))
    parts, losses = np.zeros_like(w), 0.0
    for m in range(count):
        one = points, directors, cells[m : m + 1], warp[m : m + 1], WOVEN
        losses += QuadForce(*one)(w, parts, ahead)
    r, loss = force((points, directors, cells[:count], warp[:count], WOVEN), w, ahead=ahead)
    assert np.array_equal(r, parts) and loss == pytest.approx(losses, rel=1e-14)


def test_numbers_that_are_none_are_seen():
    points, directors, cells, warp = curved()
    quads = QuadForce(points, directors, cells, warp, WOVEN)
    for bad in (np.nan, np.inf):
        for k in range(6):
            w = bent(points, directors)
            w[7, k] = bad
            r, _ = force(quads, w)
            around = np.unique(cells[np.any(cells == 7, axis=1)])
            assert not np.isfinite(r[around]).all(axis=1).any()
            assert np.isfinite(np.delete(r, around, axis=0)).all()


def test_where_arrays_lie_does_not_matter():
    points, directors, cells, warp = curved((7, 5))
    w, forces = bent(points, directors), []
    for shift in range(4):
        quads = QuadForce(points, directors, cells, warp, WOVEN)
        buffers = [np.zeros(w.size + 8) for _ in range(3)]
        own, ahead, r = (b[shift : shift + w.size].reshape(w.shape) for b in buffers)
        own[:], ahead[:] = w, 1.01 * w
        forces.append((quads(own, r, ahead), r.copy()))
    assert all(a == forces[0][0] and np.array_equal(b, forces[0][1]) for a, b in forces)


def test_fields_of_another_sheet_are_refused():
    points, directors, cells, warp = curved()
    quads = QuadForce(points, directors, cells, warp, WOVEN)
    with pytest.raises(ValueError, match=r"fields of 24 nodes are \(24, 6\), not \(23, 6\)"):
        quads(np.zeros((23, 6)), np.zeros((24, 6)))
