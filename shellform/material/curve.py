# SPDX-License-Identifier: LGPL-3.0-or-later
"""A measured curve as a law of one strain: load against strain, its slope and its energy (Fig. 3).

Points (x, y) from (0, 0) up are joined by monotone cubics (Fritsch and Carlson, SIAM J. Numer.
Anal. 17, 1980; scipy's PCHIP), and past the last one by a line of the slope there. What is stored,

    w(x) = integral of y from 0 to x,

is the exact integral of these pieces. Below zero a curve is its mirror (shear, bending), or, of
cloth that is measured in tension alone, the line of the slope at rest.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

from .laminate import FabricError

LEAST = 0.25  # slope at rest over that of the first piece, at least: a toe is not without stiffness


@dataclass(frozen=True)
class Curve:
    """A curve through points.

    Parameters
    ----------
    x, y : tuples of numbers, strain and load from (0, 0), both rising
    mirrored : True where below zero the curve is its mirror, False where it is a line
    name : what the points are, for messages

    Raises
    ------
    FabricError naming curve, value and mend
    """

    x: tuple[float, ...]
    y: tuple[float, ...]
    mirrored: bool
    name: str = field(default="curve", compare=False, repr=False)

    def __post_init__(self) -> None:
        try:
            x, y = (np.array(values, float) for values in (self.x, self.y))
        except (TypeError, ValueError):
            raise FabricError(
                f"{self.name}: points are numbers, not {self.x!r}, {self.y!r}."
            ) from None
        if x.ndim != 1 or x.shape != y.shape or len(x) < 2:
            raise FabricError(
                f"{self.name}: two numbers or more, and as many loads as strains, not {x.size} "
                f"strains and {y.size} loads."
            )
        if not (np.isfinite(x).all() and np.isfinite(y).all()):
            raise FabricError(
                f"{self.name}: a point is no finite number: {x.tolist()}, {y.tolist()}."
            )
        if x[0] != 0 or y[0] != 0:
            raise FabricError(
                f"{self.name}: begins at ({x[0]:g}, {y[0]:g}), not at (0, 0): take the load at "
                "rest off, or add the point (0, 0)."
            )
        for k in range(1, len(x)):
            if x[k] <= x[k - 1]:
                raise FabricError(
                    f"{self.name}: the strain goes from {x[k - 1]:g} to {x[k]:g} at point {k + 1}: "
                    "give points in rising order, each once."
                )
            if y[k] <= y[k - 1]:
                raise FabricError(
                    f"{self.name}: the slope is not positive at point {k + 1}, where the load goes "
                    f"from {y[k - 1]:g} to {y[k]:g}: end the curve before it, or smooth it."
                )
        object.__setattr__(self, "x", tuple(x.tolist()))
        object.__setattr__(self, "y", tuple(y.tolist()))

    @cached_property
    def slopes(self) -> np.ndarray:
        """Slopes (n,) at the points; positive at the first and the last."""
        x, y = np.array(self.x), np.array(self.y)
        secants = np.diff(y) / np.diff(x)
        if len(x) == 2:
            return np.repeat(secants, 2)
        if self.mirrored:
            both = PchipInterpolator(np.r_[-x[:0:-1], x], np.r_[-y[:0:-1], y])
            slopes = both.derivative()(x)
        else:
            slopes = PchipInterpolator(x, y).derivative()(x)
            slopes[0] = max(slopes[0], LEAST * secants[0])
        slopes[-1] = max(slopes[-1], LEAST * secants[-1])
        return slopes

    @cached_property
    def pieces(self) -> np.ndarray:
        """Coefficients (n, 5) of w in powers 0 to 4 of x less the point where a piece begins."""
        spline = CubicHermiteSpline(np.array(self.x), np.array(self.y), self.slopes)
        pieces = np.zeros((len(self.x), 5))
        pieces[:-1, 1:] = spline.c[::-1].T / [1, 2, 3, 4]
        pieces[-1, 1:3] = self.y[-1], 0.5 * self.slopes[-1]
        width = np.diff(self.x)
        stored = np.sum(pieces[:-1] * width[:, None] ** np.arange(5), axis=1)
        pieces[1:, 0] = np.cumsum(stored)
        return pieces

    @property
    def at_rest(self) -> float:
        """Slope at zero."""
        return float(self.slopes[0])

    @cached_property
    def steepest(self) -> float:
        """Largest slope anywhere."""
        x = np.linspace(0.0, self.x[-1], 50 * len(self.x))
        return float(max(self(x, 2).max(), self.at_rest))

    def __call__(self, x: Any, derivative: int = 1) -> np.ndarray:
        """Load y at strains x; with derivative 0 what is stored, with 2 the slope."""
        x = np.asarray(x, float)
        u = np.abs(x) if self.mirrored else np.maximum(x, 0.0)
        k = np.searchsorted(self.x, u, side="right") - 1
        t, c = u - np.array(self.x)[k], self.pieces[k]
        value = np.zeros_like(u)
        for power in range(4, derivative - 1, -1):
            factor = np.prod(np.arange(power - derivative + 1, power + 1))
            value = value * t + factor * c[..., power]
        if self.mirrored:
            return np.where((x < 0) & (derivative == 1), -value, value)
        line = self.at_rest * (0.5 * x**2, x, np.ones_like(x))[derivative]
        return np.where(x < 0, line, value)

    def energy(self, x: Any, choose: Callable, below: Callable) -> Any:
        """w of an expression; `choose(condition, if true, else)` and `below(a, b)` as in UFL."""
        u = choose(below(x, 0.0), -x, x) if self.mirrored else x
        value = self._piece(u, len(self.x) - 1)
        for k in range(len(self.x) - 2, -1, -1):
            value = choose(below(u, self.x[k + 1]), self._piece(u, k), value)
        if self.mirrored:
            return value
        return choose(below(x, 0.0), 0.5 * self.at_rest * x * x, value)

    def _piece(self, u, k):
        t, value = u - self.x[k], 0.0
        for c in self.pieces[k, ::-1].tolist():
            value = value * t + c
        return value
