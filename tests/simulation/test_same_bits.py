# SPDX-License-Identifier: LGPL-3.0-or-later
"""The same machine, build and ranks give the same bits, wherever memory lies.

Cloth that folds is chaotic: a last digit that depends on an address, on memory that was not written
or on the order of a set is another curve after half a second.
"""

import numpy as np
import pytest

from demos.studies.repeatability.run import FILES, environment, repeat
from shellform.scene.scene_file import write_scene
from tests.dressing.test_dress import dressed
from tests.simulation.short_walk import WALK

pytestmark = pytest.mark.serial


def placed(values, offset):
    """A copy of values that lies `offset` bytes behind a multiple of 64."""
    room = np.zeros(values.nbytes + 128, np.uint8)
    begin = -room.ctypes.data % 64 + offset
    copy = room[begin : begin + values.nbytes].view(float).reshape(values.shape)
    copy[:] = values
    assert copy.ctypes.data % 64 == offset
    return copy


# what the stable step and contact are found by, of nodes (n, 3) or (n, 6)
REDUCTIONS = {
    "vdot": np.vdot,
    "sum": lambda a, _: a.sum(),
    "sum of rows": lambda a, b: np.sum(a * b, axis=1),
    "norm": lambda a, _: np.linalg.norm(a, axis=1),
    "product with a matrix": lambda a, b: a[:, :3] @ b[:3, :3],
    "einsum": lambda a, b: np.einsum("ni,ni->n", a, b),
    "cross": lambda a, b: np.cross(a[:, :3], b[:, :3]),
    "sine": lambda a, _: np.sin(np.ascontiguousarray(a[:, 0])),
    "angle": lambda a, b: np.arctan2(*(np.ascontiguousarray(x[:, 0]) for x in (a, b))),
}


@pytest.mark.parametrize("name", REDUCTIONS)
@pytest.mark.parametrize("count", [7, 1345])
def test_numpy_does_not_ask_where_arrays_lie(name, count):
    """NumPy aligns arrays to 16 bytes; sums in vectors of 32 or 64 must not begin elsewhere."""
    a, b = np.random.default_rng(3).standard_normal((2, count, 6))
    found = {
        np.asarray(REDUCTIONS[name](placed(a, i), placed(b, k))).tobytes()
        for i in (0, 16, 32, 48)
        for k in (0, 16, 32, 48)
    }
    assert len(found) == 1


def test_environments_differ():
    """Of any two runs in size, in seed and in how memory is handed out."""
    several = [environment(k) for k in range(10)]
    assert len({sum(map(len, one.values())) % 16 for one in several}) > 5
    assert len({one["PYTHONHASHSEED"] for one in several}) == 10
    assert len({one["MALLOC_PERTURB_"] for one in several}) == 10


@pytest.mark.slow
@pytest.mark.thorough
def test_a_walk_repeats(tmp_path):
    """Four processes, environments and memory unlike: bytes of the files are the same."""
    write_scene(WALK, tmp_path / "scene.toml")
    found = repeat(tmp_path / "scene.toml", tmp_path, 4, dressed("compliant").path)
    assert set(found[0]) == set(FILES) and all(hashes == found[0] for hashes in found)
