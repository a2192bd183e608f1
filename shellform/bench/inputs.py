# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a card leaves open: numbers that are estimated, with their spread, and forms that are taken.

Estimates spread by the factors of the card's provenance, or, where it gives none, by those of the
prior for cloth of that mass (material/prior.py). A band is the answer at the factors between which
8 of 10 such fabrics lie: what is not measured is not known better.
"""

from dataclasses import replace

import numpy as np

from shellform.material.curve import Curve
from shellform.material.fabric import Fabric
from shellform.material.friction import Elements
from shellform.material.measured import Measured
from shellform.material.prior import SHEAR, bending_prior

SPREADING = ("bending", "shear")


def spreads(fabric: Fabric) -> dict[str, tuple[float, float]]:
    """Factors (low, high) of what is estimated, of bending and shear; empty where none is."""
    known = fabric.provenance
    if known is None:
        return {}
    low, middle, high = bending_prior(fabric.areal_mass, "warp")
    prior = {
        "bending": (low / middle, high / middle),
        "shear": (SHEAR[0] / SHEAR[1], SHEAR[2] / SHEAR[1]),
    }
    return {
        name: known.spread.get(name, prior[name]) for name in SPREADING if name in known.estimated
    }


def scaled(fabric: Fabric, quantity: str, factor: float) -> Fabric:
    """The fabric with its bending, or its shear, so many times as stiff, friction and all.

    ValueError for another quantity
    """
    if quantity not in SPREADING:
        raise ValueError(f"{', '.join(SPREADING)} can be scaled, not {quantity!r}")
    law, friction = fabric.law, fabric.friction
    bends = quantity == "bending"
    membrane, bending = np.array(fabric.membrane), np.array(fabric.bending)
    if bends:
        bending *= factor
    else:
        membrane[2, 2] *= factor
    curves = ("bend_warp", "bend_weft") if bends else ("shear_angle",)
    sliders = ("bend_warp", "bend_weft", "twist") if bends else ("shear",)
    # the moment of fourth order follows from the two
    fourth = 1.8 * bending @ np.linalg.solve(membrane, bending)
    fabric = replace(
        fabric, membrane=membrane, bending=bending, fourth_moment=0.5 * (fourth + fourth.T)
    )
    if isinstance(law, Measured):
        law = replace(law, **{name: _curve(getattr(law, name), factor) for name in curves})
    if friction is not None:
        more = {name: _elements(getattr(friction, name), factor) for name in sliders}
        friction = replace(friction, **more)
    return fabric.with_law(law).with_friction(friction)


def _curve(curve: Curve | None, factor: float) -> Curve | None:
    if curve is None:
        return None
    return replace(curve, y=tuple(factor * y for y in curve.y))


def _elements(elements: Elements, factor: float) -> Elements:
    return tuple((factor * k, factor * m, factor * g) for k, m, g in elements)


def lines(fabric: Fabric) -> list[str]:
    """For a person: inputs that are measured, those estimated, and what the card leaves open."""
    known = fabric.provenance
    said = "the card does not say what is measured: give it a table [provenance]"
    if known is not None:
        said = known.line()
    return [f"{fabric.name}: {said}", *(f"  {line}" for line in taken(fabric))]


def taken(fabric: Fabric) -> list[str]:
    """What no test of the card gives, in words."""
    table = (fabric.card or {}).get("measured", {})

    def has(*names):
        return any(key.startswith(name) for key in table for name in names)

    found = []
    if has("LT_", "WT_") and not has("stretch_"):
        found.append("the form of the curve of tension, of which EMT and LT are given")
    if has("2HB_") and not has("curvature_"):
        found.append("from where on yarns slip in bending, 5 per metre")
    if has("2HG") and not has("angle"):
        found.append("from where on yarns slip in shear, 0.01 rad")
    if not has("B_twist") and "bending_twist_N_m" not in table:
        found.append("the stiffness against twist, by Huber's mean, where the card has none")
    return [f"taken, not measured: {one}" for one in found]
