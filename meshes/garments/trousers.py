"""Trousers as one surface of quads, standing as on a body with its feet on z = 0.

x points forward, y to the left, z up. Girths are exact on the mesh; the right half is the mirror
image of the left. The shape between the rings is in fork.py.
"""
# SPDX-License-Identifier: LGPL-3.0-or-later

from __future__ import annotations

from itertools import pairwise

import numpy as np

from meshes.repair import scaled_jacobian
from meshes.surface import MeshError, Surface
from meshes.topology import segments_of_line

from .fork import bridge_cells, bridge_ends, loft
from .ring import COARSE, count_cells, half_ring, ring
from .sleeve_and_skirt import check_cell_size, check_girths

# Breadth over depth of the rings, of a clothed person standing.
_RATIOS = {"waist": 1.30, "hip": 1.28, "thigh": 0.75, "knee": 0.88, "hem": 0.90}
_BELOW_FORK = 0.05  # m; where the thigh's girth is measured
_LEG_SPACING = 0.095  # m; half distance of the middles of a standing person's thighs


def _table():
    girths = {
        "small": {"waist": 0.80, "hip": 0.97, "thigh": 0.72, "knee": 0.54, "hem": 0.40},
        "medium": {"waist": 0.90, "hip": 1.07, "thigh": 0.75, "knee": 0.56, "hem": 0.42},
        "large": {"waist": 1.00, "hip": 1.17, "thigh": 0.78, "knee": 0.58, "hem": 0.44},
    }
    regular = {"waist_height": 1.04, "hip_height": 0.90, "fork_height": 0.795, "knee_height": 0.48}
    stature = {"short": 0.771 / 0.845, "regular": 1.0, "long": 0.925 / 0.845}
    return {
        f"{width}-{length}": {
            **measures,
            **{name: round(factor * height, 3) for name, height in regular.items()},
            "hem_height": 0.06,
        }
        for width, measures in girths.items()
        for length, factor in stature.items()
    }


SIZES = _table()


def trousers(
    size: str = "large-regular",
    *,
    waist: float | None = None,
    hip: float | None = None,
    thigh: float | None = None,
    knee: float | None = None,
    hem: float | None = None,
    waist_height: float | None = None,
    hip_height: float | None = None,
    fork_height: float | None = None,
    knee_height: float | None = None,
    hem_height: float | None = None,
    back_lift: float = 0.025,
    stance: float = 0.10,
    fork_gap: float = 0.003,
    cell_size: float = 0.025,
) -> Surface:
    """A pair of trousers.

    Parameters
    ----------
    size : of `SIZES`, 'small', 'medium' or 'large' and 'short', 'regular' or 'long'; gives every
        measure that is None.
    waist, hip, thigh, knee, hem : girths in m of the mesh's polygons. The thigh is measured 50 mm
        below the fork.
    waist_height, hip_height, fork_height, knee_height, hem_height : above the floor in m. The rise
        is waist minus fork, the inseam fork minus hem.
    back_lift : height of the waist at the back above that at the front, in m.
    stance : half distance of the legs' middles at the hem, in m; legs wider apart open the fork.
    fork_gap : half distance of the inner sides of the legs at the thigh's ring, in m.
    cell_size : m, at most 0.04; half of it gives twice the cells in each direction and keeps the
        points, but for the change from chords to curves.

    Returns
    -------
    Surface with directors outward and the warp down along the legs. Edges: the closed loops
    'waist', 'right_hem', 'left_hem' and the lines 'rise' (front waist to back waist),
    'right_inseam', 'left_inseam', 'right_outseam', 'left_outseam'. Panels: 'right_front',
    'right_back', 'left_front', 'left_back'.

    Raises
    ------
    ValueError : for a size or measure out of range, or measures that do not go together.

    Notes
    -----
    Sizes: U.S. military labels give the wearer's waist, 27 to 31, 31 to 35 and 35 to 39 inches, and
    inseam, 26.5 to 29.5, to 32.5 and to 35.5 inches. A finished pair of the medium size measures
    0.90 at the waist, 0.76 at the thigh and 0.42 m at the hem; the other sizes are graded from it
    by 0.10 m (4 inches) at waist and hip, and less below. Heights of the regular length fit the
    median man of ANSUR II (Gordon et al., NATICK/TR-15/007, 2014; crotch 0.845, waist 1.055, knee
    0.49 m), the fork 50 mm lower than the crotch; short and long are scaled with the 5th and 95th
    percentile of the crotch height, 0.771 and 0.925 m, whose inseams lie in the bands above.
    """
    if size not in SIZES:
        raise ValueError(f"trousers: there is no size {size!r}, give one of {', '.join(SIZES)}.")
    given = {
        "waist": waist,
        "hip": hip,
        "thigh": thigh,
        "knee": knee,
        "hem": hem,
        "waist_height": waist_height,
        "hip_height": hip_height,
        "fork_height": fork_height,
        "knee_height": knee_height,
        "hem_height": hem_height,
    }
    measures = {**SIZES[size], **{k: v for k, v in given.items() if v is not None}}
    _check(measures, back_lift, stance, fork_gap)
    check_cell_size("trousers", cell_size, COARSE)

    half = 2 * count_cells(0.25 * measures["hip"], cell_size, least=2)
    around = half_ring(measures["hip"], _RATIOS["hip"], half)
    ends = bridge_ends(around[0, 0], measures["hip_height"], measures["fork_height"])
    bridge = bridge_cells(ends, cell_size)
    hip_ring = around + [0.0, 0.0, measures["hip_height"]]
    waist_ring = half_ring(measures["waist"], _RATIOS["waist"], half, back_lift)
    waist_ring[:, 2] += measures["waist_height"]
    thigh_ring, knee_ring, hem_ring = _leg_rings(measures, half, bridge, stance, fork_gap)
    rows = loft(waist_ring, hip_ring, thigh_ring, knee_ring, hem_ring, ends, cell_size)
    try:
        surface = _joined(rows, half)
    except MeshError as error:
        raise ValueError(
            f"{error} The measures do not go together, compare them with SIZES."
        ) from None
    quality = scaled_jacobian(surface).min()
    if quality < 0.2:
        raise ValueError(
            f"trousers: these measures give cells of a quality of {quality:.2f} (see "
            "scaled_jacobian), bring them closer to those of a size in SIZES."
        )
    return surface


def _check(measures, back_lift, stance, fork_gap):
    check_girths("trousers", **{name: measures[name] for name in _RATIOS})
    heights = [f"{name}_height" for name in ("waist", "hip", "fork", "knee", "hem")]
    for name in heights:
        if not 0.0 <= measures[name] <= 2.0:
            raise ValueError(
                f"trousers: {name} = {measures[name]} does not fit a person, give the height above "
                "the floor in m, 0 to 2."
            )
    for upper, lower in pairwise(heights):
        least = 0.1 if lower == "knee_height" else 0.03
        if not measures[upper] - measures[lower] >= least:
            raise ValueError(
                f"trousers: {upper} = {measures[upper]} m must lie {least} m or more above "
                f"{lower} = {measures[lower]} m."
            )
    ratio = measures["thigh"] / measures["hip"]
    if not 0.55 <= ratio <= 0.85:
        raise ValueError(
            f"trousers: a thigh of {measures['thigh']} m and a hip of {measures['hip']} m do not "
            f"meet at a fork, the thigh must be 0.55 to 0.85 of the hip, not {ratio:.2f}."
        )
    for name, value, most in (("back_lift", back_lift, 0.1), ("fork_gap", fork_gap, 0.05)):
        if not 0.0 <= value <= most or (name == "fork_gap" and value == 0.0):
            raise ValueError(f"trousers: {name} = {value} m must lie in 0 to {most} m.")
    if not 0.05 <= stance <= 0.6:
        raise ValueError(
            f"trousers: stance = {stance} m must lie in 0.05 to 0.6 m, half the distance of the "
            "legs at the hem."
        )


def _leg_rings(measures, half, bridge, stance, fork_gap):
    """Rings (half + bridge, 3) of the left leg at thigh, knee and hem."""
    thigh_height = measures["fork_height"] - _BELOW_FORK
    heights = {
        "thigh": thigh_height,
        "knee": measures["knee_height"],
        "hem": measures["hem_height"],
    }
    rings = []
    for name, height in heights.items():
        # From the innermost point (-y) by the front; the first column is half a bridge on.
        points = ring(measures[name], _RATIOS[name], half + bridge, -0.5 * np.pi)
        inner = points[:, 1].min()
        if name == "thigh":
            middle = fork_gap - inner
        else:
            down = (thigh_height - height) / (thigh_height - measures["hem_height"])
            middle = _LEG_SPACING + down * (stance - _LEG_SPACING)
            if middle + inner <= 0.0:
                least = _LEG_SPACING + (-inner - _LEG_SPACING) / down  # puts the middle at -inner
                raise ValueError(
                    f"trousers: the legs, {measures[name]} m round at the {name}, run into each "
                    f"other; give a stance above {np.ceil(1e3 * least) / 1e3:.3f} m."
                )
        rings.append(np.roll(points, -(bridge // 2), axis=0) + [0.0, middle, height])
    return rings


def _quads(grid):
    """Quads between the rows of a grid of point numbers, (rows, columns, 4)."""
    return np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]], axis=-1)


def _joined(rows, half):
    """The left half of the trousers from its rows, and its mirror image, as one Surface."""
    width = rows.leg.shape[1]
    side, fork = half // 2, (half + width) // 2
    inner = rows.leg[0, half + 1 :]
    left = np.concatenate([rows.torso.reshape(-1, 3), inner, rows.leg[1:].reshape(-1, 3)])
    torso = np.arange(rows.torso.shape[0] * (half + 1)).reshape(-1, half + 1)
    leg = np.append(torso[-1], np.arange(torso.size, len(left))).reshape(-1, width)
    leg = np.concatenate([leg, leg[:, :1]], axis=1)
    parts = _quads(torso), _quads(leg)
    cells = np.concatenate([part.reshape(-1, 4) for part in parts])
    columns = np.concatenate([np.tile(np.arange(p.shape[1]), len(p)) for p in parts])
    front = np.flatnonzero((columns < side) | (columns >= fork))
    back = np.setdiff1d(np.arange(len(cells)), front)

    # Points with y = 0 are their own mirror image.
    own = left[:, 1] == 0.0
    image = np.where(own, np.arange(len(left)), len(left) + np.cumsum(~own) - 1)
    points = np.concatenate([left, left[~own] * [1.0, -1.0, 1.0]])
    count = len(cells)
    cells = np.concatenate([cells, image[cells][:, [3, 2, 1, 0]]])
    # From the upper to the lower side of each cell; columns run down, and mirrored cells too.
    corners = points[cells]
    warp = corners[:, [1, 2]].sum(axis=1) - corners[:, [0, 3]].sum(axis=1)
    warp /= np.linalg.norm(warp, axis=1, keepdims=True)

    lines = {
        "hem": leg[-1],
        "inseam": leg[:, fork],
        "outseam": np.append(torso[:, side], leg[1:, side]),
    }
    edges = {
        "waist": np.append(torso[0], image[torso[0, -2::-1]]),
        "rise": np.concatenate([torso[:, 0], leg[0, -2:half:-1], torso[::-1, -1]]),
    }
    edges.update({f"left_{name}": line for name, line in lines.items()})
    edges.update({f"right_{name}": image[line] for name, line in lines.items()})
    return Surface(
        points,
        cells,
        {name: segments_of_line(line) for name, line in edges.items()},
        warp=warp,
        panels={
            "left_front": front,
            "left_back": back,
            "right_front": count + front,
            "right_back": count + back,
        },
        source="trousers",
    )
