# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact with closed surfaces of triangles: balances, weight, stick and slip, speed, restart."""

import warnings

import numpy as np
import pytest

from contact.body.blended_surface import BlendedSurface
from contact.body.rigid_surface import RigidSurface
from contact.body.segments import Body, Fixed, Segment, Steady, turned
from contact.geometry.triangle_mesh.closest import signed_distances
from contact.geometry.triangle_mesh.placed import new_placed, refit
from contact.geometry.triangle_mesh.sphere import sphere
from contact.geometry.triangle_mesh.topology import mesh_of
from contact.solver.surface_correction import SurfaceCorrection
from contact.solver.union_correction import UnionCorrection
from contact.solver.velocity_correction import VelocityCorrection
from tests.contact.solver.bodies import G, energy
from tests.contact.solver.surfaces import ball, box, lump, valley


def distances(surface, t, x):
    """Signed distances (n,) of points from the flat triangles at time t."""
    vertices = surface.positions(t, np.empty((surface.vertex_count, 3)))
    mesh = mesh_of(surface.triangles, vertices)
    placed = new_placed(mesh, len(vertices))
    placed.vertices[:] = vertices
    refit(mesh, placed)
    out, found = np.empty(len(x)), np.empty(len(x), np.int64)
    signed_distances(mesh, placed, np.ascontiguousarray(x), out, found)
    return out


def around(surface, t, rng, count, nearest, farthest):
    """Points between two distances of the surface at time t."""
    points = rng.uniform(-0.15, 0.15, (int(1 / (farthest - nearest)) * count, 3))
    gap = distances(surface, t, points)
    points = points[(gap > nearest) & (gap < farthest)][:count]
    assert len(points) == count
    return points


@pytest.mark.parametrize("smooth", [True, False])
@pytest.mark.parametrize("with_old", [False, True])
def test_momentum_moments_and_energy_close(with_old, smooth):
    """All that changes in the cloth is in the book, whatever the body does, at an offset too."""
    rng = np.random.default_rng(1)
    surface, dt, t = lump(rng), 2e-3, 0.02
    x = around(surface, t, rng, 400, -3e-3, 6e-3)
    mass = rng.uniform(1e-4, 1e-2, len(x))
    correction = SurfaceCorrection(surface, len(x), friction=(0.5, 0.3), offset=2e-3, smooth=smooth)
    old = 2 * rng.standard_normal(x.shape)
    free = old + 0.1 * rng.standard_normal(x.shape) if with_old else old
    v = free.copy()
    correction(x, v, mass, dt, t, old if with_old else None)
    book, impulse = correction.last, correction.last.impulse
    assert correction.active > 100 and set(correction.segment) == {-1, 0, 1, 2}
    change = mass[:, None] * (v - free)
    scale = np.abs(change).sum()
    assert np.abs(impulse - change).max() < 1e-15 * scale
    assert np.abs(book.segment_impulse.sum(axis=0) - change.sum(axis=0)).max() < 1e-13 * scale
    centres = correction.start_pose.centres
    moment = book.segment_moment + np.cross(centres, book.segment_impulse)
    assert np.abs(moment.sum(axis=0) - np.cross(x, change).sum(axis=0)).max() < 1e-13 * scale
    forces = np.sum(mass[:, None] * (free - old) * (old + v)) / 2
    booked = book.work.sum() - book.friction_loss.sum() - book.impact_loss.sum()
    gained = energy(mass, v) - energy(mass, old)
    assert gained == pytest.approx(forces + booked, abs=1e-12 * energy(mass, old))
    assert correction.window.seconds == dt
    assert np.array_equal(correction.window.table, book.table)
    correction.reset()
    assert not correction.window.impulse.any() and not correction.window.table.any()


@pytest.mark.parametrize("with_old", [False, True])
def test_union_with_shapes_closes_momentum_moments_and_energy(with_old):
    """An ellipsoid through the surface, on a segment of the skin or beside: books add up."""
    rng = np.random.default_rng(8)
    surface, dt, t = lump(rng), 2e-3, 0.02
    own = surface.body.segments
    motion = Steady([0.0, 0.05, 0.02], velocity=[0.3, 0.1, 0.2], spin=[1.0, -2.0, 3.0])
    body = Body([Segment("s1", [0.07, 0.05, 0.05], own[1].motion), own[0], own[2],
                 Segment("cap", [0.06, 0.05, 0.05], motion)])  # fmt: skip
    x = around(surface, t, rng, 400, -3e-3, 6e-3)
    mass = rng.uniform(1e-4, 1e-2, len(x))
    union = UnionCorrection(
        VelocityCorrection(body, len(x), 0.4, offset=2e-3),
        SurfaceCorrection(surface, len(x), body, 0.4, offset=2e-3),
        ["s1", "cap"],
    )
    old = 2 * rng.standard_normal(x.shape)
    free = old + 0.1 * rng.standard_normal(x.shape) if with_old else old
    v = free.copy()
    union(x, v, mass, dt, t, old.copy() if with_old else None)
    book, change = union.last, mass[:, None] * (v - free)
    assert union.shapes.active > 20 and union.surface.active > 100
    assert set(union.segment) == {-1, 0, 1, 2, 3}
    scale = np.abs(change).sum()
    assert np.abs(book.impulse - change).max() < 1e-14 * scale
    assert np.abs(book.segment_impulse.sum(axis=0) - change.sum(axis=0)).max() < 1e-13 * scale
    moment = book.segment_moment + np.cross(union.start_pose.centres, book.segment_impulse)
    assert np.abs(moment.sum(axis=0) - np.cross(x, change).sum(axis=0)).max() < 1e-13 * scale
    forces = np.sum(mass[:, None] * (free - old) * (old + v)) / 2
    booked = book.work.sum() - book.friction_loss.sum() - book.impact_loss.sum()
    gained = energy(mass, v) - energy(mass, old)
    assert gained == pytest.approx(forces + booked, abs=1e-12 * energy(mass, old))
    assert np.array_equal(union.window.table, book.table)


def test_virtual_power_of_a_sticking_node_is_that_of_its_segments():
    """With h -> 0 the power that the segments give is the impulse times the node's velocity."""
    rng = np.random.default_rng(2)
    surface, t = lump(rng), 0.02
    x = around(surface, t, rng, 100, 1e-5, 1e-3)
    mass, dt = np.ones(len(x)), 1e-7
    correction = SurfaceCorrection(surface, len(x), friction=1e9)
    middle = surface.positions(t, np.empty((surface.vertex_count, 3))).mean(axis=0)
    v = 3e5 * (middle - x)
    correction(x, v, mass, dt, t)
    assert correction.sticking > 50
    pose, last = surface.body.new_pose(t + 0.5 * dt), correction.last
    power = np.sum(last.segment_impulse * pose.velocities + last.segment_moment * pose.spins)
    assert power == pytest.approx(last.work.sum(), rel=1e-6)
    # energies go by the weights of the skin: the sum is exact, the parts are of their size
    assert np.abs(last.work).max() < 10 * abs(power)


@pytest.mark.parametrize("divisions", [2, 4])
def test_slides_on_a_sphere_of_triangles_as_on_a_sphere(divisions):
    """No energy is lost or gained, and the radius stays, however coarse the triangles are."""
    radius, dt = 0.1, 1e-3
    correction = SurfaceCorrection(ball(radius, divisions), 1, offset=5e-4)
    x = np.array([[0.03, 0.02, 0.1]])
    x *= (radius + 5e-4) / np.linalg.norm(x)
    v = np.cross(x, [[3.0, -1.0, 2.0]])
    speed, mass = np.linalg.norm(v), np.ones(1)
    heights = []
    for step in range(1500):
        v -= dt * 2 * speed**2 / 0.1005**2 * x  # pressed on
        correction(x, v, mass, dt, step * dt)
        x += dt * v
        heights.append(np.linalg.norm(x) - radius - 5e-4)
    assert correction.active == 1
    # what a step along the tangent rises
    assert -1e-9 < min(heights) and max(heights) < (dt * speed) ** 2 / radius
    assert np.linalg.norm(v) == pytest.approx(speed, rel=2e-3 if divisions == 2 else 2e-4)


@pytest.mark.parametrize("slope", [0.4, 0.6])
@pytest.mark.parametrize("smooth", [True, False])
def test_stick_and_slip_on_an_incline(slope, smooth):
    """mu = 0.5 on the top of a box: holds for good, or slides by (sin - mu cos) g t^2/2."""
    seconds, dt, mu, angle = (10.0 if slope < 0.5 else 0.5), 1e-3, 0.5, np.arctan(slope)
    surface = box([2.0, 2.0, 0.1], 40 if smooth else 1, Fixed((0.0, 0.0, -0.1)))
    gravity = G * np.array([np.sin(angle), 0, -np.cos(angle)])
    correction = SurfaceCorrection(surface, 1, friction=mu, smooth=smooth)
    x, v, mass, sticking = np.array([[0.013, 0.02, 0.0]]), np.zeros((1, 3)), np.array([0.01]), 0
    for step in range(round(seconds / dt)):
        v += gravity * (dt if step else dt / 2)
        correction(x, v, mass, dt, step * dt)
        x += dt * v
        sticking += correction.sticking
    way = np.linalg.norm(x[0] - [0.013, 0.02, 0.0])
    if slope < mu:
        force = correction.window.impulse[0] / correction.window.seconds
        assert way < 1e-9 and sticking == round(seconds / dt)
        assert force == pytest.approx(-mass[0] * gravity, rel=1e-4)
    else:
        exact = 0.5 * G * (np.sin(angle) - mu * np.cos(angle)) * seconds**2
        assert way == pytest.approx(exact, rel=1e-3) and sticking == 0


def test_reaction_of_a_node_that_sticks_to_a_turning_lifted_body():
    """m (a - g) in every step, with the centripetal part; the node stays where it is on it."""
    lift, spin, dt, mass = 3.0, 4.0, 1e-4, np.array([0.02])
    tilted = turned(np.eye(3), np.array([0.0, 0.3, 0]))

    def motion(t):
        turn, velocity = np.array([0, 0, spin * t]), np.array([0, 0, lift * t])
        return 0.5 * t * velocity, turned(tilted, turn), velocity, np.array([0, 0, spin])

    vertices, triangles = sphere(0.4, 3)
    surface = RigidSurface(vertices * [1.0, 0.75, 0.5], triangles, motion, "disc")
    correction = SurfaceCorrection(surface, 1, friction=3.0, offset=1e-3)
    # onto the disc first: from above until it is met
    place = np.array([[0.15, 0.05, 0.25]])
    at_rest = SurfaceCorrection(
        RigidSurface(surface.local, triangles, Fixed(axes=tilted), "disc"),
        1,
        friction=3.0,
        offset=1e-3,
    )
    v = np.array([[0.0, 0.0, -1.0]])
    for _ in range(2000):
        v[:] = [0.0, 0.0, -1.0]
        at_rest(place, v, mass, dt, 0.0)
        place += dt * v
    material = tilted @ place[0]

    def where(t):
        centre, axes, _, _ = motion(t)
        return centre + material @ axes

    x, v, worst, steps = where(0.0)[None], (where(0.0) - where(-dt))[None] / dt, 0.0, 2000
    for step in range(steps):
        t = step * dt
        v += [0, 0, -G * dt]
        correction(x, v, mass, dt, t)
        x += dt * v
        arm = where(t) - motion(t)[0]
        acceleration = np.array([0, 0, lift]) + spin**2 * np.array([-arm[0], -arm[1], 0])
        exact = mass[0] * (acceleration + [0, 0, G])
        error = np.linalg.norm(correction.last.impulse[0] / dt - exact)
        worst = max(worst, error / np.linalg.norm(exact))
        assert correction.sticking == 1
    assert spin**2 * np.linalg.norm(arm[:2]) > 2
    assert worst < 1e-5 and np.linalg.norm(x[0] - where(steps * dt)) < 1e-10


@pytest.mark.parametrize("mu", [0.0, 0.3])
@pytest.mark.parametrize("speed", [1.0, 30.0, 300.0])
def test_impact_never_tunnels_and_never_gains_energy(speed, mu):
    """Nodes thrown at a body with hollows, up to twice its size in a single step."""
    rng = np.random.default_rng(3)
    surface, dt = lump(rng, moving=False), 1e-3
    x = around(surface, 0.0, rng, 150, 2e-3, 0.03)
    mass = np.full(len(x), 1e-3)
    middle = surface.positions(0.0, np.empty((surface.vertex_count, 3))).mean(axis=0)
    v = speed * (middle - x) / np.linalg.norm(x - middle, axis=1, keepdims=True)
    v += 0.3 * speed * rng.standard_normal(v.shape)
    correction, touched = SurfaceCorrection(surface, len(x), friction=mu), 0
    for step in range(min(60, int(0.1 / (speed * dt)) + 3)):
        before = v.copy()
        correction(x, v, mass, dt, step * dt)
        growth = np.sum(v * v, axis=1) - np.sum(before**2, axis=1)
        assert growth.max() < 1e-12 * speed**2
        book = correction.last
        lost = energy(mass, before) - energy(mass, v)
        balance = book.friction_loss.sum() + book.impact_loss.sum()
        assert lost == pytest.approx(balance, abs=1e-12 * mass.sum() * speed**2)
        touched += correction.active
        x += dt * v
        # the smooth surface lies within a little of the flat one
        assert distances(surface, 0.0, x).min() > -correction.looks()[1][2] - 1e-4
    assert touched > 30


def test_nothing_in_reach_nothing_evaluated():
    x, v = np.full((50, 3), 0.3), np.full((50, 3), -1.0)
    kept, mass = v.copy(), np.ones(50)
    correction = SurfaceCorrection(ball(), 50, friction=0.3)
    correction(x, v, mass, 1e-3, 0.0)
    assert correction.evaluated == 50 and correction.active == 0 and np.array_equal(v, kept)
    for step in range(1, 100):  # 0.4 m away: nothing to ask for 0.2 s and more
        correction(x, v, mass, 1e-3, step * 1e-3)
        x += 1e-3 * v
        assert correction.evaluated == 0
    assert (correction.segment == -1).all() and not correction.last.impulse.any()


def test_certificates_change_nothing():
    """As with every closest point asked anew, to roundoff."""
    results = []
    for kept in (True, False):
        rng = np.random.default_rng(5)
        surface, dt = lump(rng), 1e-4
        x = around(surface, 0.0, rng, 200, 1e-4, 0.01)
        v, mass = 0.3 * rng.standard_normal(x.shape), np.ones(len(x))
        correction, asked = SurfaceCorrection(surface, len(x), friction=0.4), 0
        for step in range(60):
            if not kept:
                correction.restore(correction.state())
                correction._near[:] = -1
            correction(x, v, mass, dt, step * dt)
            x += dt * v
            asked += correction.evaluated
        results.append((x, v, correction.window.table.copy(), asked))
    (x, v, table, asked), (other_x, other_v, other_table, all_asked) = results
    assert np.abs(x - other_x).max() < 1e-12 and np.abs(v - other_v).max() < 1e-10
    assert table == pytest.approx(other_table, rel=1e-9, abs=1e-12) and table.any()
    assert asked < 0.4 * all_asked


def test_nodes_meet_only_what_they_can_touch():
    rng = np.random.default_rng(6)
    surface = lump(rng, moving=False)
    x = around(surface, 0.0, rng, 200, 1e-4, 1e-3)
    mass = np.ones(len(x))
    correction = SurfaceCorrection(surface, len(x), surface.body)
    correction.allowed[:] = surface.body.mask(["s1"])
    middle = surface.positions(0.0, np.empty((surface.vertex_count, 3))).mean(axis=0)
    v = 5.0 * (middle - x)
    correction(x, v, mass, 5e-3, 0.0)
    assert set(correction.segment) == {-1, 1}
    correction.allowed[:] = 0
    v[:] = 5.0 * (middle - x)
    correction(x, v, mass, 5e-3, 0.0)
    assert set(correction.segment) == {-1}


def test_wrong_settings_are_refused():
    for settings, message in (
        ({"offset": -1e-3}, "offset"),
        ({"recovery": 0.0}, "recovery"),
        ({"fixed": [True]}, "fixed"),
        ({"friction": (0.1, 0.2)}, "kinetic"),
        ({"body": Body([Segment("a", [0.1] * 3, Fixed())])}, "'ball' that the body has not.*: a"),
    ):
        with pytest.raises(ValueError, match=message):
            SurfaceCorrection(ball(), 3, **settings)
    correction = SurfaceCorrection(ball(), 3)
    with pytest.raises(ValueError, match=r"v has shape \(2, 3\), not \(3, 3\)"):
        correction(np.zeros((3, 3)), np.zeros((2, 3)), np.ones(3), 1e-3, 0.0)
    broken = np.full((3, 3), 1.0)
    broken[2, 1] = np.nan
    with pytest.raises(FloatingPointError, match=r"node 2 has position .* at t = 0\.25 s"):
        correction(broken, np.zeros((3, 3)), np.ones(3), 1e-3, 0.25)
    jumping = RigidSurface(
        *sphere(0.1, 1), lambda t: ((float(t > 1.0), 0, 0), np.eye(3), 0, 0), "hopper"
    )
    correction = SurfaceCorrection(jumping, 1)
    with pytest.raises(
        ValueError, match=r"surface of hopper jumps by 1 m between t = 1 and 1\.001"
    ):
        correction(np.ones((1, 3)), np.zeros((1, 3)), np.ones(1), 1e-3, 1.0)


def test_cloth_that_goes_along_with_the_body_asks_the_tree_once():
    """Carried along at 3 m/s beside a ball nothing comes nearer, whatever way both have gone."""
    place = [np.zeros(3), np.eye(3), np.array([3.0, 0.0, 0.0]), np.zeros(3)]
    surface = RigidSurface(*sphere(0.1, 3), lambda t: (t * place[2], *place[1:]), "ball")
    points = around(surface, 0.0, np.random.default_rng(3), 200, 2e-3, 8e-3)
    correction = SurfaceCorrection(surface, len(points), friction=0.3)
    x, v, mass = points.copy(), np.tile(place[2], (len(points), 1)), np.ones(len(points))
    asked = []
    for step in range(50):
        correction(x, v, mass, 1e-4, step * 1e-4)
        x += 1e-4 * v
        asked.append(correction.evaluated)
    assert np.abs(x - points - [0.015, 0.0, 0.0]).max() < 1e-12
    assert asked[0] >= len(points) and not any(asked[1:])


def test_restart_continues_bit_for_bit():
    def run(correction, x, v, first, steps):
        for step in range(first, first + steps):
            v -= [0, 0, G * 1e-3]
            correction(x, v, mass, 1e-3, step * 1e-3)
            x += 1e-3 * v

    rng = np.random.default_rng(7)
    surface = lump(rng)
    x = around(surface, 0.0, rng, 100, 1e-4, 0.02)
    v, mass = np.zeros_like(x), np.ones(len(x))
    whole = SurfaceCorrection(surface, len(x), friction=0.3)
    run(whole, x, v, 0, 20)
    kept, looks = (whole.state(), x.copy(), v.copy()), whole.looks()
    run(whole, x, v, 20, 20)
    for with_looks in (False, True):
        again, y, u = (
            SurfaceCorrection(surface, len(x), friction=0.3),
            kept[1].copy(),
            kept[2].copy(),
        )
        again.restore(kept[0])
        if with_looks:
            again.take_looks(*looks)
        run(again, y, u, 20, 20)
        assert np.array_equal(x, y) and np.array_equal(v, u)
        assert np.array_equal(whole.segment, again.segment)


@pytest.mark.parametrize("part", [0.98, 1.05])
def test_valley_holds_with_the_sum_of_its_sides(part):
    """Gravity along a straight valley: mu counts 1 / sin(half opening) times; both sides push."""
    half, mu, dt = 0.7, 0.3, 1e-3
    angle = np.arctan(part * mu / np.sin(half))
    gravity = G * np.array([np.sin(angle), 0.0, -np.cos(angle)])
    correction = SurfaceCorrection(valley(half), 1, friction=mu, offset=1e-3, smooth=False)
    x, v = np.array([[-0.5, 0.0, 1e-3 / np.sin(half)]]), np.zeros((1, 3))
    for step in range(500):
        v += gravity * (dt if step else dt / 2)
        correction(x, v, np.ones(1), dt, step * dt)
        x += dt * v
    assert np.abs(x[0, 1:] - [0.0, 1e-3 / np.sin(half)]).max() < 1e-9
    assert correction.last.impulse[0, 2] == pytest.approx(G * np.cos(angle) * dt, rel=1e-6)
    if part < 1:
        assert abs(x[0, 0] + 0.5) < 1e-9 and correction.sticking == 1
    else:
        exact = 0.5 * G * (np.sin(angle) - mu / np.sin(half) * np.cos(angle)) * 0.5**2
        assert x[0, 0] + 0.5 == pytest.approx(exact, rel=1e-2)


def test_node_pushed_across_a_valley_moves_continuously():
    """Twice as many positions, half the greatest jump of where the step ends."""
    surface, depth, offset, jumps = valley(0.7), 2e-3, 1e-3, []
    for count in (200, 400, 800):
        s = 4 * depth * np.linspace(-1, 1, count)
        skin = np.abs(s) / np.tan(0.7) + offset / np.sin(0.7)
        x = np.column_stack([0 * s, s, skin + 1e-4])
        v = np.zeros_like(x)
        v[:, 2] = -depth - x[:, 2]
        correction = SurfaceCorrection(surface, count, offset=offset, smooth=False)
        correction(x, v, np.ones(count), 1.0, 0.0)
        end = x + v
        assert (correction.segment >= 0).all() and not correction.pinched
        jumps.append(np.abs(np.diff(end, axis=0)).max())
        assert distances(surface, 0.0, end).min() > offset - 2e-9
    assert jumps[1] < 0.6 * jumps[0] and jumps[2] < 0.6 * jumps[1]


def test_two_parts_that_close_hold_the_node_between_them():
    """Two blocks of one surface come nearer than two offsets: held and counted, not ejected."""
    left, right = box([0.05] * 3), box([0.05] * 3)
    n = left.vertex_count
    vertices = np.vstack([left.local - [0.054, 0, 0], right.local + [0.054, 0, 0]])
    triangles = np.vstack([left.triangles, right.triangles + n])

    def side(sign):
        def pose(t):
            way = 3e-3 * np.sin(np.pi * min(t, 1.0)) ** 2
            return np.array([-sign * way, 0, 0]), np.eye(3), np.zeros(3), np.zeros(3)

        return pose

    body = Body([Segment("left", [0.01] * 3, side(-1)), Segment("right", [0.01] * 3, side(1))])
    weights = np.repeat(np.eye(2), n, axis=0)
    surface = BlendedSurface(vertices, triangles, weights, body)
    correction = SurfaceCorrection(surface, 1, friction=0.3, offset=0.002, smooth=False)
    x, v, dt, mass = np.array([[-0.001, 0.001, 0]]), np.zeros((1, 3)), 1e-3, np.array([1e-3])
    pinched, fastest = 0, 0.0
    for step in range(1200):
        correction(x, v, mass, dt, step * dt)
        pinched += correction.pinched
        fastest = max(fastest, np.linalg.norm(v))
        x += dt * v
    assert pinched > 100 and fastest < 0.1
    assert np.linalg.norm(x) < 0.005
    assert not correction.pinched and distances(surface, 1.2, x).min() > 0.002 - 1e-9


@pytest.mark.parametrize("smooth", [True, False])
def test_node_that_starts_inside_is_moved_out_at_the_recovery_speed(smooth):
    correction, dt = SurfaceCorrection(ball(0.1, 3), 1, recovery=0.5, smooth=smooth), 1e-3
    x, v, depths = np.array([[-0.08, 0.003, 0.002]]), np.zeros((1, 3)), []
    for step in range(100):
        v[:] = 0
        correction(x, v, np.ones(1), dt, step * dt)
        assert np.linalg.norm(v) < 0.5 * (1 + 1e-9)
        depths.append(correction.max_depth)
        x += dt * v
    assert depths[0] == pytest.approx(0.02, abs=2e-3) and depths[-1] < 1e-9
    assert np.linalg.norm(x) == pytest.approx(0.1, abs=1e-9 if smooth else 2e-3)


def test_sharp_edges_that_are_met_as_smooth_ones_are_told():
    """As cloth first touches: of triangles where it is, and only of these."""
    above, v = np.array([[0.05, 0.05, 0.18], [-0.05, -0.05, 0.18]]), np.zeros((2, 3))
    down = above * [1.0, 1.0, 0.0] + [0.0, 0.0, 0.1]
    correction = SurfaceCorrection(box([0.1] * 3), 2)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        correction(above, v, np.ones(2), 1e-3, 0.0)
        SurfaceCorrection(box([0.1] * 3), 2, smooth=False)(down, v - 1.0, np.ones(2), 1e-3, 0.0)
        SurfaceCorrection(ball(0.1, 2), 2)(0.5 * down, v, np.ones(2), 1e-3, 0.0)
    with pytest.warns(UserWarning, match="over 2 of 12 triangles of the surface of box the norm"):
        correction(down, v - [0.0, 0.0, 1.0], np.ones(2), 1e-3, 1e-3)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        correction(down, v - [0.0, 0.0, 1.0], np.ones(2), 1e-3, 2e-3)


@pytest.mark.parametrize("speed", [1.0, 30.0])
def test_a_thin_plate_stops_a_node_on_the_side_it_comes_from(speed):
    """The far side, 1 mm behind and within reach, has no say; both sides are tried."""
    dt, offset = 1e-4, 3e-4
    plate = box([0.1, 0.1, 5e-4])
    correction = SurfaceCorrection(plate, 2, offset=offset, smooth=False, recovery=20.0)
    x = np.array([[0.013, 0.021, 9e-4], [0.013, 0.021, -9e-4]])
    v = np.array([[0.0, 0.0, -speed], [0.0, 0.0, speed]])
    for step in range(30):
        correction(x, v, np.ones(2), dt, step * dt)
        x += dt * v
    assert np.abs(x[:, 2]) == pytest.approx(5e-4 + offset, abs=1e-9)
    assert np.array_equal(np.sign(x[:, 2]), [1.0, -1.0])
    assert np.abs(x[:, :2] - [0.013, 0.021]).max() < 1e-12 and not correction.pinched
