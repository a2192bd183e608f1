# SPDX-License-Identifier: LGPL-3.0-or-later
"""Small captures as strangers have them: the right value, or the right sentence.

They lie in ../shared/cases/captures beside the repository, made of a public walk that is in
../shared/data as well; without the folders these tests skip. Twins of their kinds that need none
are in test_marker_sets.py, test_exports.py and test_c3d_files.py.
"""

from pathlib import Path

import numpy as np
import pytest

from shellform.motion.capture.formats import read_table
from shellform.motion.capture.read_motion import read_markers, read_motion

CASES = Path(__file__).parents[4] / "shared" / "cases" / "captures"
JOINTS = [f"{side}_{joint}" for side in ("right", "left") for joint in ("hip", "knee", "ankle")]


@pytest.fixture(scope="module")
def cases():
    """Folder of the captures."""
    if not CASES.is_dir():
        pytest.skip("the captures (../shared/cases/captures beside the repository) are not here")
    return CASES.resolve()


@pytest.fixture
def walk(paper_data):
    """The public walk that the captures are made of, as its markers at both sides tell it."""
    return read_motion(paper_data / "bmc_walk2.trc")


def off(rec, walk):
    """Largest distance of a joint's centre from that of the walk [m]."""
    assert len(rec.times) == len(walk.times) == 251 and rec.rate == pytest.approx(150.0)
    apart = [rec.joint_centre(j) - walk.joint_centre(j) for j in JOINTS]
    return np.linalg.norm(apart, axis=2).max()


def told(rec, *words):
    return any(all(word in note for word in words) for note in rec.notes)


def test_opencap(cases, walk):
    """0.0 mm: the augmented markers count, not the joints beside them, and that is told."""
    rec = read_motion(cases / "opencap.trc")
    assert off(rec, walk) < 2e-5  # coordinates have five decimals
    assert told(rec, "map 'opencap'") and told(rec, "all 36 labels")


@pytest.mark.parametrize("map", [None, "own_map.toml"])
def test_pose2sim(cases, walk, map):
    """Joint centres alone, by the shipped map and by the user's own: those of the walk, which went
    into the file filtered."""
    rec = read_motion(cases / "pose2sim.trc", map=map and cases / map, cutoff=None, rigid=False)
    assert off(rec, walk) < 2e-5
    assert told(rec, "RKnee", "taken for joint centres")


def test_mips(cases, walk):
    """Whole numbers of 0.07 mm, three of them at a joint."""
    pytest.importorskip("c3d", reason="C3D files of MIPS are read by c3d, not installed here")
    assert off(read_motion(cases / "mips_int.c3d"), walk) < 1e-4


@pytest.mark.parametrize("name", ["motive.csv", "nexus.csv", "qtm.tsv"])
def test_exports_of_programs(cases, walk, name):
    assert off(read_motion(cases / name), walk) < 2e-5


@pytest.mark.parametrize(
    ("name", "word"), [("utf16.trc", "UTF-16"), ("comma_separated.trc", "commas")]
)
def test_encoding_and_separator(cases, walk, name, word):
    rec = read_motion(cases / name)
    assert off(rec, walk) < 2e-5 and told(rec, word)


def test_bvh(cases):
    """Read, as a skeleton of one joint; as a motion it lacks the legs, which is said."""
    raw = read_table(cases / "walk.bvh")
    assert raw.names == ("Hips", "Hips end") and raw.rate == pytest.approx(100.0)
    assert raw.positions[0].tolist() == [[0.0, 90.0, 0.0], [0.0, 91.0, 0.0]]
    with pytest.raises(ValueError, match=r"walk\.bvh: no shipped map fits.*right_hip.*not there"):
        read_motion(cases / "walk.bvh")


def test_two_rates(cases):
    pytest.importorskip("ezc3d", reason="C3D files are read by ezc3d, not installed here")
    with pytest.raises(ValueError, match="POINT:RATE is 100 Hz and the header's rate is 150 Hz"):
        read_motion(cases / "rate_param_100_header_150.c3d")


def test_fewer_labels(cases):
    pytest.importorskip("ezc3d", reason="C3D files are read by ezc3d, not installed here")
    rec = read_motion(cases / "fewer_labels.c3d")
    assert told(rec, "8 of 28 points have no label")
    assert len(read_markers(cases / "fewer_labels.c3d").names) == 20


def test_all_residuals(cases):
    pytest.importorskip("ezc3d", reason="C3D files are read by ezc3d, not installed here")
    with pytest.raises(ValueError, match=r"every residual is -1.*export it"):
        read_motion(cases / "all_resid_minus1_coords_fine.c3d")
