# SPDX-License-Identifier: LGPL-3.0-or-later
"""How a foot goes from footfall to footfall: it rolls over its sole, and swings.

The foot is rigid, in a vertical plane of its own: along (forward) and up. Its pitch is positive
with the toe up. With no toe joint it leaves the floor at 39 degrees, where the hindfoot of a real
one has about 55 and its ankle is at the same height. The sole is a flat between two arcs, the heel
and what lies before the ball, so that the heel and toe rockers of gait (Perry, Gait Analysis, 1992)
are a rolling without slip and without sinking in: the point of contact moves by -R da and the ankle
turns about it. Lengths are those of `proportions`, at a stature of 1.755 m with footwear.

Swings are quintic splines between the states at toe-off and heel strike; with two continuous
derivatives at both, the whole path has them.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BPoly, BSpline, make_interp_spline

from shellform.motion.proportions import ANKLE, HEEL, RIM, TOE

BALL = 0.12  # where the flat ends before the ankle [m]
# (where the arc begins, its radius): an arc rises to RIM over the rest of the foot
HEEL_ARC = (RIM - HEEL, RIM)
TOE_ARC = (BALL, ((TOE - BALL) ** 2 + RIM**2) / (2 * RIM))
STEEPEST = np.arcsin((TOE - BALL) / TOE_ARC[1])  # pitch [rad] at which the toe end touches


def sole(count: int = 41) -> np.ndarray:
    """Outline of the sole (n, 2), along and up from the ankle [m], at a stature of 1.755 m."""
    toe, heel = np.linspace(0, STEEPEST, count), np.linspace(np.pi / 2, 0, count)
    (x1, r1), (x2, r2) = HEEL_ARC, TOE_ARC
    back = np.stack([x1 - r1 * np.sin(heel), r1 - r1 * np.cos(heel)], axis=1)
    front = np.stack([x2 + r2 * np.sin(toe), r2 - r2 * np.cos(toe)], axis=1)
    flat = np.stack([np.linspace(x1, x2, count), np.zeros(count)], axis=1)
    return np.concatenate([back, flat, front]) - [0.0, ANKLE]


def turned(points: np.ndarray, pitch: np.ndarray) -> np.ndarray:
    """Points (n, 2) of the foot at pitches (m,) [rad]: (m, n, 2)."""
    c, s = np.cos(pitch)[:, None], np.sin(pitch)[:, None]
    return np.stack([c * points[:, 0] - s * points[:, 1], s * points[:, 0] + c * points[:, 1]], -1)


def rolled(
    pitch: ArrayLike, rate: ArrayLike = 0.0, change: ArrayLike = 0.0
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Ankle of a foot that rolls on the floor: place, velocity, acceleration, each (..., 2).

    Parameters
    ----------
    pitch, rate, change : pitch [rad] and its time derivatives, at most `STEEPEST` downwards.
        With pitch 0 the ankle is at (0, ANKLE).
    """
    a, da, dda = np.broadcast_arrays(*(np.asarray(v, float) for v in (pitch, rate, change)))
    start, radius = (np.where(a > 0, h, t) for h, t in zip(HEEL_ARC, TOE_ARC, strict=True))
    # from the point of contact to the ankle, in the foot and then turned
    x, z = radius * np.sin(a) - start, ANKLE - radius * (1 - np.cos(a))
    x, z = np.cos(a) * x - np.sin(a) * z, np.sin(a) * x + np.cos(a) * z
    place = np.stack([start - radius * a + x, z], axis=-1)
    velocity = np.stack([-da * z, da * x], axis=-1)
    vx, vz = velocity[..., 0] + radius * da, velocity[..., 1]
    return place, velocity, np.stack([-dda * z - da * vz, dda * x + da * vx], axis=-1)


def spline(
    times: ArrayLike,
    values: ArrayLike,
    start: Sequence[Any] = (0.0, 0.0),
    end: Sequence[Any] | None = None,
) -> BSpline:
    """Quintic spline through values (n, ...) with given first and second derivatives at the ends.

    `end` None leaves the end free (third and fourth derivative zero).
    """
    zero = np.zeros(np.shape(values)[1:])
    first = [(k, zero + value) for k, value in enumerate(start, 1)]
    last = [(3, zero), (4, zero)]
    if end is not None:
        last = [(k, zero + value) for k, value in enumerate(end, 1)]
    return make_interp_spline(times, values, k=5, bc_type=(first, last))


class Footfall(NamedTuple):
    """One contact of a foot with the floor: where and when, and how its pitch goes.

    along, aside : ankle of the flat foot, along the walk and to the left [m]
    strike : time of heel strike [s], -inf for a foot that stands from the beginning
    flat : time from which the foot is flat [s]
    pitches : knots (time [s], pitch [rad]) of its rise, the first 0, the last at toe-off
    """

    along: float
    aside: float
    strike: float
    flat: float
    pitches: tuple

    @property
    def off(self) -> float:
        """Time of toe-off [s]."""
        return self.pitches[-1][0]


class Swing(NamedTuple):
    """What a foot passes between two footfalls: rows of knots, each column after its instant.

    Instants are fractions of the swing, 0 to 1; x along, z up and y aside, to the left, of the
    ankle [m]; pitch [rad].
    """

    x: tuple
    z: tuple
    pitch: tuple
    y: tuple = ((), ())


STRIKE = (np.radians(17.6), np.radians(-365.0), 31.0)  # pitch, its rate [1/s] and change [1/s^2]
OFF_RATE = -5.6  # pitch rate at toe-off [1/s]


def track(
    falls: Sequence[Footfall], swings: Sequence[Swing], times: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Ankle (n, 3) [m] and pitch (n,) [rad] of one foot at times (n,) [s], two derivatives smooth.

    Parameters
    ----------
    falls : list of Footfall, in order; the first one is there from the beginning
    swings : list of Swing, one less: from each footfall to the next
    """
    ankle, pitch = np.zeros((len(times), 3)), np.zeros(len(times))
    for k, fall in enumerate(falls):
        here = (times >= fall.strike) & (times <= fall.off)
        pitch[here] = _stance_pitch(fall, times[here])
        place = rolled(pitch[here])[0]
        ankle[here] = np.stack(
            [fall.along + place[:, 0], np.full(here.sum(), fall.aside), place[:, 1]], axis=1
        )
        if k + 1 == len(falls):
            break
        into, swing = falls[k + 1], swings[k]
        here = (times > fall.off) & (times < into.strike)
        span = into.strike - fall.off
        s = (times[here] - fall.off) / span

        def passed(knots, start, end, s=s, span=span):
            at = np.concatenate([[0.0], knots[0], [1.0]])
            values = np.concatenate([[start[0]], knots[1], [end[0]]])
            scale = (1.0, span, span**2)
            start, end = (
                [d * f for d, f in zip(state, scale, strict=True)] for state in (start, end)
            )
            return spline(at, values, start[1:], end[1:])(s)

        off_pitch = fall.pitches[-1][1]
        start, end = rolled(off_pitch, OFF_RATE), rolled(*STRIKE)
        start[0][0] += fall.along
        end[0][0] += into.along
        pitch[here] = passed(swing.pitch, (off_pitch, OFF_RATE, 0.0), STRIKE)
        for axis, along, knots in ((0, 0, swing.x), (2, 1, swing.z)):
            ends = ([state[along] for state in end_states] for end_states in (start, end))
            ankle[here, axis] = passed(knots, *ends)
        ankle[here, 1] = passed(swing.y, (fall.aside, 0.0, 0.0), (into.aside, 0.0, 0.0))
    return ankle, pitch


def _stance_pitch(fall, times):
    """Pitch (n,) [rad] from heel strike over the flat foot to toe-off."""
    pitch = np.zeros(len(times))
    if np.isfinite(fall.strike):
        down = times < fall.flat
        slap = BPoly.from_derivatives([fall.strike, fall.flat], [STRIKE, (0.0, 0.0, 0.0)])
        pitch[down] = slap(times[down])
    at, values = np.array(fall.pitches).T
    rising = times > at[0]
    pitch[rising] = spline(at, values, end=(OFF_RATE, 0.0))(times[rising])
    return pitch
