# SPDX-License-Identifier: LGPL-3.0-or-later
"""A format of marker files is one reader and one entry of a table."""

import subprocess
import sys

import numpy as np
import pytest

from shellform.motion.capture.formats import FORMATS, Format, read_table
from shellform.motion.capture.marker_table import Raw
from shellform.motion.capture.read_motion import read_markers

RATE = 50.0


def read_points(path):
    """Lines `label x y z`, the same labels in every frame: a format nobody has."""
    rows = [line.split() for line in path.read_text().splitlines()]
    names = tuple(dict.fromkeys(row[0] for row in rows))
    places = np.array([row[1:] for row in rows], float).reshape(-1, len(names), 3)
    return Raw(names, np.arange(len(places)) / RATE, places, RATE, "mm", "z")


@pytest.fixture
def points_file(monkeypatch, tmp_path):
    monkeypatch.setitem(FORMATS, ".points", Format(read_points, "One label a line."))
    places = np.random.default_rng(3).uniform(0.0, 1000.0, (4, 2, 3))
    places[:, 1, 2] += 900.0  # mm; a person's height
    path = tmp_path / "walk.POINTS"
    path.write_text(
        "\n".join(
            f"Ann:{name} {' '.join(map(str, place))}"
            for frame in places.tolist()
            for name, place in zip(("HEEL", "SACRUM"), frame, strict=True)
        )
    )
    return path, places


def test_a_new_format_is_read(points_file):
    """Everything after the reader is the same for all: prefixes, unit, vertical."""
    path, places = points_file
    raw = read_table(path)
    assert raw.names == ("HEEL", "SACRUM") and np.array_equal(raw.positions, places)
    markers = read_markers(path)
    assert markers.rate == RATE
    assert markers.positions == pytest.approx(1e-3 * places, abs=1e-12)
    assert any("prefix Ann" in note for note in markers.notes)


def test_endings_that_are_not_known(points_file, tmp_path):
    """Refused with the known ones, the new one among them."""
    path = tmp_path / "walk.mov"
    path.write_text("")
    with pytest.raises(ValueError, match=r"walk\.mov: no marker file; \.trc, .* and \.points"):
        read_table(path)


def test_every_format_says_what_it_reads():
    for ending, form in FORMATS.items():
        assert ending == ending.lower() and ending.startswith(".")
        assert form.content.endswith(".") and form.read.__doc__


@pytest.mark.serial
def test_the_library_for_c3d_is_imported_only_to_read_one():
    code = "import sys, shellform.motion.capture.read_motion; print('ezc3d' in sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "False"
