# SPDX-License-Identifier: LGPL-3.0-or-later
"""Names, signs and axes of OpenSim's gait models for segments, joints and the ground.

OpenSim's ground has x ahead, y up and z to the right, and so has every body of gait2392 and of
Rajagopal's model when it stands. Coordinates of both are called alike, but a knee that bends is
negative in gait2392 (Delp and others, IEEE Trans. Biomed. Eng. 37, 1990) and positive in Rajagopal
and others (IEEE Trans. Biomed. Eng. 63, 2016). Pelvis and hips turn about z, then about x, then
about y, each as the one before has left it; of knees and ankles z stands for the hinge.
"""

from dataclasses import dataclass

import numpy as np

from shellform.motion.recording import JOINTS, SIDES

GROUND = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # rows x, y, z
BODIES = {"pelvis": "pelvis"} | {
    f"{side}_{segment}": f"{body}_{side[0]}"
    for side in SIDES
    for segment, body in (("thigh", "femur"), ("shank", "tibia"), ("foot", "calcn"))
}
PELVIS = ("pelvis_tilt", "pelvis_list", "pelvis_rotation")
MODELS = ("rajagopal", "gait2392")


@dataclass(frozen=True)
class Coordinate:
    """A coordinate of a joint.

    name : in the model; joint : see `JOINTS`
    turn : 0 flexion (upwards of an ankle), 1 abduction outward, 2 rotation about the upward axis
    sign : of the model's angle against that
    """

    name: str
    joint: str
    turn: int
    sign: float


def coordinates_of(model: str) -> tuple[Coordinate, ...]:
    """Coordinates of hips, knees and ankles.

    Parameters
    ----------
    model : one of MODELS

    Raises
    ------
    ValueError for another model

    Examples
    --------
    >>> [c.name for c in coordinates_of("gait2392")][:3]
    ['hip_flexion_r', 'hip_adduction_r', 'hip_rotation_r']
    """
    if model not in MODELS:
        raise ValueError(f"there are names for the models {' and '.join(MODELS)}, not '{model}'")
    knee = -1.0 if model == "gait2392" else 1.0
    found = []
    for joint in JOINTS:
        side, kind = joint.split("_")
        inward = 1.0 if side == "right" else -1.0  # a turn about up
        rows = {
            "hip": [("hip_flexion", 1.0), ("hip_adduction", -1.0), ("hip_rotation", inward)],
            "knee": [("knee_angle", knee)],
            "ankle": [("ankle_angle", 1.0)],
        }[kind]
        found += [Coordinate(f"{n}_{side[0]}", joint, k, s) for k, (n, s) in enumerate(rows)]
    return tuple(found)


def to_ground(vectors: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) of shellform's axes along those of OpenSim's ground."""
    return vectors @ GROUND.T
