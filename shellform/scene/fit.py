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
    k = wearer.index("pelvis")
    if not inside(waist[:, :2], pose.centres[k, :2]):
        raise ValueError(
            f"the waist of {surface.source} does not enclose the wearer's pelvis at "
            f"{np.round(pose.centres[k, :2], 3).tolist()} m: it is centred at "
            f"{np.round(waist[:, :2].mean(axis=0), 3).tolist()} m"
        )
    for side in SIDES:
        edge = surface.edges.get(f"{side}_hem")
        if edge is None:
            continue
        hem = surface.points[edge[:, 0]]
        k = wearer.index(f"{side}_shank")
        if not inside(hem[:, :2], pose.centres[k, :2]):
            raise ValueError(
                f"the {side} hem of {surface.source} does not enclose the wearer's {side} leg at "
                f"{np.round(pose.centres[k, :2], 3).tolist()} m: give the garment or the stance "
                "another width"
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
        body, cloth = body_girth(wearer, pose, [k], level), girth_at(surface, level, cells)
        if 0 < cloth * (1 + STRETCH) < body:
            raise ValueError(
                f"the wearer measures {body:.3f} m around the {place}, {surface.source} only "
                f"{cloth:.3f} m there: take a larger size, or check the wearer's girths"
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


def girth_at(surface: meshes.Surface, height: float, cells: np.ndarray) -> float:
    """Length [m] of the section of the `cells` (mask) at a height [m]; 0 where there is none."""
    corners = surface.cells[cells, : 3 if surface.kind == "triangle" else 4]
    corners = surface.points[corners]
    after = np.roll(corners, -1, axis=1)
    above = corners[:, :, 2] > height
    crossed = above != np.roll(above, -1, axis=1)
    rise = np.where(crossed, after[:, :, 2] - corners[:, :, 2], 1.0)
    part = np.where(crossed, (height - corners[:, :, 2]) / rise, 0.0)[:, :, None]
    places = corners + part * (after - corners)
    twice = crossed.sum(axis=1) == 2
    ends = places[twice][crossed[twice]].reshape(-1, 2, 3)
    return float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum())
