# SPDX-License-Identifier: LGPL-3.0-or-later
"""From where a walker is looked at."""

from typing import Any

import numpy as np

from contact.body.segments import Body
from shellform.motion.wearer import Wearer

from .surfaces import view_axes

VIEW = (-62.0, 10.0)  # azimuth, elevation [degrees]


def fit_view(
    axes: Any, corners: np.ndarray, view: tuple[float, float] = VIEW, margin: float = 0.03
) -> None:
    """Set the limits of axes to corners (n, 3) [m]."""
    right, up, _ = view_axes(*view)
    for put, direction in ((axes.set_xlim, right), (axes.set_ylim, up)):
        along = corners @ direction
        put(along.min() - margin, along.max() + margin)


def view_from_the_right(wearer: Wearer) -> tuple[float, float]:
    """Azimuth and elevation [degrees] of a view from the wearer's right, somewhat in front."""
    ahead = heading_at(wearer, wearer.start)
    return float(np.degrees(np.arctan2(ahead[1], ahead[0]))) + VIEW[0], VIEW[1]


def heading_at(wearer: Body | Wearer, time: float) -> np.ndarray:
    """Horizontal direction (3,) that a wearer looks in; +x without both hips."""
    if not isinstance(wearer, Wearer) or not {"left_hip", "right_hip"} <= set(wearer.joints):
        return np.array([1.0, 0.0, 0.0])
    centres = wearer.new_joints(time).centres
    hips = (centres[wearer.joints.index(f"{side}_hip")] for side in ("left", "right"))
    to_left = np.subtract(*hips)
    return np.array([to_left[1], -to_left[0], 0.0])
