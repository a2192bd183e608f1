# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a captured or made-up motion hands to the body: J1, J2, M of every segment, Eq. 17.

Frames in order, world axes right-handed with z up, SI units. Segments of the lower body and the
meaning of their three points:

    segment               J1               J2               M
    pelvis                top, mid pelvis  mid hip centres  in front (mid ASIS)
    right_, left_thigh    hip centre       knee centre      lateral of the knee
    right_, left_shank    knee centre      ankle centre     lateral of the ankle
    right_, left_foot     heel             toe end          lateral of the toe end

so e1 runs down (forward in the foot) and e2 forward in the pelvis, outward in the legs. A recording
may lack feet, and holds those of the upper body only for garments that hang on it:

    thorax                mid C7, jugulum  mid T10, xiphoid in front (of the jugulum)
    right_, left_upper_arm  shoulder       elbow centre     lateral of the elbow
    right_, left_forearm  elbow centre     wrist centre     lateral of the elbow
"""

from dataclasses import dataclass, field

import numpy as np

SIDES = ("right", "left")
LEGS = tuple(f"{side}_{part}" for side in SIDES for part in ("thigh", "shank", "foot"))
SEGMENTS = ("pelvis", *LEGS)
ARMS = tuple(f"{side}_{part}" for side in SIDES for part in ("upper_arm", "forearm"))
UPPER_SEGMENTS = ("thorax", *ARMS)

# joint: the segment above, the one below, and whose point J1 (0) or J2 (1) is the centre
JOINTS = {}
for _side in SIDES:
    _thigh, _shank, _foot = (f"{_side}_{part}" for part in ("thigh", "shank", "foot"))
    JOINTS[f"{_side}_hip"] = ("pelvis", _thigh, (_thigh, 0))
    JOINTS[f"{_side}_knee"] = (_thigh, _shank, (_shank, 0))
    JOINTS[f"{_side}_ankle"] = (_shank, _foot, (_shank, 1))
# of the upper body; the trunk turns against the pelvis at the top of this
UPPER_JOINTS = {"lumbar": ("pelvis", "thorax", ("pelvis", 0))}
for _side in SIDES:
    _arm, _forearm = (f"{_side}_{part}" for part in ("upper_arm", "forearm"))
    UPPER_JOINTS[f"{_side}_shoulder"] = ("thorax", _arm, (_arm, 0))
    UPPER_JOINTS[f"{_side}_elbow"] = (_arm, _forearm, (_forearm, 0))
ALL_JOINTS = JOINTS | UPPER_JOINTS  # each after those above it


@dataclass(frozen=True, eq=False)
class Recording:
    """Tracks of the three points of every segment.

    Parameters
    ----------
    times : (n,) float [s], rising, evenly spaced
    points : dict, segment -> (n, 3, 3) float [m]: frame, point (J1, J2, M), coordinate
    source : str, file or generator, for messages
    notes : tuple of str, what was detected and repaired on the way
    facts : dict of what the source knows, as "stride_length" [m], "cadence" [steps/min],
        "stature" [m], "events": (name, time) pairs
    first_frame : int, the first frame of the motion itself; those before it lead into it

    Raises
    ------
    ValueError for times that do not rise, points of another shape or missing, no such first frame
    """

    times: np.ndarray
    points: dict
    source: str = "recording"
    notes: tuple = ()
    facts: dict = field(default_factory=dict)
    first_frame: int = 0

    def __post_init__(self):
        times = np.asarray(self.times, float)
        if times.ndim != 1 or len(times) < 2 or not (np.diff(times) > 0).all():
            raise ValueError(f"{self.source}: times must rise over at least two frames")
        if not 0 <= self.first_frame < len(times):
            raise ValueError(
                f"{self.source}: the first frame is one of 0 to {len(times) - 1}, not "
                f"{self.first_frame}"
            )
        for name, track in self.points.items():
            if np.shape(track) != (len(times), 3, 3):
                raise ValueError(
                    f"{self.source}: points of '{name}' have shape {np.shape(track)}, not "
                    f"({len(times)}, 3, 3)"
                )
            if not np.isfinite(track).all():
                frame = int(np.argwhere(~np.isfinite(track))[0, 0])
                raise ValueError(
                    f"{self.source}: a point of '{name}' is missing at t = {times[frame]:.3f} s"
                )

    @property
    def rate(self) -> float:
        """Frames a second [Hz]."""
        return (len(self.times) - 1) / (self.times[-1] - self.times[0])

    def joint_centre(self, joint: str) -> np.ndarray:
        """Track (n, 3) of a joint's centre [m]."""
        segment, end = ALL_JOINTS[joint][2]
        return self.points[segment][:, end]

    def lengths(self) -> dict[str, tuple[float, float]]:
        """Length |J2 - J1| [m] of every segment, (median, relative spread max - min)."""
        out = {}
        for name, track in self.points.items():
            length = np.linalg.norm(track[:, 1] - track[:, 0], axis=1)
            out[name] = (float(np.median(length)), float(np.ptp(length) / np.median(length)))
        return out
