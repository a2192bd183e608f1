# SPDX-License-Identifier: LGPL-3.0-or-later
"""An equilibrium path: points in the order they were met, and the curve through them.

The curve between two points is a cubic of Hermite in the length of the path: the tangents come with
the first factorisation of every step and cost nothing.
"""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path as File

from mpi4py import MPI

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from shellform.fem.shell import Shell


@dataclass(frozen=True)
class PathState:
    """A sheet at a point of a path, in the surface's numbering: for any number of ranks.

    Attributes
    ----------
    level : float; field : (n, 6), displacements [m] and directors
    moved : (n, 3) [m], displacements of the step that led there, along the axes of the nodes; zeros
        where none did
    """

    level: float
    field: np.ndarray
    moved: np.ndarray

    @classmethod
    def of(cls, shell: Shell, level: float, moved: np.ndarray | None = None) -> "PathState":
        """State of a shell as it lies; `moved` (n_owned, 3). Collective."""
        field = np.hstack([shell.displacements(), shell.directors()])
        if moved is None:
            moved = np.zeros((shell.partition.n_owned, 3))
        return cls(float(level), field, shell.partition.gather(moved))

    def put(self, shell: Shell) -> None:
        """Let a shell of the same surface lie as here.

        Raises
        ------
        ValueError for another number of nodes
        """
        n = len(shell.surface.points)
        if self.field.shape != (n, 6):
            raise ValueError(
                f"a state of {len(self.field)} nodes does not fit {shell.surface.source} with {n}"
            )
        shell.w.x.array.reshape(-1, 6)[:] = self.field[shell.partition.nodes]


@dataclass(frozen=True)
class Path:
    """What `follow` returns: k points, the first where it began.

    Attributes
    ----------
    levels : (k,), load levels
    arc : (k,) [m], length of the path up to each point: root mean square of the displacements over
        the sheet, step by step
    iterations : (k,) int, factorisations that each point has cost
    displacements : name -> (k, 3) [m], of what is watched; the mean of its nodes
    reactions : name -> (k, 3) [N], sum of the forces of the supports on the nodes of what is
        watched
    states : the last one, or all of them
    stopped : "level", "displacement" or "steps", which condition ended it
    level_rates : (k,) [1/m]; displacement_rates : name -> (k, 3), derivatives by `arc`
    """

    levels: np.ndarray
    arc: np.ndarray
    iterations: np.ndarray
    displacements: Mapping[str, np.ndarray]
    reactions: Mapping[str, np.ndarray]
    states: Sequence[PathState]
    stopped: str
    level_rates: np.ndarray
    displacement_rates: Mapping[str, np.ndarray]

    def curve(self, name: str, count: int = 1000) -> tuple[np.ndarray, np.ndarray]:
        """Levels (count,) and displacements (count, 3) [m] on the curve through the points."""
        at = np.linspace(0.0, self.arc[-1], count)
        displacement = self.displacements[name], self.displacement_rates[name]
        return self._level()(at), CubicHermiteSpline(self.arc, *displacement)(at)

    def limit_levels(self) -> np.ndarray:
        """Levels at which the load turns, in the order they are met: limit points."""
        level = self._level()
        at = level.derivative().roots(extrapolate=False)
        slope = level.derivative()
        near = 1e-6 * self.arc[-1]
        return level(at[slope(at - near) * slope(at + near) < 0.0])

    def _level(self):
        return CubicHermiteSpline(self.arc, self.levels, self.level_rates)

    def save(self, file: str | File) -> None:
        """Write an .npz, whole or not at all; all ranks may call it, the first one writes."""
        if MPI.COMM_WORLD.rank:
            return
        arrays = {
            "levels": self.levels,
            "arc": self.arc,
            "iterations": self.iterations,
            "stopped": np.array(self.stopped),
            "level_rates": self.level_rates,
            "names": np.array(list(self.displacements), dtype=str),
            "displacements": np.array(list(self.displacements.values())),
            "reactions": np.array(list(self.reactions.values())),
            "displacement_rates": np.array(list(self.displacement_rates.values())),
            "state_levels": np.array([state.level for state in self.states]),
            "fields": np.array([state.field for state in self.states]),
            "moved": np.array([state.moved for state in self.states]),
        }
        file = File(file)
        unfinished = file.with_name(file.name + ".part")
        with open(unfinished, "wb") as part:
            np.savez_compressed(part, **arrays)
        os.replace(unfinished, file)

    @classmethod
    def load(cls, file: str | File) -> "Path":
        """Read what `save` wrote."""
        with np.load(file) as data:
            names = data["names"].tolist()

            def by_name(key):
                return dict(zip(names, data[key], strict=True))

            states = zip(data["state_levels"].tolist(), data["fields"], data["moved"], strict=True)
            return cls(
                data["levels"],
                data["arc"],
                data["iterations"],
                by_name("displacements"),
                by_name("reactions"),
                tuple(PathState(*state) for state in states),
                str(data["stopped"]),
                data["level_rates"],
                by_name("displacement_rates"),
            )
