# SPDX-License-Identifier: LGPL-3.0-or-later
"""Damaged mesh files: a surface or one sentence, never a traceback, a hang or half a file unsaid.

hypothesis chooses the damage from the test itself (derandomize), so every run sees the same files.
FUZZ_EXAMPLES asks for more than the slice of some seconds that every run of the tests has.
"""

import os
import warnings

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import meshes
from tests.meshes.files.gltf_file import glb
from tests.meshes.files.test_drawing_files import obj, ply
from tests.meshes.strangers import off_file

pytestmark = pytest.mark.serial  # files are damaged the same way on every rank

EXAMPLES = int(os.environ.get("FUZZ_EXAMPLES", "60"))
TUBE = meshes.cylinder(0.15, 0.6, (6, 3), angle=2 * np.pi)
ODD = (
    b"nan", b"inf", b"1e999", b"-", b"", b"1e308", b"-1e308", b"0", b"-1", b"1e-320", b"0x10", b"x",
    b"\xff", b"\0", b"9" * 40, b"{", b"'", b'"', b"\n", b"\\\n", b"#", b"-99999", b"4294967295",
)  # fmt: skip
DAMAGE = st.lists(
    st.tuples(
        st.sampled_from(["cut", "delete", "double", "bytes", "token"]),
        st.floats(0.0, 1.0),
        st.floats(0.0, 1.0),
        st.sampled_from(ODD),
    ),
    min_size=1,
    max_size=3,
)


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """{name: contents} of a sound file of every format."""
    folder = tmp_path_factory.mktemp("sound")
    out = {"a.obj": obj(TUBE).encode(), "a.glb": glb(TUBE)}
    out["a.off"] = off_file(TUBE.points, TUBE.cells.tolist())
    for order in ("ascii", "binary_little_endian", "binary_big_endian"):
        out[f"{order}.ply"] = ply(TUBE, order, "vertex_index")
    for kind in ("stl", "vtu", "vtk", "msh"):
        meshes.save(TUBE, folder / f"a.{kind}")
        out[f"a.{kind}"] = (folder / f"a.{kind}").read_bytes()
    return out


def damaged(data, what, a, b, odd):
    first, last = sorted((int(a * len(data)), int(b * len(data))))
    if what == "cut":
        return data[:last]
    if what == "delete":
        return data[:first] + data[min(last, first + 200) :]
    if what == "double":
        return data[:last] + data[first : min(last, first + 200)] + data[last:]
    if what == "bytes":
        return data[:first] + odd + data[first + len(odd) :]
    words = data.split(b" ")
    words[int(a * (len(words) - 1))] = odd
    return b" ".join(words)


def sentence(path, **options):
    """The surface, or None where it is refused in one sentence that names the file."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            surface = meshes.load(path, **options)
        except ValueError as error:
            said = str(error)
            assert said.startswith(path.name) and "\n" not in said and len(said) < 700, said
            return None
    assert np.isfinite(surface.points).all() and surface.area > 0.0
    assert all("\n" not in note for note in surface.notes)
    return surface


@given(place=st.integers(0, 9), damage=DAMAGE, weld=st.sampled_from([0.0, 0.0, 1e-3, 0.05]))
@settings(
    max_examples=EXAMPLES,
    derandomize=True,
    deadline=None,
    database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
def test_damaged_files(files, tmp_path, place, damage, weld):
    name = sorted(files)[place]
    data = files[name]
    for step in damage:
        data = damaged(data, *step)
    (tmp_path / name).write_bytes(data)
    sentence(tmp_path / name, weld=weld)


@pytest.mark.parametrize("place", range(10))
def test_half_a_file_is_not_taken_for_a_whole_one(files, tmp_path, place):
    """Refused, or told that points have no face."""
    name = sorted(files)[place]
    for part in (0.3, 0.5, 0.7, 0.9):
        (tmp_path / name).write_bytes(files[name][: int(part * len(files[name]))])
        surface = sentence(tmp_path / name)
        if surface is not None:
            whole = len(surface.cells) == len(TUBE.cells)
            assert whole or any("belong to no face" in note for note in surface.notes)


@given(
    corners=st.lists(st.lists(st.integers(-3, 9), min_size=0, max_size=7), max_size=12),
    grid=st.lists(st.integers(0, 3), min_size=24, max_size=24),
)
@settings(max_examples=EXAMPLES, derandomize=True, deadline=None, database=None)
def test_faces_at_random(tmp_path_factory, corners, grid):
    """Any faces on any eight points of a grid: branching, folded, twice, without area."""
    path = tmp_path_factory.mktemp("faces") / "x.obj"
    lines = [f"v {x} {y} {z}" for x, y, z in np.reshape(grid, (8, 3)).tolist()]
    lines += ["f " + " ".join(map(str, face)) for face in corners]
    path.write_text("\n".join(lines))
    for options in ({}, {"weld": 0.5}, {"midsurface": True}):
        surface = sentence(path, **options)
        if surface is not None and not options:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                try:
                    meshes.prepare_garment(surface, waist="highest")
                except ValueError as error:
                    assert str(error).startswith("x.obj")
