# SPDX-License-Identifier: LGPL-3.0-or-later
"""The contact hook: balances, closed-form motions and a slow twin of the kernel."""

import numpy as np
import pytest
from scipy.optimize import brentq

from contact.body.segments import Body, Fixed, Segment, Steady, turned
from contact.geometry.ellipsoid import closest_points
from contact.solver.nearest_step import PINCHED, nearest_step
from contact.solver.supporting_planes import PLANE
from contact.solver.velocity_correction import VelocityCorrection

G = 9.81
LIMB = np.array([0.1, 0.05, 0.08])


def spheres(*centres, radius=0.1, motion=Fixed):
    return Body(
        [Segment(f"s{k}", [radius] * 3, motion(centre)) for k, centre in enumerate(centres)]
    )


def random_axes(rng):
    q = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    return q * np.sign(np.linalg.det(q))


def limbs(rng, count=4, moving=True):
    """Overlapping ellipsoids, in motion or at rest."""
    segments = []
    for k in range(count):
        pose = rng.uniform(-0.05, 0.05, 3), random_axes(rng)
        rates = rng.uniform(-3, 3, 3), rng.uniform(-20, 20, 3)
        motion = Steady(*pose, *rates) if moving else Fixed(*pose)
        segments.append(Segment(f"limb {k}", LIMB * rng.uniform(0.7, 1.3), motion))
    return Body(segments)


def outside(body, t, rng, count, margin, offset=0.0):
    """Points up to `margin` off the surface of the body at time t."""
    pose = body.pose(t, body.new_pose())
    points = pose.centres.mean(axis=0) + rng.uniform(-0.2, 0.2, (int(1 / margin) * count, 3))
    gap = clearance(body, t, points).min(axis=0)
    points = points[(gap > offset) & (gap < offset + margin)][:count]
    assert len(points) == count
    return points


def clearance(body, t, x):
    """Distance of points from every segment, (m, n)."""
    pose = body.pose(t, body.new_pose())
    return np.array(
        [
            closest_points(x, r, c, a)[2]
            for r, c, a in zip(body.radii, pose.centres, pose.axes, strict=True)
        ]
    )


def energy(mass, v):
    return 0.5 * np.sum(mass * np.sum(v * v, axis=1))


# ---------------------------------------------------------------- one ellipsoid, slow twin


def twin(x, v, mass, dt, start, end, radii, mu_s, mu_k, offset):
    """One node on one moving ellipsoid by dense search and bisection; not inside at the start."""
    (c0, a0), (c1, a1) = start, end

    def gap(y):
        foot, normal, distance = closest_points(y, radii)
        return distance[0] - offset, foot[0], normal[0]

    y0, y1 = a0 @ (x - c0), a1 @ (x + dt * v - c1)
    way = np.linalg.norm(y1 - y0)
    first_gap, foot, normal = gap(y0)
    if first_gap > way:
        return v, None
    if way > 1e-3 * radii.min() ** 2 / radii.max() and first_gap > 0:
        times = np.linspace(0, 1, 4001)
        inside = closest_points(y0 + times[:, None] * (y1 - y0), radii)[2] < offset
        if not inside.any():
            return v, None
        low, high = times[inside.argmax() - 1], times[inside.argmax()]
        for _ in range(60):
            middle = 0.5 * (low + high)
            if gap(y0 + middle * (y1 - y0))[0] < 0:
                high = middle
            else:
                low = middle
        _, foot, normal = gap(y0 + high * (y1 - y0))
    surface = (c1 + a1.T @ y0 - x) / dt
    n = a1.T @ normal
    plane = n @ (a1.T @ (foot - y0)) + offset  # along n from the start, in the moved body
    relative = v - surface
    push = plane - dt * relative @ n
    if push <= 0:
        return v, None
    relative = relative + push / dt * n
    slip = relative - (relative @ n) * n
    normal_impulse, size = mass * push / dt, np.linalg.norm(slip)
    if mass * size <= mu_s * normal_impulse:
        relative = relative - slip
    else:
        relative = relative - mu_k * normal_impulse / mass * slip / size
    return surface + relative, 0


@pytest.mark.parametrize("speed", [0.1, 3.0, 100.0])
@pytest.mark.parametrize("offset", [0.0, 0.004])
def test_kernel_does_what_its_slow_twin_does(speed, offset):
    rng = np.random.default_rng(0)
    body, dt, t = limbs(rng, 1), 1e-3, 0.3
    x = outside(body, t, rng, 60, 3e-3, offset)
    v = speed * rng.standard_normal(x.shape)
    mass = rng.uniform(1e-4, 1e-2, len(x))
    start, end = body.pose(t, body.new_pose()), body.pose(t + dt, body.new_pose())
    poses = [(p.centres[0], p.axes[0]) for p in (start, end)]
    expected = [
        twin(*node, dt, *poses, body.radii[0], 0.4, 0.3, offset)
        for node in zip(x, v, mass, strict=True)
    ]
    correction = VelocityCorrection(body, len(x), (0.4, 0.3), offset)
    correction(x, v, mass, dt, t)
    assert np.array_equal(correction.segment, [-1 if e[1] is None else 0 for e in expected])
    assert 10 < correction.active < len(x)
    assert np.abs(v - [e[0] for e in expected]).max() < 1e-9 * max(1, speed)


# ---------------------------------------------------------------- balances


@pytest.mark.parametrize("flesh", [np.inf, 1e4])
@pytest.mark.parametrize("with_old", [False, True])
def test_momentum_moments_and_energy_close(with_old, flesh):
    """All that changes in the cloth is in the book, whatever the body does, hard or soft."""
    rng = np.random.default_rng(1)
    body, dt, t = limbs(rng), 2e-3, 0.1
    x = outside(body, t, rng, 400, 3e-3)
    mass = rng.uniform(1e-4, 1e-2, len(x))
    correction = VelocityCorrection(body, len(x), (0.5, 0.3), flesh=flesh)
    if flesh < np.inf:  # half of the nodes lie in all that is around them
        x[::2] += 0.2 * (body.pose(t, body.new_pose()).centres.mean(axis=0) - x[::2])
        correction.sunk[::2] = 15
    old = 2 * rng.standard_normal(x.shape)
    free = old + 0.1 * rng.standard_normal(x.shape) if with_old else old
    v = free.copy()
    correction(x, v, mass, dt, t, old if with_old else None)
    book, impulse = correction.last, correction.last.impulse
    assert correction.active > (100 if flesh == np.inf else 50)
    assert len(set(correction.segment)) == 5
    assert (correction.pinched > 20) == (flesh < np.inf)
    change = mass[:, None] * (v - free)
    scale = np.abs(change).sum()
    assert np.abs(impulse - change).max() < 1e-15 * scale
    assert np.abs(book.segment_impulse.sum(axis=0) - change.sum(axis=0)).max() < 1e-14 * scale
    centres = body.pose(t, body.new_pose()).centres
    moment = book.segment_moment + np.cross(centres, book.segment_impulse)
    assert np.abs(moment.sum(axis=0) - np.cross(x, change).sum(axis=0)).max() < 1e-14 * scale
    # work of the forces and of contact by the mean of old and new velocity
    forces = np.sum(mass[:, None] * (free - old) * (old + v)) / 2
    booked = book.work.sum() - book.friction_loss.sum() - book.impact_loss.sum()
    gained = energy(mass, v) - energy(mass, old)
    assert gained == pytest.approx(forces + booked, abs=1e-13 * energy(mass, old))
    assert book.friction_loss.min() > 0 if not with_old else True
    assert correction.window.seconds == dt
    assert np.array_equal(correction.window.table, book.table)
    correction.reset()
    assert not correction.window.impulse.any() and not correction.window.table.any()


def patch(side, cells, height):
    """Mass points of a square sheet above the body, and their masses."""
    s = np.linspace(-side / 2, side / 2, cells)
    x = np.array([[a, b, height] for a in s for b in s])
    return x, np.full(len(x), 1e-3 / len(x))


@pytest.mark.parametrize("mu", [0.0, 0.3])
@pytest.mark.parametrize("speed", [0.1, 1.0, 10.0, 100.0, 300.0])
def test_impact_never_tunnels_and_never_gains_energy(speed, mu):
    """A patch flies onto two fixed limbs, at a slant; up to twice the limb in a single step."""
    body = Body(
        [
            Segment("a", LIMB, Fixed([0.03, 0, 0], turned(np.eye(3), np.array([0.3, 0.2, 0.1])))),
            Segment("b", LIMB, Fixed([-0.03, 0, 0], turned(np.eye(3), np.array([-0.4, 0, 1.0])))),
        ]
    )
    for dt in (1e-4, 1e-3):
        x, mass = patch(0.3, 13, 0.11)
        v = np.tile([0.3 * speed, 0.1 * speed, -speed], (len(x), 1))
        correction = VelocityCorrection(body, len(x), mu)
        touched = np.zeros(len(x), bool)
        for step in range(min(400, int(0.5 / (speed * dt)) + 3)):
            before = v.copy()
            correction(x, v, mass, dt, step * dt)
            lost = energy(mass, before) - energy(mass, v)
            assert lost > -1e-14 * energy(mass, before)
            growth = np.sum(v * v, axis=1) - np.sum(before**2, axis=1)
            assert growth.max() < 1e-14 * speed**2
            change = np.sum(mass[:, None] * (v - before), axis=0)
            scale = mass.sum() * speed
            assert np.abs(correction.last.impulse.sum(axis=0) - change).max() < 1e-14 * scale
            book = correction.last
            balance = book.friction_loss.sum() + book.impact_loss.sum()
            assert lost == pytest.approx(balance, abs=1e-13 * mass.sum() * speed**2)
            hit = correction.segment >= 0
            touched |= hit
            path = x[hit] + np.linspace(0, 1, 21)[:, None, None] * (dt * v[hit])
            if hit.any():
                assert clearance(body, 0, path.reshape(-1, 3)).min() > -1e-9
            x += dt * v
            assert clearance(body, 0, x).min() > -1e-9
        if speed * dt * (step + 1) > 0.3:
            # all in the shadow of the limbs were caught, and some flew past
            assert 20 < touched.sum() < len(x)


def test_any_fast_path_among_several_bodies_ends_outside_with_no_more_energy():
    """Steps up to three limbs long in all directions: into one, off it into the next."""
    rng = np.random.default_rng(9)
    body, dt = limbs(rng, 8, moving=False), 1e-3
    x = outside(body, 0, rng, 3000, 0.05)
    free = 300 * rng.uniform(0, 1, (len(x), 1)) * rng.standard_normal(x.shape)
    for mu in (0.0, 0.3):
        v = free.copy()
        correction = VelocityCorrection(body, len(x), mu)
        correction(x, v, np.ones(len(x)), dt, 0.0)
        assert correction.active > 500
        growth = np.sum(v * v, axis=1) - np.sum(free**2, axis=1)
        assert growth.max() < 1e-10 * 300**2
        gap = clearance(body, 0, x + dt * v).min(axis=0)
        assert (gap < -1e-9).sum() <= correction.pinched


def test_at_300_metres_a_second_the_entry_stops_the_node():
    """Straight down on a sphere: the node stays at the pole, its impulse is its momentum."""
    body, dt, mass = spheres((0, 0, 0)), 1e-3, np.array([2e-3])
    x, v = np.array([[0.0, 0, 0.15]]), np.array([[0.0, 0, -300.0]])
    correction = VelocityCorrection(body, 1)
    correction(x, v, mass, dt, 0.0)
    assert x[0, 2] + dt * v[0, 2] == pytest.approx(0.1, abs=1e-12)
    correction(x + dt * v, v, mass, dt, dt)
    assert abs(v[0, 2]) < 1e-9
    assert correction.window.impulse[0] == pytest.approx([0, 0, 0.6], rel=1e-12)
    assert correction.window.impact_loss.sum() == pytest.approx(0.5 * 2e-3 * 300**2, rel=1e-12)


def test_a_path_that_misses_the_body_is_left_alone():
    """Over the horizon in one long step: below the plane of the start, but outside."""
    x, v = np.array([[0.0, 0, 0.1001]]), np.array([[300.0, 0, -1.0]])
    correction = VelocityCorrection(spheres((0, 0, 0)), 1, 0.5)
    correction(x, v, np.ones(1), 1e-3, 0.0)
    assert correction.segment[0] == -1 and np.array_equal(v, [[300.0, 0, -1.0]])


# ---------------------------------------------------------------- friction


def incline(slope, mu, seconds, dt, radius=1e4):
    """A node on top of a huge sphere, gravity tilted by atan(slope); way slid, steps sticking."""
    angle = np.arctan(slope)
    gravity = G * np.array([np.sin(angle), 0, -np.cos(angle)])
    correction = VelocityCorrection(spheres((0, 0, -radius), radius=radius), 1, mu)
    x, v, mass = np.zeros((1, 3)), np.zeros((1, 3)), np.array([0.01])
    sticking = 0
    for step in range(round(seconds / dt)):
        v += gravity * (dt if step else dt / 2)
        correction(x, v, mass, dt, step * dt)
        x += dt * v
        sticking += correction.sticking
    return np.linalg.norm(x[0]), sticking, correction


def test_incline_below_the_cone_sticks_for_good():
    way, sticking, correction = incline(0.4, 0.5, 10.0, 1e-3)
    assert way < 1e-9 and sticking == 10_000
    window, angle = correction.window, np.arctan(0.4)
    force = window.impulse[0] / window.seconds
    weight = 0.01 * G * np.array([-np.sin(angle), 0, np.cos(angle)])
    assert force == pytest.approx(weight, rel=1e-4)
    # by the free velocities friction takes what gravity's half kick put in: first order in dt
    assert 0 < window.friction_loss.sum() < 0.01 * G**2 * 1e-3 * 10


def test_incline_above_the_cone_slides_as_the_formula_says():
    way, sticking, _ = incline(0.6, 0.5, 1.0, 5e-4)
    angle = np.arctan(0.6)
    exact = 0.5 * G * (np.sin(angle) - 0.5 * np.cos(angle))
    assert way == pytest.approx(exact, rel=1e-3) and sticking == 0


def test_static_friction_holds_what_kinetic_would_not():
    assert incline(0.4, (0.5, 0.2), 1.0, 1e-3)[0] < 1e-9
    assert incline(0.6, (0.7, 0.2), 1.0, 1e-3)[0] < 1e-9
    assert incline(0.6, (0.5, 0.2), 1.0, 1e-3)[0] > 1


def test_without_friction_nothing_acts_along_the_surface():
    rng = np.random.default_rng(2)
    x = rng.standard_normal((200, 3))
    x *= 0.1001 / np.linalg.norm(x, axis=1, keepdims=True)
    v = rng.standard_normal(x.shape)
    free = v.copy()
    correction = VelocityCorrection(spheres((0, 0, 0)), len(x), 0.0)
    correction(x, v, np.ones(len(x)), 1e-3, 0.0)
    assert correction.active > 50 and correction.sticking == 0
    # the impulse is along the radius to the place where the free path meets the sphere
    hit = correction.segment >= 0
    n = correction.last.impulse[hit]
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    assert np.abs(np.cross(0.1 * n - x[hit], free[hit])).max() < 1e-12
    assert (np.sum(n * free[hit], axis=1) < 0).all()
    assert not correction.last.friction_loss.any()


@pytest.mark.parametrize("start", [0.1, 0.5])
def test_node_leaves_a_smooth_sphere_where_it_should(start):
    """Sliding from rest, cos(leave) = 2/3 cos(start); until then energy is kept."""
    radius, mass = 0.1, np.array([0.01])
    errors = []
    for dt in (2e-4, 1e-4, 5e-5):
        correction = VelocityCorrection(spheres((0, 0, 0), radius=radius), 1, 0.0)
        x, v = radius * np.array([[np.sin(start), 0, np.cos(start)]]), np.zeros((1, 3))
        left = None
        for step in range(round(1.5 / dt)):
            old = v.copy()
            v[0, 2] -= G * (dt if step else dt / 2)
            correction(x, v, mass, dt, step * dt, old)
            if correction.segment[0] == 0:
                left = x[0] / np.linalg.norm(x[0])
            x += dt * v
            if x[0, 2] < 0:
                break
        assert abs(correction.window.impact_loss.sum()) < 2 * dt * mass[0] * G * radius
        errors.append(abs(left[2] - 2 / 3 * np.cos(start)))
    assert errors[-1] < 2e-3 and errors[-1] < 0.6 * errors[0]


# ---------------------------------------------------------------- moving bodies


def test_reaction_in_an_accelerating_turning_body():
    """A node that sticks to a body: m (a - g), with the centripetal part, step by step."""
    lift, spin, tilt, dt, mass = 3.0, 4.0, 0.3, 1e-4, np.array([0.02])
    tilted = turned(np.eye(3), np.array([0.0, tilt, 0]))

    def motion(t):
        turn = np.array([0, 0, spin * t])
        centre, velocity = np.array([0, 0, 0.5 * lift * t**2]), np.array([0, 0, lift * t])
        return centre, turned(tilted, turn), velocity, np.array([0, 0, spin])

    body = Body([Segment("disc", [0.4, 0.3, 0.2], motion)])
    material = closest_points([[0.15, 0.05, 0.3]], body.radii[0])[0][0]

    def place(t):
        centre, axes, _, _ = motion(t)
        return centre + material @ axes

    x = place(0.0)[None]
    v = (place(0.0) - place(-dt))[None] / dt
    correction, steps = VelocityCorrection(body, 1, 3.0), 4000
    worst = 0.0
    for step in range(steps):
        t = step * dt
        v += [0, 0, -G * dt]
        correction(x, v, mass, dt, t)
        x += dt * v
        arm = place(t) - motion(t)[0]
        acceleration = np.array([0, 0, lift]) + spin**2 * np.array([-arm[0], -arm[1], 0])
        exact = mass[0] * (acceleration + [0, 0, G])
        error = np.linalg.norm(correction.last.impulse[0] / dt - exact)
        worst = max(worst, error / np.linalg.norm(exact))
        assert correction.sticking == 1
    assert spin**2 * np.linalg.norm(arm[:2]) > 2  # the centripetal part is no trifle
    assert worst < 1e-5
    assert np.linalg.norm(x[0] - place(steps * dt)) < 1e-10


def test_a_moving_wall_takes_the_node_along_and_pays_for_it():
    body = Body([Segment("wall", [10, 10, 10.0], Steady([0, 0, -10], velocity=[0.5, 0, 2.0]))])
    correction, mass = VelocityCorrection(body, 1, 0.1), np.array([0.3])
    x, v, dt = np.array([[0, 0, 1e-4]]), np.zeros((1, 3)), 1e-3
    for step in range(3):
        correction(x, v, mass, dt, step * dt)
        x += dt * v
    # normal velocity of the wall, along it mu times as much
    assert v[0] == pytest.approx([0.2, 0, 2.0], rel=1e-3)
    window = correction.window
    gained = energy(mass, v)
    assert window.work.sum() - window.friction_loss.sum() - window.impact_loss.sum() == (
        pytest.approx(gained, rel=1e-12)
    )
    # force times way of the wall
    way = window.impulse[0] @ [0.5, 0, 2.0]
    assert window.work.sum() == pytest.approx(way, rel=1e-12)


def test_forces_turn_with_the_scene():
    rng = np.random.default_rng(3)
    Q, shift = random_axes(rng), np.array([0.3, -0.2, 0.1])
    results = []
    for turn in (False, True):
        rng = np.random.default_rng(4)
        segments = []
        for k in range(4):
            c, a = rng.uniform(-0.05, 0.05, 3), random_axes(rng)
            u, w = rng.uniform(-3, 3, 3), rng.uniform(-20, 20, 3)
            if turn:
                c, a, u, w = Q @ c + shift, a @ Q.T, Q @ u, Q @ w
            segments.append(Segment(f"limb {k}", LIMB, Steady(c, a, u, w)))
        plain = limbs(np.random.default_rng(0), 1)  # only to draw points around the origin
        x = outside(plain, 0, rng, 300, 0.05)
        v = 3 * rng.standard_normal(x.shape)
        if turn:
            x, v = x @ Q.T + shift, v @ Q.T
        correction = VelocityCorrection(Body(segments), len(x), 0.4)
        correction(x, v, np.full(len(x), 1e-3), 1e-3, 0.0)
        results.append((correction.last, correction.segment))
    (last, segment), (turned_last, turned_segment) = results
    assert np.array_equal(segment, turned_segment) and (segment >= 0).sum() > 50
    scale = np.abs(last.impulse).max()
    assert np.abs(turned_last.impulse - last.impulse @ Q.T).max() < 1e-12 * scale
    assert np.abs(turned_last.segment_impulse - last.segment_impulse @ Q.T).max() < 1e-12 * (
        np.abs(last.segment_impulse).max()
    )
    assert np.abs(turned_last.segment_moment - last.segment_moment @ Q.T).max() < 1e-11 * scale


# ---------------------------------------------------------------- several bodies


def groove(radius=0.1, half=0.08):
    """Two overlapping spheres and the height of their crease above the centres."""
    return spheres((-half, 0, 0), (half, 0, 0), radius=radius), np.sqrt(radius**2 - half**2)


def sweep(count, depth):
    """A node at the crease pushed `depth` below it, start and end swept across by +- 2 depths."""
    body, crease = groove()
    s = 2 * depth * np.linspace(-1, 1, count)
    skin = np.sqrt(0.1**2 - (np.abs(s) - 0.08) ** 2)  # height of the union of the two
    x = np.column_stack([s, 0 * s, skin + 0.1 * depth])
    v = np.zeros_like(x)
    v[:, 1], v[:, 2] = 0.3 * depth, crease - depth - x[:, 2]
    correction = VelocityCorrection(body, count)
    correction(x, v, np.ones(count), 1.0, 0.0)
    return s, x + v, correction


@pytest.mark.parametrize("depth", [1e-5, 1e-3, 5e-3])
def test_node_swept_through_a_crease_moves_continuously(depth):
    """Twice as many positions, half the greatest jump of place and direction."""
    jumps = []
    for count in (400, 800, 1600):
        _, end, correction = sweep(count, depth)
        direction = correction.last.impulse
        direction = direction / np.linalg.norm(direction, axis=1, keepdims=True)
        assert (correction.segment >= 0).all() and not correction.pinched
        jumps.append([np.abs(np.diff(q, axis=0)).max() for q in (end, direction)])
        assert clearance(correction.body, 0, end).min() > -1e-12
    jumps = np.array(jumps)
    assert np.all(jumps[1:] < 0.55 * jumps[:-1])
    assert jumps[-1, 0] < 2 * 4 * depth / 1600 and jumps[-1, 1] < 5e-3


def test_crease_shares_the_force():
    _, end, correction = sweep(401, 3e-3)
    book = correction.last
    # the sweep as a whole is symmetric, and its middle position alone
    mirror = np.array([-1, 1, 1])
    left, right = book.segment_impulse
    assert np.abs(left * mirror - right).max() < 1e-12 * np.abs(left).max()
    assert np.abs(end[::-1] * mirror - end).max() < 1e-13
    body, crease = groove()
    for mu in (0.0, 0.4):
        correction = VelocityCorrection(body, 1, mu)
        x, v = np.array([[0, 0, crease]]), np.array([[0.0, 0.01, -0.1]])
        correction(x, v, np.ones(1), 1e-3, 0.0)
        left, right = correction.last.segment_impulse
        assert np.abs(left * mirror - right).max() < 1e-15
        # the pushes along the two normals carry the whole approach: 2 l n_z = 0.1
        n = np.array([0.08, 0, crease]) / 0.1
        assert left[0] == pytest.approx(0.05 * n[0] / n[2], rel=1e-9)
        assert left[2] + right[2] == pytest.approx(0.1, rel=1e-9)
        # friction along the groove by the sum of the two pushes, stopping the slip at most
        assert left[1] + right[1] == pytest.approx(-min(0.01, mu * 0.1 / n[2]), rel=1e-6, abs=1e-12)


def test_groove_holds_with_the_sum_of_its_sides():
    """Gravity along a straight groove: the wedge factor 1 / sin(half opening) on mu."""
    body, crease = groove(1e3, 600.0)
    factor = 1e3 / crease  # 2 l = weight / n_z
    for slope, holds in ((0.98 * 0.3 * factor, True), (1.05 * 0.3 * factor, False)):
        angle = np.arctan(slope)
        gravity = G * np.array([0, np.sin(angle), -np.cos(angle)])
        correction = VelocityCorrection(body, 1, 0.3)
        x, v, dt = np.array([[0.0, 0, crease]]), np.zeros((1, 3)), 1e-3
        for step in range(1000):
            v += gravity * (dt if step else dt / 2)
            correction(x, v, np.ones(1), dt, step * dt)
            x += dt * v
        exact = 0.5 * G * (np.sin(angle) - 0.3 * factor * np.cos(angle))
        if holds:
            assert abs(x[0, 1]) < 1e-9 and correction.sticking == 1
        else:
            assert x[0, 1] == pytest.approx(exact, rel=1e-2)


def test_rest_in_the_pocket_of_three_spheres():
    """Three equal shares of the weight, on the average and in the last step."""
    angles = 2 * np.pi * np.arange(3) / 3
    centres = 0.11 * np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    height = np.sqrt(0.13**2 - 0.11**2)
    correction = VelocityCorrection(spheres(*centres, radius=0.13), 1, 0.0)
    x, v, dt = np.array([[1e-3, -5e-4, height + 2e-3]]), np.zeros((1, 3)), 1e-3
    for step in range(400):
        v[0, 2] -= G * dt
        correction(x, v, np.ones(1), dt, step * dt)
        x += dt * v
    assert x[0] == pytest.approx([0, 0, height], abs=1e-9)
    impulse = correction.last.segment_impulse
    assert impulse[:, 2] == pytest.approx(np.full(3, G * dt / 3), rel=1e-6)
    assert np.abs(impulse.sum(axis=0) - [0, 0, G * dt]).max() < 1e-9 * G * dt


@pytest.mark.parametrize("mu", [0.0, 0.5])
def test_concentric_duplicates_do_not_double_the_force(mu):
    rng = np.random.default_rng(5)
    pose = Fixed([0.1, 0, -0.1], random_axes(rng))
    single = Body([Segment("a", LIMB, pose)])
    triple = Body([Segment(name, LIMB, pose) for name in "abc"])
    x = outside(single, 0, rng, 100, 2e-3)
    v0 = rng.standard_normal(x.shape)
    results = []
    for body in (single, triple):
        correction = VelocityCorrection(body, len(x), mu)
        for _ in range(3):
            v = v0.copy()
            correction(x, v, np.ones(len(x)), 2e-3, 0.0)
        results.append((v, correction.last.segment_impulse.sum(axis=0), correction))
    assert results[0][2].active > 20
    assert np.array_equal(results[0][0], results[1][0])
    assert results[0][1] == pytest.approx(results[1][1], rel=1e-13)
    # each node has one of them, and keeps it
    assert not results[1][2].last.segment_impulse[1:].any()


def test_wedge_against_a_search_over_its_faces():
    """Projection onto random half-spaces by the conditions that single it out."""
    rng = np.random.default_rng(6)
    planes, step, pushes = np.zeros(5, PLANE), np.empty(3), set()
    for _ in range(3000):
        count = rng.integers(1, 6)
        normal = rng.standard_normal((count, 3)) + [0, 0, 1.5]
        planes["normal"][:count] = normal / np.linalg.norm(normal, axis=1, keepdims=True)
        planes["bound"][:count] = rng.uniform(-1, 0.5, count)
        free = rng.standard_normal(3)
        status = nearest_step(free, planes, count, -1, 1e-14, step)
        n, bound, push = (planes[name][:count] for name in ("normal", "bound", "push"))
        if status == PINCHED:
            continue
        pushes.add(status)
        assert np.abs(free + push @ n - step).max() < 1e-13
        left = n @ step - bound
        assert left.min() > -1e-10 and push.min() >= 0
        assert np.abs(push * left).max() < 1e-9
    assert pushes == {0, 1, 2, 3}


def test_wedge_without_room_holds_the_first_plane():
    planes, step = np.zeros(2, PLANE), np.empty(3)
    planes["normal"] = [[0, 0, 1], [0, 0, -1]]
    planes["bound"] = [0.1, 0.2]  # apart by less than nothing
    assert nearest_step(np.zeros(3), planes, 2, 0, 1e-15, step) == PINCHED
    assert np.array_equal(step, [0, 0, 0.1])
    assert nearest_step(np.zeros(3), planes, 2, -1, 1e-15, step) == PINCHED
    assert np.array_equal(step, [0, 0, -0.2])
    # almost opposite: there is room, but a hundred times as far away as the overlap is deep
    planes["normal"] = [[0.01, 0, np.sqrt(1 - 1e-4)], [0.01, 0, -np.sqrt(1 - 1e-4)]]
    assert nearest_step(np.zeros(3), planes, 2, 0, 1e-15, step) == PINCHED
    assert np.linalg.norm(step) == pytest.approx(0.1)


def test_pinched_node_is_held_and_counted_not_ejected():
    """Two spheres close to less than two offsets and open again."""

    def motion(sign):
        def pose(t):
            # from a gap of 8 mm to 2 mm and back, the offset is 2 mm
            gap = 0.004 - 0.003 * np.sin(np.pi * min(t, 1.0)) ** 2
            return np.array([sign * (0.1 + gap), 0, 0]), np.eye(3), np.zeros(3), np.zeros(3)

        return pose

    body = Body([Segment("left", [0.1] * 3, motion(-1)), Segment("right", [0.1] * 3, motion(1))])
    correction = VelocityCorrection(body, 1, 0.3, offset=0.002)
    x, v, dt, mass = np.array([[-0.001, 0.001, 0]]), np.zeros((1, 3)), 1e-3, np.array([1e-3])
    pinched, fastest = 0, 0.0
    for step in range(1200):
        correction(x, v, mass, dt, step * dt)
        pinched += correction.pinched
        fastest = max(fastest, np.linalg.norm(v))
        x += dt * v
    # the spheres move at 1 cm/s, and a node inside leaves at 10 cm/s at most
    assert pinched > 100 and fastest < 0.1
    assert np.linalg.norm(x) < 0.005
    assert not correction.pinched and clearance(body, 1.2, x).min() > 0.002 - 1e-9


def test_node_that_starts_inside_is_moved_out_at_the_recovery_speed():
    body, dt = spheres((0, 0, 0), (0.02, 0, 0)), 1e-3
    correction = VelocityCorrection(body, 1, 0.0, recovery=0.5)
    x, v = np.array([[-0.05, 0.0, 0.0]]), np.zeros((1, 3))
    depths = []
    for step in range(200):
        v[:] = 0
        correction(x, v, np.ones(1), dt, step * dt)
        assert np.linalg.norm(v) < 0.5 * (1 + 1e-12)
        depths.append(correction.max_depth)
        x += dt * v
    assert depths[0] == pytest.approx(0.05) and depths[-1] < 1e-12
    assert x[0] == pytest.approx([-0.1, 0, 0], abs=1e-12)
    # out of the lens of two bodies: the near skin of the other is inside and no way out
    x = np.array([[0.03, 0.02, 0.0]])
    for step in range(400):
        v[:] = 0
        correction(x, v, np.ones(1), dt, step * dt)
        x += dt * v
    assert clearance(body, 0, x).min() == pytest.approx(0, abs=1e-12)
    assert x[0, 0] > 0.03


# ---------------------------------------------------------------- bookkeeping


FLESH = 1e5  # stiffness over areal mass [1/s^2]


def pull_in(correction, x, mass, dt, steps, pull):
    """Positions and velocities of nodes (n, 3) after steps under an acceleration (3,)."""
    v = np.zeros_like(x)
    for step in range(steps):
        before = v.copy()
        v += dt * np.asarray(pull)
        correction(x, v, mass, dt, step * dt, v_old=before)
        x += dt * v
    return v


def test_soft_bodies_let_cloth_into_the_crease_until_they_balance_its_pull():
    """Between two spheres, normals obtuse: 2 k d cos = pull; hard ones hold at their crease."""
    body, half, dt, pull = spheres((-0.08, 0, 0), (0.08, 0, 0)), 0.08, 1e-3, 200.0
    edge = np.sqrt(0.1**2 - half**2)

    def surplus(z):
        arm = np.hypot(half, z)
        return 2 * FLESH * (0.1 - arm) * z / arm - pull

    expected = {np.inf: edge, FLESH: brentq(surplus, 0.7 * edge, edge, xtol=1e-15)}
    for flesh, height in expected.items():
        correction = VelocityCorrection(body, 1, flesh=flesh, recovery=1e-9)
        x = np.array([[0.0, 0.0, edge + 1e-3]])
        v = pull_in(correction, x, np.ones(1), dt, 3000, (0, 0, -pull))
        assert x[0] == pytest.approx([0, 0, height], abs=1e-9) and np.abs(v).max() < 1e-9
        assert correction.last.segment_impulse[:, 2] == pytest.approx([pull * dt / 2] * 2)
        assert correction.pinched == (flesh < np.inf)
        assert correction.pinch_depth == pytest.approx(
            0.1 - np.hypot(half, height) if flesh < np.inf else 0.0, abs=1e-9
        )
    with pytest.raises(ValueError, match="positive, not 0"):
        VelocityCorrection(body, 1, flesh=0.0)


def closing(gap, seconds):
    """Two spheres of 0.1 m whose skins go from `gap` apart to as much overlap and back."""

    def motion(sign):
        def pose(t):
            a = 2 * np.pi / seconds
            on = 0.0 <= t <= seconds
            away = 0.1 + 0.5 * gap * (np.cos(a * t) if on else 1.0)
            speed = -0.5 * gap * a * np.sin(a * t) if on else 0.0
            return sign * np.array([away, 0, 0]), np.eye(3), sign * np.array([speed, 0, 0]), NONE

        return pose

    return Body([Segment("left", [0.1] * 3, motion(-1)), Segment("right", [0.1] * 3, motion(1))])


NONE = np.zeros(3)


def test_flesh_that_closes_over_cloth_takes_it_to_the_middle_and_gives_the_work_back():
    """Skins overlap by 20 mm and part again: the cloth stays, is let go, and no work is left."""
    body, dt, seconds = closing(0.02, 1.0), 2e-4, 1.0
    correction = VelocityCorrection(body, 1, flesh=FLESH)
    x, v, mass = np.array([[0.004, 0.0, 0.0]]), np.zeros((1, 3)), np.array([1e-3])
    deepest = 0.0
    for step in range(int(1.2 * seconds / dt)):
        before = v.copy()
        correction(x, v, mass, dt, step * dt, v_old=before)
        x += dt * v
        deepest = max(deepest, correction.pinch_depth)
        if abs(step * dt - 0.5 * seconds) < dt / 2:
            # as deep in one as in the other
            assert abs(clearance(body, step * dt, x)[:, 0] + 0.01).max() < 5e-4
            assert correction.pinched == 1 and correction.max_depth == 0.0
            # flesh on flesh is not the cloth's: k d of 1 N/kg is left out of what is booked
            push = np.abs(correction.last.segment_impulse[:, 0]).max()
            assert push < 0.05 * mass[0] * FLESH * 0.01 * dt
    assert 0.009 < deepest < 0.012 and not correction.pinched
    assert clearance(body, 1.2 * seconds, x).min() > 0.0
    book = correction.window
    stored = book.impact_loss.sum()
    work = book.work.sum() - book.friction_loss.sum() - stored
    assert work == pytest.approx(energy(mass, v), abs=1e-12)
    assert abs(stored) < 0.01 * mass[0] * FLESH * deepest**2 and np.linalg.norm(v) < 0.05


@pytest.mark.parametrize("part", [0.9, 1.2])
def test_flesh_holds_cloth_by_the_friction_of_both_sides(part):
    """Between two spheres that overlap by 10 mm friction holds 2 mu k d, and no more."""
    body, mu, depth = spheres((-0.095, 0, 0), (0.095, 0, 0)), 0.3, 0.005
    correction = VelocityCorrection(body, 1, mu, flesh=FLESH)
    correction.sunk[:] = body.mask(["s0", "s1"])
    x, v = np.zeros((1, 3)), np.zeros((1, 3))
    dt, pull, steps = 1e-4, part * 2 * mu * FLESH * depth, 20
    for step in range(steps):
        before = v.copy()
        v[0, 1] += dt * pull
        correction(x, v, np.ones(1), dt, step * dt, v_old=before)
        x += dt * v
    slipped = max(0.0, part - 1) / part * pull * steps * (steps + 1) * dt**2 / 2
    # along y the way leads out of the lens: both sides push by y / R besides, 2 % here
    assert x[0, 1] == pytest.approx(slipped, rel=0.03, abs=1e-12)


def test_ellipsoids_of_one_segment_make_a_hard_crease():
    """On one rigid part of a wearer, or where normals are acute, it pushes with what it takes."""
    for half, carriers in ((0.08, ("pelvis", "pelvis")), (0.06, ("thigh", "shank"))):
        body = spheres((-half, 0, 0), (half, 0, 0))
        body.carriers = carriers
        correction = VelocityCorrection(body, 1, flesh=1.0)
        v, dt = np.array([[0.0, 0.0, -3e-3]]), 1e-3
        x = np.array([[0.0, 0.0, np.sqrt(0.1**2 - half**2)]])
        correction(x, v, np.ones(1), dt, 0.0)
        assert correction.last.impulse[0, 2] == pytest.approx(3e-3, rel=1e-6)
        assert not correction.pinched


def test_a_node_meets_only_segments_it_can_touch():
    """Two equal spheres in one place: the node stops at the second, or falls through both."""
    body = spheres((0, 0, 0), (0, 0, 0))
    x, mass = np.tile([0.0, 0.0, 0.1], (3, 1)), np.ones(3)
    allowed = [body.mask(["s0"]), body.mask(["s1"]), 0]
    correction = VelocityCorrection(body, 3, allowed=allowed)
    v = np.tile([0.0, 0.0, -1.0], (3, 1))
    correction(x, v, mass, 1e-3, 0.0)
    assert correction.segment.tolist() == [0, 1, -1]
    np.testing.assert_allclose(v[:, 2], [0, 0, -1], atol=1e-12)
    np.testing.assert_allclose(correction.last.segment_impulse[:, 2], [1, 1], rtol=1e-12)
    with pytest.raises(ValueError, match="no segment 's7'"):
        body.mask(["s7"])


def test_nothing_in_reach_nothing_evaluated():
    x, v = np.full((50, 3), 3.0), np.full((50, 3), -1.0)
    kept = v.copy()
    correction = VelocityCorrection(limbs(np.random.default_rng(0)), 50, 0.3)
    correction(x, v, np.ones(50), 1e-3, 0.0)
    assert correction.evaluated == correction.active == 0 and np.array_equal(v, kept)
    assert (correction.segment == -1).all() and not correction.last.impulse.any()
    # beside a long limb: in its bounding sphere, still without a closest point
    limb = Body([Segment("limb", [0.5, 0.05, 0.05], Fixed())])
    correction = VelocityCorrection(limb, 1)
    correction(np.array([[0, 0.2, 0.2]]), np.zeros((1, 3)), np.ones(1), 1e-3, 0.0)
    assert correction.evaluated == 0


def test_fixed_nodes_are_left_alone():
    x, v = np.array([[0, 0, 0.1], [0, 0, 0.1]]), np.array([[0, 0, -1.0], [0, 0, -1.0]])
    correction = VelocityCorrection(spheres((0, 0, 0)), 2, 0.3, fixed=[True, False])
    correction(x, v, np.ones(2), 1e-3, 0.0)
    assert np.array_equal(v[0], [0, 0, -1]) and np.abs(v[1]).max() < 1e-12
    assert not correction.last.impulse[0].any() and correction.segment[0] == -1


def test_offset_is_where_the_node_rests():
    correction = VelocityCorrection(spheres((0, 0, 0)), 1, 0.3, offset=0.007)
    x, v = np.array([[0, 0, 0.12]]), np.zeros((1, 3))
    for step in range(300):
        v[0, 2] -= G * 1e-3
        correction(x, v, np.ones(1), 1e-3, step * 1e-3)
        x += 1e-3 * v
    assert x[0] == pytest.approx([0, 0, 0.107], abs=1e-12)


def test_not_a_number_is_reported_with_its_node():
    correction = VelocityCorrection(spheres((0, 0, 0)), 3)
    for broken in (0, 1):
        arrays = [np.ones((3, 3)), np.ones((3, 3))]
        arrays[broken][2, 1] = np.nan
        with pytest.raises(FloatingPointError, match=r"node 2 has position .* at t = 0\.25 s"):
            correction(*arrays, np.ones(3), 1e-3, 0.25)


def test_wrong_settings_are_refused():
    body = spheres((0, 0, 0))
    for settings, message in (
        ({"offset": -1e-3}, "offset"),
        ({"recovery": 0.0}, "recovery"),
        ({"fixed": [True]}, "fixed"),
        ({"friction": (0.1, 0.2)}, "kinetic"),
    ):
        with pytest.raises(ValueError, match=message):
            VelocityCorrection(body, 3, **settings)
    with pytest.raises(ValueError, match=r"v has shape \(2, 3\), not \(3, 3\)"):
        VelocityCorrection(body, 3)(np.zeros((3, 3)), np.zeros((2, 3)), np.ones(3), 1e-3, 0.0)


def test_restart_continues_bit_for_bit():
    def run(correction, x, v, first, steps):
        for step in range(first, first + steps):
            v -= [0, 0, G * 1e-3]
            correction(x, v, mass, 1e-3, step * 1e-3)
            x += 1e-3 * v

    rng = np.random.default_rng(7)
    body = limbs(rng)
    x = outside(body, 0, rng, 100, 0.02)
    v, mass = np.zeros_like(x), np.ones(len(x))
    whole = VelocityCorrection(body, len(x), 0.3)
    run(whole, x, v, 0, 40)
    kept = whole.state(), x.copy(), v.copy()
    run(whole, x, v, 40, 40)
    again = VelocityCorrection(body, len(x), 0.3)
    again.restore(kept[0])
    run(again, kept[1], kept[2], 40, 40)
    assert np.array_equal(x, kept[1]) and np.array_equal(v, kept[2])
    assert np.array_equal(whole.segment, again.segment)
