# SPDX-License-Identifier: LGPL-3.0-or-later
"""The hook between steps on a body with flesh: `VelocityCorrection` whose skin gives way.

What flesh has stored and not yet given back stands among the impact losses of the ledger until it
does; `stored_energy` says how much that is.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from contact.body.flesh_bed import HARD, Flesh
from contact.body.segments import Body

from .bed_push import SIDE
from .flesh_step import flesh_kernel
from .friction import Friction
from .velocity_correction import VelocityCorrection


class OnFlesh:
    """What flesh below nodes keeps; a part of a correction.

    sides : (n,) SIDE, what presses each node and how deep it lies [m]
    """

    sides: np.ndarray

    def lay_beds(self, flesh: Flesh, names: Sequence[str], areal_mass: float, nodes: int) -> None:
        """Flesh below segments of these names, under cloth of an areal mass [kg/m^2]."""
        self._beds_of_segments, self._areal = flesh.beds(names), float(areal_mass)
        self.sides = np.zeros(nodes, SIDE)
        self.sides["owner"] = -1

    def stored_energy(self, mass: np.ndarray) -> float:
        """Energy [J] in the flesh below nodes of masses (n,) [kg], after the last step."""
        held = self.sides["owner"] >= 0
        bed, side = self._beds_of_segments[self.sides["owner"][held]], self.sides[held]
        area = mass[held] / self._areal
        slides, relaxes = bed["slip_stiffness"] > 0, bed["relaxing_stiffness"] > 0
        energy = bed["stiffness"] * side["depth"] ** 2
        energy += bed["slip_stiffness"] * np.where(slides, side["depth"] - side["slip"], 0.0) ** 2
        energy[relaxes] += side["relaxing"][relaxes] ** 2 / bed["relaxing_stiffness"][relaxes]
        return float(0.5 * (area * energy).sum())

    def normal_give(self, nodes: np.ndarray, dt: float) -> np.ndarray:
        """See `NodeCorrection.normal_give`: an elastic layer takes little of a step."""
        owner = self.sides["owner"][nodes]
        bed = self._beds_of_segments[np.maximum(owner, 0)]
        stiffness = bed["stiffness"] + bed["slip_stiffness"] + bed["relaxing_stiffness"]
        return np.where(owner >= 0, 1.0 / (1.0 + dt * dt / self._areal * stiffness), 0.0)


class FleshCorrection(OnFlesh, VelocityCorrection):
    """Contact and friction with a body with flesh, applied between steps.

    Parameters
    ----------
    body, nodes, friction, offset, options : see VelocityCorrection
    flesh : Flesh
    areal_mass : float, of the cloth [kg/m^2]: a node has the area of its mass over it
    hard : numbers of segments that have no flesh whatever it says

    Attributes
    ----------
    sides : (n,) SIDE, what presses each node and how deep it lies [m]

    Raises
    ------
    ValueError as VelocityCorrection, and for flesh of unknown segments
    """

    def __init__(
        self,
        body: Body,
        nodes: int,
        friction: Any,
        offset: float,
        *,
        flesh: Flesh,
        areal_mass: float,
        hard: Sequence[int] = (),
        **options: Any,
    ):
        self.lay_beds(flesh, body.names, areal_mass, nodes)
        self._beds_of_segments["stiffness"][list(hard)] = HARD
        # in creases parts that press cloth against each other let it in
        soft = self._beds_of_segments["stiffness"].min() / self._areal
        super().__init__(body, nodes, friction, offset, flesh=soft, **options)

    def _kernel_of(self, friction: Friction) -> Any:
        return flesh_kernel(friction.kinetic_coefficient)

    def _run(self, x, v, old, mass, dt):
        last, window = self.last, self.window
        return self._correct(
            x, v, old, mass, dt, self.fixed, self._sets, self._look, self._away, self._node,
            self._step, self._segments, self._planes, self._beds_of_segments, self.sides,
            self._areal, self._beds, last.impulse, last.table, window.impulse, window.table,
        )  # fmt: skip

    def _ask(self, nodes, x, v, old, mass, dt, step, correct):
        _, look, away, impulse, table, beds = self._scratch_of(len(nodes))
        sets = np.take(self._sets, nodes, axis=1)
        correct(
            x, v, old, mass, dt, self.fixed[nodes], sets, look, away, self._node,
            step, self._segments, self._planes, self._beds_of_segments, self.sides[nodes],
            self._areal, beds, impulse[0], table[0], impulse[1], table[1],
        )  # fmt: skip

    def state(self) -> dict[str, np.ndarray]:
        """See VelocityCorrection; with the sides."""
        return super().state() | {"sides": self.sides.copy()}

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Continue from `state()`."""
        super().restore(state)
        self.sides[:] = state["sides"]
