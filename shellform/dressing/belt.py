# SPDX-License-Identifier: LGPL-3.0-or-later
"""A belt and the hands that put a garment on: forces on the nodes of its waist edge, Fig. 7.

The belt is a cable of given tension T along a closed edge: every segment of it pulls its two ends
together with T. A closed cable pulls itself together without a net force; on a body it presses
with T times the curvature, all around with 2 pi T in the normal direction, whatever the shape.

Hands are springs from the nodes of the edge to places that move; they hold with a force, let go by
losing stiffness, and leave contact to do its part, as a prescribed motion would not.
"""

from collections.abc import Callable
from typing import Self

from mpi4py import MPI

import numpy as np

from contact.kernel import kernel
from shellform.dynamics.explicit import Newmark
from shellform.dynamics.part import AppliedForce


@kernel
def add_tension(x: np.ndarray, tension: float, force: np.ndarray) -> None:
    """Add the forces of a closed cable through points x (k, 3) [m] to force (k, 3) [N]."""
    k = len(x)
    for i in range(k):
        j = (i + 1) % k
        d0, d1, d2 = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
        length = np.sqrt(d0 * d0 + d1 * d1 + d2 * d2)
        if length == 0.0:
            continue
        pull = tension / length
        force[i, 0] += pull * d0
        force[i, 1] += pull * d1
        force[i, 2] += pull * d2
        force[j, 0] -= pull * d0
        force[j, 1] -= pull * d1
        force[j, 2] -= pull * d2


class Ring:
    """Nodes of a closed edge in their order, over all ranks.

    Parameters
    ----------
    stepper : Newmark; edge : str, name of a closed edge

    Attributes
    ----------
    nodes : (k,) int, in the surface's numbering
    x : (k, 3) [m], positions after `look`; mine : places in the ring of this rank's nodes; own :
        their local numbers

    Raises
    ------
    ValueError if the edge is not one closed line
    """

    def __init__(self, stepper: Newmark, edge: str) -> None:
        partition = stepper.shell.partition
        segments = partition.edge(edge)[:, :2]
        closed = np.array_equal(segments[1:, 0], segments[:-1, 1])
        if not closed or segments[-1, 1] != segments[0, 0]:
            raise ValueError(
                f"edge '{edge}' of {partition.surface.source} is not one closed line, as a waist is"
            )
        self.nodes = segments[:, 0]
        local = partition.local_numbers[self.nodes]
        self.mine = np.flatnonzero((local >= 0) & (local < partition.n_owned))
        self.own = local[self.mine]
        self.x, self._comm = np.zeros((len(self.nodes), 3)), partition.comm

    def look(self, stepper: Newmark) -> np.ndarray:
        """Bring `x` up to date on every rank."""
        self.x[:] = 0.0
        self.x[self.mine] = stepper.points[self.own] + stepper.owned[self.own, :3]
        if self._comm.size > 1:
            self._comm.Allreduce(MPI.IN_PLACE, self.x)
        return self.x


class Belt(AppliedForce):
    """A cable of tension `tension` [N] along a closed edge of a sheet in explicit steps.

    `tension` may be changed at any time; at 0 the belt costs nothing.
    """

    def __init__(self, edge: str = "waist", tension: float = 0.0) -> None:
        self.edge, self.tension = edge, tension

    def attach(self, stepper: Newmark) -> Self:
        """See Part; ValueError if the edge is not one closed line."""
        self.ring = Ring(stepper, self.edge)
        self._force = np.zeros_like(self.ring.x)
        return super().attach(stepper)

    def add_force(self, stepper: Newmark, force: np.ndarray) -> None:
        """See AppliedForce."""
        if self.tension == 0.0:
            return
        self._force[:] = 0.0
        add_tension(self.ring.look(stepper), self.tension, self._force)
        force[self.ring.own] += self._force[self.ring.mine]


class Hands(AppliedForce):
    """Springs from the nodes of an edge to places that move, in explicit steps.

    Parameters
    ----------
    edge : str
    places : function of time -> (shift (3,) [m], velocity (3,) [m/s]) of the rest positions
    stiffness : float [N/m], damping : float [N s/m], of each node's spring
    """

    def __init__(
        self,
        edge: str,
        places: Callable[[float], tuple[np.ndarray, np.ndarray]],
        stiffness: float,
        damping: float,
    ) -> None:
        self.edge = edge
        self.places, self.stiffness, self.damping = places, stiffness, damping
        self.hold = 1.0  # 1 firm, 0 let go

    def attach(self, stepper: Newmark) -> Self:
        """See Part."""
        partition = stepper.shell.partition
        own = partition.local(partition.find(self.edge))
        self.own = own[own < partition.n_owned]
        return super().attach(stepper)

    def add_force(self, stepper: Newmark, force: np.ndarray) -> None:
        """See AppliedForce."""
        if self.hold == 0.0:
            return
        shift, velocity = self.places(stepper.time)
        away = shift - stepper.owned[self.own, :3]
        slow = velocity - stepper.v[self.own]
        force[self.own] += self.hold * (self.stiffness * away + self.damping * slow)
