# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sleeves and skirts against cones, and measures at fault."""

import numpy as np
import pytest

import meshes
from tests.meshes.measures import euler, facing, inside_volume, loop_length, section_length


def frustum(upper, lower, height):
    """Lateral area and volume of a cone frustum of two girths."""
    one, other = upper / (2.0 * np.pi), lower / (2.0 * np.pi)
    area = np.pi * (one + other) * np.hypot(height, one - other)
    return area, np.pi * height / 3.0 * (one**2 + one * other + other**2)


TUBES = {
    "sleeve": (lambda h: meshes.sleeve(0.6, 0.5, 0.3, cell_size=h), (0.5, 0.3, 0.6)),
    "middle": (lambda h: meshes.sleeve(0.6, 0.5, 0.3, 0.4, cell_size=h), (0.5, 0.3, 0.6)),
    "skirt": (
        lambda h: meshes.skirt(
            0.8, 1.0, 1.4, 0.6, 0.2, waist_ratio=1.0, hem_ratio=1.0, cell_size=h
        ),
        (0.8, 1.4, 0.6),
    ),
}


@pytest.mark.parametrize("name", TUBES)
def test_tubes_converge_to_cones(name):
    make, measures = TUBES[name]
    exact = np.array(frustum(*measures))
    found = np.array([(make(h).area, inside_volume(make(h))) for h in (0.04, 0.02, 0.01)])
    errors = np.abs(found - exact) / exact
    # A regular polygon of n sides and a circle of its girth differ by pi^2 / (3 n^2) in area.
    assert np.all(errors[-1] < 3e-3)
    orders = np.log2(errors[:-1] / errors[1:])
    assert np.all((orders > 1.9) & (orders < 2.1))


@pytest.mark.parametrize("cell_size", [0.04, 0.025, 0.01])
def test_girths_of_tubes(cell_size):
    sleeve = meshes.sleeve(0.6, 0.5, 0.3, 0.45, ratio=1.2, cell_size=cell_size)
    assert loop_length(sleeve, "top") == pytest.approx(0.5, rel=1e-9)
    assert loop_length(sleeve, "bottom") == pytest.approx(0.3, rel=1e-9)
    assert section_length(sleeve, 0.3 - 1e-8) == pytest.approx(0.45, rel=1e-6)
    assert np.array_equal(sleeve.bounds[:, 2], [0.0, 0.6])
    skirt = meshes.skirt(cell_size=cell_size)
    assert loop_length(skirt, "waist") == pytest.approx(0.74, rel=1e-9)
    assert loop_length(skirt, "hem") == pytest.approx(1.30, rel=1e-9)
    assert section_length(skirt, 0.84 - 1e-8) == pytest.approx(1.02, rel=1e-6)
    assert np.allclose(skirt.bounds[:, 2], [0.44, 1.04])
    for surface in (sleeve, skirt):
        assert euler(surface) == 0 and meshes.scaled_jacobian(surface).min() > 0.9
        assert np.all(np.einsum("ni,ni->n", surface.directors, surface.points * [1, 1, 0]) > 0.0)
        assert np.all(surface.warp[:, 2] < -0.7)
        assert np.abs(np.einsum("mi,mi->m", surface.warp, facing(surface))).max() < 1e-12
        assert np.allclose(surface.points[surface.edges["seam"]][..., 1], 0.0)


@pytest.mark.parametrize(
    "make, change, sentence",
    [
        (meshes.sleeve, {"girth_top": 50.0}, "girth_top = 50.0 is no girth"),
        (meshes.sleeve, {"length": 0.0}, "length = 0.0 m does not fit"),
        (meshes.sleeve, {"ratio": 0.0}, "breadth over depth"),
        (meshes.sleeve, {"cell_size": 0.2}, "0.001 to 0.05"),
        (meshes.skirt, {"hem": -1.0}, "hem = -1.0 is no girth"),
        (meshes.skirt, {"hip_depth": 0.7}, "must rise in this order"),
        (meshes.skirt, {"length": 1.2}, "hem above floor"),
    ],
)
def test_impossible_tubes(make, change, sentence):
    measures = {"length": 0.6, "girth_top": 0.5, "girth_bottom": 0.3}
    if make is meshes.skirt:
        measures = {}
    with pytest.raises(ValueError, match=sentence):
        make(**{**measures, **change})
