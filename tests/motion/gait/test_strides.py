# SPDX-License-Identifier: LGPL-3.0-or-later
"""Strides from footfall to footfall: known events, standing before, amid and after the walk."""

from itertools import pairwise

import numpy as np
import pytest

from shellform.motion.capture.gait_initiation import gait_initiation
from shellform.motion.capture.read_motion import read_motion
from shellform.motion.gait.standing_pose import standing_of
from shellform.motion.gait.strides import counted, strides
from shellform.motion.gait.synthetic_walk import synthetic_walk
from shellform.motion.recording import SIDES, Recording
from shellform.motion.wearer import Wearer


def strikes(walk, side):
    return np.array([t for name, t in walk.facts["events"] if name == f"{side}_heel_strike"])


def without_facts(walk):
    """The same motion, whose heel strikes have to be found."""
    return Recording(walk.times, walk.points, walk.source)


def paused(walk, at, seconds):
    """The walk with a rest at a time [s], into and out of which it goes smoothly in 0.5 s."""
    t = np.arange(0, walk.times[-1] + seconds, 0.01)
    # the pace goes 1 -> 0 -> 1 as a smooth step
    s = np.clip((t - (at - 0.25)) / 0.5, 0, 1), np.clip((t - (at + seconds - 0.25)) / 0.5, 0, 1)
    ease = [x * x * (3 - 2 * x) for x in s]
    clock = np.cumsum(1 - ease[0] + ease[1]) * 0.01
    keep = clock <= walk.times[-1]
    flat = {name: track.reshape(len(track), 9) for name, track in walk.points.items()}
    points = {
        name: np.stack([np.interp(clock[keep], walk.times, c) for c in track.T], 1)
        for name, track in flat.items()
    }
    points = {name: track.reshape(-1, 3, 3) for name, track in points.items()}
    return Recording(t[keep], points, "a walk with a rest"), lambda time: np.interp(time, clock, t)


@pytest.mark.parametrize("obstacle", [0.0, 0.5])
@pytest.mark.parametrize("stand", [0.3, 3.5])
def test_strides_of_known_events(obstacle, stand):
    """All intervals between the strikes that the generator names, and no standing before them."""
    walk = synthetic_walk(strides=4, obstacle=obstacle, stand=stand)
    found = strides(walk)
    for side in SIDES:
        exact = strikes(walk, side)
        assert len(exact) == 4
        np.testing.assert_allclose(found[side], np.c_[exact[:-1], exact[1:]], atol=0.01)
    begin, end = counted(walk)
    assert stand <= begin < stand + 0.1 and end == walk.times[-1]
    wearer = strides(Wearer(walk, []))
    assert all((wearer[side] == found[side]).all() for side in SIDES)


@pytest.mark.parametrize("obstacle", [0.0, 0.5])
@pytest.mark.parametrize("stand", [0.3, 3.5])
def test_strides_that_are_looked_for(obstacle, stand):
    """Without the generator's events: the same strides, to 0.04 s, over an obstacle too."""
    walk = synthetic_walk(strides=4, obstacle=obstacle, stand=stand)
    found = strides(without_facts(walk))
    for side in SIDES:
        exact = strikes(walk, side)
        # the last strike, at the end of the recording, is no peak
        exact = exact[exact < walk.times[-1] - 0.1]
        np.testing.assert_allclose(found[side], np.c_[exact[:-1], exact[1:]], atol=0.04)


def test_standing_is_no_stride():
    """A rest of 3.5 s in the third stride takes that stride out, and no other."""
    walk = synthetic_walk(strides=5, obstacle=0.0)
    right, left = strikes(walk, "right"), strikes(walk, "left")
    at = 0.5 * (right[2] + left[2])
    still, clock = paused(walk, at, 3.5)
    found = strides(still)
    for side, own in (("right", right), ("left", left)):
        own = own[own < walk.times[-1] - 0.1]
        pairs = np.array([p for p in pairwise(own) if not p[0] < at < p[1]])
        assert len(pairs) == len(own) - 2
        np.testing.assert_allclose(found[side], clock(pairs), atol=0.05)
        assert np.diff(found[side], axis=1).max() < 1.2


def test_standing_at_the_end_does_not_count():
    walk = synthetic_walk(strides=3, obstacle=0.0)
    at = walk.times[-1] - 0.3
    still, _ = paused(walk, at, 4.0)
    keep = still.times < at + 3.0
    still = Recording(still.times[keep], {n: p[keep] for n, p in still.points.items()})
    assert counted(still)[1] == pytest.approx(at + 0.2, abs=0.1)
    assert max(found[:, 1].max() for found in strides(still).values()) <= counted(still)[1]
    nothing = Recording(still.times[-50:], {n: p[-50:] for n, p in still.points.items()})
    assert counted(nothing) == (still.times[-50], still.times[-1])
    assert all(found.shape == (0, 2) for found in strides(nothing).values())


def test_what_leads_into_a_capture_does_not_count():
    """Frames put before the first one: the strides and what counts stay as they were."""
    walk = synthetic_walk(strides=3, obstacle=0.0)
    keep = walk.times >= 1.0
    points = {name: track[keep] for name, track in walk.points.items()}
    for facts in ({}, walk.facts):
        part = Recording(walk.times[keep], points, facts=facts)
        full = gait_initiation(part, standing_of(part), 1.0)
        assert full.times[0] == pytest.approx(0.0) and counted(full) == counted(part)
        assert counted(full)[0] == pytest.approx(1.0)
        for side in SIDES:
            np.testing.assert_array_equal(strides(full)[side], strides(part)[side])
            assert len(strides(full)[side]) >= 1


def test_strides_of_public_captures(paper_data):
    """A capture of less than two strides; one whose file marks its foot strikes."""
    found = strides(read_motion(paper_data / "bmc_walk2.trc"))
    assert [len(found[side]) for side in ("left", "right")] == [1, 0]
    assert np.ptp(found["left"]) == pytest.approx(1.02, abs=0.05)
    ezc3d = pytest.importorskip("ezc3d", reason="C3D files are read by ezc3d, not installed here")
    path = paper_data / "biomechzoo_HC038A11.c3d"
    event = ezc3d.c3d(str(path))["parameters"]["EVENT"]
    labels, sides = event["LABELS"]["value"], event["CONTEXTS"]["value"]
    found = strides(read_motion(path))
    for side in SIDES:
        marked = sorted(
            t for t, what, s in zip(event["TIMES"]["value"][1], labels, sides)
            if what == "Foot Strike" and s.lower() == side
        )  # fmt: skip
        assert len(marked) >= 2
        for pair in pairwise(marked):
            assert np.abs(found[side] - pair).max(axis=1).min() < 0.05


def test_wrong_first_frame():
    walk = synthetic_walk(strides=1, obstacle=0.0)
    with pytest.raises(ValueError, match="the first frame is one of 0 to"):
        Recording(walk.times, walk.points, first_frame=len(walk.times))
