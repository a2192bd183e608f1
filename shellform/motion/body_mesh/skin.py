# SPDX-License-Identifier: LGPL-3.0-or-later
"""A wearer's skin: a body of triangles at the wearer's size, carried by the recorded segments.

The body is bound in the standing pose, placed on the joints there, brought to the girths, and its
weights are those of `rigging`, smooth between the legs. Calf and thigh meet behind the knee as
flesh (`contact.body.skinning`), and bulge as joints bend (`bulging`).
"""

from collections.abc import Mapping

import numpy as np

from contact.body.segment_frame import pose_from_markers
from contact.body.segments import Pose
from contact.body.skinned_surface import Bend, SkinnedSurface
from shellform.motion.gait.standing_pose import standing_of
from shellform.motion.proportions import STATURE
from shellform.motion.recording import SEGMENTS, SIDES
from shellform.motion.wearer import Wearer

from .between_legs import SKIN, WEIGHTS, between_legs
from .bulging import bulge_of
from .coarse import coarse_ends
from .fitting import fitted
from .lower_body import lower_body
from .placing import MIDDLE, placed
from .rigging import weights_of
from .surface import BodySurface

DRAWN = 4  # times that weights are drawn smooth
# where thighs may meet, at a stature of STATURE [m]: from the middle plane, above the knee centres;
# the skin that follows the thigh by the first part is not pressed, by the second wholly
BETWEEN, OVER_KNEE, SHARE = 0.060, 0.165, (0.5, 0.8)


def skin_of(
    wearer: Wearer, body: BodySurface, stature: float, girths: Mapping[str, float] | None = None
) -> SkinnedSurface:
    """Skin of a wearer, on the segments of the recording that a body has.

    Parameters
    ----------
    wearer : Wearer; body : whole, as of `template` or `scan`
    stature : of the wearer [m]; girths : those of `girths.NAMES` that are asked for [m], others
        stay as the body has them

    Raises
    ------
    ValueError where the body has no legs that can be measured, or cannot be brought to the girths
    """
    points = standing_of(wearer.recording)
    standing = placed(coarse_ends(lower_body(body)), points, stature)
    smooth = between_legs(standing, SKIN)
    if girths:
        standing, _ = fitted(standing, girths, smooth)
    names = tuple(name for name in SEGMENTS if name in wearer.recording.points)
    weights = weights_of(standing)
    drawn = between_legs(standing, WEIGHTS)
    for _ in range(DRAWN):
        weights = drawn @ weights
    for side in SIDES:  # a recording may lack feet
        if f"{side}_foot" not in names:
            weights[:, SEGMENTS.index(f"{side}_shank")] += weights[
                :, SEGMENTS.index(f"{side}_foot")
            ]
    weights = weights[:, [SEGMENTS.index(name) for name in names]]
    frames = [pose_from_markers(*points[name]) for name in names]
    still = np.zeros((len(names), 3))
    bound = Pose(
        np.array([centre for centre, _ in frames]), np.array([axes for _, axes in frames]),
        still, still,
    )  # fmt: skip
    which = np.array([list(wearer.recording.points).index(name) for name in names])
    marks = standing.landmarks
    knees = [
        Bend(
            f"{side}_thigh", f"{side}_shank",
            *(marks[f"{side}_{joint}"] for joint in ("knee", "hip", "ankle")),
        )
        for side in SIDES
    ]  # fmt: skip
    drawing = smooth.indptr, smooth.indices, smooth.data
    return SkinnedSurface(
        standing.points,
        standing.triangles,
        weights,
        names,
        lambda t, out: wearer.segments_into(t, which, out),
        bound,
        [*knees, *_thighs(standing, weights, names)],
        drawing,
        bulge_of(standing, weights, names, bound, knees, drawing),
    )


def _thighs(standing, weights, names):
    """The thighs as flesh that meets at the plane halfway between them: none or one `Bend`."""
    thighs = [f"{side}_thigh" for side in ("left", "right")]
    scale, marks = standing.stature / STATURE, standing.landmarks
    arm, share = standing.points - standing.middle, np.zeros(len(weights))
    for thigh, sign in zip(thighs, (1.0, -1.0), strict=True):
        own = sign * (arm @ standing.left) > 0.0
        share[own] = weights[own, names.index(thigh)]
    knees = max(marks["left_knee"][2], marks["right_knee"][2])
    low = (standing.points[:, 2] > knees + OVER_KNEE * scale) & (arm[:, 2] < 0.0)
    medial = low & (np.abs(arm @ standing.left) < BETWEEN * scale)
    parts = np.clip((share - SHARE[0]) / (SHARE[1] - SHARE[0]), 0.0, 1.0) * medial
    centre = standing.middle
    ends = centre + standing.left, centre - standing.left
    return [Bend(*thighs, centre, *ends, margin=MIDDLE * scale, near=0.9, room=0.002, parts=parts)]
