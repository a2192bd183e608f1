# SPDX-License-Identifier: LGPL-3.0-or-later
"""From where a walker is looked at."""

import numpy as np

from .surfaces import view_axes

VIEW = (-62.0, 10.0)


def fit_view(axes, corners, view=VIEW, margin=0.03):
    """Set the limits of axes to corners (n, 3) [m]."""
    right, up, _ = view_axes(*view)
    for put, direction in ((axes.set_xlim, right), (axes.set_ylim, up)):
        along = corners @ direction
        put(along.min() - margin, along.max() + margin)


def view_from_the_right(wearer):
    """Azimuth and elevation [degrees] of a view from the wearer's right, somewhat in front."""
    ahead = heading_at(wearer, wearer.start)
    return float(np.degrees(np.arctan2(ahead[1], ahead[0]))) + VIEW[0], VIEW[1]


def heading_at(wearer, time):
    """Horizontal direction (3,) that a wearer looks in; +x without both hips."""
    if not {"left_hip", "right_hip"} <= set(getattr(wearer, "joints", ())):
        return np.array([1.0, 0.0, 0.0])
    centres = wearer.new_joints(time).centres
    left = centres[wearer.joints.index("left_hip")] - centres[wearer.joints.index("right_hip")]
    return np.array([left[1], -left[0], 0.0])
