# SPDX-License-Identifier: LGPL-3.0-or-later
"""What cloth of a mass per area bends and shears with where nobody has measured it.

Bending: percentiles of 618 measured fabrics (DrapeTester's table of bending by KES; statistics
computed from it, the table has no licence), of which 183 have 0.18 to 0.28 kg/m2:

    1e-6 N m        5 %   25 %   50 %   75 %   95 %      0.18 to 0.28 kg/m2:  10 %   50 %   90 %
    along warp      1.1    4.1   13.8   35.9   110                             4.8   19.7    61
    along weft      0.9    3.3    8.8   23.7   49.7

10 and 90 % of all lie between these, by the normal distribution of their logarithms. Of the weft in
the narrower class no numbers are known: those of the warp are lowered as the medians of all are.

Shear: 30 to 80 N/m is the range FAST recommends for cloth that is to be tailored, 54 N/m the mean
of men's suiting (Kawabata); a working range, not percentiles.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from .units import MASS, spelt

CLASS = (0.18, 0.28)  # kg/m2
OF_CLASS = np.array([4.8, 19.7, 61.0]) * 1e-6  # N m: 10, 50, 90 % along the warp
OF_ALL = {  # N m: 5, 25, 50, 75, 95 %
    "warp": np.array([1.1, 4.1, 13.8, 35.9, 110.0]) * 1e-6,
    "weft": np.array([0.9, 3.3, 8.8, 23.7, 49.7]) * 1e-6,
}
NORMAL = np.array([-1.6449, -0.6745, 0.0, 0.6745, 1.6449])
TENTH = 1.2816
SHEAR = (30.0, 54.0, 80.0)  # N/m per radian
YARNS = ("warp", "weft")


def bending_prior(areal_mass: float, yarn: str) -> tuple[float, float, float]:
    """Bending stiffness [N m] of cloth of a mass [kg/m^2]: 10, 50 and 90 % lie below.

    Examples
    --------
    >>> [f"{1e6 * B:.1f}" for B in bending_prior(0.21, "warp")]
    ['4.8', '19.7', '61.0']
    """
    if CLASS[0] <= areal_mass <= CLASS[1]:
        lower = 1.0 if yarn == "warp" else OF_ALL["weft"][2] / OF_ALL["warp"][2]
        low, middle, high = OF_CLASS * lower
    else:
        at = np.interp([-TENTH, 0.0, TENTH], NORMAL, np.log(OF_ALL[yarn]))
        low, middle, high = np.exp(at)
    return float(low), float(middle), float(high)


def filled(kind: str, table: Mapping[str, Any], estimated: tuple[str, ...]) -> dict[str, Any]:
    """A card's table "kes" or "measured" with the prior's medians for what it says is estimated.

    Numbers that the table has stay; without a mass it stays as it is.
    """
    table = dict(table)
    mass = _mass(table)
    if kind not in ("kes", "measured") or mass is None:
        return table
    more: dict[str, Any] = {}
    for yarn in YARNS:
        given = {"kes": ("bending",), "measured": ("B", "curvature", "bending_length")}[kind]
        if "bending" in estimated and not _has(table, [f"{name}_{yarn}" for name in given]):
            key = f"bending_{yarn}_N_m" if kind == "kes" else f"B_{yarn}_N_m"
            more[key] = bending_prior(mass, yarn)[1]
    given = ("shear",) if kind == "kes" else ("G", "angle", "EB5")
    if "shear" in estimated and not _has(table, given):
        more["shear_N_per_m_per_radian" if kind == "kes" else "G_N_per_m_per_radian"] = SHEAR[1]
    return table | more


def _has(table, names):
    return any(key == name or key.startswith(f"{name}_") for key in table for name in names)


def _mass(table):
    if "areal_mass_kg_per_m2" in table:
        mass, factor = table["areal_mass_kg_per_m2"], 1.0
    else:
        keys = {spelt("weight", unit): by for unit, by in MASS.units.items()}
        found = next((key for key in keys if key in table), None)
        mass, factor = table.get(found), keys.get(found, 1.0)
    if isinstance(mass, bool) or not isinstance(mass, int | float):
        return None
    return factor * mass
