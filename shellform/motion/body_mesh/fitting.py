# SPDX-License-Identifier: LGPL-3.0-or-later
"""A standing body brought to the girths of the wearer, by smooth scalings about trunk and legs.

Level slices are scaled about the line of the joints: those of a leg by factors at thigh, knee, calf
and ankle, those of the trunk by factors at hip and waist, with a monotone cubic between them (PCHIP
of Fritsch and Carlson). Between gluteal fold and hip the two blend. The factors that give the
asked girths are found by Newton's method with a matrix that Broyden's formula improves; a girth
is measured as on a person, see `girths`.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.sparse import csr_matrix

from shellform.motion.anthropometry import GIRTHS, THIGH, wearer_girths
from shellform.motion.proportions import STATURE
from shellform.motion.recording import SIDES

from .girths import HIP, NAMES, girths, levels
from .placing import apart_points
from .surface import BodySurface

LOWER_THIGH = 0.408  # median girth just above the kneecap, men of ANSUR II [m]
WITHIN = 1e-3  # of the girths that are asked for
STEPS = 30
LEAST, MOST = 0.5, 2.0  # of a scaling


def asked_girths(
    stature: float, mass: float | None = None, own: Mapping[str, float] | None = None
) -> dict[str, float]:
    """Girths [m] of waist, hip, thigh, knee, calf and ankle: the wearer's own, else by size.

    Where the knee is not given, it grows as thigh and calf do.

    Raises
    ------
    ValueError as `anthropometry.wearer_girths`, and for a knee as thick as the thigh
    """
    own = dict(own or {})
    knee = own.pop("knee", None)
    out = wearer_girths(stature, mass, own)
    if knee is None:
        size = out["thigh"] / GIRTHS["thigh"] * out["calf"] / GIRTHS["calf"]
        knee = LOWER_THIGH * np.sqrt(size)
    if not out["ankle"] < knee < out["thigh"]:
        raise ValueError(
            f"girth 'knee' of {knee:.3g} m is not between those of ankle and thigh, "
            f"{out['ankle']:.3g} and {out['thigh']:.3g} m"
        )
    return {name: float(knee) if name == "knee" else out[name] for name in NAMES}


def fitted(
    surface: BodySurface, asked: Mapping[str, float], smoothing: csr_matrix
) -> tuple[BodySurface, dict[str, float]]:
    """The surface with girths [m] as asked for, the others as they were, and all as measured.

    surface : standing, as `placed` gives; smoothing : of `between_legs`, in what is measured

    Raises
    ------
    ValueError for girths that no scaling between LEAST and MOST gives
    """
    heights = levels(surface)
    unknown = [name for name in asked if name not in NAMES]
    if unknown:
        raise ValueError(f"no girth is called '{unknown[0]}'; there are: {', '.join(NAMES)}")

    def measured(factors):
        scaled = _scaled(surface, heights, dict(zip(NAMES, factors, strict=True)))
        drawn = replace(scaled, points=smoothing @ scaled.points)
        around = girths(drawn, heights)
        return scaled, np.array([around[name] for name in NAMES])

    factors = np.ones(len(NAMES))
    scaled, have = measured(factors)
    want = np.array([asked.get(name, own) for name, own in zip(NAMES, have, strict=True)])
    slope = np.diag(have)  # a girth grows as its own factor, to begin with
    for _ in range(STEPS):
        if np.abs(have / want - 1.0).max() < WITHIN:
            break
        change = np.linalg.solve(slope, want - have)
        change = np.clip(factors + change, LEAST, MOST) - factors
        factors = factors + change
        before, (scaled, have) = have, measured(factors)
        miss = have - before - slope @ change
        slope += np.outer(miss, change) / max(change @ change, 1e-30)
    worst = int(np.argmax(np.abs(have / want - 1.0)))
    if np.abs(have / want - 1.0)[worst] > 10 * WITHIN:
        raise ValueError(
            f"{surface.source} cannot be brought to a {NAMES[worst]} of {want[worst]:.3f} m with "
            f"the other girths: it stays at {have[worst]:.3f} m"
        )
    return scaled, dict(zip(NAMES, have.tolist(), strict=True))


def _scaled(surface, heights, factors):
    """The surface with level slices scaled by factors at the heights of the measures."""
    scale, z = surface.stature / STATURE, surface.points[:, 2]
    hips = surface.middle[2]
    trunk = PchipInterpolator(
        [heights["hip"], heights["waist"]], [factors["hip"], factors["waist"]], extrapolate=False
    )
    of_trunk = trunk(np.clip(z, heights["hip"], heights["waist"]))[:, None]
    sole = min(surface.landmarks[f"{side}_ankle"][2] for side in SIDES)
    knots = sorted((heights[name], factors[name]) for name in ("thigh", "knee", "calf", "ankle"))
    at, by = np.array(knots).T
    # below the ankle joint a foot keeps its size
    legs = PchipInterpolator(np.concatenate([[sole], at]), np.concatenate([[1.0], by]))
    of_leg = legs(np.clip(z, sole, at[-1]))[:, None]
    u = np.clip((z - hips - THIGH * scale) / ((HIP - THIGH) * scale), 0.0, 1.0)
    share = (u * u * (3.0 - 2.0 * u))[:, None]
    level = surface.points[:, :2]
    centre = surface.middle[:2]
    out = surface.points.copy()
    aside = (surface.points - surface.middle) @ surface.left
    for side, sign in zip(SIDES, (-1.0, 1.0), strict=True):
        marks = np.array([surface.landmarks[f"{side}_{j}"] for j in ("ankle", "knee", "hip")])
        axis = np.stack([np.interp(z, marks[:, 2], marks[:, c]) for c in range(2)], axis=1)
        moved = share * (of_trunk - 1.0) * (level - centre)
        moved += (1.0 - share) * (of_leg - 1.0) * (level - axis)
        own = sign * aside > 0 if sign > 0 else aside <= 0
        out[own, :2] += moved[own]
    return replace(surface, points=apart_points(out, surface))
