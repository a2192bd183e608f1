# SPDX-License-Identifier: LGPL-3.0-or-later
"""Friction inside the cloth: yarns that slip on each other (Jenkins elements; Fig. 3's loops).

In a strain e, several springs k act side by side, each in series with a slider that yields at m
(Iwan, J. Appl. Mech. 33, 1966), or at more where the yarns press harder as the strain grows:

    stress = sum of clip(k (e - p), -Y, Y),    Y = m + g |e|,    p the slip of a slider.

Rate does not matter. On a first loading a slider slips from m/(k - g) on; turned back from a large
strain, the branches lie 2 Y apart. A closed cycle loses the area between them: with g = 0, 4 m (a -
m/k) at the amplitude a > m/k.
"""

from collections.abc import Iterable
from dataclasses import dataclass, fields

import numpy as np

from .laminate import FabricError

Elements = tuple[tuple[float, float, float], ...]  # (k, m, g)


@dataclass(frozen=True)
class ClothFriction:
    """Springs in series with sliders, (k, m) or (k, m, g), in each strain of a sheet.

    Parameters
    ----------
    tension_warp, tension_weft, shear : k, m and g [N/m] of E11, E22, 2 E12
    bend_warp, bend_weft, twist : k, g [N m] and m [N] of K11, K22, 2 K12

    Raises
    ------
    FabricError for numbers that no slider can have

    Examples
    --------
    >>> ClothFriction(bend_warp=[(6e-5, 3e-4)]).bend_warp
    ((6e-05, 0.0003, 0.0),)
    """

    tension_warp: Elements = ()
    tension_weft: Elements = ()
    shear: Elements = ()
    bend_warp: Elements = ()
    bend_weft: Elements = ()
    twist: Elements = ()

    def __post_init__(self) -> None:
        for item in fields(self):
            elements = tuple(_element(item.name, given) for given in getattr(self, item.name))
            object.__setattr__(self, item.name, elements)

    def elements(self) -> list[Elements]:
        """Elements by strain, E11, E22, 2 E12, K11, K22, 2 K12."""
        return [getattr(self, item.name) for item in fields(self)]

    def summary(self) -> str:
        """Where there are sliders and what they yield at from rest, in words."""
        units = ["N/m"] * 3 + ["N"] * 3
        names = (item.name.replace("_", " ") for item in fields(self))
        return ", ".join(
            f"{name} {sum(m for _, m, _ in some):.3g} {unit}"
            for name, some, unit in zip(names, self.elements(), units, strict=True)
            if some
        )

    def counts(self) -> list[int]:
        """How many sliders each strain has."""
        return [len(elements) for elements in self.elements()]

    def table(self) -> np.ndarray:
        """All elements (s, 3), strain by strain."""
        return np.array([one for some in self.elements() for one in some]).reshape(-1, 3)

    def stresses(self, strains: np.ndarray, slips: np.ndarray) -> np.ndarray:
        """Stresses (m, s) that sliders bear at strains (m, 6), having slipped by slips (m, s)."""
        (k, m, g), e = self.table().T, np.repeat(strains, self.counts(), axis=1)
        most = m + g * np.abs(e)
        return np.clip(k * (e - slips), -most, most)

    def slips_that_bear(self, strains: np.ndarray, stresses: np.ndarray) -> np.ndarray:
        """Slips (m, s) with which sliders at strains (m, 6) bear stresses (m, s).

        What is beyond the yield stress is left out.
        """
        (k, m, g), e = self.table().T, np.repeat(strains, self.counts(), axis=1)
        most = m + g * np.abs(e)
        return e - np.clip(stresses, -most, most) / k


def _element(where: str, given: Iterable[float]) -> tuple[float, float, float]:
    numbers = tuple(float(number) for number in given)
    k, m, g = (*numbers, 0.0)[:3] if len(numbers) in (2, 3) else (0.0, 0.0, 0.0)
    if not (np.isfinite((k, m, g)).all() and min(m, g) >= 0 and m + g > 0 and k > g):
        raise FabricError(
            f"friction in {where}: a stiffness k, a yield stress m and its growth g, k > g >= 0, "
            f"m >= 0 and not both zero; not {numbers}"
        )
    return k, m, g


def follow(element: tuple[float, float, float], strains: np.ndarray) -> np.ndarray:
    """Stresses of an element led along strains (n,) from rest, step by step."""
    k, m, g = element
    slip, stress = 0.0, np.empty(len(strains))
    for i, e in enumerate(strains):
        most = m + g * abs(e)
        stress[i] = min(max(k * (e - slip), -most), most)
        slip = e - stress[i] / k
    return stress
