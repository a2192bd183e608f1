# SPDX-License-Identifier: LGPL-3.0-or-later
"""Units of fabric tests, in the names of keys: `B_warp_gf_cm2_per_cm`, `weight_g_per_m2`.

A number outside what cloth has is refused with the unit it may have been meant in: KES tells
bending in gf cm^2/cm, FAST in uN m, and a bending stiffness of 0.12 N m is that of a board.
gf is the weight of a gram at 9.80665 m/s^2.
"""

from collections.abc import Container, Mapping
from dataclasses import dataclass
from reprlib import repr as brief
from typing import Any

import numpy as np

from .laminate import FabricError
from .spelling import nearest

GF = 9.80665e-3  # N


@dataclass(frozen=True)
class Dimension:
    """Units of a kind of quantity, with what each is in SI, and the range of cloth in SI."""

    units: Mapping[str, float]
    low: float
    high: float


MASS = Dimension({"kg_per_m2": 1.0, "g_per_m2": 1e-3, "mg_per_cm2": 1e-2}, 5e-3, 10.0)
LENGTH = Dimension({"m": 1.0, "mm": 1e-3, "cm": 1e-2}, 1e-5, 0.05)
OVERHANG = Dimension({"m": 1.0, "mm": 1e-3, "cm": 1e-2}, 2e-3, 0.5)
BENDING = Dimension({"N_m": 1.0, "uN_m": 1e-6, "gf_cm2_per_cm": GF * 1e-2}, 1e-8, 1e-2)
MOMENT = Dimension({"N": 1.0, "mN": 1e-3, "gf_cm_per_cm": GF}, 1e-7, 1.0)
LOAD = Dimension({"N_per_m": 1.0, "gf_per_cm": GF * 100}, 1e-3, 1e5)
STIFFNESS = Dimension({"N_per_m": 1.0, "gf_per_cm": GF * 100}, 1.0, 1e7)
SHEAR = Dimension(
    {
        "N_per_m_per_radian": 1.0,
        "N_per_m_per_degree": 180 / np.pi,
        "gf_per_cm_degree": GF * 100 * 180 / np.pi,
    },
    1.0,
    1e5,
)
WORK = Dimension({"J_per_m2": 1.0, "gf_cm_per_cm2": GF * 100}, 1e-3, 1e3)
STRAIN = Dimension({"percent": 1e-2, "": 1.0}, 1e-4, 5.0)
ANGLE = Dimension({"degrees": np.pi / 180, "radians": 1.0}, 1e-4, 1.5)
CURVATURE = Dimension({"per_m": 1.0, "per_cm": 100.0}, 1e-2, 2e3)
PART = Dimension({"percent": 1e-2, "": 1.0}, 1e-3, 1.0)
RATIO = Dimension({"": 1.0}, -0.99, 3.0)


def spelt(name: str, unit: str) -> str:
    """Key of a quantity in a unit."""
    return f"{name}_{unit}" if unit else name


def read_quantities(
    table: Mapping[str, Any],
    quantities: Mapping[str, Dimension],
    where: str,
    lists: Container[str] = (),
) -> dict[str, Any]:
    """Values in SI by name of the quantity, from keys with units: arrays of `lists`, else numbers.

    Raises
    ------
    FabricError : a key that is not known, a quantity in two units, no number, or one that no cloth
        has, with the mend
    """
    keys = {spelt(n, u): (n, u) for n, d in quantities.items() for u in d.units}
    values: dict[str, Any] = {}
    said: dict[str, str] = {}
    for key, given in table.items():
        if key not in keys:
            raise FabricError(f'{where}: unknown key "{key}"; {_mend(key, keys, quantities)}')
        name, unit = keys[key]
        if name in values:
            raise FabricError(
                f'{where}: "{said[name]}" and "{key}" are one quantity in two units: leave one out.'
            )
        said[name] = key
        place = f"{where}: {key}"
        values[name] = _in_si(given, quantities[name], name, unit, place, name in lists)
    return values


def _in_si(given, dimension, name, unit, where, is_list):
    try:
        numbers = np.array(given, float)
    except (TypeError, ValueError, OverflowError):
        numbers = np.array(np.nan)
    if isinstance(given, bool | str) or numbers.ndim != is_list or not np.isfinite(numbers).all():
        what = "a list of finite numbers" if is_list else "a finite number"
        raise FabricError(f"{where} = {brief(given)} is not {what}.")
    values = numbers * dimension.units[unit]
    largest = float(np.abs(values).max(initial=0.0)) if numbers.ndim else float(values)
    if not is_list or largest > 0:
        check_range(largest, dimension, name, unit, where)
    return values if is_list else float(values)


def check_range(value: float, dimension: Dimension, name: str, unit: str, where: str) -> None:
    """FabricError if a value in SI, given in a unit, is none of a cloth."""
    if dimension.low <= value <= dimension.high:
        return
    factor = dimension.units[unit]
    shown = value / factor
    meant = [
        spelt(name, other)
        for other, by in dimension.units.items()
        if other != unit and dimension.low <= shown * by <= dimension.high
    ]
    mend = f"was it meant as {' or '.join(meant)}?" if meant else "check number and unit."
    raise FabricError(
        f"{where} = {shown:g} lies outside {dimension.low / factor:.3g} to "
        f"{dimension.high / factor:.3g}, what cloth has: {mend}"
    )


def _mend(key, keys, quantities):
    for name in sorted(quantities, key=len, reverse=True):
        if key == name or key.startswith(f"{name}_"):
            choices = (spelt(name, unit) for unit in quantities[name].units)
            longer = (other for other in quantities if len(other) > len(name))
            if not any(key.startswith(f"{other}_") for other in longer):
                return f"write {' or '.join(choices)}."
    close = nearest(key, keys)
    if close.startswith("did"):
        return close
    names = dict.fromkeys(name.removesuffix("_warp").removesuffix("_weft") for name in quantities)
    return f"there are {', '.join(names)}, of a yarn with _warp or _weft, each with its unit."
