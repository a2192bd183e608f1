# SPDX-License-Identifier: LGPL-3.0-or-later
"""The wearer of a scene: a captured or a synthetic motion, and ellipsoids of the person's size.

Only what the scene asks for is imported, read and made. A motion that does not begin at rest is led
into from standing; what of the body the garment cannot come to is left out.
"""

from collections.abc import Collection, Mapping

import numpy as np

from meshes import Surface
from shellform.errors import Mendable
from shellform.motion import anthropometry
from shellform.motion.capture.gait_initiation import gait_initiation
from shellform.motion.capture.options import IN_SCENE, options_of
from shellform.motion.gait.standing_pose import standing_of
from shellform.motion.gait.synthetic_walk import synthetic_walk
from shellform.motion.joint_parts import chosen_parts
from shellform.motion.proportions import STATURE
from shellform.motion.recording import SIDES, Recording
from shellform.motion.wearer import Wearer

from .reach import reachable
from .scene import Scene
from .shoulders import belt_of, hangs_on_shoulders, pattern_read

HELD_UP, LET_DOWN = 0.3, 0.9  # s, that arms are held up in a new shirt, and let down in


def wearer_of(scene: Scene) -> Wearer:
    """Wearer of a scene, who starts from standing.

    Raises
    ------
    ValueError, FileNotFoundError for a capture that cannot be read, or a part of it that is empty
    """
    motion, person = scene.motion, scene.person
    shoulders = hangs_on_shoulders(scene.garment)
    if shoulders:
        _check_shoulders(scene)
    if motion.file == "synthetic":
        recording = synthetic_walk(
            stature=STATURE if person.stature is None else person.stature,
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
        try:
            recording = read_motion(
                motion.file, window=window, **options_of(motion), upper=shoulders
            )
        except Mendable as error:
            raise Mendable(error.fact, error.mend, IN_SCENE) from None
    standing = standing_of(recording)
    if shoulders:
        recording, standing = _with_upper_body(scene, recording, standing)
    if not at_rest(recording, standing):
        recording = gait_initiation(recording, standing, motion.initiation)
    wearer = Wearer(recording, ellipsoids_of(scene, recording))
    chosen_parts(wearer, scene.output.parts)  # a joint that is not there is found before dressing
    return wearer


def _check_shoulders(scene):
    """ValueError for what garments that hang on the shoulders cannot have here."""
    hangs = f"{scene.garment.file} hangs on the shoulders"
    if scene.person.body != "ellipsoids":
        raise ValueError(
            f"person.body = {str(scene.person.body)!r}: bodies of triangles end at the waist here, "
            f"and {hangs}: leave person.body out"
        )
    if scene.steps.dressing == "particles":
        raise ValueError(
            f"steps.dressing = 'particles': {hangs}, where masses and springs fold it under the "
            "arms: take 'shell'"
        )


def _with_upper_body(scene, recording, standing):
    """Recording and standing pose with trunk and arms, for a garment that hangs on these."""
    # only here: other wearers have none
    from shellform.motion.arms_off_trunk import arms_off_trunk
    from shellform.motion.upper_body import neutral, with_upper_body

    stature = scene.person.stature or recording.facts.get("stature")
    recording = with_upper_body(recording, stature)
    recording = arms_off_trunk(recording, ellipsoids_of(scene, recording))
    upper = neutral({name: points[None] for name, points in standing.items()}, stature)
    return recording, {**standing, **{name: track[0] for name, track in upper.items()}}


def dressing_wearer(scene: Scene, wearer: Wearer, end: float | None = None) -> Wearer:
    """The wearer of a shirt, who stands and lets the arms down from where its sleeves are sewn.

    wearer : with trunk and arms; end : time [s] at which the arms are down, None: first frame
    """
    # only here, as above
    from meshes.patterns.placing import sleeve_angle
    from shellform.motion.arm_lowering import arms_lowered
    from shellform.motion.upper_body import abduction

    first = {name: track[0] for name, track in wearer.recording.points.items()}
    angle = sleeve_angle(pattern_read(scene.garment)) - abduction(first)
    end = wearer.start if end is None else end
    lowered = arms_lowered(wearer.recording, angle, end, HELD_UP, LET_DOWN)
    rows = ellipsoids_of(scene, wearer.recording)
    return Wearer(lowered, [row for row in rows if row[0] in wearer.names])


def ellipsoids_of(scene: Scene, recording: Recording) -> list[anthropometry.Ellipsoid]:
    """Ellipsoids of the wearer of a scene who stands in the first frame, as rows for `Wearer`."""
    person = scene.person
    girths = dict(person.girths)
    if person.body != "ellipsoids":
        girths.pop("knee", None)  # which ellipsoids have not
    right, left = (recording.points[f"{side}_thigh"][0, 0] for side in SIDES)
    lengths = {name: length for name, (length, _) in recording.lengths().items()}
    stature, above = person.stature or recording.facts.get("stature"), []
    if "thorax" in lengths:
        # only here: other wearers have no upper body
        from shellform.motion.upper_anthropometry import GIRTHS, upper_ellipsoids

        upper = {name: girths.pop(name) for name in GIRTHS if name in girths}
        above = upper_ellipsoids(lengths, stature, person.mass, upper)
    lower = anthropometry.ellipsoids(
        lengths,
        stature=stature,
        mass=person.mass,
        girths=girths or None,
        hip_spacing=float(np.linalg.norm(right - left)),
    )
    return [*lower, *above]


def dressed_wearer(scene: Scene, wearer: Wearer, surface: Surface) -> Wearer:
    """The wearer with only the ellipsoids that the garment can come to; the same if these are all.

    What `reachable` leaves out is kept where a table of parts names it. A body of triangles stays
    whole: its segments are those of the skin.
    """
    if scene.person.body != "ellipsoids":
        return wearer
    near = reachable(wearer, surface, belt_of(scene.belt, scene.garment))
    names = {wearer.names[k] for k in np.flatnonzero(near)}
    if isinstance(scene.output.parts, dict):
        names |= {name for named in scene.output.parts.values() for name in named}
    return part_of(scene, wearer, names)


def part_of(scene: Scene, wearer: Wearer, names: Collection[str]) -> Wearer:
    """The wearer with only the ellipsoids of these names; the same if these are all."""
    if set(names) >= set(wearer.names):
        return wearer
    rows = ellipsoids_of(scene, wearer.recording)
    return Wearer(wearer.recording, [row for row in rows if row[0] in names])


def cut(recording: Recording, start: float | None = None, end: float | None = None) -> Recording:
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


def at_rest(recording: Recording, standing: Mapping[str, np.ndarray], near: float = 1e-6) -> bool:
    """True if a recording begins in the standing pose, at rest."""
    return all(
        np.abs(track[:2] - standing[name]).max() < near for name, track in recording.points.items()
    )
