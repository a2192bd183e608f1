# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where and how a wearer stands at the start: height of the hips, their middle, heading."""

import numpy as np

from .proportions import ANKLE_UP
from .recording import SIDES
from .wearer import Wearer


def stance(wearer: Wearer) -> tuple[float, np.ndarray, np.ndarray]:
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
