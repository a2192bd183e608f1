# SPDX-License-Identifier: LGPL-3.0-or-later
"""A specimen led to and fro: strains, loads, and what the card says the loads are (Fig. 3).

The load is the one that works on the strain: per area at rest, dW = load d(strain). The card's load
along the same strains is the slope of what its law stores and what its sliders bear (friction.py),
computed from the card alone, without a mesh:

    pull    E11 = e + e^2/2,     load per width against elongation, the other yarn held
    shear   2 E12 = sin gamma,   load per width against angle, yarns of constant length
    bend    K11 = kappa,         moment per width against curvature, the other way flat
"""

from dataclasses import dataclass, replace

import numpy as np

import ufl

from shellform.material.curve import Curve
from shellform.material.fabric import Fabric
from shellform.material.friction import follow
from shellform.material.measured import Measured
from shellform.material.sheet import Sheet

STEP = 1e-5  # of a strain, in differences of the energy
KINDS = ("pull", "shear", "bend")
LAST = {"pull": 0.2, "shear": np.radians(8.0), "bend": 250.0}  # KES: 8 degrees, 2.5 per cm
KES_LOAD = 490.3325  # N/m, 500 gf/cm
UNITS = {"pull": ("-", "N/m"), "shear": ("rad", "N/m"), "bend": ("1/m", "N")}


@dataclass(frozen=True)
class Cycle:
    """Strains and loads (n,) of a specimen, from rest, and the card's loads (n,) along them.

    kind : of KINDS; yarn : "warp" or "weft", of shear ""; expected : None where a card's law does
    not say it without a mesh
    """

    kind: str
    yarn: str
    strain: np.ndarray
    load: np.ndarray
    expected: np.ndarray | None

    @property
    def name(self) -> str:
        """As "bend weft"."""
        return f"{self.kind} {self.yarn}".strip()

    def error(self) -> float | None:
        """Largest difference of the two loads over the largest load."""
        if self.expected is None:
            return None
        return float(np.abs(self.load - self.expected).max() / np.abs(self.expected).max())

    def results(self) -> dict:
        """For summary.json."""
        strain, load = UNITS[self.kind]
        return {
            "strain": self.strain, "load": self.load, "expected": self.expected,
            "units": {"strain": strain, "load": load}, "largest_error": self.error(),
        }  # fmt: skip


def curve_of(fabric: Sheet, kind: str, yarn: str = "") -> Curve | None:
    """Measured curve of a fabric, None where it has none."""
    if not isinstance(fabric.law, Measured):
        return None
    law = fabric.law
    if kind == "shear":
        return law.shear_angle
    if kind == "pull":
        return law.warp if yarn == "warp" else law.weft
    return law.bend_warp if yarn == "warp" else law.bend_weft


def largest_strain(fabric: Sheet, kind: str, yarn: str = "") -> float:
    """How far a specimen is led: to the end of its curve, or as KES does.

    Pulls go to 500 gf/cm, or to 20 % where the card has not this much before.
    """
    curve = curve_of(fabric, kind, yarn)
    if curve is not None:
        return curve.x[-1]
    if kind == "pull":
        row = 1 if yarn == "weft" else 0
        return min(LAST["pull"], KES_LOAD / float(fabric.membrane[row, row]))
    return LAST[kind]


def path(kind: str, most: float, points: int) -> np.ndarray:
    """Strains after rest: up and back of a pull, else to one side, to the other, and again."""
    up = np.linspace(0.0, most, points + 1)[1:]
    if kind == "pull":
        return np.r_[up, up[-2::-1], 0.0]
    around = np.linspace(most, -most, 2 * points + 1)[1:]
    return np.r_[up, around, -around]


def says_its_loads(fabric: Sheet) -> bool:
    """True where the loads follow without a mesh: nothing couples stretching and bending."""
    couples = fabric.law is not None and fabric.law.couples
    return not (couples or np.any(fabric.coupling))


def expected_loads(fabric: Sheet, kind: str, yarn: str, strains: np.ndarray) -> np.ndarray:
    """Loads (n,) of the card along strains (n,) from rest.

    Raises
    ------
    ValueError for a fabric whose stretching and bending are coupled
    """
    if not says_its_loads(fabric):
        raise ValueError(f"'{fabric.name}' couples stretching and bending: its loads need a mesh")
    curve = curve_of(fabric, kind, yarn)
    loads = elastic(fabric, kind, yarn, strains) if curve is None else curve(strains)
    if fabric.friction is None:
        return loads
    row = {"pull": 0, "shear": 2, "bend": 3}[kind] + (yarn == "weft")
    strain, rate = {
        "pull": (strains + 0.5 * strains**2, 1 + strains),
        "shear": (np.sin(strains), np.cos(strains)),
        "bend": (strains, np.ones_like(strains)),
    }[kind]
    for element in fabric.friction.elements()[row]:
        loads = loads + rate * follow(element, strain)
    return loads


def elastic(fabric: Sheet, kind: str, yarn: str, strains: np.ndarray) -> np.ndarray:
    """Slopes (n,) of the energy of the fabric's law, by central differences."""
    A, D = (ufl.as_matrix(m.tolist()) for m in (fabric.membrane, fabric.bending))
    i = 1 if yarn == "weft" else 0

    def energy(x):
        E, K = np.zeros(3), np.zeros(3)
        if kind == "pull":
            E[i] = x + 0.5 * x**2
        elif kind == "shear":
            E[2] = np.sin(x)
        else:
            K[i] = x
        if fabric.law is None:
            return 0.5 * E @ fabric.membrane @ E + 0.5 * K @ fabric.bending @ K
        E, K = (ufl.as_vector(v.tolist()) for v in (E, K))
        return float(ufl.as_ufl(fabric.law.membrane_and_bending(E, K, A, D))(()))

    h = STEP * LAST[kind] / LAST["pull"]
    return np.array([(energy(x + h) - energy(x - h)) / (2 * h) for x in strains])


def hardly_pulled(fabric: Fabric) -> Fabric:
    """The fabric without friction of tension, for specimens that bend: it yields at any strain."""
    if fabric.friction is None:
        return fabric
    return fabric.with_friction(replace(fabric.friction, tension_warp=(), tension_weft=()))
