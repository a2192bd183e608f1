# SPDX-License-Identifier: LGPL-3.0-or-later
"""Ellipsoids of trunk, shoulders, neck and arms, for garments that hang on the shoulders.

As in anthropometry.py a girth gives an ellipsoid its size and breadth over depth its shape. The
chest is widest where it is measured; one ellipsoid across makes the slope from neck to acromion.

Means of ANSUR II men (Gordon et al., NATICK/TR-15/007, 2014): girths of chest 1.059, neck 0.398,
upper arm (flexed) 0.358, forearm (flexed) 0.310, wrist 0.176, chest 0.290 broad and 0.254 deep,
chest height 1.280, acromion 1.440 m high, breadth over the deltoids 0.510. The survey has no
regression on mass here: all grow as the root of mass over stature, as cylinders do.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from .anthropometry import LEAST, MASS, MOST, Ellipsoid, perimeter
from .proportions import STATURE
from .recording import SIDES
from .upper_body import HIPS, TOP

GIRTHS = {
    "chest": 1.059,
    "neck": 0.398,
    "upper_arm": 0.358,
    "forearm": 0.310,
    "wrist": 0.176,
}  # [m]
CHEST_SHAPE = 0.290 / 0.254
CHEST = (1.280 - HIPS, 0.190)  # centre over the hip centres, semi-axis up [m]
# centre over the hip centres; semi-axes up, fore-aft, across: through acromion and base of the neck
SHOULDERS = (0.475, (0.085, 0.075, 0.235))
NECK = (0.620, 0.120)  # centre over the hip centres, semi-axis up [m]
ARM_PAST = (0.060, 0.045)  # how far the upper arm reaches past shoulder and elbow centre [m]
FOREARM_OVER = 0.045  # how far the forearm reaches past the elbow centre [m]


def upper_girths(
    stature: float = STATURE, mass: float | None = None, girths: Mapping[str, float] | None = None
) -> dict[str, float]:
    """Girths [m] of GIRTHS: those given, the others by stature [m] and mass [kg], None: median.

    ValueError for a girth that is not in metres
    """
    mass = MASS * (stature / STATURE) ** 2 if mass is None else mass
    grown = np.sqrt(mass / MASS * STATURE / stature)
    out = {name: float(value * grown) for name, value in GIRTHS.items()}
    for name, value in (girths or {}).items():
        if not LEAST < value < MOST:
            raise ValueError(
                f"girth '{name}' of {value:g} is not in metres: give a number as {GIRTHS[name]:g}"
            )
        out[name] = float(value)
    if not out["wrist"] < out["forearm"]:
        raise ValueError(
            f"girth 'wrist' of {out['wrist']:.3g} m is not below that of the forearm, "
            f"{out['forearm']:.3g} m: give both"
        )
    return out


def upper_ellipsoids(
    lengths: Mapping[str, ArrayLike],
    stature: float | None = STATURE,
    mass: float | None = None,
    girths: Mapping[str, float] | None = None,
) -> list[Ellipsoid]:
    """Ellipsoids on UPPER_SEGMENTS; arguments and rows as of `anthropometry.ellipsoids`."""
    stature = STATURE if stature is None else stature
    scale, size = stature / STATURE, upper_girths(stature, mass, girths)
    long = {name: float(np.ravel(value)[0]) for name, value in lengths.items()}

    def at(level: float) -> np.ndarray:
        """Centre on the thorax at a level over the hips, its top being at TOP."""
        return np.array([(TOP - level) * scale - 0.5 * long["thorax"], 0.0, 0.0])

    depth = size["chest"] / perimeter(1.0, CHEST_SHAPE)
    chest = np.array([CHEST[1] * scale, depth, CHEST_SHAPE * depth])
    around = size["neck"] / (2 * np.pi)
    rows: list[Ellipsoid] = [
        ("thorax", "thorax", at(CHEST[0]), chest),
        ("shoulders", "thorax", at(SHOULDERS[0]), scale * np.array(SHOULDERS[1])),
        ("neck", "thorax", at(NECK[0]), np.array([NECK[1] * scale, around, around])),
    ]
    for side in SIDES:
        arm, forearm = (f"{side}_{part}" for part in ("upper_arm", "forearm"))
        over, under = (past * scale for past in ARM_PAST)
        radius = size["upper_arm"] / (2 * np.pi)
        centre = np.array([0.5 * (under - over), 0.0, 0.0])
        half = 0.5 * (long[arm] + over + under)
        rows.append((arm, arm, centre, np.array([half, radius, radius])))
        # the wrist's girth at its centre: at a part `thin` of the half length from the middle
        over, radius = FOREARM_OVER * scale, size["forearm"] / (2 * np.pi)
        thin = np.sqrt(1 - (size["wrist"] / size["forearm"]) ** 2)
        half = (long[forearm] + over) / (1 + thin)
        centre = np.array([half - over - 0.5 * long[forearm], 0.0, 0.0])
        rows.append((forearm, forearm, centre, np.array([half, radius, radius])))
    return rows
