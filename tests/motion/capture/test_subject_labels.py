# SPDX-License-Identifier: LGPL-3.0-or-later
"""Names of subjects before labels, words behind them: taken off where they say nothing, and labels
of another subject never fill up those of the first."""

import numpy as np
import pytest

from shellform.motion.capture.formats import read_table
from shellform.motion.capture.read_motion import read_motion
from tests.motion.capture.made_up import BMC, OPENCAP, PLUG_IN_MARKERS, POSE2SIM, walker, write_trc

FORMS = (
    "Subject01:{}", "Scene:Ann:{}", "Skeleton_{}", "Skeleton 001_{}", "Subject01|{}", "Ann.{}",
    "{}_m", "{}_1", "  {} ", '"{}"', "ann_{}_filtered",
)  # fmt: skip
SETS = {"bmc": BMC, "plug-in": PLUG_IN_MARKERS, "pose2sim": POSE2SIM, "opencap": OPENCAP}


def off(rec, truth):
    return max(
        np.abs(rec.joint_centre(f"{side}_{joint}") - truth[side][joint]).max()
        for side in ("right", "left")
        for joint in ("hip", "knee", "ankle")
    )


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("key", SETS)
def test_words_that_all_labels_share(tmp_path, form, key):
    names, tracks, truth = walker(SETS[key], seconds=1.2)
    labels = [form.format(n) for n in names]
    path = write_trc(tmp_path / "walk.trc", labels, 1000 * tracks)
    rec = read_motion(path, cutoff=None, rigid=False)
    assert off(rec, truth) < 1e-9 and f"all {len(names)} labels belong to the set" in rec.notes
    word = form.replace("{}", "").strip(' "')
    assert not word or any("taken off the labels" in note for note in rec.notes)


@pytest.mark.parametrize("case", [str.lower, str.upper])
def test_case_does_not_count(tmp_path, case):
    names, tracks, truth = walker(PLUG_IN_MARKERS, seconds=1.2)
    path = write_trc(tmp_path / "walk.trc", [case(n) for n in names], 1000 * tracks)
    assert off(read_motion(path, cutoff=None, rigid=False), truth) < 1e-9


@pytest.mark.parametrize("sign", [":", "_"])
def test_two_subjects(tmp_path, sign):
    """Both complete: refused. One of them with a few labels, another's toe among them: not used."""
    names, tracks, truth = walker(BMC, seconds=1.2)
    ann = [f"Ann{sign}{n}" for n in names]
    bob = [f"Bob{sign}{n}" for n in names]
    two = np.concatenate([tracks, tracks + [0.0, 2.0, 0.0]], axis=1)
    path = write_trc(tmp_path / "walk.trc", ann + bob, 1000 * two)
    with pytest.raises(ValueError, match=r"walk\.trc: 2 subjects, Ann.*Bob.*export one"):
        read_motion(path)
    toes = [n.endswith(".MT2") for n in names]
    for k in np.flatnonzero(toes):
        ann[k] = f"Bob{sign}{names[k]}"  # the marker that Ann lacks, called as Bob's
    path = write_trc(tmp_path / "walk.trc", ann, 1000 * tracks)
    rec = read_motion(path, cutoff=None, rigid=False)
    assert off(rec, truth) < 1e-9
    assert not any(name.endswith("foot") for name in rec.points)
    assert any("Bob" in note for note in rec.notes)


def test_labels_of_segments_before_a_colon(tmp_path):
    """Where no subject is complete alone, what stands before the colon is a part of one body."""
    names, tracks, truth = walker(BMC, seconds=1.2)
    labels = [f"{'Upper' if 'SIS' in n else 'Leg'}:{n}" for n in names]
    path = write_trc(tmp_path / "walk.trc", labels, 1000 * tracks)
    assert off(read_motion(path, cutoff=None, rigid=False), truth) < 1e-9


def test_twins_and_columns_without_a_name(tmp_path):
    """One label twice: refused with both columns. `*113` and `U_12` of Nexus and Cortex: left over
    and told."""
    names, tracks, truth = walker(BMC, seconds=1.2)
    twins = [*names[:-1], names[0]]
    path = write_trc(tmp_path / "walk.trc", twins, 1000 * tracks)
    with pytest.raises(ValueError, match=rf"two markers are called '{names[0]}' \(columns 1, 18\)"):
        read_table(path)
    stray = np.concatenate([tracks, tracks[:, :2] + [0.0, 0.0, 0.3]], axis=1)
    path = write_trc(tmp_path / "walk.trc", [*names, "*113", "U_12"], 1000 * stray)
    rec = read_motion(path, cutoff=None, rigid=False)
    assert off(rec, truth) < 1e-9
    assert any("18 of 20 labels" in n and "*113, U_12" in n for n in rec.notes), rec.notes


def test_labels_that_no_set_knows_are_shown(tmp_path):
    names, tracks, _ = walker(BMC, seconds=1.2)
    path = write_trc(tmp_path / "walk.trc", [f"M{k:03}" for k in range(len(names))], 1000 * tracks)
    with pytest.raises(
        ValueError, match=r"none of the 18 labels belongs to a set \('M000', 'M001'"
    ):
        read_motion(path)
