# SPDX-License-Identifier: LGPL-3.0-or-later
"""Loads as nodal forces and moments: the external part of Eqs. 2 and 14.

Dead loads (gravity, tractions, forces on lines and at points) do not depend on the motion, so they
are integrated once into nodal forces. A moment turns with nothing: m is fixed in space and works
on the spin of the director, r_d = m x d. Pressure follows the surface and is left to UFL.

Every load has an amplitude: a function of the load level or time. Without one it grows with the
level in statics and stands at its full value in dynamics. A load of zero is left out.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from .element import GAUSS3
from .lumped_mass import nodal_areas
from .partition import Partition, Place
from .shape_functions import surface_rule

# of the load level or time; a vector (3,), or a function of points (k, 3) that gives one each
Amplitude = Callable[[float], float]
Field = ArrayLike | Callable[[np.ndarray], ArrayLike]


class Loads:
    """Loads on the nodes of a partition.

    Attributes
    ----------
    forces : list of (amplitude, (n_owned, 3) [N])
    moments : list of (amplitude, owned nodes (k,), (k, 3) [N m])
    pressures : list of (amplitude, pressure [Pa]), positive along the director's side
    named : list of str, the kinds of load given, in their order
    """

    def __init__(self, partition: Partition, areal_mass: float):
        self.partition, self.areal_mass = partition, areal_mass
        self.forces: list[tuple] = []
        self.moments: list[tuple] = []
        self.pressures: list[tuple] = []
        self.named: list[str] = []
        self.frozen = False

    def freeze(self) -> None:
        """Take no more loads: explicit steps have taken these over."""
        self.frozen = True

    def _check_open(self):
        if self.frozen:
            raise ValueError("give all loads before the stepper is made; it has taken these over")

    def kinds(self) -> dict[str, int]:
        """Kinds of load on the sheet -> how many of each, without those of zero."""
        return {kind: self.named.count(kind) for kind in dict.fromkeys(self.named)}

    def point(self, where: Place, force: Field, amplitude: Amplitude | None = None) -> None:
        """Force (3,) [N] on *each* node at a place (see `Partition.find`)."""
        whole = np.zeros_like(self.partition.surface.points)
        whole[self.partition.find(where)] = _vector(force, "force", "N")
        self._add_forces("forces at points", whole, amplitude)

    def line(self, edge: str, force: Field, amplitude: Amplitude | None = None) -> None:
        """Force per length (3,) or function of points (k, 3) -> (k, 3) [N/m] along a named edge."""
        self._add_forces("forces on lines", self._along(edge, force, "line load", "N/m"), amplitude)

    def surface(self, traction: Field, amplitude: Amplitude | None = None) -> None:
        """Dead traction (3,) or function of points (k, 3) -> (k, 3) [Pa] on the whole surface."""
        surface = self.partition.surface
        whole = np.zeros_like(surface.points)
        for shape, weights, at in surface_rule(surface):
            value = _field(traction, at, "traction", "Pa") * weights[:, None]
            for i, node in enumerate(surface.cells.T):
                np.add.at(whole, node, shape[i] * value)
        self._add_forces("dead tractions", whole, amplitude)

    def gravity(
        self, acceleration: ArrayLike = (0.0, 0.0, -9.81), amplitude: Amplitude | None = None
    ) -> None:
        """Weight by an acceleration (3,) [m/s^2]; needs the fabric's areal mass."""
        g = _vector(acceleration, "gravity", "m/s^2")
        if self.areal_mass is None:
            raise ValueError("gravity needs a fabric with a density or an areal mass")
        _check(amplitude)
        if not g.any():
            return
        # on the nodal areas of the lumped mass: in free fall all nodes fall alike
        areas = nodal_areas(self.partition.surface)
        self._add_forces("gravity", self.areal_mass * areas[:, None] * g, amplitude)

    def edge_moment(self, edge: str, moment: Field, amplitude: Amplitude | None = None) -> None:
        """Moment per length (3,) [N m/m], fixed in space, on the directors of a named edge."""
        self._add_moments(
            "moments on lines", self._along(edge, moment, "edge moment", "N m/m"), amplitude
        )

    def point_moment(self, where: Place, moment: Field, amplitude: Amplitude | None = None) -> None:
        """Moment (3,) [N m], fixed in space, on the director of each node at a place."""
        whole = np.zeros_like(self.partition.surface.points)
        whole[self.partition.find(where)] = _vector(moment, "moment", "N m")
        self._add_moments("moments at points", whole, amplitude)

    def pressure(self, pressure: float, amplitude: Amplitude | None = None) -> None:
        """Pressure [Pa] that stays normal to the moving surface, positive towards the director."""
        if np.ndim(pressure) != 0 or not np.isfinite(pressure):
            raise ValueError(f"pressure must be one finite number of Pa, not {pressure}")
        self._check_open()
        _check(amplitude)
        if pressure == 0:
            return
        self.pressures.append((amplitude, float(pressure)))
        self.named.append("pressure")

    def steady(self) -> bool:
        """True if no load has an amplitude."""
        return not any(load[0] for load in (*self.forces, *self.moments, *self.pressures))

    def force_at(self, level: float, out: np.ndarray, default: float | None = None) -> np.ndarray:
        """Add the nodal forces (n_owned, 3) [N] at a level or time to `out`.

        `default` is the factor of loads without amplitude; None: the level.
        """
        for amplitude, nodal in self.forces:
            out += factor(amplitude, level, default) * nodal
        return out

    def pressure_at(self, level: float, default: float | None = None) -> float:
        """Sum of the pressures [Pa] at a level or time."""
        return sum(factor(a, level, default) * p for a, p in self.pressures)

    def moment_at(
        self, level: float, default: float | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Owned nodes (k,) that carry moments and the moments (k, 3) [N m] at a level or time."""
        if len(self.moments) == 1:
            amplitude, nodes, moments = self.moments[0]
            return nodes, factor(amplitude, level, default) * moments
        if not self.moments:
            return np.empty(0, int), np.empty((0, 3))
        nodes = np.unique(np.concatenate([load[1] for load in self.moments]))
        total = np.zeros((len(nodes), 3))
        for amplitude, at, moments in self.moments:
            total[np.searchsorted(nodes, at)] += factor(amplitude, level, default) * moments
        return nodes, total

    def _along(self, edge, value, what, unit):
        surface = self.partition.surface
        if not isinstance(edge, str):
            raise ValueError(
                f"a {what} needs the name of an edge; name one by surface.with_edges(NAME=locator)"
            )
        segments = self.partition.edge(edge)
        whole = np.zeros_like(surface.points)
        points = surface.points[segments]  # (k, 2 or 3, 3): two ends, middle
        for x, w in GAUSS3:
            if segments.shape[1] == 2:
                shape, slope = np.array([1 - x, x]), np.array([-1.0, 1.0])
            else:
                shape = np.array([(1 - x) * (1 - 2 * x), x * (2 * x - 1), 4 * x * (1 - x)])
                slope = np.array([4 * x - 3, 4 * x - 1, 4 - 8 * x])
            length = np.linalg.norm(np.einsum("i,kij->kj", slope, points), axis=1)
            at = np.einsum("i,kij->kj", shape, points)
            load = _field(value, at, what, unit) * (w * length)[:, None]
            for i, node in enumerate(segments.T):
                np.add.at(whole, node, shape[i] * load)
        return whole

    def _add_forces(self, kind, whole, amplitude):
        self._check_open()
        _check(amplitude)
        if not whole.any():
            return
        self.named.append(kind)
        self.forces.append((amplitude, whole[self.partition.owned_nodes]))

    def _add_moments(self, kind, whole, amplitude):
        self._check_open()
        _check(amplitude)
        if not whole.any():
            return
        self.named.append(kind)
        owned = whole[self.partition.owned_nodes]
        nodes = np.flatnonzero(owned.any(axis=1))
        self.moments.append((amplitude, nodes, owned[nodes]))


def factor(amplitude: Amplitude | None, level: float, default: float | None) -> float:
    """Value of an amplitude at a level; of no amplitude: `default`, or the level itself.

    ValueError for an amplitude that is no finite number there.
    """
    if amplitude is not None:
        value = amplitude(level)
        if not np.isfinite(value):
            raise ValueError(f"the amplitude of a load is {value} at level or time {level:g}")
        return value
    return level if default is None else default


def _check(amplitude):
    if amplitude is not None and not callable(amplitude):
        raise ValueError(f"an amplitude is a function of the level or time, not {amplitude!r}")


def _vector(value, what, unit):
    value = np.asarray(value, float)
    if value.shape != (3,) or not np.all(np.isfinite(value)):
        raise ValueError(f"{what} must be three finite numbers in {unit}, not {value.tolist()}")
    return value


def _field(value, points, what, unit):
    if not callable(value):
        return _vector(value, what, unit)
    value = np.asarray(value(points), float)
    if value.shape != points.shape or not np.all(np.isfinite(value)):
        raise ValueError(f"{what} must give finite values of shape {points.shape} in {unit}")
    return value
