# SPDX-License-Identifier: LGPL-3.0-or-later
"""Panels meshed and sewn: areas, girths, seams node to node, eased and notched, no crossing."""

import numpy as np
import pytest

import meshes
from meshes import MeshError
from meshes.garments.ring import polygon_length
from meshes.geometry import cell_areas
from meshes.patterns import Edge, Panel, SewingPattern, Stitch, read_pattern, sew
from meshes.patterns.crossings import crossings
from meshes.patterns.relax import springs
from tests.meshes.patterns.drafts import FILES, polygon, rectangle, sewn, tube


def flat_areas(surface):
    corners = surface.corners_at_rest.reshape(-1, 3)
    return cell_areas(corners, np.arange(len(corners)).reshape(-1, 4))


def lines_in_panels(surface, edge):
    """Lengths of a line of nodes in the flat cells on either side of it."""
    lines = {}
    pairs = {tuple(sorted(pair)) for pair in surface.edges[edge].tolist()}
    of = {cell: name for name, rows in surface.panels.items() for cell in rows.tolist()}
    for cell, nodes in enumerate(surface.cells.tolist()):
        for k in range(4):
            if tuple(sorted((nodes[k], nodes[(k + 1) % 4]))) in pairs:
                side = np.linalg.norm(surface.flat[cell, (k + 1) % 4] - surface.flat[cell, k])
                lines.setdefault(of[cell], []).append(side)
    return lines


@pytest.fixture(scope="module", params=["skirt", "trousers", "shirt"])
def garment(request):
    pattern = read_pattern(FILES / f"{request.param}.json")
    return pattern, sew(pattern, cell_size=0.03)


def test_areas_of_panels_are_those_of_the_file(garment):
    """To half a per cent, from the curves of the edges."""
    pattern, surface = garment
    areas = flat_areas(surface)
    assert set(surface.panels) == {panel.name for panel in pattern.panels}
    for panel in pattern.panels:
        assert areas[surface.panels[panel.name]].sum() == pytest.approx(panel.area, rel=5e-3)


def test_seams_match_node_by_node(garment):
    """Both sides have as many parts, each side the length of its edges, but for chords."""
    pattern, surface = garment
    for number, stitch in enumerate(pattern.stitches):
        lines = lines_in_panels(surface, f"seam_{number}")
        sides = [
            (chain[0][0], pattern.chain_length(chain)) for chain in (stitch.first, stitch.second)
        ]
        if sides[0][0] == sides[1][0]:  # a dart: both sides lie in one panel
            assert sum(lines[sides[0][0]]) == pytest.approx(sum(s for _, s in sides), rel=1e-2)
            continue
        one, other = (lines[name] for name, _ in sides)
        assert len(one) == len(other)
        for name, length in sides:
            assert sum(lines[name]) == pytest.approx(length, rel=1e-2)


def test_openings_have_the_girths_of_the_file(garment):
    """Of unsewn edges in the panels, which is what the cloth wants to be."""
    pattern, surface = garment
    known = {edge for s in pattern.stitches for edge in (*s.first, *s.second)}
    for panel in pattern.panels:
        for edge in panel.edges:
            if (panel.name, edge.name) not in known:
                line = lines_in_panels(surface, f"{panel.name}.{edge.name}")[panel.name]
                assert sum(line) == pytest.approx(edge.length, rel=5e-3)


def test_sewing_leaves_no_crossing_and_little_strain(garment):
    _, surface = garment
    assert len(crossings(surface.points, surface.cells)) == 0
    ends, rest = springs(surface.cells, surface.flat)
    strain = (
        np.linalg.norm(surface.points[ends[:, 1]] - surface.points[ends[:, 0]], axis=1) / rest - 1
    )
    assert np.percentile(np.abs(strain), 90) < 0.04


def test_openings(garment):
    """A skirt has two, trousers three, a shirt with sleeves four."""
    pattern, surface = garment
    count = {"skirt.json": 2, "trousers.json": 3, "shirt.json": 4}[pattern.source]
    assert len(meshes.boundary_loops(surface)) == count


def test_crossings_are_found():
    """Two sheets that pass through each other, and the same apart."""
    one = meshes.rectangle(0.2, 0.2, (4, 4))
    turn = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]
    for shift, some in ((0.1, True), (0.3, False)):
        other = one.transform(rotation=turn, translation=(shift + 1e-3, 0.013, 0.1))
        points = np.concatenate([one.points, other.points])
        found = crossings(points, np.concatenate([one.cells, other.cells + len(one.points)]))
        assert (len(found) > 0) == some


def test_warp_is_the_grain_line():
    """In the flat cells the first axis, in space the direction that it lies in."""
    for grain in ((0.0, 1.0), (1.0, 0.0), (1.0, 1.0)):
        surface = sew(tube(0.3, 0.12, grain=grain), cell_size=0.03)
        up = surface.warp[:, 2]
        assert np.allclose(np.abs(up), grain[1] / np.hypot(*grain), atol=0.05)


def test_notches_meet():
    """Ease lies between the notches: before them both sides are as long as each other."""
    # 0.1 m on both sides up to the notch, then 0.4 m into 0.2 m
    long = rectangle("long", 0.5, 0.2, notches=np.array([[0.1, 0.2]]))
    band = rectangle("band", 0.3, 0.06, notches=np.array([[0.1, 0.0]]))
    pattern = SewingPattern("eased", (long, band), sewn(("long.top", "band.bottom")))
    surface = sew(pattern, cell_size=0.02)
    assert any(
        "long.top (0.500 m) is eased into band.bottom (0.300 m), 1.67" in n for n in surface.notes
    )
    lines = lines_in_panels(surface, "seam_0")
    reach = {}
    for name, rows in surface.panels.items():
        where = np.zeros((len(surface.points), 2))
        where[surface.cells[rows].ravel()] = surface.flat[rows].reshape(-1, 2)
        nodes = np.unique(surface.edges["seam_0"])
        # the grain runs along y of the panel, the first axis of flat: x is minus the second
        reach[name] = -where[nodes, 1]
    assert len(lines["long"]) == len(lines["band"])
    before = reach["band"] < 0.1 + 1e-9
    assert np.allclose(reach["long"][before], reach["band"][before], atol=1e-9)
    after = reach["band"][~before]
    assert np.allclose(reach["long"][~before], 0.1 + 2 * (after - 0.1), atol=1e-9)
    assert before.sum() > 3 and len(after) > 3


def test_darts_take_cloth_away():
    """A wedge sewn up makes a cone: the angle missing at its point is that of the wedge."""
    corners = [
        (-0.15, 0),
        (0.15, 0),
        (0.15, 0.2),
        (0.03, 0.2),
        (0, 0.08),
        (-0.03, 0.2),
        (-0.15, 0.2),
    ]
    pattern = SewingPattern("dart", (polygon("back", corners),), sewn(("back.3", "back.4")))
    assert pattern.darts == pattern.stitches
    surface = sew(pattern, cell_size=0.03)
    tip = np.flatnonzero(
        np.bincount(
            surface.cells.ravel()[
                np.all(np.isclose(surface.flat, [0.08, 0.0], atol=1e-9), axis=2).ravel()
            ],
            minlength=len(surface.points),
        )
    )
    assert len(tip) == 1
    angle = 0.0
    for cell, k in np.argwhere(surface.cells == tip[0]):
        one, two = (surface.flat[cell, (k + s) % 4] - surface.flat[cell, k] for s in (1, -1))
        angle += np.arccos(one @ two / np.linalg.norm(one) / np.linalg.norm(two))
    assert angle == pytest.approx(2 * np.pi - 2 * np.arctan2(0.03, 0.12), abs=1e-6)


def test_a_panel_drawn_from_the_inside_is_mirrored():
    """The cells of a clockwise panel look out like the others, and keep their shape."""
    front = rectangle("front", 0.3, 0.2)
    back = rectangle("back", 0.3, 0.2)
    inside = Panel("back", tuple(Edge(e.name, e.points * [-1.0, 1.0], e.kind) for e in back.edges))
    stitches = sewn(("front.left", "back.right"), ("front.right", "back.left"))
    for second in (back, inside):
        surface = sew(SewingPattern("two", (front, second), stitches), cell_size=0.04)
        girth = [
            polygon_length(surface.points[np.append(loop, loop[0])])
            for loop in meshes.boundary_loops(surface)
        ]
        assert girth == pytest.approx([0.6, 0.6], rel=0.02)
        outward = np.einsum(
            "ni,ni->n", surface.directors, surface.points - surface.points.mean(axis=0)
        )
        assert np.all(outward > 0)


def test_a_seam_over_panels_side_by_side():
    """A band sewn to two panels at once: their corners are nodes of the band."""
    front, back = rectangle("front", 0.3, 0.2), rectangle("back", 0.2, 0.2)
    band = rectangle("band", 0.5, 0.05)
    stitches = sewn(
        ("front.right", "back.left"),
        ("front.left", "back.right"),
        ("band.left", "band.right"),
        ("band.bottom", "front.top+back.top"),
    )
    # tops run against the bottom: the panels lie the other way along it
    stitches = (*stitches[:3], Stitch(stitches[3].first, stitches[3].second[::-1]))
    surface = sew(SewingPattern("band", (front, back, band), stitches), cell_size=0.03)
    assert len(meshes.boundary_loops(surface)) == 2
    assert surface.area == pytest.approx(0.5 * 0.25, rel=0.02)


def test_cloth_that_goes_through_itself_is_told():
    """A front sewn to a back the wrong way about, left to left, as if both were seen in front."""
    front, back = rectangle("front", 0.3, 0.2), rectangle("back", 0.3, 0.2)
    right = sewn(("front.left", "back.right"), ("front.right", "back.left"))
    wrong = sewn(("front.left", "back.left"), ("front.right", "back.right"))
    notes = [sew(SewingPattern("two", (front, back), s), 0.04).notes for s in (right, wrong)]
    assert notes[0] == () and "two: the sewn cloth goes through itself at" in notes[1][-1]


def test_a_strip_sewn_with_a_half_turn_is_refused():
    pattern = tube(0.3, 0.1)
    twisted = Stitch(*(pattern.stitches[0].first, pattern.stitches[0].second), along=True)
    with pytest.raises(MeshError, match=r"tube: .*side"):
        sew(SewingPattern("tube", pattern.panels, (twisted,)), cell_size=0.03)
