# SPDX-License-Identifier: LGPL-3.0-or-later
"""The steps of a synthetic walk: where and when each foot comes down, and how it gets there.

Numbers are for a stature of 1.755 m; their sources stand in `synthetic_walk`.
"""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from shellform.motion.proportions import HEEL, HIP_SPACING, SIGN, TOE
from shellform.motion.recording import SIDES

from .footfall import Footfall, Swing
from .obstacle_crossing import LEAD, TRAIL, Crossing

STEP, STEP_TIME = 0.66, 0.545  # [m], [s]
SUPPORT = 0.090  # both feet on the floor after a heel strike [s]
FLAT, RISE = 0.095, 0.258  # flat after heel strike; heel off before toe-off [s]
OFF = np.radians(-38.5)  # pitch at toe-off, of a foot without a toe joint
FIRST_STEP, FIRST_TIME, FIRST_OFF, FIRST_RISE = 0.55, 0.95, 0.42, 0.26  # from standing
FIRST_PITCH = np.radians(-34.0)
# swing of a level stride: instants, places as part of the stride or heights [m], pitches
SWING_X = ((0.25, 0.52, 0.78), (0.195, 0.529, 0.907))
SWING_Z = ((0.20, 0.60, 0.85), (0.254, 0.110, 0.096))
SWING_PITCH = ((0.2, 0.5, 0.8), tuple(np.radians((-75.0, -28.0, 16.5))))
FIRST_Z = ((0.20, 0.60, 0.85), (0.195, 0.125, 0.105))
FIRST_PITCHES = ((0.2, 0.5, 0.8), tuple(np.radians((-46.0, -12.0, 16.5))))
LOWEST = 0.10  # the feet go over a lower obstacle as over this one [m]


class Footsteps(NamedTuple):
    """Steps of a walk at a stature of 1.755 m: arrays with step 0 the foot that stands first.

    side : tuple of str; place, strike : (n,) float, ankle of the flat foot [m], heel strike [s];
    start : begin of the motion [s]; lead : step that crosses first, or None; front, depth,
    height : obstacle [m]; share : of the changes made for an obstacle of 0.5 m, 0.5 to 1.
    """

    side: tuple
    place: np.ndarray
    strike: np.ndarray
    start: float
    lead: int | None
    front: float
    depth: float
    height: float
    share: float

    def crossing(self, i: int) -> Crossing | None:
        """How step i crosses, or None."""
        return None if self.lead is None else {self.lead: LEAD, self.lead + 1: TRAIL}.get(i)


def footsteps(
    strides: int, height: float, stride: int, stand: float, first: str, depth: float
) -> Footsteps:
    """Where and when the feet come down; two steps more than asked for, to go on smoothly."""
    n = 2 * strides + 3
    length, time = np.full(n, STEP), np.full(n, STEP_TIME)
    length[:2], time[:2] = (0.0, FIRST_STEP), (0.0, FIRST_TIME)
    lead = 2 * stride - 1 if height > 0 else None
    # even a low obstacle slows people down, and is cleared by more
    height = max(height, LOWEST)
    share = min(1.0, 0.5 + height)
    if lead:
        length[lead] = TOE + LEAD.before + depth + LEAD.past + HEEL
        for way, i in ((LEAD, lead), (TRAIL, lead + 1)):
            time[i] += share * (way.time - STEP_TIME)
    place = np.cumsum(length)
    front = place[lead - 1] + TOE + LEAD.before if lead else np.nan
    other = SIDES[1 - SIDES.index(first)]
    side = tuple(first if i % 2 else other for i in range(n))
    return Footsteps(side, place, stand + np.cumsum(time), stand, lead, front, depth, height, share)


def footfalls(steps: Footsteps) -> dict[str, list[Footfall]]:
    """Footfalls by side; both feet stand at the origin first."""
    falls: dict[str, list[Footfall]] = {side: [] for side in SIDES}
    half = 0.5 * HIP_SPACING
    off = steps.start + FIRST_OFF
    rise: tuple[tuple[float, float], ...] = ((off - FIRST_RISE, 0.0), (off, FIRST_PITCH))
    falls[steps.side[1]].append(Footfall(0.0, SIGN[steps.side[1]] * half, -np.inf, 0.0, rise))
    for i in range(len(steps.side) - 1):
        side, strike = steps.side[i], steps.strike[i]
        off = steps.strike[i + 1] + SUPPORT
        rise = ((off - RISE, 0.0), (off, OFF))
        way = steps.crossing(i + 1)
        if way:  # up on the forefoot while the other foot crosses
            vault = ((off - before, steps.share * pitch) for before, pitch in way.vault)
            rise = ((strike + SUPPORT + 0.08, 0.0), *vault, (off, OFF))
        begin = strike if i else -np.inf
        falls[side].append(Footfall(steps.place[i], SIGN[side] * half, begin, strike + FLAT, rise))
    return falls


def level_swings(falls: Sequence[Footfall]) -> list[Swing]:
    """Swing from each footfall to the next."""
    out = []
    for begin, end in pairwise(falls):
        go = end.along - begin.along
        first = go < STEP  # from standing: half a stride
        x = (SWING_X[0], tuple(begin.along + go * np.array(SWING_X[1])))
        z, pitch = (FIRST_Z, FIRST_PITCHES) if first else (SWING_Z, SWING_PITCH)
        out.append(Swing(x, z, pitch))
    return out


def events_of(
    falls: Mapping[str, Sequence[Footfall]], slow: float, end: float
) -> tuple[tuple[str, float], ...]:
    """(name, time [s]) of heel strikes and toe-offs until the end, in order."""
    events = []
    for side in SIDES:
        events += [(f"{side}_heel_strike", float(fall.strike * slow)) for fall in falls[side]]
        events += [(f"{side}_toe_off", float(fall.off * slow)) for fall in falls[side]]
    within = [(name, time) for name, time in events if 0.0 <= time <= end + 0.05]
    return tuple(sorted(within, key=lambda event: event[1]))
