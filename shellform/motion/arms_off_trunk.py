# SPDX-License-Identifier: LGPL-3.0-or-later
"""Arms of a capture held off the trunk, whose ellipsoids they would move into.

Arms that hang press flesh against flesh; rigid ellipsoids pass through each other there, and cloth
between them has no place. Each arm is turned outwards about its shoulder, by one angle for the
whole motion, until from its middle to the wrist it keeps GAP from trunk and legs: swing and bend
stay those of the capture. Nearer to the shoulder arm and trunk overlap, as at any joint.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from contact.body.segment_frame import pose_from_markers
from contact.geometry.ellipsoid import closest_points

from .anthropometry import Ellipsoid
from .recording import SIDES, Recording
from .upper_body import arms_raised

GAP = 0.01  # [m]
FRAMES, PLACES = 40, 7  # looked at in the motion, and along each half of the arm
STEP, MOST = np.radians(1.0), np.radians(45.0)


def arms_off_trunk(recording: Recording, ellipsoids: Sequence[Ellipsoid]) -> Recording:
    """The recording with its arms turned outwards as far as that takes, and a note.

    Parameters
    ----------
    recording : with the upper body; ellipsoids : of all of its segments, rows as for `Wearer`
    """
    count = len(recording.times)
    which = np.unique(np.linspace(0, count - 1, min(count, FRAMES)).round().astype(int))
    few = {name: track[which] for name, track in recording.points.items()}
    points, said = recording.points, []
    trunk = [row for row in ellipsoids if not row[1].endswith(("arm", "foot"))]
    for side in SIDES:
        arm = [row for row in ellipsoids if row[1].startswith(side) and row[1].endswith("arm")]
        angle = 0.0
        while angle < MOST and _gap(arms_raised(few, angle, (side,)), arm, trunk) < GAP:
            angle += STEP
        if angle:
            points = arms_raised(points, angle, (side,))
            said.append(f"the {side} arm by {np.degrees(angle):.0f}")
    if not said:
        return recording
    note = (
        f"arms held off the trunk, whose ellipsoids they overlapped: {' and '.join(said)} degrees"
    )
    return replace(recording, points=points, notes=(*recording.notes, note))


def _gap(points, arm, trunk):
    """Least distance [m] of an arm, from the middle of the upper arm on, from the trunk."""
    places, radii = [], []
    for name, segment, centre, size in arm:
        at, axes = _placed(points[segment], centre)
        part = np.linspace(0.0 if name.endswith("upper_arm") else -0.8, 0.8, PLACES)
        places.append(at[:, None] + (part * size[0])[:, None] * axes[:, None, 0])
        radii.append(np.broadcast_to(size[1] * np.sqrt(1.0 - part**2), places[-1].shape[:2]))
    x, r = np.concatenate(places, axis=1), np.concatenate(radii, axis=1)
    least = np.inf
    for name, segment, centre, size in trunk:
        if name in ("shoulders", "neck"):
            continue
        at, axes = _placed(points[segment], centre)
        for frame in range(len(x)):
            distances = closest_points(x[frame], size, at[frame], axes[frame])[2]
            least = min(least, float((distances - r[frame]).min()))
    return least


def _placed(track, centre):
    """Centres (n, 3) and axes (n, 3, 3) of an ellipsoid on a segment with points (n, 3, 3)."""
    middle, axes = pose_from_markers(track[:, 0], track[:, 1], track[:, 2])
    return middle + np.einsum("i,nij->nj", centre, axes), axes
