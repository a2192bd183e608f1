# SPDX-License-Identifier: LGPL-3.0-or-later
"""The wearer's dimensions: semi-axes and places of the ellipsoids, from stature, mass or girths.

A tape measures the convex hull of a body's section. So every ellipsoid gets its size from a girth
at the level where it is measured, and its shape from breadth and depth there. Semi-axes are
constant: the segments are rigid, whatever a capture says of their length from frame to frame.

Medians are those of ANSUR II men, n = 4082 (Gordon et al., 2012 Anthropometric Survey of U.S. Army
Personnel, NATICK/TR-15/007), regressions on stature and mass were made on the same public table.
Levels are heights there, scaled with stature.

What holds a belt: the pelvis is widest near the hip joints and narrows upwards, the abdomen is
widest above the waist and narrows downwards. They meet in a crease all around, narrower than both,
just below the waist; a loop drawn tight there needs force to move either way. The crotch is the
lower end of the pelvis between the thighs, which are deeper than wide and so just do not touch.
Where hip joints are close together the thighs do not move into one another: flesh goes outward.
"""

from collections.abc import Mapping
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.spatial import ConvexHull, QhullError
from scipy.special import ellipe

from .proportions import HIP_SPACING, LENGTHS, RIM, STATURE
from .recording import SIDES

# name, segment, centre (3,), radii (3,) [m]
Ellipsoid = tuple[str, str, np.ndarray, np.ndarray]

MASS = 84.6  # median [kg]
GIRTHS = {"waist": 0.937, "hip": 1.017, "thigh": 0.624, "calf": 0.392, "ankle": 0.228}  # [m]
# girth [m] = a + b stature [m] + c mass [kg]; R2 0.88, 0.85, 0.71
REGRESSIONS = {
    "hip": (0.808, -0.140, 5.35e-3),
    "thigh": (0.595, -0.184, 4.13e-3),
    "calf": (0.351, -0.068, 1.89e-3),
}
# breadth over depth of trunk and hips at these levels
WAIST_SHAPE, HIP_SHAPE = 0.325 / 0.234, 0.344 / 0.246
# levels [m] at a stature of 1.755 m: up from the hip centres, which stand 0.92 m above the floor
WAIST, THIGH = 0.135, -0.105
PELVIS, ABDOMEN = (0.030, 0.120), (0.190, 0.240)  # centre up from the hips and semi-axis [m]
CALF_OVER_KNEE = 0.055  # how far the shank reaches over the knee centre [m]
ANKLE_LEVEL = 0.030  # where the ankle is thinnest, up from its centre [m]
THIGH_PAST = (0.105, 0.050)  # how far the thigh reaches past hip and knee centre [m]
THIGH_HALF_BREADTH, THIGH_OUTWARD = 0.092, 0.010  # [m]
THIGH_GAP = 0.003  # from the middle plane to a thigh, at least, when standing [m]
FOOT_BREADTH, FOOT_HEIGHT, SHOE = 0.102, 0.090, 0.0075  # [m]
LEAST, MOST = 0.1, 2.5  # girths taken for metres
TILT = 1e-9  # of an ellipsoid's section below which a plane only touches it


def ellipsoids(
    lengths: Mapping[str, ArrayLike],
    stature: float | None = STATURE,
    mass: float | None = None,
    girths: Mapping[str, float] | None = None,
    feet: bool = True,
    hip_spacing: float | None = None,
) -> list[Ellipsoid]:
    """Ellipsoids of the lower body.

    Parameters
    ----------
    lengths : dict, segment -> length [m] or (length, spread), as `Recording.lengths()` gives
    stature : float [m] or None: 1.755 m
    mass : float [kg] or None: of median build, 84.6 kg at 1.755 m, with the square of stature
    girths : dict of the wearer's own girths [m]: any of waist, hip, thigh, calf, ankle
    feet : False leaves them out, as when trousers are put on
    hip_spacing : distance of the hip centres [m]; None: that of a median man, by stature

    Returns
    -------
    list of (name, segment, centre (3,), radii (3,)) [m], centres from (J1 + J2)/2 and both along
    the segment's axes e1, e2, e3 of Eq. 17. 'abdomen' rides on the pelvis.

    Raises
    ------
    ValueError
        For a dimension that is unknown, not positive or not in metres, and for a missing segment.
    """
    stature = STATURE if stature is None else stature
    size = wearer_girths(stature, mass, girths)
    long = {name: float(np.ravel(value)[0]) for name, value in lengths.items()}
    needed = ["pelvis", *(f"{side}_{part}" for side in SIDES for part in ("thigh", "shank"))]
    missing = [name for name in needed if name not in long]
    if missing:
        raise ValueError(f"the wearer's segments lack {', '.join(missing)}")
    scale = stature / STATURE
    hip_spacing = HIP_SPACING * scale if hip_spacing is None else hip_spacing
    legs = []
    for side in SIDES:
        thigh = _thigh(long[f"{side}_thigh"], size["thigh"], scale, hip_spacing)
        legs.append((f"{side}_thigh", *thigh))
        legs.append((f"{side}_shank", *_shank(long[f"{side}_shank"], size, scale)))
        if feet and f"{side}_foot" in long:
            legs.append((f"{side}_foot", *_foot(long[f"{side}_foot"], scale, side)))
    trunk = _trunk(long, size, scale)
    return [*trunk, *((name, name, centre, radii) for name, centre, radii in legs)]


def wearer_girths(
    stature: float = STATURE, mass: float | None = None, girths: Mapping[str, float] | None = None
) -> dict[str, float]:
    """Girths [m] of waist, hip, thigh, calf, ankle: those given, the others from stature and mass.

    No regression of the waist was at hand: it grows as the root of mass over stature, as a cylinder
    does; the ankle grows as the calf. Raises ValueError as `ellipsoids`.
    """
    if not 1.0 < stature < 2.5:
        raise ValueError(f"stature {stature:g} is not that of an adult in metres: give 1.0 to 2.5")
    if mass is None:
        mass = MASS * (stature / STATURE) ** 2
    if not 25.0 < mass < 300.0:
        raise ValueError(f"mass {mass:g} is not that of an adult in kilograms: give 25 to 300")
    at = {name: a + b * stature + c * mass for name, (a, b, c) in REGRESSIONS.items()}
    typical = {name: a + b * STATURE + c * MASS for name, (a, b, c) in REGRESSIONS.items()}
    # the regression's constant is rounded: at the median wearer it gives the median
    out = {name: GIRTHS[name] * at[name] / typical[name] for name in REGRESSIONS}
    out["waist"] = GIRTHS["waist"] * np.sqrt(mass / MASS * STATURE / stature)
    out["ankle"] = GIRTHS["ankle"] * out["calf"] / GIRTHS["calf"]
    for name, value in (girths or {}).items():
        if name not in GIRTHS:
            raise ValueError(f"no girth is called '{name}'; there are: {', '.join(GIRTHS)}")
        if not LEAST < value < MOST:
            raise ValueError(
                f"girth '{name}' of {value:g} is not in metres: give a number as {GIRTHS[name]:g}"
            )
        out[name] = float(value)
    for thin, thick in pairwise(("ankle", "calf", "thigh", "hip")):
        if not out[thin] < out[thick]:
            raise ValueError(
                f"girth '{thin}' of {out[thin]:.3g} m is not below that of the {thick}, "
                f"{out[thick]:.3g} m: give both"
            )
    return out


def section(
    centre: np.ndarray,
    axes: np.ndarray,
    radii: np.ndarray,
    level: float,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    count: int = 360,
) -> np.ndarray:
    """Points (count, 3) [m] around the section of an ellipsoid by normal . x = level; maybe none.

    centre (3,), axes (3, 3) rows e1, e2, e3, radii (3,).
    """
    normal = np.asarray(normal, float)
    # x = centre + B u on the unit sphere |u| = 1: the plane cuts a circle out of it
    B = np.asarray(axes).T * radii
    m = B.T @ normal
    size = np.linalg.norm(m)
    away = (level - normal @ centre) / size
    if abs(away) >= 1 - TILT:
        return np.zeros((0, 3))
    m = m / size
    p = np.cross(m, np.eye(3)[np.argmin(np.abs(m))])
    p /= np.linalg.norm(p)
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)[:, None]
    ring = np.cos(angle) * p + np.sin(angle) * np.cross(m, p)
    return np.asarray(centre) + (away * m + np.sqrt(1 - away**2) * ring) @ B.T


def girth(
    centres: np.ndarray,
    axes: np.ndarray,
    radii: np.ndarray,
    level: float,
    normal: ArrayLike = (0.0, 0.0, 1.0),
) -> float:
    """What a tape measures around ellipsoids in the plane normal . x = level [m].

    The perimeter of the convex hull of their sections, to 1e-4 of itself; 0 where the plane meets
    none. centres (m, 3) [m], axes (m, 3, 3), radii (m, 3) [m], normal a unit vector.
    """
    each = zip(centres, axes, radii, strict=True)
    points = np.concatenate([section(*one, level, normal) for one in each])
    normal = np.asarray(normal, float)
    p = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    p /= np.linalg.norm(p)
    flat = points @ np.stack([p, np.cross(normal, p)], axis=1)
    try:
        return ConvexHull(flat).area if len(flat) else 0.0  # of a plane hull: its perimeter
    except QhullError:
        return 0.0


def _thigh(long, size, scale, hip_spacing):
    """Centre and radii of a thigh whose girth is right at `THIGH`, all along, outward, fore-aft."""
    over, under = (past * scale for past in THIGH_PAST)
    half = 0.5 * (long + over + under)
    centre = 0.5 * (under - over)  # from mid segment, downwards
    level = -THIGH * scale - 0.5 * long
    shrink = np.sqrt(1 - ((level - centre) / half) ** 2)
    breadth = THIGH_HALF_BREADTH * np.sqrt(size / GIRTHS["thigh"]) * np.sqrt(scale)
    depth = _other_axis(size, shrink * breadth) / shrink
    outward = max(THIGH_OUTWARD * scale, breadth + THIGH_GAP * scale - 0.5 * hip_spacing)
    return np.array([centre, outward, 0.0]), np.array([half, breadth, depth])


def _shank(long, size, scale):
    """Centre and radii of a shank: the calf's girth is the largest, the ankle's at its level."""
    over = CALF_OVER_KNEE * scale
    # a point at a part `thin` of the half length from the centre has the girth of the ankle
    thin = np.sqrt(1 - (size["ankle"] / size["calf"]) ** 2)
    under = (1 - thin) * 0.5 * (long + over) - ANKLE_LEVEL * scale
    under = max(under / (1 - 0.5 * (1 - thin)), 0.01 * scale)  # round the ankle's centre
    radius = size["calf"] / (2 * np.pi)
    centre = 0.5 * (under - over)
    return np.array([centre, 0.0, 0.0]), np.array([0.5 * (long + over + under), radius, radius])


def _foot(long, scale, side):
    """Centre and radii of a shoe that begins at J1 and rests on the floor when standing."""
    whole = max(long, LENGTHS["foot"] * scale)
    up = (0.5 * FOOT_HEIGHT - RIM) * scale
    # e3 = e1 x e2 points down in a right foot, up in a left one
    centre = np.array([0.5 * (whole - long), 0.0, -up if side == "right" else up])
    radii = np.array([0.5 * whole + SHOE, 0.5 * FOOT_BREADTH * scale, 0.5 * FOOT_HEIGHT * scale])
    return centre, radii


def _trunk(long, size, scale):
    """Pelvis and abdomen as rows of `ellipsoids`: widest by the hip's girth, right at `WAIST`."""
    rows = []
    for name, (up, half), level, around, shape in (
        ("pelvis", PELVIS, PELVIS[0], size["hip"], HIP_SHAPE),
        ("abdomen", ABDOMEN, WAIST, size["waist"], WAIST_SHAPE),
    ):
        shrink = np.sqrt(1 - ((level - up) / half) ** 2)
        depth = around / shrink / perimeter(1.0, shape)
        centre = np.array([0.5 * long["pelvis"] - up * scale, 0.0, 0.0])
        rows.append((name, "pelvis", centre, np.array([half * scale, depth, shape * depth])))
    return rows


def perimeter(a: float, b: float) -> float:
    """Perimeter [m] of an ellipse of semi-axes a, b [m] (Abramowitz and Stegun 17.3.3)."""
    large, small = max(a, b), min(a, b)
    return 4 * large * ellipe(1 - (small / large) ** 2)


def _other_axis(length, a):
    """Semi-axis of an ellipse from its perimeter and the other semi-axis [m]."""
    return brentq(lambda b: perimeter(a, b) - length, 1e-6 * a, length / 4, xtol=1e-12)
