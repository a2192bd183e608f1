# SPDX-License-Identifier: LGPL-3.0-or-later
"""The points of an equilibrium path, collected while it is followed."""

from collections.abc import Mapping

import numpy as np

from shellform.fem.partition import Place

from .arc_length import ArcLength
from .equilibrium import Equilibrium
from .path import Path, PathState


class PathRecorder:
    """Levels, displacements, reactions and states at each point; all methods are collective.

    Parameters
    ----------
    equilibrium : Equilibrium, at the first point; watch, keep_states : see `follow`
    """

    def __init__(self, equilibrium: Equilibrium, watch: Mapping[str, Place], keep_states: bool):
        self.equilibrium, self.keep_states = equilibrium, keep_states
        find = equilibrium.shell.partition.find
        self.nodes = {name: find(place) for name, place in watch.items()}
        self.levels: list[float] = []
        self.lengths: list[float] = []
        self.iterations: list[int] = []
        self.level_rates: list[float] = []
        self.displacements: dict[str, list] = {name: [] for name in self.nodes}
        self.rates: dict[str, list] = {name: [] for name in self.nodes}
        self.reactions: dict[str, list] = {name: [] for name in self.nodes}
        self.states: list[PathState] = []
        equilibrium.residual(equilibrium.x, equilibrium.F)  # for the reactions
        self._point(0.0, 0, None)

    def add(self, arc: ArcLength) -> None:
        """The point that a step of `arc` has come to."""
        self._add_tangent(arc)
        (size,) = arc.inner((arc.moved, arc.moved))
        self._point(float(np.sqrt(size)), arc.factorisations - sum(self.iterations), arc.moved)

    def end(self, arc: ArcLength) -> None:
        """The last point is reached: its tangent, by one more factorisation."""
        if arc.find_tangent():
            self._add_tangent(arc)
        self.iterations[-1] = arc.factorisations - sum(self.iterations[:-1])

    def _add_tangent(self, arc):
        towards, rate = arc.tangent
        self.level_rates.append(rate)
        if self.nodes:
            field = self.equilibrium.shell.partition.gather(self.equilibrium.in_world(towards))
            for name, nodes in self.nodes.items():
                self.rates[name].append(field[nodes].mean(axis=0))

    def _point(self, length, iterations, moved):
        shell = self.equilibrium.shell
        self.levels.append(self.equilibrium.level)
        self.lengths.append(length)
        self.iterations.append(iterations)
        if not self.keep_states:
            self.states.clear()
        self.states.append(PathState.of(shell, self.equilibrium.level, moved))
        if self.nodes:
            u, reactions = self.states[-1].field[:, :3], self.equilibrium.reactions()
            for name, nodes in self.nodes.items():
                self.displacements[name].append(u[nodes].mean(axis=0))
                self.reactions[name].append(reactions[nodes].sum(axis=0))

    def path(self, stopped: str) -> Path:
        """The path so far."""
        levels, displacements = np.array(self.levels), _arrays(self.displacements)
        arc = np.cumsum(self.lengths)
        return Path(
            levels,
            arc,
            np.array(self.iterations),
            displacements,
            _arrays(self.reactions),
            tuple(self.states),
            stopped,
            _with_last(arc, levels, np.array(self.level_rates)),
            {
                name: _with_last(arc, displacements[name], np.array(rates))
                for name, rates in self.rates.items()
            },
        )


def _arrays(lists):
    return {name: np.array(rows) for name, rows in lists.items()}


def _with_last(arc, values, rates):
    """Rates at all points; at the last, where it is not known, of a cubic which ends straight."""
    if len(rates) == len(arc):
        return rates
    if len(arc) < 2:
        return np.zeros_like(values)
    secant = (values[-1] - values[-2]) / (arc[-1] - arc[-2])
    return np.concatenate([rates, [1.5 * secant - 0.5 * rates[-1]]])
