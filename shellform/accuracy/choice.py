# SPDX-License-Identifier: LGPL-3.0-or-later
"""Error against cost, as measured: the cheapest setting for an error asked for.

Scenes whose solution is known, or known well from finer meshes, were run with cells of many sizes
(`demos/studies/accuracy/run.py`, which writes the table read here). The relative error of a
quantity is

    error^2 = (s C r^p + own)^2 + spread^2,   r = h/l,

h the size of a cell, l the length that matters in the scene: the radius to which the sheet is bent
or on which it lies, or where it hangs free the bending length (D/(m g))^(1/3). C and p are fitted;
s is the scene's own sensitivity, by which its error is larger than a cell's (a long belt adds up
the errors of its cells); `own` is what the scene itself leaves however small the cells. The spread
is what another start changes where folds choose among many states: no cell size helps below it,
but the mean of n runs has only 1/sqrt(n) of it.

Of a walk the error is that of the root mean square of the torque about hips and knees, each
relative to itself; peak and course of the mean curve are predicted beside it. Cells and runs are
chosen together: runs so many that the mean curve is known to what is asked (ensemble_size.py).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Protocol

from .asked import percent, relative_error
from .convergence import FLAT, PowerLaw
from .ensemble_size import runs_needed
from .measured import TABLE, power_laws

# cells in a garment, by the word: size over the length that matters; none are larger than those of
# a draft
GARMENT = {"draft": 2.0, "standard": 1.4, "fine": 1.0}
POOR = 0.1  # spreads and doubts above it are named
LIMB = 0.0525  # m, radius of a limb where trousers meet it
# families of the walks measured, by the bending length of their cloth: compliant (17 mm) and stiff
# (40 mm), parted at the geometric mean
CLOTH, STIFF_CLOTH, STIFF = "quads", "quads, stiff cloth", 0.026  # m
# which quantity of a case an error is asked of
LEADING = {
    "roll_up": "position",
    "capstan": "force",
    "strip": "position",
    "sleeve": "torque",
    "drape": "shape",
    "walk": "torque rms",
}


class Bends(Protocol):
    """A fabric, as far as its own weight bends it."""

    def bending_length(self, g: float = ..., degrees: float = ...) -> float:
        """Length [m] of cloth whose weight bends it by some degrees."""


def garment_length(fabric: Bends) -> float:
    """Length [m] that matters for a garment: what folds, and what lies on a limb.

    A cell of a third of a limb's radius leaves (1/3)^2/12 = 1 % of mu phi of what a sliding cloth
    pulls with, see demos/capstan.py.
    """
    return min(_fold_length(fabric), LIMB / 3)


def cloth_family(fabric: Bends) -> str:
    """Which of the walks measured a garment of a fabric is like."""
    return STIFF_CLOTH if _fold_length(fabric) > STIFF else CLOTH


def _fold_length(fabric):
    return math.sqrt(fabric.bending_length() * fabric.bending_length(degrees=90.0))


@dataclass(frozen=True)
class Choice:
    """A size of cells and the errors it is predicted to leave.

    Attributes
    ----------
    case, family : what was measured
    asked : float, relative error, or a word; None where a size of cells was given instead
    length : l [m]; ratio : h/l; predicted : {quantity: relative error}
    kept : bool, whether the error asked for can be promised; power_laws : {quantity: PowerLaw} of
    a single run; runs : whose mean is reported
    """

    case: str
    family: str
    asked: float | str | None
    length: float
    ratio: float
    kept: bool = True
    sensitivity: float = 1.0
    own: float = 0.0
    power_laws: dict = field(default_factory=dict, repr=False)
    runs: int = 1

    @property
    def size(self) -> float:
        """Size of a cell [m]."""
        return self.ratio * self.length

    @property
    def power_law(self) -> PowerLaw:
        """How the error of the quantity asked for goes with the size, in the mean of the runs."""
        return self.power_laws[LEADING[self.case]].of_runs(self.runs)

    @property
    def order(self) -> float:
        """Power of the size with which the error goes, 1 where none was measured."""
        return self.power_law.order if self.power_laws else 1.0

    @property
    def predicted(self) -> dict[str, float]:
        """Errors predicted, by quantity."""
        return {
            name: law.of_runs(self.runs).error(self.ratio, self.sensitivity, self.own)
            for name, law in self.power_laws.items()
        }

    @property
    def error(self) -> float:
        """Error predicted for the quantity asked for."""
        return self.predicted.get(LEADING[self.case], math.nan)

    def at(self, size: float) -> Choice:
        """The same with cells of another size [m], as a whole number of them asks for."""
        return replace(self, ratio=size / self.length)

    @property
    def promised(self) -> bool | None:
        """Whether the error predicted is what was asked for; None if nothing was."""
        if self.asked is None:
            return None
        goal = relative_error(self.asked, self.case)
        return bool(self.kept and self.error <= goal * (1 + 1e-9))

    @property
    def wish(self) -> str:
        """What was asked for, as a text."""
        if self.asked is None:
            return "cells as given"
        return f"accuracy {self.asked if isinstance(self.asked, str) else percent(self.asked)}"

    def lines(self, seconds: float | None = None) -> list[str]:
        """Lines for a person, before the start; seconds : predicted [s] or None."""
        quantity, wish = LEADING[self.case], self.wish
        said = ", ".join(f"{name} {percent(e)}" for name, e in self.predicted.items())
        mean = f", mean of {self.runs} runs" if self.runs > 1 else ""
        lines = [
            f"{wish}: {self.family}, cells of {1e3 * self.size:.3g} mm = "
            f"{self.ratio:.3g} of {1e3 * self.length:.3g} mm{mean}; predicted errors: {said}"
            + (f"; about {_time(seconds)}" if seconds is not None else "")
            + (" a run" if seconds is not None and self.runs > 1 else "")
        ]
        law = self.power_law if self.power_laws else PowerLaw(0.0, 1.0)
        spread, doubt = law.spread, law.doubt
        if spread > POOR:
            lines.append(f"of {quantity} another start alone changes {percent(spread)}")
        if doubt > POOR:
            lines.append(
                f"errors of {quantity} were measured against a value that is itself known to "
                f"{percent(doubt)}: take them for a guess"
            )
        if not self.kept and self.asked is not None:
            if spread >= relative_error(self.asked, self.case):
                why = f"runs from another start differ by {percent(spread)}"
            elif self.power_law.order < FLAT:
                why = f"errors show no order in the cells' size; any leave {percent(self.error)}"
            else:
                why = f"cells so fine have not been measured; these leave {percent(self.error)}"
            lines.append(f"{wish} of {quantity} cannot be promised: {why}")
        return lines

    def summary(self, estimated: float | None, how: str) -> dict:
        """`accuracy` of summary.json: estimated : relative error reached, or None; how : text."""
        one = self.power_laws[LEADING[self.case]].spread if self.power_laws else None
        return {
            "asked": self.asked,
            "of": LEADING[self.case],
            "predicted": self.error if self.power_laws else None,
            "predicted_all": self.predicted,
            "promised": self.promised,
            "another_start_changes": one,
            "runs": self.runs,
            "measured_against_known_to": self.power_law.doubt if self.power_laws else None,
            "estimated": estimated,
            "how": how,
            "cell_size": self.size,
        }


def choose(
    case: str,
    asked: float | str,
    length: float,
    sensitivity: float = 1.0,
    own: float = 0.0,
    families: Sequence[str] | None = None,
    work: Callable[[str, float], float] | None = None,
    table: Path = TABLE,
) -> Choice:
    """The cheapest setting for an error.

    Parameters
    ----------
    case : key of LEADING; asked : relative error, 'N%' or a word; length : l [m]
    sensitivity, own : see the header
    families : those to choose from, None: the first measured
    work : function (family, ratio) -> cost to compare families by, needed for several

    Raises
    ------
    ValueError for an error that is none
    """
    error, runs, known = relative_error(asked, case), 1, power_laws(case, table)
    families = families or [next(iter(known))]
    if case == "walk":
        runs = runs_needed(asked, table)
        if asked in GARMENT:
            # a word fixes the cells
            family, ratio = families[0], GARMENT[asked]
            laws = known[family]
            return Choice(case, family, asked, length, ratio, power_laws=laws, runs=runs)
    found = []
    for family in families:
        law = known[family][LEADING[case]].of_runs(runs)
        ratio, kept = law.ratio(error, sensitivity, own)
        if case == "walk":
            ratio = min(ratio, GARMENT["draft"])
        found.append(
            Choice(case, family, asked, length, ratio, kept, sensitivity, own, known[family], runs)
        )
    if len(found) == 1 or work is None:
        return found[0]
    return min(found, key=lambda c: (not c.kept, work(c.family, c.ratio)))


def accuracy_line(entry: dict) -> str:
    """A line for a person after a run, from `Choice.summary`."""
    if entry["predicted"] is None:
        return f"error of {entry['of']}: not measured, measured.csv has none of this case"
    mean = f", mean of {entry['runs']} runs" if entry["runs"] > 1 else ""
    line = f"error of {entry['of']}{mean}: predicted {percent(entry['predicted'])}"
    if entry["estimated"] is not None:
        line += f", estimated {percent(entry['estimated'])}"
    return f"{line} ({entry['how']})"


def _time(value):
    return f"{value:.2g} s" if value < 100 else f"{value / 60:.2g} minutes"
