# SPDX-License-Identifier: LGPL-3.0-or-later
"""Whether a wearer fits into a garment: girths of both at the same heights, edges around limbs.

A tape around the body measures the convex hull of its ellipsoids, one along the cloth the section
of the cells.
"""

from collections.abc import Sequence

import numpy as np

import meshes
from contact.body.segments import Pose
from shellform.motion import anthropometry
from shellform.motion.recording import SIDES
from shellform.motion.wearer import Wearer

OFF = 0.15  # from the wearer's waist to a garment's, at most [m]
LOWER = (0.0, 0.02, 0.04, 0.06, 0.1)  # where a section is open, the next below counts [m]
STRETCH = 0.05  # cloth that must stretch more to reach around the body is refused


def waist_height(wearer: Wearer) -> float:
    """Height [m] of the narrowest place between pelvis and abdomen, where a belt stays."""
    pose = wearer.new_pose(wearer.start)
    which = [wearer.index("pelvis"), wearer.index("abdomen")]
    heights = np.linspace(pose.centres[which[0], 2], pose.centres[which[1], 2], 101)
    girths = [body_girth(wearer, pose, which, height) for height in heights]
    return float(heights[int(np.argmin(girths))])


def check_fit(surface: meshes.Surface, wearer: Wearer) -> None:
    """ValueError if the wearer cannot be inside the garment."""
    pose = wearer.new_pose(wearer.start)
    waist = surface.points[surface.edges["waist"][:, 0]]
    _check_height(surface, wearer)
    k = wearer.index("pelvis")
    if not inside(waist[:, :2], pose.centres[k, :2]):
        raise ValueError(
            f"the waist of {surface.source} does not enclose the wearer's pelvis at "
            f"{np.round(pose.centres[k, :2], 3).tolist()} m: it is centred at "
            f"{np.round(waist[:, :2].mean(axis=0), 3).tolist()} m"
        )
    if {"hem", "hem_2"} <= set(surface.edges):
        raise ValueError(
            f"the two lower openings of {surface.source} are not left and right of its waist: turn "
            "it (turn_deg under [garment]; x is forward, y to the wearer's left, z up)"
        )
    for side in SIDES:
        edge = surface.edges.get(f"{side}_hem")
        if edge is None:
            continue
        hem = surface.points[edge[:, 0]]
        k = wearer.index(f"{side}_shank")
        joint = wearer.recording.points[f"{side}_thigh"][0]
        if hem[:, 2].mean() > joint[0, 2]:
            raise ValueError(
                f"the {side} hem of {surface.source} lies at {hem[:, 2].mean():.2f} m, above the "
                f"wearer's hip joint at {joint[0, 2]:.2f} m: a sleeve is no leg, and what hangs on "
                "the shoulders cannot be put on; take trousers or a skirt, or place the garment "
                "with place_m under [garment]"
            )
        if not inside(hem[:, :2], pose.centres[k, :2]):
            raise ValueError(
                f"the {side} hem of {surface.source} does not enclose the wearer's {side} leg at "
                f"{np.round(pose.centres[k, :2], 3).tolist()} m: give the garment or the stance "
                "another width (a sleeve is no leg), or turn it (turn_deg under [garment]; x is "
                "forward, y left, z up)"
            )
    places, closed = [("hips", "pelvis", np.ones(len(surface.cells), bool))], np.inf
    if {"right_hem", "left_hem"} <= set(surface.edges):
        legs = meshes.regions(surface)
        # below it a leg of the garment goes all around
        closed = surface.points[legs["torso"], 2].min() - 3 * surface.mean_cell_size
        for side in SIDES:
            cells = np.isin(surface.cells, legs[f"{side}_leg"]).all(axis=1)
            places += [(f"{side} {part}", f"{side}_{part}", cells) for part in ("thigh", "shank")]
    for place, name, cells in places:
        k = wearer.index(name)
        level = pose.centres[k, 2] if name == "pelvis" else min(pose.centres[k, 2], closed)
        for lower in LOWER:
            cloth = girth_at(surface, level - lower, cells, pose.centres[k, :2])
            if cloth:
                level -= lower
                break
        body = body_girth(wearer, pose, [k], level)
        if 0 < cloth * (1 + STRETCH) < body:
            raise ValueError(
                f"the wearer measures {body:.3f} m around the {place}, {surface.source} only "
                f"{cloth:.3f} m there: take a larger size, or check the wearer's girths"
            )


def _check_height(surface, wearer):
    """ValueError if the waist of the garment is not where a belt stays."""
    lies = surface.points[np.unique(surface.edges["waist"]), 2].mean()
    stays = waist_height(wearer)
    if abs(lies - stays) > OFF:
        raise ValueError(
            f"the waist of {surface.source} lies at {lies:.2f} m, {abs(lies - stays):.2f} m "
            f"{'above' if lies > stays else 'below'} the wearer's at {stays:.2f} m: make it to the "
            "wearer's height (measures_m waist_height), or move a file's by place_m = [0, 0, "
            f"{stays - lies:.2f}] under [garment]"
        )


def inside(polygon: np.ndarray, point: np.ndarray) -> bool:
    """True if a closed polygon (k, 2) goes around a point (2,)."""
    arms = polygon - point
    after = np.roll(arms, -1, axis=0)
    cross = arms[:, 0] * after[:, 1] - arms[:, 1] * after[:, 0]
    turns = np.arctan2(cross, np.sum(arms * after, axis=1)).sum()
    return abs(turns) > np.pi


def body_girth(wearer: Wearer, pose: Pose, which: Sequence[int], height: float) -> float:
    """Length [m] of a tape around the ellipsoids `which` at a height [m]."""
    return anthropometry.girth(pose.centres[which], pose.axes[which], wearer.radii[which], height)


def girth_at(
    surface: meshes.Surface, height: float, cells: np.ndarray, centre: np.ndarray | None = None
) -> float:
    """Length [m] of the shortest way along the cloth around a point, at a height [m].

    Parameters
    ----------
    cells : mask of the cells that count; centre : (2,) [m], None: the middle of the section

    Returns
    -------
    0 where the cloth does not go all around: below a hem, above a waist, at a slit. Pockets and
    other double cloth do not count twice.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import dijkstra

    corners = surface.cells[cells, : 3 if surface.kind == "triangle" else 4]
    ends = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2)
    z = surface.points[ends, 2] > height
    crossed = z[:, :, 0] != z[:, :, 1]
    pair = ends[crossed.sum(axis=1) == 2][crossed[crossed.sum(axis=1) == 2]]
    if not len(pair):
        return 0.0
    sides, number = np.unique(np.sort(pair, axis=1), axis=0, return_inverse=True)
    low, high = surface.points[sides[:, 0]], surface.points[sides[:, 1]]
    part = (height - low[:, 2]) / (high[:, 2] - low[:, 2])
    places = low + part[:, None] * (high - low)
    one, other = number.reshape(-1, 2).T
    flat = places[:, :2] - (places[:, :2].mean(axis=0) if centre is None else centre)
    length = np.linalg.norm(places[one] - places[other], axis=1) + 1e-15
    # every way is followed on two floors; crossing the ray y = 0, x > 0 changes the floor
    (x1, y1), (x2, y2) = flat[one].T, flat[other].T
    over = (y1 > 0.0) != (y2 > 0.0)
    over &= (x1 * y2 - x2 * y1) * np.where(over, y2 - y1, 1.0) > 0.0
    n, rows, columns = len(places), [], []
    for floor in (0, n):
        rows.append(one + floor)
        columns.append(other + np.where(over, n - floor, floor))
    graph = coo_matrix(
        (np.tile(length, 2), (np.concatenate(rows), np.concatenate(columns))), shape=(2 * n, 2 * n)
    ).tocsr()
    starts = np.unique(one[over])
    if not len(starts):
        return 0.0
    found = dijkstra(graph, directed=False, indices=starts)[np.arange(len(starts)), starts + n]
    return float(found.min()) if np.isfinite(found.min()) else 0.0
