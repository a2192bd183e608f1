# SPDX-License-Identifier: LGPL-3.0-or-later
"""The body: named segments in prescribed rigid motion, posed by markers (Eq. 17).

A segment has a constant shape, an ellipsoid or another, and a motion; its motion gives the pose
(centre, axes, velocity of the centre, spin) at any time. Axes are rows e1, e2, e3: local
coordinates are axes @ (x - centre).
"""

from collections.abc import Iterable
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import ArrayLike

from contact.geometry.ellipsoid import Ellipsoid, ellipsoid
from contact.geometry.shape import SHAPES, Shape
from contact.kernel import kernel

from .segment_sets import bits_of

TOLERANCE = 1e-9  # of axes @ axes.T against the identity


class Pose(NamedTuple):
    """Where m segments are and how they move, each array contiguous float.

    centres (m, 3) [m], axes (m, 3, 3) rows e1, e2, e3, velocities (m, 3) of the centres [m/s],
    spins (m, 3) [rad/s].
    """

    centres: np.ndarray
    axes: np.ndarray
    velocities: np.ndarray
    spins: np.ndarray


class Fixed:
    """A pose that never changes.

    Parameters
    ----------
    centre : (3,) float [m]
    axes : (3, 3) float or None, rows e1, e2, e3; None: the world's axes

    Examples
    --------
    >>> import shellform as sf
    >>> centre, axes, velocity, spin = sf.Fixed((0.0, 0.0, -0.2)).pose(1.5)
    >>> centre.tolist(), velocity.tolist()
    ([0.0, 0.0, -0.2], [0.0, 0.0, 0.0])
    """

    moves = False

    def __init__(self, centre: ArrayLike = (0.0, 0.0, 0.0), axes: ArrayLike | None = None):
        self.centre = np.array(centre, float)
        self.axes = np.eye(3) if axes is None else np.array(axes, float)

    def pose(self, t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Centre, axes, velocity, spin at time t [s]."""
        return self.centre, self.axes, np.zeros(3), np.zeros(3)


class Steady(Fixed):
    """Constant velocity of the centre and constant spin.

    Parameters
    ----------
    centre, axes : pose at t = 0, as for `Fixed`
    velocity : (3,) float [m/s]
    spin : (3,) float, in world axes [rad/s]
    """

    moves = True

    def __init__(
        self,
        centre: ArrayLike = (0.0, 0.0, 0.0),
        axes: ArrayLike | None = None,
        velocity: ArrayLike = (0.0, 0.0, 0.0),
        spin: ArrayLike = (0.0, 0.0, 0.0),
    ):
        super().__init__(centre, axes)
        self.velocity = np.array(velocity, float)
        self.spin = np.array(spin, float)

    def pose(self, t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Centre, axes, velocity, spin at time t [s]."""
        axes = turned(self.axes, self.spin * t)
        return self.centre + t * self.velocity, axes, self.velocity, self.spin


class Segment:
    """One rigid part of the body.

    Parameters
    ----------
    name : str
    shape : (3,) float, semi-axes along e1, e2, e3 [m]; or a `contact.geometry.shape.Shape`
    motion : object with pose(t), or a function of t; both return (centre, axes, velocity, spin).
        A motion whose attribute `moves` is False is asked once only.

    Examples
    --------
    >>> import shellform as sf
    >>> def falling(t):
    ...     return (0.0, 0.0, 1.0 - t), np.eye(3), (0.0, 0.0, -1.0), np.zeros(3)
    >>> ball = sf.Segment("ball", (0.1, 0.1, 0.1), falling)
    >>> sf.Body([ball]).new_pose(0.25).centres.tolist()
    [[0.0, 0.0, 0.75]]
    """

    def __init__(self, name: str, shape: Shape | ArrayLike, motion: Any):
        if not (isinstance(name, str) and name):
            raise ValueError(f"a segment needs a name, not {name!r}")
        self.name, self.motion = name, motion
        given = isinstance(shape, SHAPES)
        self.shape: Shape = cast(Shape, shape) if given else ellipsoid(name, cast(ArrayLike, shape))
        self.pose = motion if callable(motion) else motion.pose
        self.moves = getattr(motion, "moves", True)

    @property
    def radii(self) -> np.ndarray:
        """Semi-axes (3,) [m] of an ellipsoid; ValueError for other shapes."""
        if not isinstance(self.shape, Ellipsoid):
            raise ValueError(f"segment '{self.name}' is no ellipsoid but a {self.shape}")
        return np.array(self.shape.radii)


class Body:
    """Named segments; any object with these attributes, new_pose() and pose(t, out) can stand in.

    Parameters
    ----------
    segments : sequence of Segment

    Attributes
    ----------
    names : tuple of str
    shapes : tuple of m `contact.geometry.shape.Shape`
    carriers : tuple of m names of what the segments ride on: those with the same move as one

    Examples
    --------
    >>> import shellform as sf
    >>> head = sf.Segment("head", (0.08, 0.08, 0.12), sf.Fixed((0.0, 0.0, 0.3)))
    >>> chest = sf.Segment("chest", (0.15, 0.12, 0.25), sf.Fixed())
    >>> body = sf.Body([head, chest])
    >>> body.names, body.index("chest")
    (('head', 'chest'), 1)
    """

    def __init__(self, segments: Iterable[Segment]):
        self.segments = tuple(segments)
        if not self.segments:
            raise ValueError("a body needs at least one segment")
        self.names = tuple(segment.name for segment in self.segments)
        twice = sorted({name for name in self.names if self.names.count(name) > 1})
        if twice:
            raise ValueError(f"segments need different names, found twice: {', '.join(twice)}")
        self.shapes = tuple(segment.shape for segment in self.segments)
        self.carriers = self.names
        self._moving = [k for k, segment in enumerate(self.segments) if segment.moves]

    def __len__(self) -> int:
        return len(self.segments)

    @property
    def radii(self) -> np.ndarray:
        """Semi-axes (m, 3) [m] of a body of ellipsoids; ValueError where one is another shape."""
        return np.array([segment.radii for segment in self.segments])

    def index(self, name: str) -> int:
        """Number of the segment called `name`."""
        if name not in self.names:
            raise ValueError(f"no segment '{name}'; there are: {', '.join(self.names)}")
        return self.names.index(name)

    def mask(self, names: Iterable[str]) -> int:
        """Set of the named segments as a whole number, see `contact.body.segment_sets.bits_of`.

        ValueError where a bit stands for others besides.
        """
        bits, which = bits_of(self.carriers), sorted({self.index(name) for name in names})
        out = 0
        for k in which:
            out |= 1 << int(bits[k])
        for k in np.flatnonzero(out >> bits & 1):
            if k not in which:
                raise ValueError(
                    f"of {len(bits)} segments '{self.names[k]}' cannot be told from "
                    f"'{self.names[which[list(bits[which]).index(bits[k])]]}'; name both, or make "
                    "fewer segments"
                )
        return out

    def new_pose(self, t: float = 0.0) -> Pose:
        """Arrays for `pose`, filled at time t [s]; segments at rest are set here for good."""
        m = len(self.segments)
        out = Pose(*(np.zeros(shape) for shape in ((m, 3), (m, 3, 3), (m, 3), (m, 3))))
        return self._fill(range(m), t, out)

    def pose(self, t: float, out: Pose) -> Pose:
        """Pose at time t [s], written into arrays from `new_pose`; returns them.

        Raises
        ------
        ValueError
            When a motion gives a non-finite number or axes that are no rotation.
        """
        return self._fill(self._moving, t, out)

    def _fill(self, which, t, out):
        for k in which:
            centre, axes, velocity, spin = self.segments[k].pose(t)
            out.centres[k], out.axes[k] = centre, axes
            out.velocities[k], out.spins[k] = velocity, spin
        if which:
            self._check(t, out)
        return out

    def _check(self, t, out):
        k, error = _first_bad(*out)
        if k >= 0 and np.isfinite(error):
            raise ValueError(
                f"axes of segment '{self.names[k]}' at t = {t:.6g} s are no right-handed "
                f"orthonormal rows e1, e2, e3 (off by {error:.2g})"
            )
        if k >= 0:
            raise ValueError(f"motion of segment '{self.names[k]}' is not finite at t = {t:.6g} s")

    def accelerations(self, t: float, step: float = 1e-4) -> tuple[np.ndarray, np.ndarray]:
        """Accelerations of the centres (m, 3) [m/s^2] and of the spins (m, 3) [rad/s^2].

        Central differences of the velocities over 2 `step` [s].
        """
        ahead, back = self.new_pose(t + step), self.new_pose(t - step)
        return (
            (ahead.velocities - back.velocities) / (2 * step),
            (ahead.spins - back.spins) / (2 * step),
        )


@kernel
def _first_bad(centres, axes, velocities, spins):
    """First segment whose pose is no rigid motion, or -1, and by how much (NaN: not finite)."""
    for k in range(len(centres)):
        a, error = axes[k], 0.0
        for i in range(3):
            # with e1 x e2 = e3, unit and perpendicular e1, e2 leave nothing else to check
            j, h = (i + 1) % 3, (i + 2) % 3
            error = max(error, abs(a[0, j] * a[1, h] - a[0, h] * a[1, j] - a[2, i]))
        for i in range(2):
            for j in range(2):
                product = a[i, 0] * a[j, 0] + a[i, 1] * a[j, 1] + a[i, 2] * a[j, 2]
                error = max(error, abs(product - (1.0 if i == j else 0.0)))
        for i in range(3):
            number = centres[k, i] + velocities[k, i] + spins[k, i] + a[0, i] + a[1, i] + a[2, i]
            if not np.isfinite(number):
                return k, np.nan
        if not error < TOLERANCE:
            return k, error
    return -1, 0.0


@kernel
def turned(axes: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Rows of axes (3, 3) turned by the rotation vector angle (3,) [rad] (Rodrigues)."""
    size = np.sqrt(angle[0] ** 2 + angle[1] ** 2 + angle[2] ** 2)
    out = axes.copy()
    if size == 0.0:
        return out
    k0, k1, k2 = angle[0] / size, angle[1] / size, angle[2] / size
    cosine, sine = np.cos(size), np.sin(size)
    for i in range(3):
        a0, a1, a2 = axes[i, 0], axes[i, 1], axes[i, 2]
        along = (1.0 - cosine) * (a0 * k0 + a1 * k1 + a2 * k2)
        out[i, 0] = cosine * a0 + along * k0 + sine * (k1 * a2 - k2 * a1)
        out[i, 1] = cosine * a1 + along * k1 + sine * (k2 * a0 - k0 * a2)
        out[i, 2] = cosine * a2 + along * k2 + sine * (k0 * a1 - k1 * a0)
    return out
