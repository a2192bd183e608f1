# SPDX-License-Identifier: LGPL-3.0-or-later
"""Skin that bulges: against a slow twin; nothing at binding; nothing of it where none is asked for.

Rates, power, force and moment are those of `test_skinning`, whose third skin bulges.
"""

import numpy as np
import pytest
from scipy.interpolate import PPoly

from contact.body import bulge as module
from contact.body.bulge import Bulge, amount
from contact.body.segments import Pose
from contact.body.skinned_surface import SkinnedSurface

from .test_skinning import NAMES, bending, bulge, knee, leg, places, rest, slow


def skin_of(given, pose=bending):
    points, triangles, weights = leg()
    bound = rest()
    return SkinnedSurface(
        points, triangles, weights, NAMES, lambda t, out: pose(t, out, bound), bound, [knee()],
        None, given,
    )  # fmt: skip


def beta(swell, t):
    """P(c) - P(c0) by scipy."""
    bound = rest()
    pose = bending(t, Pose(*(np.zeros_like(part) for part in bound)), bound)
    u, v = (np.asarray(line, float) for line in (swell.along_above, swell.along_below))
    now = [
        pose.axes[j].T @ (bound.axes[j] @ line)
        for j, line in ((NAMES.index(swell.above), u), (NAMES.index(swell.below), v))
    ]
    P = PPoly(
        np.array(swell.amounts)[:, ::-1].T, np.linspace(*swell.cosines, len(swell.amounts) + 1)
    )

    def straight(c):
        inside = np.clip(c, *swell.cosines)
        return P(inside) + P(inside, 1) * (c - inside)

    return straight(now[0] @ now[1]) - straight(u @ v)


@pytest.mark.parametrize("t", [0.3, 0.9])
def test_equals_the_slow_twin(t):
    points, _, _ = leg()
    given = bulge(points)
    moved = points.copy()
    for swell in given.swells:
        own = given.fields == swell.field
        moved[own] += beta(swell, t) * given.directions[own]
    assert np.abs(moved - points).max() > 0.005
    assert np.abs(places(skin_of(given), t) - slow(t, points=moved)).max() < 1e-12


def test_is_where_it_was_bound():
    points, _, _ = leg()
    still = skin_of(bulge(points), lambda t, out, bound: bending(0.0, out, bound))
    assert np.abs(places(still, 0.7) - points).max() < 1e-14


def test_amounts_are_smooth_and_go_on_straight():
    pieces, width, h = np.array([[0.1, 0.2, -0.3, 0.4], [0.0, 0.0, 0.1, -0.2]]), 0.5, 1e-6
    pieces[1, :2] = pieces[0] @ width ** np.arange(4), pieces[0, 1:] @ [1.0, 1.0, 0.75]
    c = np.linspace(-1.0, 2.0, 301)
    value, slope = np.array([amount(0.0, width, 2, pieces, x) for x in c]).T
    ahead = np.array([amount(0.0, width, 2, pieces, x + h)[0] for x in c])
    back = np.array([amount(0.0, width, 2, pieces, x - h)[0] for x in c])
    assert np.abs((ahead - back) / (2 * h) - slope).max() < 1e-5
    for beyond in (c < 0.0, c > 1.0):
        assert np.abs(np.diff(value[beyond], 2)).max() < 1e-15


def test_without_one_nothing_of_it_is_evaluated(monkeypatch):
    points, _, _ = leg()
    flat = bulge(points)
    none = [s._replace(amounts=0.0 * np.array(s.amounts)) for s in flat.swells]
    with_none = places(skin_of(flat._replace(swells=none)), 0.8)

    def never(*given):
        raise AssertionError

    for kernel in ("set_bulge", "bulge_rates", "add_bulge"):
        monkeypatch.setattr(module, kernel, never)
    skin = skin_of(None)
    assert (places(skin, 0.8) == with_none).all()
    n = skin.vertex_count
    skin.velocities(0.8, np.empty((n, 3)))
    skin.add_to_segments(0.8, np.ones((n, 6)), np.zeros((2, 9)))
    with pytest.raises(AssertionError):
        places(skin_of(flat), 0.8)


def test_of_two_fields_each_has_its_own_amount():
    """A field without swells stays."""
    points, _, _ = leg()
    given = bulge(points)
    one = Bulge(given.fields, given.directions, given.swells[:2])
    shift = np.abs(places(skin_of(one), 0.8) - places(skin_of(None), 0.8)).max(axis=1)
    assert shift[given.fields == 0].max() > 0.003
    assert shift[given.fields == 1].max() == 0.0
