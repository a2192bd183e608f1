# SPDX-License-Identifier: LGPL-3.0-or-later
"""A wearer's skin: a body of triangles at the wearer's size, carried by the recorded segments.

The body is bound in the standing pose, placed on the joints there, brought to the girths, and its
weights are those of `rigging`, smooth between the legs. Calf and thigh meet behind the knee as
flesh (`contact.body.skinning`).
"""

from collections.abc import Mapping

import numpy as np

from contact.body.segment_frame import pose_from_markers
from contact.body.segments import Pose
from contact.body.skinned_surface import Bend, SkinnedSurface
from shellform.motion.gait.standing_pose import standing_of
from shellform.motion.recording import SEGMENTS, SIDES
from shellform.motion.wearer import Wearer

from .between_legs import SKIN, WEIGHTS, between_legs
from .fitting import fitted
from .lower_body import lower_body
from .placing import placed
from .rigging import weights_of
from .surface import BodySurface

DRAWN = 4  # times that weights are drawn smooth


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
    standing = placed(lower_body(body), points, stature)
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
    return SkinnedSurface(
        standing.points,
        standing.triangles,
        weights,
        names,
        lambda t, out: wearer.segments_into(t, which, out),
        bound,
        knees,
        (smooth.indptr, smooth.indices, smooth.data),
    )
