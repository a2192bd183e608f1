# SPDX-License-Identifier: LGPL-3.0-or-later
"""From a scene to its parts: the wearer in motion, the garment where it will be worn, the plan.

Only what the scene asks for is imported, read and made. Everything a user can get wrong about body
and garment is found here, before any computation.
"""

from inspect import signature

import numpy as np

import meshes
from shellform.motion import anthropometry
from shellform.motion.capture.standing_start import lead_in
from shellform.motion.gait.leg import ANKLE_UP
from shellform.motion.gait.synthetic_walk import standing_of, synthetic_walk
from shellform.motion.recording import SIDES, Recording
from shellform.motion.wearer import Wearer
from shellform.results.joint_torque import chosen_parts

from .reach import reachable
from .scene_file import fabric_of

HIP_HEIGHT = 0.918  # of the hip joints of the person that the sizes of trousers fit [m]
NO_MEASURES = ("size", "cell_size")  # of the arguments of trousers
STRETCH = 0.05  # cloth that must stretch more to reach around the body is refused


def wearer_of(scene):
    """Wearer of a scene, who starts from standing.

    Raises
    ------
    ValueError, FileNotFoundError for a capture that cannot be read, or a part of it that is empty
    """
    motion, person = scene.motion, scene.person
    if motion.file == "synthetic":
        recording = synthetic_walk(
            **({} if person.stature is None else {"stature": person.stature}),
            strides=motion.strides,
            obstacle=motion.obstacle,
            obstacle_stride=min(3, motion.strides),
        )
        recording = cut(recording, motion.start, motion.end)
    else:
        from shellform.motion.capture.read_motion import read_motion

        window = None
        if motion.start is not None or motion.end is not None:
            window = (
                -np.inf if motion.start is None else motion.start,
                np.inf if motion.end is None else motion.end,
            )
        recording = read_motion(
            motion.file, motion.map, motion.unit, motion.up, motion.cutoff, motion.max_gap, window
        )
    standing = standing_of(recording)
    if not at_rest(recording, standing):
        recording = lead_in(recording, standing, motion.lead_in)
    wearer = Wearer(recording, ellipsoids_of(scene, recording))
    chosen_parts(wearer, scene.output.parts)  # a joint that is not there is told before dressing
    return wearer


def ellipsoids_of(scene, recording):
    """Ellipsoids of the wearer of a scene who stands in the first frame, as rows for `Wearer`."""
    person = scene.person
    right, left = (recording.points[f"{side}_thigh"][0, 0] for side in SIDES)
    return anthropometry.ellipsoids(
        {name: length for name, (length, _) in recording.lengths().items()},
        stature=person.stature or recording.facts.get("stature"),
        mass=person.mass,
        girths=person.girths or None,
        hip_spacing=float(np.linalg.norm(right - left)),
    )


def dressed_wearer(scene, wearer, surface):
    """The wearer with only the ellipsoids that the garment can come to; the same if these are all.

    What `reachable` leaves out is kept where a table of parts names it.
    """
    near = reachable(wearer, surface, scene.belt)
    names = {wearer.names[k] for k in np.flatnonzero(near)}
    if isinstance(scene.output.parts, dict):
        names |= {name for named in scene.output.parts.values() for name in named}
    return part_of(scene, wearer, names)


def part_of(scene, wearer, names):
    """The wearer with only the ellipsoids of these names; the same if these are all."""
    if set(names) >= set(wearer.names):
        return wearer
    rows = ellipsoids_of(scene, wearer.recording)
    return Wearer(wearer.recording, [row for row in rows if row[0] in names])


def cut(recording, start=None, end=None):
    """Part of a recording between two times [s]; ValueError if that holds less than two frames."""
    times = recording.times
    keep = times >= (-np.inf if start is None else start - 1e-9)
    keep &= times <= (np.inf if end is None else end + 1e-9)
    if keep.sum() < 2:
        raise ValueError(
            f"{recording.source} lasts from {times[0]:.3f} to {times[-1]:.3f} s: motion.start = "
            f"{start} and motion.end = {end} leave less than two frames of it"
        )
    points = {name: track[keep] for name, track in recording.points.items()}
    return Recording(times[keep], points, recording.source, recording.notes, recording.facts)


def at_rest(recording, standing, near=1e-6):
    """True if a recording begins in the standing pose, at rest."""
    return all(
        np.abs(track[:2] - standing[name]).max() < near for name, track in recording.points.items()
    )


def garment_of(scene, wearer):
    """Surface of the garment, where it is worn by the standing wearer.

    Raises
    ------
    ValueError, meshes.MeshError for measures or a file that make no garment, or one that does not
    fit the wearer
    """
    garment = scene.garment
    known = [name for name in signature(meshes.trousers).parameters if name not in NO_MEASURES]
    for name in garment.measures:
        if name not in known:
            raise ValueError(
                f"garment.measures: no '{name}' of trousers; there are {', '.join(known)}"
            )
    height, middle, heading = stance(wearer)
    if garment.file is not None:
        surface = meshes.worn(meshes.load(garment.file, unit=garment.unit), waist=garment.waist)
    elif garment.size is not None:
        surface = meshes.trousers(garment.size, **garment.measures, cell_size=scene.cell_size)
    else:
        scale = height / HIP_HEIGHT
        fitted = {
            name: scale * value
            for name, value in meshes.SIZES["large-regular"].items()
            if name.endswith("_height")
        }
        fitted["waist_height"] = waist_height(wearer) - middle[2] + height
        surface = meshes.trousers(**fitted | garment.measures, cell_size=scene.cell_size)
    cosine, sine = heading[:2]
    turn = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1.0]])
    surface = surface.transform(turn, (*middle[:2], middle[2] - height))
    check_fit(surface, wearer)
    return surface


def stance(wearer):
    """Height of the hip joints over the floor [m], their middle (3,), heading (3,) at the start."""
    points = {name: track[0] for name, track in wearer.recording.points.items()}
    hips = [points[f"{side}_thigh"][0] for side in SIDES]
    middle = np.mean(hips, axis=0)
    leg = np.mean(
        [wearer.recording.lengths()[f"{s}_{p}"][0] for s in SIDES for p in ("thigh", "shank")]
    )
    floor = min(points[f"{side}_shank"][1, 2] for side in SIDES) - ANKLE_UP * 2 * leg
    across = hips[1] - hips[0]  # to the left
    heading = np.array([across[1], -across[0], 0.0])
    return middle[2] - floor, middle, heading / np.linalg.norm(heading)


def waist_height(wearer):
    """Height [m] of the narrowest place between pelvis and abdomen, where a belt stays."""
    pose = wearer.new_pose(wearer.start)
    which = [wearer.index("pelvis"), wearer.index("abdomen")]
    heights = np.linspace(*pose.centres[which, 2], 101)
    girths = [body_girth(wearer, pose, which, height) for height in heights]
    return float(heights[int(np.argmin(girths))])


def check_fit(surface, wearer):
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


def inside(polygon, point):
    """True if a closed polygon (k, 2) goes around a point (2,)."""
    arms = polygon - point
    after = np.roll(arms, -1, axis=0)
    cross = arms[:, 0] * after[:, 1] - arms[:, 1] * after[:, 0]
    turns = np.arctan2(cross, np.sum(arms * after, axis=1)).sum()
    return abs(turns) > np.pi


def body_girth(wearer, pose, which, height):
    """Length [m] of a tape around the ellipsoids `which` at a height [m]."""
    return anthropometry.girth(pose.centres[which], pose.axes[which], wearer.radii[which], height)


def girth_at(surface, height, cells):
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


def fabric(scene):
    """Fabric of a scene."""
    return fabric_of(scene.fabric)
