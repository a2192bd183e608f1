# SPDX-License-Identifier: LGPL-3.0-or-later
"""Director kinematics against rotation matrices, great circles and finite differences."""

import numpy as np
import pytest

from shellform.fem import director

E1, E2, E3 = np.eye(3)


def random_directors(count, seed=0):
    rng = np.random.default_rng(seed)
    d = rng.standard_normal((count, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    return d, director.tangent_frames(d), rng


def test_rotation_matrix_is_orthogonal_and_turns_by_the_angle():
    rng = np.random.default_rng(1)
    theta = rng.standard_normal((50, 3)) * np.linspace(0, 4, 50)[:, None]
    R = director.rotation_matrix(theta)
    assert np.abs(R @ np.swapaxes(R, 1, 2) - np.eye(3)).max() < 1e-14
    assert np.abs(np.linalg.det(R) - 1).max() < 1e-14
    assert np.abs(np.einsum("nij,nj->ni", R, theta) - theta).max() < 1e-13
    trace = 1 + 2 * np.cos(np.linalg.norm(theta, axis=1))
    assert np.abs(np.trace(R, axis1=1, axis2=2) - trace).max() < 1e-13


def test_rotation_matrix_quarter_turn():
    R = director.rotation_matrix([0, 0, np.pi / 2])
    assert np.abs(R @ E1 - E2).max() < 1e-15


def test_paper_form_equals_the_rotation_of_the_director():
    """Eq. 8 is Eq. 7 applied to e3; this fixes the sign of its last term."""
    theta = np.array([0.7, -1.9])
    R = director.rotation_matrix(theta[0] * E1 + theta[1] * E2)
    assert np.abs(director.rotated_director(theta, E1, E2, E3) - R @ E3).max() < 1e-15


def test_tip_recovers_the_infinitesimal_rotation():
    """Eq. 9 for theta -> 0: theta2 e1 - theta1 e2, with an error of second order."""
    direction = np.array([0.6, -0.8])
    errors = []
    for size in (1e-2, 1e-3, 1e-4):
        theta = size * direction
        tip = director.director_tip(theta, E1, E2, E3)
        errors.append(np.linalg.norm(tip - (theta[1] * E1 - theta[0] * E2)))
    orders = np.log10(np.array(errors[:-1]) / errors[1:])
    assert np.all(np.abs(orders - 2) < 0.01)
    assert np.array_equal(director.director_tip([0.0, 0.0], E1, E2, E3), np.zeros(3))


def test_updated_form_agrees_with_the_paper_form_from_the_initial_director():
    """One step of the exponential map is Eq. 8 with a = theta2 e1 - theta1 e2."""
    rng = np.random.default_rng(2)
    theta = rng.uniform(-1, 1, (40, 2))
    d, T = np.tile(E3, (40, 1)), np.tile(np.stack([E1, E2], axis=1), (40, 1, 1))
    updated, _ = director.exponential_map(d, T, np.column_stack([theta[:, 1], -theta[:, 0]]))
    assert np.abs(updated - director.rotated_director(theta, E1, E2, E3)).max() < 1e-14


def test_many_small_updates_equal_one_rotation_in_a_plane():
    """Ten turns in 1000 updates end where they began; the paper form cannot pass half a turn."""
    d, T = E3[None], np.stack([E1, E2], axis=1)[None]
    for _ in range(1000):
        d, T = director.exponential_map(d, T, np.array([[20 * np.pi / 1000, 0.0]]))
    assert np.abs(d - E3).max() < 1e-12
    assert np.abs(T[0] - np.stack([E1, E2], axis=1)).max() < 1e-12


def test_paper_form_is_singular_at_half_a_turn():
    """At |theta| = pi a whole circle of rotations gives -e3: the map's Jacobian loses rank."""
    angles = np.linspace(0, 2 * np.pi, 7)
    at_pi = np.pi * np.column_stack([np.cos(angles), np.sin(angles)])
    assert np.abs(director.rotated_director(at_pi, E1, E2, E3) + E3).max() < 1e-15

    def smallest_stretch(size):
        h, theta = 1e-6, np.array([size, 0.0])
        columns = [
            (
                director.rotated_director(theta + h * e, E1, E2, E3)
                - director.rotated_director(theta - h * e, E1, E2, E3)
            )
            / (2 * h)
            for e in np.eye(2)
        ]
        return np.linalg.svd(np.array(columns))[1].min()

    assert smallest_stretch(np.pi) < 1e-6
    assert smallest_stretch(0.5) > 0.9


def test_updated_form_is_regular_after_half_a_turn():
    d, T = E3[None], np.stack([E1, E2], axis=1)[None]
    d, T = director.exponential_map(d, T, np.array([[np.pi, 0.0]]))
    h = 1e-6
    for k in range(2):
        theta = h * np.eye(2)[k][None]
        ahead, _ = director.exponential_map(d, T, theta)
        back, _ = director.exponential_map(d, T, -theta)
        assert np.abs((ahead - back) / (2 * h) - T[:, :, k]).max() < 1e-9


def test_frames_stay_orthonormal_and_right_handed():
    d, T, rng = random_directors(100)
    for _ in range(20):
        d, T = director.exponential_map(d, T, rng.uniform(-3, 3, (100, 2)))
    basis = np.concatenate([T, d[:, :, None]], axis=2)
    assert np.abs(np.swapaxes(basis, 1, 2) @ basis - np.eye(3)).max() < 1e-14
    assert np.abs(np.linalg.det(basis) - 1).max() < 1e-14


def test_frames_are_carried_parallel():
    """The frame turns with the rotation that takes the director along its great circle."""
    d, T, rng = random_directors(30, seed=3)
    theta = rng.uniform(-2, 2, (30, 2))
    a = np.einsum("nij,nj->ni", T, theta)
    R = director.rotation_matrix(np.cross(d, a))
    turned, frames = director.exponential_map(d, T, theta)
    assert np.abs(turned - np.einsum("nij,nj->ni", R, d)).max() < 1e-14
    assert np.abs(frames - R @ T).max() < 1e-14


def test_a_held_second_rotation_keeps_the_director_in_its_plane():
    d = np.array([[0.6, 0.0, 0.8]])
    T = director.tangent_frames(d, np.array([[0.0, 1.0, 0.0]]))
    assert np.abs(np.abs(T[0, :, 1]) - [0, 1, 0]).max() < 1e-15
    for _ in range(50):
        d, T = director.exponential_map(d, T, np.array([[1.3, 0.0]]))
    assert abs(d[0, 1]) < 1e-14


def test_logarithm_inverts_the_exponential():
    d, T, rng = random_directors(200, seed=4)
    theta = rng.standard_normal((200, 2))
    theta *= (rng.uniform(0, 3.1, 200) / np.linalg.norm(theta, axis=1))[:, None]
    target, _ = director.exponential_map(d, T, theta)
    assert np.abs(director.logarithmic_map(d, T, target) - theta).max() < 1e-12


def test_logarithm_of_the_same_and_of_the_opposite_director():
    d, T, _ = random_directors(3)
    assert np.abs(director.logarithmic_map(d, T, d)).max() < 1e-15
    half = director.logarithmic_map(d, T, -d)
    assert np.linalg.norm(half, axis=1) == pytest.approx(np.pi)


def test_map_P_is_the_derivative_of_the_update():
    """Eq. 10: P by central differences of (u, d), and P^T its transpose."""
    d, T, rng = random_directors(5, seed=5)
    Q = np.linalg.qr(rng.standard_normal((5, 3, 3)))[0]
    x, h = rng.standard_normal((5, 5)), 1e-6

    def moved(step):
        u = np.einsum("nji,nj->ni", Q, step * x[:, :3])
        return np.hstack([u, director.exponential_map(d, T, step * x[:, 3:])[0]])

    forward = director.push_forward(x, T, Q)
    assert np.abs((moved(h) - moved(-h)) / (2 * h) - forward).max() < 1e-9
    r = rng.standard_normal((5, 6))
    work = np.sum(director.pull_back(r, T, Q) * x)
    assert work == pytest.approx(np.sum(r * forward), rel=1e-13)
