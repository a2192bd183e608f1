# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the picture of wrinkles shows: which moments, which cells, which lines."""

import numpy as np
import pytest

from contact.body.segments import Body, Fixed, Segment
from shellform.motion.gait.synthetic_walk import synthetic_walk
from shellform.motion.recording import Recording
from shellform.pictures.walk import series_files
from shellform.pictures.wrinkles import (
    MAPS,
    TAUT_COLOUR,
    colours_of,
    crest_lines,
    draw_drape_wrinkles,
    moments_of,
    read_wrinkles,
)
from shellform.results.series import Series
from tests.results.test_series import shortened

pytestmark = pytest.mark.serial


@pytest.fixture
def sheets(tmp_path, comm):
    """Folders of two frames of a relaxed and of a resolved sheet, and the former's shell."""
    shells = {kind: shortened(kind, comm) for kind in ("relaxed", "resolved")}
    for kind, shell in shells.items():
        series = Series(tmp_path / kind)
        for time in (0.0, 0.5):
            series.write(shell, time)
    return tmp_path, shells["relaxed"]


@pytest.mark.parametrize("obstacle", [0.0, 0.5])
def test_moments_of_a_walk(obstacle):
    walk = synthetic_walk(obstacle=obstacle)
    times = np.linspace(walk.times[0], walk.times[-1], 200)
    moments = moments_of(walk, times)
    assert list(moments) == ["standing", "widest step", "most bent knee"]
    at = {name: np.abs(walk.times - times[k]).argmin() for name, k in moments.items()}
    ankles = [walk.joint_centre(f"{side}_ankle") for side in ("right", "left")]
    apart = ankles[0] - ankles[1]
    assert moments["standing"] == 0 and abs(apart[0, 0]) < 0.2
    assert abs(apart[at["widest step"], 0]) > 0.5 and abs(apart[at["widest step"], 2]) <= 0.2
    hips = [walk.joint_centre(f"{side}_hip") for side in ("right", "left")]
    legs = [np.linalg.norm(h - a, axis=1) for h, a in zip(hips, ankles, strict=True)]
    # a leg is never shorter, but for what lies between the times
    assert np.min(legs) > np.min(legs, axis=0)[at["most bent knee"]] - 0.02


def test_a_recording_without_legs_shows_standing():
    walk = synthetic_walk(strides=1, obstacle=0.0)
    pelvis = Recording(walk.times, {"pelvis": walk.points["pelvis"]})
    assert moments_of(pelvis, walk.times[::5]) == {"standing": 0}


def test_what_is_read_is_what_the_shell_tells(sheets):
    folder, shell = sheets
    (_, first), (time, path) = series_files(folder / "relaxed")
    found, expected = read_wrinkles(path, time), shell.wrinkling()
    assert time == 0.5 and found.frame.time == 0.5 and first.name == "0000.vtu"
    for one, other in zip(found[1:], expected, strict=True):
        assert np.array_equal(one, other)
    assert read_wrinkles(series_files(folder / "resolved")[0][1], 0.0) is None


def test_lines_run_along_the_crests_inside_their_cells(sheets):
    folder, shell = sheets
    wrinkled = read_wrinkles(series_files(folder / "relaxed")[0][1], 0.0)
    lines, count = crest_lines(wrinkled), len(shell.surface.cells)
    assert lines.shape == (count, 2, 3)  # all of them wrinkle
    along = lines[:, 1] - lines[:, 0]
    assert np.abs(np.cross(along, wrinkled.crest)).max() < 1e-12
    corners = wrinkled.frame.points[wrinkled.frame.cells]
    for axis in (0, 1):
        assert (lines[..., axis].max(axis=1) < corners[..., axis].max(axis=1)).all()
        assert (lines[..., axis].min(axis=1) > corners[..., axis].min(axis=1)).all()


def test_colours_tell_state_and_strain(sheets):
    folder, _ = sheets
    wrinkled = read_wrinkles(series_files(folder / "relaxed")[0][1], 0.0)
    states = np.array([0, 1, 1, 2, 2, 1])
    strains = np.array([0.0, 0.01, 0.2, 0.01, 0.2, 0.3])
    colours = colours_of(wrinkled._replace(state=states, strain=strains), 0.2)
    assert len(np.unique(colours, axis=0)) == 5  # the last is beyond the scale
    assert np.array_equal(colours[2], colours[5])
    darkness = colours.sum(axis=1)
    assert darkness[2] < darkness[1] and darkness[4] < darkness[3]
    assert TAUT_COLOUR.startswith("#") and set(MAPS) == {1, 2}


def test_nothing_is_drawn_of_resolved_sheets(sheets):
    folder, _ = sheets
    body = Body([Segment("ball", [0.1] * 3, Fixed((0.1, 0.1, -0.15)))])
    for kind, drawn in (("resolved", False), ("relaxed", True)):
        path = folder / f"{kind}.png"
        assert draw_drape_wrinkles(path, body, folder / kind) is drawn
        assert path.exists() is drawn
    assert (folder / "relaxed.png").read_bytes()[1:4] == b"PNG"
