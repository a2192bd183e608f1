# SPDX-License-Identifier: LGPL-3.0-or-later
"""Nearest points of edges, and impulses of pairs that share nodes, against slow twins."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear, minimize_scalar

from contact.body.segments import Body, Fixed, Segment
from contact.geometry.capsule import Capsule
from contact.geometry.shape import foot_and_normal
from contact.solver.cell_pairs import PAIR, find_pairs, list_near
from contact.solver.friction import Friction
from contact.solver.nearest_on_cell import nearest_in_cell, nearest_on_edge
from contact.solver.pair_impulses import add_shares, pass_kernel, set_masses
from contact.solver.segment_motion import segment_records, set_motion

SHAPES = Capsule(0.3, 0.001), (0.2, 0.002, 0.003), (0.05, 0.04, 0.002)


def records(shape, offset=5e-4):
    body = Body([Segment("thin", shape, Fixed())])
    out, pose = segment_records(body), body.new_pose()
    set_motion(pose.centres, pose.axes, pose.centres, pose.axes, offset, out)
    return out


@pytest.mark.parametrize("shape", SHAPES)
def test_nearest_point_of_an_edge(shape):
    """Against a bounded search along the edge; where it is an end, -1."""
    segment, rng, inside = records(shape)[0], np.random.default_rng(1), 0
    for _ in range(300):
        a, b = rng.uniform(-0.04, 0.04, (2, 3))

        def distance(tau, a=a, b=b):
            return foot_and_normal(segment, *(a + tau * (b - a)))[0]

        tau = nearest_on_edge(segment, a, b - a)
        best = minimize_scalar(distance, bounds=(0, 1), method="bounded", options={"xatol": 1e-9})
        ends = min(distance(0.0), distance(1.0))
        if tau < 0.0:
            assert ends <= best.fun + 1e-9
        else:
            inside += 1
            assert 0.0 < tau < 1.0
            assert distance(tau) == pytest.approx(min(best.fun, ends), abs=1e-8)
    assert inside > 50


@pytest.mark.parametrize("corners", [3, 4])
@pytest.mark.parametrize("shape", SHAPES)
def test_nearest_point_inside_a_cell(shape, corners):
    """A plane cell with its point p over a foot f of the segment, across the normal there: p is the
    nearest point of the plane. A straight side of the segment may leave it to the edges."""
    segment, rng, inside = records(shape)[0], np.random.default_rng(5), 0
    line, way, straight = np.empty(3), np.empty(3), isinstance(shape, Capsule)
    frame = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])[: corners - 4 or None]
    for _ in range(100):
        out = foot_and_normal(segment, *rng.uniform(-0.4, 0.4, 3))
        gap, normal = rng.uniform(1e-4, 1e-2), np.array(out[4:])
        p, (e1, e2) = np.array(out[1:4]) + gap * normal, np.linalg.svd([normal])[2][1:]
        flat = 0.02 * (frame + rng.uniform(-0.3, 0.3, (corners, 2)) + rng.uniform(-1, 1, 2))
        x = p + flat @ [e1, e2]
        x = np.vstack([x, x[-1:]])[:4]
        turns = [np.cross(flat[k], flat[(k + 1) % corners]) for k in range(corners)]
        a, b = nearest_in_cell(segment, x, line, way)
        if a < 0.0:
            assert straight or min(turns) < 1e-7
            continue
        inside += 1
        assert straight or min(turns) > -1e-7
        low, high = ((1 - b) * x[k] + b * x[3 - k] for k in (0, 1))
        found = (1 - a) * low + a * high
        assert foot_and_normal(segment, *found)[0] == pytest.approx(gap, abs=1e-9)
        assert straight or np.abs(found - p).max() < 1e-5
    assert inside > 10


def test_parallel_edges_are_left_to_their_nodes():
    segment = records(SHAPES[0])[0]
    assert nearest_on_edge(segment, np.array([-0.02, 0, 0.002]), np.array([0.04, 0, 0])) == -1.0


def test_listed_are_those_within_the_skin():
    """Every pair whose step can meet is in the list made before."""
    rng, segments = np.random.default_rng(2), records(SHAPES[0])
    x = rng.uniform(-0.1, 0.1, (400, 3))
    edges = np.stack([np.arange(0, 400, 2), np.arange(1, 400, 2)], axis=1)
    pieces = np.hstack([edges, np.full((200, 2), -1)])
    widths, listed = np.full(200, 0.04), np.empty((200, 2), np.int64)
    found = list_near(x, pieces, widths, segments, 5e-4, 0.01, listed)
    near = set(listed[:found, 0].tolist())
    points = np.linspace(0, 1, 101)[:, None]
    gaps = [
        min(foot_and_normal(segments[0], *p)[0] for p in x[i] + points * (x[j] - x[i])) - 5e-4
        for i, j in edges
    ]
    assert {e for e in range(200) if gaps[e] < 0.01} <= near and 10 < len(near) < 200
    assert list_near(x, pieces, widths, segments, 5e-4, 0.01, listed[:3]) == found
    assert list_near(x, pieces, np.full(200, 0.002), segments, 5e-4, 0.01, listed) == 0


def test_passes_find_the_impulses_of_all_pairs():
    """Without friction: the non-negative least-squares solution in the metric of the masses."""
    rng, n, k, dt = np.random.default_rng(3), 6, 5, 1e-3
    mass, v = rng.uniform(1.0, 2.0, n), rng.standard_normal((n, 3))
    pairs = np.zeros(k, PAIR)
    pairs["nodes"][:, :2] = [[0, 1], [1, 2], [2, 3], [3, 4], [1, 5]]
    pairs["weights"][:, 0] = rng.uniform(0.2, 0.8, k)
    pairs["weights"][:, 1] = 1.0 - pairs["weights"][:, 0]
    normals = rng.standard_normal((k, 3)) * [0.3, 0.3, 1.0]
    normals[:, 2] = np.abs(normals[:, 2])
    pairs["normal"] = normals / np.linalg.norm(normals, axis=1)[:, None]
    pairs["bound"] = rng.uniform(-1e-3, 1e-3, k)
    share, fixed = np.zeros(n), np.zeros(n, bool)
    one_pass, law = pass_kernel(Friction.kinetic_coefficient), np.zeros(6)
    free = v.copy()
    for _ in range(400):
        change, share[:] = np.zeros((n, 3)), 0.0
        add_shares(pairs, v, dt, share)
        set_masses(pairs, share, mass, fixed)
        one_pass(pairs, v, dt, law, change)
        v += change / mass[:, None]
    # rows: what gives the normal velocity of the point of each pair
    rows = np.zeros((k, n, 3))
    for s in range(k):
        for a in range(2):
            rows[s, pairs["nodes"][s, a]] = pairs["weights"][s, a] * pairs["normal"][s]
    rows = rows.reshape(k, -1)
    weighed = (rows / np.repeat(mass, 3)) @ rows.T
    lacks = pairs["bound"] / dt - rows @ free.ravel()
    root = np.linalg.cholesky(weighed)
    exact = lsq_linear(root.T, np.linalg.solve(root, lacks), bounds=(0, np.inf), tol=1e-14).x
    assert pairs["push"] == pytest.approx(exact, abs=1e-8)
    assert 0 < np.count_nonzero(exact > 1e-6) < k + 1


def test_one_pass_is_exact_where_no_node_is_shared():
    """An edge on a rod with friction: stops dead in stick, slides by mu J in slip."""
    segments, dt = records(Capsule(0.3, 0.001)), 1e-3
    x = np.array([[0.0, -0.02, 0.0015], [0.0, 0.02, 0.0015]])
    pieces, listed = np.array([[0, 1, -1, -1]]), np.array([[0, 0]])
    mass, every = np.array([1.0, 2.0]), np.full(2, -1)
    for sideways, stick in ((0.2, True), (2.0, False)):
        v = np.array([[sideways, 0.0, -1.0]] * 2)
        pairs = np.zeros(1, PAIR)
        assert find_pairs(x, v, every, pieces, listed, segments, dt, 5e-4, 1e-4, pairs) == 1
        share = np.zeros(2)
        add_shares(pairs, v, dt, share)
        set_masses(pairs, share, mass, np.zeros(2, bool))
        change = np.zeros((2, 3))
        law = np.array([0.4, 0.3, 0, 0, 0, 0])
        pass_kernel(Friction.kinetic_coefficient)(pairs, v, dt, law, change)
        v += change / mass[:, None]
        point = 0.5 * (v[0] + v[1])
        push = pairs["push"][0]
        assert push == pytest.approx(1.0 / (0.25 / 1.0 + 0.25 / 2.0))
        assert abs(point[2]) < 1e-12
        if stick:
            assert abs(point[0]) < 1e-12
        else:
            assert change.sum(axis=0)[0] == pytest.approx(-0.3 * push)
