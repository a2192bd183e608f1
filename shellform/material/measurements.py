# SPDX-License-Identifier: LGPL-3.0-or-later
"""A fabric from what was measured: KES, FAST, ASTM D1388, curves, each in its own units (Fig. 3).

Of each of tension, shear and bending one of

    tension   stretch and load lists, with the unloading; EMT with LT, RT; E5, E20, E100 of FAST;
              of both yarns at equal stretch: biaxial_stretch, and biaxial_load of each
    shear     angle and shear_load lists, with the unloading; G with 2HG and 2HG5; EB5 of FAST
    bending   curvature and moment lists, with the unloading; B with 2HB; a bending length (D1388)

What follows from two of them must agree. Loops become sliders (loops.py). From the tests:

    B = (2 c)^3 w/8 = c^3 w g of a bending length c and the mass per area (ASTM D1388)
    G = 123/EB5 N/m with EB5 in percent (CSIRO FAST; de Boos and Tester, 1994)
    LT = 2 WT/(EMT F), RT = what of WT is given back, F the largest load, 500 gf/cm (Kawabata 1980)
    T = G gamma +- HG and M = B kappa +- HB, half of 2HG and 2HB (Kawabata)
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from . import units
from .alternatives import one_of
from .curve import Curve
from .fabric import Fabric
from .friction import ClothFriction, Elements
from .laminate import FabricError, bending_matrix, lamina_matrix
from .loops import (
    BENDING,
    SHEAR,
    TENSION,
    bending_loop,
    decrimping,
    loop,
    shear_loop,
    tension_loop,
)
from .table_file import columns
from .units import read_quantities

YARNS = ("warp", "weft")
GRAVITY = 9.80665
AGREE = 0.2  # by which a bending length may miss B, relative
TOLD = 0.05  # by which WT may miss LT and EMT


def _both(**of_a_yarn):
    return {f"{name}_{yarn}": kind for name, kind in of_a_yarn.items() for yarn in YARNS}


QUANTITIES = (
    _both(
        stretch=units.STRAIN, load=units.LOAD, unload=units.LOAD,
        curvature=units.CURVATURE, moment=units.MOMENT, unbend=units.MOMENT,
        EMT=units.STRAIN, LT=units.PART, WT=units.WORK, RT=units.PART,
        E5=units.STRAIN, E20=units.STRAIN, E100=units.STRAIN,
        B=units.BENDING, bending_length=units.OVERHANG, tensile=units.STIFFNESS,
    )
    | {f"2HB_{yarn}": units.MOMENT for yarn in YARNS}
    | {
        "angle": units.ANGLE, "shear_load": units.LOAD, "shear_unload": units.LOAD,
        "G": units.SHEAR, "2HG": units.LOAD, "2HG5": units.LOAD, "EB5": units.STRAIN,
        "F": units.LOAD, "weight": units.MASS, "thickness": units.LENGTH,
        "biaxial_stretch": units.STRAIN, "biaxial_load_warp": units.LOAD,
        "biaxial_load_weft": units.LOAD, "B_twist": units.BENDING, "poisson_ratio": units.RATIO,
    }
)  # fmt: skip
LISTS = {
    *_both(stretch=0, load=0, unload=0, curvature=0, moment=0, unbend=0, biaxial_load=0),
    "angle", "shear_load", "shear_unload", "biaxial_stretch",
}  # fmt: skip


def measured_fabric(
    table: Mapping[str, Any], name: str = "fabric", where: str = "measured", folder: Path = Path()
) -> Fabric:
    """Fabric of a card's table `measured`.

    Parameters
    ----------
    table : keys are quantities with their units (QUANTITIES), and `file`, a table of columns named
        as such keys, separated by commas
    folder : that the file's name is relative to

    Raises
    ------
    FabricError : an unknown key, what is missing, disagrees, or is no cloth's, with the mend

    Examples
    --------
    >>> suiting = measured_fabric({
    ...     "EMT_warp_percent": 5.0, "LT_warp": 0.6, "EMT_weft_percent": 8.0, "LT_weft": 0.6,
    ...     "G_gf_per_cm_degree": 0.968, "2HG_gf_per_cm": 1.204, "2HG5_gf_per_cm": 2.567,
    ...     "B_warp_gf_cm2_per_cm": 0.136, "2HB_warp_gf_cm_per_cm": 0.062,
    ...     "B_weft_gf_cm2_per_cm": 0.09, "2HB_weft_gf_cm_per_cm": 0.05,
    ...     "weight_mg_per_cm2": 26.35, "thickness_mm": 0.746,
    ... })
    >>> f"{suiting.bending[0, 0]:.3g} N m"
    '1.33e-05 N m'
    """
    table = dict(table)
    if "file" in table:
        table = columns(Path(folder) / str(table.pop("file")), where) | table
    q = read_quantities(table, QUANTITIES, where, LISTS)
    for needed in ("weight", "thickness"):
        if needed not in q:
            choices = (units.spelt(needed, unit) for unit in QUANTITIES[needed].units)
            raise FabricError(f"{where}: {needed} is missing, give {' or '.join(choices)}.")
    if "F" in q and not any(f"EMT_{yarn}" in q for yarn in YARNS):
        raise FabricError(f"{where}: F is the load at EMT, which is missing: leave F out.")
    tension = {yarn: _tension(q, yarn, where) for yarn in YARNS}
    shear, slope, shear_sliders = _shear(q, where)
    bending = {yarn: _bending(q, yarn, where) for yarn in YARNS}
    warp, weft = (tension[yarn] for yarn in YARNS)
    coupling = _coupling(q, warp, weft, where)
    stiffness = [bending[yarn][1] for yarn in YARNS]
    twist = [q["B_twist"]] if "B_twist" in q else []
    try:
        A = lamina_matrix(warp[1], weft[1], q.get("poisson_ratio", 0.0), slope, unit="N/m")
        if coupling is not None:
            A = np.diag(np.array([warp[1], weft[1], slope]))
            A[0, 1] = A[1, 0] = coupling.at_rest
        D = bending_matrix((*stiffness, *twist), A[0, 1] / np.sqrt(A[0, 0] * A[1, 1]))
        fabric = Fabric.from_stiffness(A, D, q["weight"], q["thickness"], name=name)
    except FabricError as error:
        raise FabricError(f"{where}: {error}") from None
    friction = ClothFriction(warp[2], weft[2], shear_sliders, *(bending[yarn][2] for yarn in YARNS))
    if sum(friction.counts()):
        fabric = fabric.with_friction(friction)
    curves = [warp[0], weft[0], shear, *(bending[yarn][0] for yarn in YARNS), coupling]
    if any(curve is not None for curve in curves):
        # only here: written in UFL, which quadratic cloth does not need
        from .measured import Measured

        fabric = fabric.with_law(Measured(*curves))
    if fabric.law is None and fabric.friction is None:
        return fabric
    kept = {key: np.asarray(value).tolist() for key, value in table.items()}
    return fabric.with_card({"name": name, "measured": kept})


Part = tuple[Curve | None, float, Elements]  # a curve, its slope at rest, sliders


def _tension(q: dict, yarn: str, where: str) -> Part:
    ways = [
        (f"stretch_{yarn}", f"load_{yarn}", f"[unload_{yarn}]"),
        (f"EMT_{yarn}", f"[LT_{yarn}]", f"[WT_{yarn}]", f"[RT_{yarn}]"),
        (f"E5_{yarn}", f"E20_{yarn}", f"E100_{yarn}"),
        (f"tensile_{yarn}",),
    ]
    way = one_of(q, ways, f"tension along the {yarn}", where)
    name = f"{where}: tension along the {yarn}"
    most = q.get("F", 500 * units.GF * 100)
    if way == f"tensile_{yarn}":
        return None, q[way], ()
    if way == f"stretch_{yarn}":
        x, y = q[way], q[f"load_{yarn}"]
        return loop(x, y, q.get(f"unload_{yarn}"), TENSION, name)
    if way == f"E5_{yarn}":
        x = np.array([0.0, *(q[f"E{load}_{yarn}"] for load in (5, 20, 100))])
        loads = np.array([0.0, 5.0, 20.0, 100.0]) * units.GF * 100
        return loop(x, loads, None, TENSION, name)
    EMT, LT = q[way], q.get(f"LT_{yarn}")
    WT = q.get(f"WT_{yarn}")
    if LT is not None and WT is not None and abs(WT / (0.5 * LT * EMT * most) - 1) > TOLD:
        raise FabricError(
            f"{name}: WT = {WT:.3g} J/m^2 disagrees with LT EMT F/2 = {0.5 * LT * EMT * most:.3g} "
            f"J/m^2 at F = {most:.4g} N/m: give F of the test, or leave one out."
        )
    if LT is None and WT is not None:
        LT = 2 * WT / (EMT * most)
    if LT is None:
        if f"RT_{yarn}" in q:
            raise FabricError(
                f"{name}: RT goes with LT or WT, which are missing: a straight line gives back all "
                "of its work."
            )
        # the load of a St. Venant sheet at that stretch, (1 + e) (e + e^2/2) times its stiffness
        return None, most / ((1.0 + EMT) * (EMT + 0.5 * EMT**2)), ()
    RT = q.get(f"RT_{yarn}", 1.0)
    x, y = decrimping(EMT, LT, most, RT, name)
    return tension_loop(x, y, RT, name)


def _coupling(q: dict, warp: Part, weft: Part, where: str) -> Curve | None:
    """What the load of a yarn gains where the other is stretched as much, the mean of both."""
    name = f"{where}: tension of both yarns"
    if not any(key.startswith("biaxial") for key in q):
        return None
    x = q.get("biaxial_stretch")
    loads = [q[key] for key in (f"biaxial_load_{yarn}" for yarn in YARNS) if key in q]
    if x is None or len(loads) < 2:
        raise FabricError(
            f"{name}: biaxial_stretch, biaxial_load_warp and biaxial_load_weft go together."
        )
    if "poisson_ratio" in q:
        raise FabricError(f"{name}: a poisson_ratio beside them says the same: leave one out.")
    gains = []
    for load, (curve, slope, sliders), yarn in zip(loads, (warp, weft), YARNS, strict=True):
        if np.shape(load) != np.shape(x):
            raise FabricError(f"{name}: {np.size(load)} loads of the {yarn}, {np.size(x)} strains.")
        alone = slope * x if curve is None else curve(x)
        alone = alone + sum((TENSION.lead(one, x) for one in sliders), np.zeros_like(x))
        gains.append(load - alone)
    apart = np.abs(gains[0] - gains[1]).max()
    if apart > AGREE * np.abs(gains).max():
        raise FabricError(
            f"{name}: what warp and weft gain differs by {apart:.3g} of {np.abs(gains).max():.3g} "
            "N/m, while an energy gives both the same: check the loads of all tension tests."
        )
    return Curve(tuple(x), tuple(np.mean(gains, axis=0)), False, name)


def _shear(q: dict, where: str) -> Part:
    ways = [
        ("angle", "shear_load", "[shear_unload]"),
        ("G", "[2HG]", "[2HG5]"),
        ("EB5",),
    ]
    way = one_of(q, ways, "shear", where)
    name = f"{where}: shear"
    if way == "angle":
        return loop(q["angle"], q["shear_load"], q.get("shear_unload"), SHEAR, name)
    if way == "EB5":
        return None, 1.23 / q["EB5"], ()
    return shear_loop(q["G"], q.get("2HG"), q.get("2HG5"), name)


def _bending(q: dict, yarn: str, where: str) -> Part:
    length, B = f"bending_length_{yarn}", f"B_{yarn}"
    ways = [(f"curvature_{yarn}", f"moment_{yarn}", f"[unbend_{yarn}]"), (B, f"[2HB_{yarn}]")]
    name = f"{where}: bending along the {yarn}"
    if length in q:
        by_length = q[length] ** 3 * q["weight"] * GRAVITY
        if B in q and abs(by_length / q[B] - 1) > AGREE:
            raise FabricError(
                f"{name}: B = {q[B]:.3g} N m disagrees with c^3 w g = {by_length:.3g} N m of the "
                f"bending length {1e3 * q[length]:.3g} mm (half the overhang of D1388): check "
                "both, or leave one out."
            )
        if B not in q and f"curvature_{yarn}" not in q:
            q = q | {B: by_length}
    else:
        ways.append((length,))
    way = one_of(q, ways, f"bending along the {yarn}", where)
    if way == B:
        return bending_loop(q[B], q.get(f"2HB_{yarn}"))
    part = loop(q[way], q[f"moment_{yarn}"], q.get(f"unbend_{yarn}"), BENDING, name)
    if length in q:
        _check_by_length(by_length, q[way], q[f"moment_{yarn}"], name)
    return part


def _check_by_length(by_length: float, curvature: np.ndarray, moment: np.ndarray, name: str):
    """FabricError if c^3 w g of a bending length is no stiffness of a measured curve."""
    secants = moment[1:] / curvature[1:]
    slopes = np.diff(moment) / np.diff(curvature)
    low, high = min(secants.min(), slopes.min()), max(secants.max(), slopes.max())
    if not low * (1 - AGREE) <= by_length <= high * (1 + AGREE):
        raise FabricError(
            f"{name}: c^3 w g = {by_length:.3g} N m of the bending length lies outside the "
            f"stiffnesses of the curve, {low:.3g} to {high:.3g} N m: check both, or leave one out."
        )
