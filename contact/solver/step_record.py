# SPDX-License-Identifier: LGPL-3.0-or-later
"""The records that the kernels of contact share: what holds for a step, and what a node keeps.

Kernels get these instead of long lists of arguments. A record is made once and filled anew.
"""

import numpy as np

from .friction import PARAMETERS, Friction

# one record for all nodes: the settings of the step, its counts, and the work on one node
STEP = np.dtype(
    [
        # settings
        ("dt", float),  # [s]
        ("friction", float, PARAMETERS),  # numbers of the law, see friction.py
        ("offset", float),  # from the skin at which cloth is held [m]
        ("recovery_speed", float),  # greatest of a node that is moved out of a body [m/s]
        ("recovery", float),  # way out of a body in one step for a node that starts inside [m]
        ("flesh", float),  # stiffness of soft segments over areal mass [1/s^2], see soft_contact.py
        ("bed", float),  # stiffness of one segment as a bed of the cloth [Pa/m]; 0: not asked for
        # motion of the body
        ("path", float),  # way of the surfaces in all steps before [m]
        ("motion", float),  # most that any surface point moves in this one [m]
        # frame in which ways are measured: goes along with a surface of triangles, else at rest
        ("frame", float, 3),  # its origin at the start of the step [m]
        ("shift", float, 3),  # its way in this one [m]
        ("thinnest", float),  # smallest inner radius of all segments [m]
        # counts and greatest depths of all nodes
        ("evaluated", np.int64),  # closest points
        ("active", np.int64),  # nodes in contact
        ("sticking", np.int64),  # of these in stick
        ("pinched", np.int64),  # nodes in soft segments, or left no room by hard ones
        ("max_depth", float),  # of a start below the offset surface [m]
        ("pinch_depth", float),  # the same of pinched nodes [m]
        # the node at work: steps [m]
        ("kick", float, 3),  # change of velocity by the forces of this step [m/s]
        ("free", float, 3),  # step without contact
        ("step", float, 3),  # step as corrected so far
        ("at", float, 3),  # where the path has come to
        ("tau", float),  # fraction of the step at that place
        ("trial", float, 3),  # step with friction, before normals
        ("change", float, 3),  # of the velocity by contact [m/s]
        ("impulse", float, 3),  # of one plane [N s]
        ("beds", float),  # stiffness of the segments that press it from opposite sides [Pa/m]
        ("clearance", float),  # what is left of the node's clearance [m], see broad_phase.py
        # the node at work: planes found
        ("count", np.int64),  # of hard segments
        ("soft", np.int64),  # of soft segments
        ("pushing", np.int64),  # planes that push, or PINCHED
        ("first", np.int64),  # plane of the segment touched last, or -1
        ("inside", np.int64),  # planes found last that have the node deep inside
        ("stick", np.bool_),
        ("depth", float),  # of the start [m]
        ("roundoff", float),  # of the distances [m]
    ],
    align=True,
)

# what nodes keep from step to step: rows of whole numbers (SETS, n), of floats (LOOK, n) and guards
# (n, GUARDS, GUARD), so that the loop over all nodes reads no more than it needs
ALLOWED = 0  # set of segments a node can touch
FAR = 1  # set of segments that were not near, see broad_phase.py
SEGMENT_TOUCHED = 2  # in the last step, -1: none
PENETRATED = 3  # set of soft segments it lies in
SETS = 4
LOOK = 5  # place where distances were measured (3) [m]; clearance, way of the surfaces [m]
GUARDS, GUARD = 2, 5  # see guard_planes.py

# the node at work where several segments may hold it
NODE = np.dtype(
    [("allowed", np.int64), ("far", np.int64), ("segment", np.int64), ("penetrated", np.int64)],
    align=True,
)


def step_record(friction: Friction, offset: float) -> np.ndarray:
    """Record (1,) STEP with its settings; dt and recovery are those of a step."""
    record = np.zeros(1, STEP)
    record["offset"], record["flesh"] = offset, np.inf
    set_friction(record, friction)
    return record


def set_friction(record: np.ndarray, friction: Friction) -> None:
    """Put the numbers of a law into a record (1,) STEP."""
    record["friction"] = 0.0
    record["friction"][0, : len(friction.parameters)] = friction.parameters
