# SPDX-License-Identifier: LGPL-3.0-or-later
"""Damaged captures: a recording or one sentence, never a traceback, a hang or half a file unsaid.

Files of every format are cut, overwritten, doubled and mixed by hypothesis. Its choices follow from
the test itself (derandomize), so every run sees the same files. FUZZ_EXAMPLES asks for more of them
than the slice of some seconds that every run of the tests has.
"""

import os
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from shellform.motion.capture.read_motion import read_motion
from shellform.motion.capture.segment_map import FOLDER, segment_map
from tests.motion.capture.c3d_bytes import write_c3d_bytes
from tests.motion.capture.made_up import BMC, walker, write_csv, write_trc
from tests.motion.capture.test_exports import motive, nexus, qtm, skeleton

pytest.importorskip("ezc3d", reason="C3D files are read by ezc3d, not installed here")
pytest.importorskip("c3d", reason="C3D files of MIPS are read by c3d, not installed here")

pytestmark = pytest.mark.serial  # files are damaged the same way on every rank

EXAMPLES = int(os.environ.get("FUZZ_EXAMPLES", "60"))
RATE = 50.0
ODD = (
    b"nan", b"1e999", b"-", b"", b"1e308", b"-1e308", b"0", b"-0", b"1e-320", b"0x10", b"1,5", b"x",
    b"\xff", b"\0", b"\xe2\x80\x8b", b"9" * 400, b"{", b"'", b'"', b"\t", b"\n", b"%s", b"NULL",
)  # fmt: skip

# what is done to a file: a word, two places as shares of its length, a choice, bytes
DAMAGE = st.tuples(
    st.sampled_from(
        ["cut", "delete", "double", "bytes", "bits", "token", "swap lines", "drop line"]
    ),
    st.floats(0.0, 1.0, allow_nan=False),
    st.floats(0.0, 1.0, allow_nan=False),
    st.integers(0, 255),
    st.binary(min_size=1, max_size=8),
)


def damaged(data: bytes, damage) -> bytes:
    """A file with one damage more."""
    what, a, b, k, insert = damage
    first, last = sorted((int(a * len(data)), int(b * len(data))))
    if what == "cut":
        return data[:last]
    if what == "delete":
        return data[:first] + data[min(last, first + 400) :]
    if what == "double":
        part = data[first : min(last, first + 400)]
        return data[:last] + part + data[last:]
    if what == "bytes":
        return data[:first] + insert + data[first + len(insert) :]
    if what == "bits":
        # half of them in the first part of a file, where its header is
        place = min(first if k % 2 else first % 1500, len(data) - 1)
        flipped = bytes([data[place] ^ (1 << k % 8)]) if data else b""
        return data[: max(place, 0)] + flipped + data[place + 1 :]
    if what == "token":
        found = list(re.finditer(rb"[-+.\w]+", data))
        if not found:
            return data
        m = found[int(a * (len(found) - 1)) if k % 2 else int(a * min(len(found) - 1, 60))]
        return data[: m.start()] + ODD[k % len(ODD)] + data[m.end() :]
    lines = data.split(b"\n")
    i, j = int(a * (len(lines) - 1)), int(b * (len(lines) - 1))
    if what == "swap lines":
        lines[i], lines[j] = lines[j], lines[i]
    else:
        del lines[i]
    return b"\n".join(lines)


def whole_files(folder: Path) -> dict[str, bytes]:
    """Name -> contents, of a walk of 1.2 s."""
    names, tracks, _ = walker(BMC, seconds=1.2, rate=RATE)
    pose = np.tile(np.eye(4), (len(tracks), 1, 1))
    poses = {}
    for name, s in (("right", "r"), ("left", "l")):
        for part, z in (("thigh", 0.9), ("shank", 0.5), ("foot", 0.1), ("toes", 0.05)):
            pose = pose.copy()
            pose[:, :3, 3] = [0.1 * (part == "toes"), -0.09 if name == "right" else 0.09, z]
            poses[f"{s}_{part}_4X4"] = pose
    write_trc(folder / "walk.trc", names, 1000 * tracks, rate=RATE)
    write_csv(folder / "own.csv", names, tracks, rate=RATE)
    (folder / "motive.csv").write_text(motive(names, tracks))
    (folder / "nexus.csv").write_text(nexus(names, tracks), newline="")
    (folder / "qtm.tsv").write_text(qtm(names, tracks))
    (folder / "walk.bvh").write_text(skeleton()[0])
    for order in ("intel", "dec", "mips"):
        whole = order == "dec"
        path = folder / f"{order}.c3d"
        write_c3d_bytes(path, names, 1000 * tracks, RATE, order=order, whole=whole)
    write_c3d_bytes(folder / "theia.c3d", [], np.zeros((60, 0, 3)), RATE, poses=poses)
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    return whole_files(tmp_path_factory.mktemp("whole"))


def outcome(path):
    """Recording, or the sentence of the refusal; anything else fails."""
    try:
        rec = read_motion(path)
    except ValueError as error:
        said = str(error)
        assert said.startswith(f"{path}: "), said
        assert "\n" not in said and len(said) < 4000, said
        return said
    assert all(np.isfinite(track).all() for track in rec.points.values())
    return rec


TEXTS = ("walk.trc", "own.csv", "motive.csv", "nexus.csv", "qtm.tsv", "walk.bvh")
BINARY = ("intel.c3d", "dec.c3d", "mips.c3d", "theia.c3d")
SETTINGS = {
    "derandomize": True,
    "database": None,
    "deadline": None,
    "suppress_health_check": [HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
}


def read_damaged(files, folder, name, harm):
    data = files[name]
    for damage in harm:
        data = damaged(data, damage)
    path = folder / name
    path.write_bytes(data)
    outcome(path)


@settings(max_examples=EXAMPLES, **SETTINGS)
@given(name=st.sampled_from(TEXTS), harm=st.lists(DAMAGE, min_size=1, max_size=3))
@example(name="walk.trc", harm=[("token", 0.0, 0.0, 9, b"x")])
@example(name="own.csv", harm=[("cut", 0.0, 0.5, 0, b"x")])
def test_damaged_texts(files, tmp_path, name, harm):
    read_damaged(files, tmp_path, name, harm)


@settings(max_examples=max(EXAMPLES // 3, 1), **SETTINGS)
@given(name=st.sampled_from(BINARY), harm=st.lists(DAMAGE, min_size=1, max_size=3))
def test_damaged_c3d(files, tmp_path, name, harm):
    read_damaged(files, tmp_path, name, harm)


@settings(max_examples=max(EXAMPLES // 2, 1), **SETTINGS)
@given(name=st.sampled_from((*TEXTS, *BINARY)), share=st.floats(0.3, 0.7))
@example(name="own.csv", share=0.5)
def test_half_a_file_is_never_taken_silently(files, tmp_path, name, share):
    """Refused, or told in the notes; a CSV file of one's own that ends with a line is a shorter
    walk, which no reader can know."""
    data = files[name]
    part = data[: int(share * len(data))]
    path = tmp_path / name
    path.write_bytes(part)
    found = outcome(path)
    if isinstance(found, str):
        return
    headless = name in ("own.csv", "nexus.csv")
    assert (headless and part.endswith(b"\n")) or any(
        "header says" in note or "no end" in note for note in found.notes
    ), found.notes


@settings(max_examples=EXAMPLES, **SETTINGS)
@given(name=st.sampled_from(["medial", "lateral", "theia"]), harm=st.lists(DAMAGE, min_size=1))
def test_damaged_maps(tmp_path, name, harm):
    data = (FOLDER / f"{name}.toml").read_bytes()
    for damage in harm:
        data = damaged(data, damage)
    path = tmp_path / "map.toml"
    path.write_bytes(data)
    segment_map.cache_clear()
    try:
        segment_map(path)
    except ValueError as error:
        assert str(error).startswith(f"{path}: ") and "\n" not in str(error)


def test_whole_files_are_read(files, tmp_path):
    """What is damaged above is good before: every format but the standing poses is a walk."""
    for name, data in files.items():
        path = tmp_path / name
        path.write_bytes(data)
        assert not isinstance(outcome(path), str) or name == "theia.c3d", name
