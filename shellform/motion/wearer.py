# SPDX-License-Identifier: LGPL-3.0-or-later
"""The wearer: ellipsoids that ride on recorded segments, smooth in time, and their joints, Eq. 17.

Eq. 17 gives every segment a centre and axes in every frame. Between frames the centre and the four
numbers of the unit quaternion run along cubic splines, the latter brought back to unit length: the
frames are met exactly and pose, velocity, spin and their rates are continuous (C2). Semi-axes are
constant: skin motion changes |J2 - J1| by some percent, which moves the centre but no size.

Before the first frame the wearer stands still, after the last one it has stopped for good.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from contact.body.segment_frame import pose_from_markers
from contact.body.segments import Body, Pose
from contact.geometry.ellipsoid import ellipsoid
from contact.kernel import kernel

from .recording import ALL_JOINTS, Recording

# segment axis that a joint bends about, and its sign: flexion (dorsiflexion) is positive
FLEXION = {
    "right_hip": ("pelvis", 2, 1.0),
    "left_hip": ("pelvis", 2, 1.0),
    "right_knee": ("right_thigh", 1, -1.0),
    "left_knee": ("left_thigh", 1, 1.0),
    "right_ankle": ("right_shank", 1, 1.0),
    "left_ankle": ("left_shank", 1, -1.0),
    "lumbar": ("pelvis", 2, -1.0),
    "right_shoulder": ("thorax", 2, 1.0),
    "left_shoulder": ("thorax", 2, 1.0),
    "right_elbow": ("right_upper_arm", 1, 1.0),
    "left_elbow": ("left_upper_arm", 1, -1.0),
}


class Joints(NamedTuple):
    """Where k joints are and how they bend.

    centres (k, 3) [m]; axes (k, 3), unit, of flexion; spins (k, 3) [rad/s], of the segment below
    relative to the one above.
    """

    centres: np.ndarray
    axes: np.ndarray
    spins: np.ndarray


class Wearer(Body):
    """A body in recorded motion: splines through the recording take the place of `Segment`s.

    Parameters
    ----------
    recording : shellform.motion.recording.Recording
    ellipsoids : list of (name, segment, centre (3,) in the segment's axes [m], radii (3,) [m])
    from_rest : bool, the recording begins at rest: so does the spline

    Attributes
    ----------
    names : tuple of str; radii : (m, 3) float [m]
    carriers : tuple of str, the segment each ellipsoid rides on
    joints : tuple of str, those with both segments in the recording
    start, end : float [s], first and last frame

    Raises
    ------
    ValueError for a segment that the recording lacks, a name given twice, semi-axes that make no
    ellipsoid, or points that span no plane

    Examples
    --------
    >>> from shellform.motion.anthropometry import ellipsoids
    >>> walk = sf.synthetic_walk(strides=1, obstacle=0.0)
    >>> wearer = sf.Wearer(walk, ellipsoids(walk.lengths()))
    >>> len(wearer), wearer.just_below("right_knee")
    (8, ['right_shank'])
    >>> pose = wearer.new_pose(wearer.end)
    >>> f"{pose.velocities[wearer.index('pelvis'), 0]:.1f} m/s"
    '1.1 m/s'
    """

    def __init__(
        self,
        recording: Recording,
        ellipsoids: Sequence[tuple[str, str, ArrayLike, ArrayLike]],
        from_rest: bool = True,
    ):
        if not isinstance(recording, Recording):
            raise TypeError(
                f"a Wearer moves as a Recording, as of read_motion(file), not "
                f"{type(recording).__name__}: {recording!r}"
            )
        self.recording = recording
        self.names = tuple(name for name, *_ in ellipsoids)
        self.carriers = tuple(segment for _, segment, *_ in ellipsoids)
        shapes = [ellipsoid(name, radii) for name, *_, radii in ellipsoids]
        self.shapes, self._radii = tuple(shapes), np.array([shape.radii for shape in shapes])
        segments = tuple(recording.points)
        twice = sorted({name for name in self.names if self.names.count(name) > 1})
        if twice:
            raise ValueError(f"ellipsoids need different names, found twice: {', '.join(twice)}")
        for name, segment, *_ in ellipsoids:
            if segment not in segments:
                raise ValueError(
                    f"{recording.source}: ellipsoid '{name}' rides on segment '{segment}', which "
                    f"the recording lacks; it has {', '.join(segments)}"
                )
        self._which = np.array([segments.index(s) for s in self.carriers])
        self._offsets = np.array([centre for _, _, centre, _ in ellipsoids], float)
        known = ALL_JOINTS.items()
        self.joints = tuple(j for j, (a, b, _) in known if a in segments and b in segments)
        self._above = np.array([segments.index(ALL_JOINTS[j][0]) for j in self.joints], np.int64)
        self._below = np.array([segments.index(ALL_JOINTS[j][1]) for j in self.joints], np.int64)
        hinges = [FLEXION[j] for j in self.joints]
        self._hinge = ([segments.index(s) for s, _, _ in hinges], [axis for _, axis, _ in hinges])
        self._sign = np.array([sign for *_, sign in hinges])[:, None]
        times = recording.times
        self.start, self.end = float(times[0]), float(times[-1])
        tracks = [_track(recording, name) for name in segments]
        tracks += [recording.joint_centre(joint) for joint in self.joints]
        values = np.concatenate(tracks, axis=1)
        begin = (1, np.zeros(values.shape[1])) if from_rest else "not-a-knot"
        spline = CubicSpline(times, values, bc_type=(begin, "not-a-knot"))
        self._spline = np.ascontiguousarray(np.moveaxis(spline.c, 0, 2)), times.copy()
        self._values, self._rates = np.zeros(values.shape[1]), np.zeros(values.shape[1])
        self._segments = _blank(len(segments))

    def __len__(self) -> int:
        return len(self.names)

    @property
    def radii(self) -> np.ndarray:
        """Semi-axes (m, 3) [m] of the ellipsoids."""
        return self._radii

    def new_pose(self, t: float = 0.0) -> Pose:
        """Arrays for `pose`, filled at time t [s]."""
        return self.pose(t, _blank(len(self.names)))

    def pose(self, t: float, out: Pose) -> Pose:
        """Pose of the ellipsoids at time t [s], written into arrays from `new_pose`."""
        # arrays one by one: numba takes a fifth of a millisecond to look at tuples of them
        _ride(self._which, self._offsets, *self._segments_at(t), *out)
        return out

    def _segments_at(self, t):
        _evaluate(t, *self._spline, self._values, self._rates)
        _place(self._values, self._rates, *self._segments)
        return self._segments

    def segment_pose(self, t: float, names: Sequence[str]) -> Pose:
        """Pose of segments of the recording at time t [s], by their names; a copy."""
        segments = tuple(self.recording.points)
        which = [segments.index(name) for name in names]
        return Pose(*(array[which] for array in self._segments_at(t)))

    def segments_into(self, t: float, which: np.ndarray, out: Pose) -> Pose:
        """Pose at time t [s] of segments of the recording, by their places in it, into `out`."""
        _pick(which, *self._segments_at(t), *out)
        return out

    def new_joints(self, t: float = 0.0) -> Joints:
        """Arrays for `joint_state`, filled at time t [s]."""
        return self.joint_state(t, Joints(*(np.zeros((len(self.joints), 3)) for _ in range(3))))

    def joint_state(self, t: float, out: Joints) -> Joints:
        """Joints at time t [s], written into arrays from `new_joints`."""
        segments = self._segments_at(t)
        out.centres[:] = self._values[7 * len(segments.centres) :].reshape(-1, 3)
        np.multiply(segments.axes[self._hinge], self._sign, out=out.axes)
        np.subtract(segments.spins[self._below], segments.spins[self._above], out=out.spins)
        return out

    def just_below(self, joint: str) -> list[str]:
        """Names of the ellipsoids on the segment just below a joint."""
        pairs = zip(self.names, self.carriers, strict=True)
        return [name for name, segment in pairs if segment == ALL_JOINTS[joint][1]]

    def below(self, joint: str) -> list[str]:
        """Names of the ellipsoids on the segments below a joint, the far ones included."""
        reached = {ALL_JOINTS[joint][1]}
        for above, under, _ in ALL_JOINTS.values():
            if above in reached:
                reached.add(under)
        return [n for n, s in zip(self.names, self.carriers, strict=True) if s in reached]


def _track(recording, name):
    """Columns (n, 7) of a segment: centre and quaternion, of one sign from frame to frame."""
    points = recording.points[name]
    try:
        centre, axes = pose_from_markers(points[:, 0], points[:, 1], points[:, 2])
    except ValueError as error:
        raise ValueError(f"{recording.source}: segment '{name}': {error}") from None
    turn = Rotation.from_matrix(np.swapaxes(axes, 1, 2)).as_quat()
    flips = np.where(np.sum(turn[1:] * turn[:-1], axis=1) < 0, -1.0, 1.0)
    turn[1:] *= np.cumprod(flips)[:, None]
    return np.hstack([centre, turn])


def _blank(m):
    return Pose(*(np.zeros(shape) for shape in ((m, 3), (m, 3, 3), (m, 3), (m, 3))))


@kernel
def _evaluate(t, coefficients, times, values, rates):
    """All columns of the spline and their rates at t; at rest outside the frames."""
    last = len(times) - 1
    moving = times[0] <= t <= times[last]
    t = min(max(t, times[0]), times[last])
    k = min(np.searchsorted(times, t, side="right") - 1, last - 1)
    h = t - times[k]
    for i in range(len(values)):
        a = coefficients[k, i]
        values[i] = ((a[0] * h + a[1]) * h + a[2]) * h + a[3]
        rates[i] = (3.0 * a[0] * h + 2.0 * a[1]) * h + a[2] if moving else 0.0


@kernel
def _place(values, rates, centres, axes, velocities, spins):
    """Segments' centres, axes (rows), velocities, spins from columns centre and quaternion."""
    for s in range(len(centres)):
        x, y, z, w = values[7 * s + 3], values[7 * s + 4], values[7 * s + 5], values[7 * s + 6]
        rx, ry, rz, rw = rates[7 * s + 3], rates[7 * s + 4], rates[7 * s + 5], rates[7 * s + 6]
        size2 = x * x + y * y + z * z + w * w
        for c in range(3):
            centres[s, c], velocities[s, c] = values[7 * s + c], rates[7 * s + c]
        # spin = 2 q' q* of the unit quaternion; a change of length along q drops out of it
        spins[s, 0] = 2.0 * (w * rx - x * rw + y * rz - z * ry) / size2
        spins[s, 1] = 2.0 * (w * ry - y * rw + z * rx - x * rz) / size2
        spins[s, 2] = 2.0 * (w * rz - z * rw + x * ry - y * rx) / size2
        a = axes[s]
        a[0, 0], a[1, 1] = 1.0 - 2.0 * (y * y + z * z) / size2, 1.0 - 2.0 * (x * x + z * z) / size2
        a[2, 2] = 1.0 - 2.0 * (x * x + y * y) / size2
        a[0, 1], a[1, 0] = 2.0 * (x * y + z * w) / size2, 2.0 * (x * y - z * w) / size2
        a[0, 2], a[2, 0] = 2.0 * (x * z - y * w) / size2, 2.0 * (x * z + y * w) / size2
        a[1, 2], a[2, 1] = 2.0 * (y * z + x * w) / size2, 2.0 * (y * z - x * w) / size2


@kernel
def _pick(which, at, along, speeds, turns, centres, axes, velocities, spins):
    """Segments `which` of all: centres, axes, velocities, spins."""
    for k in range(len(which)):
        s = which[k]
        for c in range(3):
            centres[k, c], velocities[k, c], spins[k, c] = at[s, c], speeds[s, c], turns[s, c]
            for i in range(3):
                axes[k, c, i] = along[s, c, i]


@kernel
def _ride(
    which, offsets, at, along, speeds, turns, centres, axes, velocities, spins
):  # fmt: skip
    """Ellipsoids at `offsets` in the axes of the segments `which` they ride on.

    at, along, speeds, turns : segments' centres, axes, velocities, spins; the rest is filled
    """
    arm = np.empty(3)
    for k in range(len(which)):
        s = which[k]
        for c in range(3):
            arm[c] = 0.0
            for i in range(3):
                arm[c] += offsets[k, i] * along[s, i, c]
                axes[k, c, i] = along[s, c, i]
            spins[k, c] = turns[s, c]
        for c in range(3):
            d, e = (c + 1) % 3, (c + 2) % 3
            centres[k, c] = at[s, c] + arm[c]
            velocities[k, c] = speeds[s, c] + turns[s, d] * arm[e] - turns[s, e] * arm[d]
