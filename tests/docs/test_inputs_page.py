# SPDX-License-Identifier: LGPL-3.0-or-later
"""The page on inputs lists what there is: formats, marker sets, keys, options, notes."""

import re
from pathlib import Path

import numpy as np
import pytest

from shellform.__main__ import TEMPLATE
from shellform.motion.capture.formats import FORMATS
from shellform.motion.capture.options import OPTIONS
from shellform.motion.capture.read_motion import read_motion
from shellform.motion.capture.segment_map import SHIPPED, segment_map, vocabulary
from tests.motion.capture.made_up import LATERAL, PLUG_IN, walker, write_trc

PAGE = (Path(__file__).parents[2] / "docs" / "inputs.md").read_text()

pytestmark = pytest.mark.serial


def rows(heading):
    """Rows of the first table under a heading, cells as texts."""
    text = PAGE.split(f"\n### {heading}\n")[1].split("\n### ")[0]
    found = [line.strip("|").split("|") for line in text.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in row] for row in found[2:]]


def test_formats():
    assert {row[0].strip("`") for row in rows("Files")} == set(FORMATS)


def test_marker_sets():
    """Every shipped map, and labels that belong to it."""
    sets = rows("Marker sets")
    assert sorted(row[0].strip("`") for row in sets) == sorted(SHIPPED)
    for name, labels, _ in sets:
        words = vocabulary(segment_map(name.strip("`")))
        for label in re.findall(r"\b[RLrl][.\w]*", labels):
            word = "".join(c for c in label.lower() if c.isalnum())
            assert word in words, (name, label)


def test_keys_of_all_options():
    keys = {row[0].strip("`"): (row[1].strip("`"), row[2].strip("`")) for row in rows("Keys")}
    for option in OPTIONS:
        assert keys[option.key] == (option.flag, option.name)


def test_conventions_are_told_where_a_scene_begins():
    for word in ("x is forward", "y to the wearer's left", "z up", "floor at 0", "y or z up"):
        assert word in TEMPLATE, word


@pytest.mark.parametrize("labels", [LATERAL, PLUG_IN])
def test_notes_of_a_capture_are_explained(tmp_path, labels):
    """Notes of a walk with a gap, a short file and mirrored labels begin as the page has them."""
    names, tracks, _ = walker(labels)
    tracks[100:105, 0] = np.nan
    tracks[..., 1] *= -1.0
    stray = np.concatenate([tracks, tracks[:, :1]], axis=1)
    path = write_trc(tmp_path / "walk.trc", [*names, "wall"], 1000 * stray)
    path.write_text(path.read_text().rsplit("\n", 3)[0] + "\n")
    notes = read_motion(path).notes
    for words in ("labels belong to the set", "left and right are mirrored", "header says"):
        assert words in PAGE and any(words in note for note in notes), (words, notes)
    told = [re.escape(row[0]).replace(r"\.\.\.", ".+") for row in rows("Notes")]
    told = [re.sub(r"\d+(\\\.\d+)?", r"[\\d.]+", re.sub("'.*'", "'.*'", row)) for row in told]
    for note in notes:
        assert any(re.match(row, note) for row in told), note
