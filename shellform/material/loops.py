# SPDX-License-Identifier: LGPL-3.0-or-later
"""Loops of fabric tests as a curve and sliders: what comes back, and what does not.

A first loading to x_end and back leaves two branches, joined where it turns. Their distance is the
sum of what sliders of several kinds leave between them (friction.py): with yield stresses that
grow with the strain, and without, slipping from several parts of x_end on. Their shares, none
negative, are found by least squares (Lawson and Hanson's NNLS in scipy). What they bear on the way
up is taken off the loading branch: the rest is elastic, so that the loading comes out as measured.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import trapezoid
from scipy.optimize import nnls

from .curve import Curve
from .friction import Elements, follow
from .laminate import FabricError

CLOSED = 0.02  # of the largest load: by how much the ends of a loop may be apart
FIT = 0.1  # of the largest distance of the branches: by how much the fit may miss it
SLIPS = (0.02, 0.1, 0.3)  # parts of the largest strain from which kinds of sliders slip
BEND_SLIP, SHEAR_SLIP = 5.0, 0.01  # where sliders given by 2HB, 2HG slip [1/m], [rad]: estimates
AT = np.radians([0.5, 5.0])  # angles of 2HG and 2HG5

Part = tuple[Curve | None, float, Elements]  # a curve, its slope at rest, sliders


class Test(NamedTuple):
    """How a test's strain x and load y are those e and f of a slider: e = strain(x), y = rate f."""

    mirrored: bool
    strain: Callable
    rate: Callable

    def lead(self, element: tuple[float, float, float], x: np.ndarray) -> np.ndarray:
        """Loads of an element led along strains x (n,) of the test from rest."""
        return self.rate(x) * follow(element, self.strain(x))


TENSION = Test(False, lambda x: x + 0.5 * x**2, lambda x: 1 + x)  # elongation; Green's strain
SHEAR = Test(True, np.sin, np.cos)  # angle; 2 E12 of yarns that keep their length
BENDING = Test(True, lambda x: x, np.ones_like)


def loop(x: ArrayLike, y: ArrayLike, back: ArrayLike | None, test: Test, name: str) -> Part:
    """Curve and sliders of branches measured at the same strains.

    Parameters
    ----------
    x, y : (n,), strains and loads from (0, 0); back : (n,), loads on the way back, or None
    test : TENSION, SHEAR or BENDING; name : begins messages

    Raises
    ------
    FabricError : a loop that is not closed, or that gives energy away
    """
    x, y = np.array(x), np.array(y)
    whole = Curve(tuple(x), tuple(y), test.mirrored, name)
    if back is None:
        return whole, whole.at_rest, ()
    back = np.array(back)
    check_loop(x, y, back, test, name)
    elements = sliders_between(whole, x, y - back, test, name)
    bearing = sum((test.lead(one, x) for one in elements), np.zeros_like(y))
    elastic = Curve(tuple(x), tuple(y - bearing), test.mirrored, f"{name} less friction")
    return elastic, elastic.at_rest, elements


def check_loop(x: np.ndarray, y: np.ndarray, back: np.ndarray, test: Test, name: str) -> None:
    """FabricError for a loop that is open, or where unloading lies above loading.

    Cloth that is bent or sheared back to nothing still pushes on, so there the loop is open.
    """
    if back.shape != y.shape:
        raise FabricError(
            f"{name}: {len(back)} loads on the way back, {len(y)} on the way up: give both at the "
            "same strains."
        )
    for end, there in ((0, "at rest"), (-1, "at the largest strain")):
        if end == 0 and test.mirrored:
            continue
        if abs(back[end] - y[end]) > CLOSED * y[-1]:
            raise FabricError(
                f"{name}: the loop is not closed {there}, where loading has {y[end]:g} and "
                f"unloading {back[end]:g}: the branches meet there."
            )
    falls = np.flatnonzero(np.diff(back) < 0)
    if len(falls):
        k = falls[0] + 1
        raise FabricError(
            f"{name}: the slope of the unloading is negative at point {k + 1}, where the load goes "
            f"from {back[k - 1]:g} to {back[k]:g}: smooth it."
        )
    above = np.flatnonzero(back > y + 1e-9 * y[-1])
    if len(above):
        k = above[0]
        raise FabricError(
            f"{name}: at the strain {x[k]:g} unloading, {back[k]:g}, lies above loading, {y[k]:g}: "
            "were the two branches taken for each other?"
        )


def sliders_between(
    curve: Curve, x: np.ndarray, distance: np.ndarray, test: Test, name: str
) -> Elements:
    """Sliders whose branches are `distance` (n,) apart at strains x (n,) of a cycle.

    FabricError where the best ones miss it by more than FIT.
    """
    end = x[-1]
    fine = np.unique(np.concatenate([np.linspace(0.0, end, 400), x]))
    kinds = [(1.0, part * end, 0.0) for part in SLIPS] + [(1.0, 0.0, 0.5), (1.0, 0.0, 0.1)]
    columns = []
    for kind in kinds:
        path = test.lead(kind, np.concatenate([fine, fine[-2::-1]]))
        up, down = path[: len(fine)], path[len(fine) - 1 :][::-1]
        columns.append(np.interp(x, fine, up - down))
    shares, _ = nnls(np.array(columns).T, distance)
    gap = np.abs(np.array(columns).T @ shares - distance).max()
    if gap > FIT * distance.max(initial=0.0) and gap > CLOSED * curve.y[-1]:
        raise FabricError(
            f"{name}: no friction inside the cloth opens this loop, the best misses the distance "
            f"of its branches by {gap:.3g} of {distance.max():.3g}: check the unloading."
        )
    return tuple(
        (share * k, share * m, share * g)
        for share, (k, m, g) in zip(shares.tolist(), kinds, strict=True)
        if share * (k * end) > 1e-6 * curve.y[-1]
    )


def decrimping(
    EMT: float, LT: float, most: float, RT: float, name: str
) -> tuple[np.ndarray, np.ndarray]:
    """Points of a load curve up to `most` [N/m] at EMT, with the work LT most EMT/2 (Kawabata).

    A line, steep enough to bear the friction that RT leaves, and a power of the stretch: estimates
    of the form, not measured.
    """
    if not 0.2 <= LT <= 1:
        raise FabricError(
            f"{name}: LT = {LT:g} is outside 0.2 to 1: it is the work over that of a straight line."
        )
    straight = min(0.1 + (1 - RT) * LT, 0.8 * LT)
    power = 2 * (1 - straight) / (LT - straight) - 1
    part = np.linspace(0.0, 1.0, 9)
    return EMT * part, most * (straight * part + (1 - straight) * part**power)


def tension_loop(x: np.ndarray, y: np.ndarray, RT: float, name: str) -> Part:
    """Curve and slider of a load curve of which a part RT of the work comes back."""
    curve = Curve(tuple(x), tuple(y), False, name)
    if RT == 1:
        return curve, curve.at_rest, ()
    k_over_g = 20.0
    fine = np.linspace(0.0, x[-1], 2001)
    kind = (k_over_g, 0.0, 1.0)
    path = TENSION.lead(kind, np.concatenate([fine, fine[-2::-1]]))
    up, down = path[: len(fine)], path[len(fine) - 1 :][::-1]
    lost = (1 - RT) * float(curve(x[-1], 0))
    share = lost / float(trapezoid(up - down, fine))
    element = share * kind[0], 0.0, share
    bearing = TENSION.lead(element, x)
    try:
        elastic = Curve(tuple(x), tuple(y - bearing), False, name)
    except FabricError:
        raise FabricError(
            f"{name}: RT = {RT:g} leaves nothing elastic at small stretch: cloth gives back half "
            "of the work or more."
        ) from None
    return elastic, elastic.at_rest, (element,)


def shear_loop(G: float, HG2: float | None, HG52: float | None, name: str) -> Part:
    """Slope and slider of G [N/m], 2HG at 0.5 and 2HG5 at 5 degrees [N/m].

    Branches lie 2 (m + g gamma) apart. G is the slope of a branch, so that of what is elastic is
    less by g.
    """
    if HG2 is None:
        if HG52 is not None:
            raise FabricError(f"{name}: 2HG5 goes with 2HG, which is missing.")
        return None, G, ()
    low, high = 0.5 * HG2, 0.5 * (HG2 if HG52 is None else HG52)
    growth = (high - low) / (AT[1] - AT[0])
    if growth < 0:
        raise FabricError(
            f"{name}: 2HG5 = {2 * high:.3g} N/m at 5 degrees is below 2HG = {2 * low:.3g} N/m at "
            "0.5 degrees: are they exchanged?"
        )
    yields = low - growth * AT[0]
    if yields < 0 or growth >= G:
        raise FabricError(
            f"{name}: between 2HG = {2 * low:.3g} and 2HG5 = {2 * high:.3g} N/m the loop opens "
            f"faster than G = {G:.3g} N/m allows: check the units of the three."
        )
    return None, G - growth, ((max(yields / SHEAR_SLIP, 2 * growth) + growth, yields, growth),)


def bending_loop(B: float, HB2: float | None) -> Part:
    """Slope and slider of B [N m] and 2HB [N]."""
    if HB2 is None:
        return None, B, ()
    return None, B, ((0.5 * HB2 / BEND_SLIP, 0.5 * HB2, 0.0),)
