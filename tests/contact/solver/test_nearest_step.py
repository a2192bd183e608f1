# SPDX-License-Identifier: LGPL-3.0-or-later
"""The nearest admissible step against the conditions that single it out."""

import numpy as np
import pytest

from contact.solver.nearest_step import PINCHED, nearest_step
from contact.solver.supporting_planes import PLANE


def test_nearest_step_against_the_conditions_of_a_projection():
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


def test_planes_without_room_hold_the_node_at_the_first():
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
