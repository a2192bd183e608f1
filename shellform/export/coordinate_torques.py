# SPDX-License-Identifier: LGPL-3.0-or-later
"""Angles of a gait model's coordinates and the clothing's torque along each.

The torque of a coordinate is its virtual work: that of all that acts below the joint, along the
axis about which the coordinate turns. A hip turns about three: to the right in the pelvis, ahead as
flexion has left it, up in the thigh (`motion.joint_coordinates`, in OpenSim's order). Knees and
ankles of gait models are hinges: the torque is that about the wearer's axis of flexion.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from shellform.motion.joint_coordinates import coordinates
from shellform.motion.recording import JOINTS, Recording
from shellform.motion.wearer import Wearer

from .opensim_names import PELVIS, Coordinate, to_ground


def angles(
    recording: Recording, chosen: tuple[Coordinate, ...], hips: ArrayLike
) -> dict[str, np.ndarray]:
    """Coordinates of the pelvis and the joints in n frames, name -> (n,) [rad], [m].

    hips : (3,) [m], middle of the hips in the model's pelvis, ahead, up, right. The pelvis is put
    where its hips have their middle in that of the wearer's, along the ground's axes.
    """
    # axes of the world in place of a heading, which then is in the pelvis's turn
    turns = coordinates(recording.points, np.eye(3)).angles
    tilt, lean, turn = turns["pelvis"].T
    found = dict(zip(PELVIS, (-tilt, lean, turn), strict=True))
    upright = Rotation.from_euler("ZXY", np.stack([found[name] for name in PELVIS], axis=1))
    ground = to_ground(recording.points["pelvis"][:, 1]) - upright.apply(np.asarray(hips))
    found |= {f"pelvis_t{axis}": ground[:, k] for k, axis in enumerate("xyz")}
    for c in chosen:
        segment = JOINTS[c.joint][1]
        if segment in turns:
            found[c.name] = c.sign * turns[segment][:, c.turn]
    return found


def coordinate_torques(
    wearer: Wearer, times: np.ndarray, torques: np.ndarray, chosen: tuple[Coordinate, ...]
) -> dict[str, np.ndarray]:
    """Torque of the clothing along coordinates, name -> (n,) [N m].

    torques : (n, k, 3) [N m] about the wearer's joints, see `segment_loads.joint_torques`
    """
    found = {c.name: np.empty(len(times)) for c in chosen if c.joint in wearer.joints}
    joints = wearer.new_joints()
    for i, time in enumerate(times.tolist()):
        flexion = wearer.joint_state(time, joints).axes.copy()
        for c in chosen:
            if c.joint not in wearer.joints:
                continue
            k = wearer.joints.index(c.joint)
            axis = flexion[k]
            if c.turn:
                axis = _hip_axis(wearer, time, c)
            found[c.name][i] = c.sign * torques[i, k] @ axis
    return found


def _hip_axis(wearer, time, coordinate):
    """Axis of abduction outward (1) or of rotation about up (2) of a hip."""
    above, below, _ = JOINTS[coordinate.joint]
    pose = wearer.segment_pose(time, (above, below))
    right, up = pose.axes[0, 2], -pose.axes[1, 0]  # of the pelvis, of the thigh
    if coordinate.turn == 2:
        return up
    ahead = np.cross(up, right)
    ahead /= np.linalg.norm(ahead)
    return ahead if coordinate.joint.startswith("left") else -ahead
