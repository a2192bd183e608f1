# SPDX-License-Identifier: LGPL-3.0-or-later
"""A strip hung up as a loop by both its ends: Peirce's heart and pear (option B of ASTM D1388).

By symmetry half of it is computed. From flat it is rolled up to the arc of a circle, its grip is
brought above its lowest point, and its weight comes on. A heart leaves the grip upwards, a pear
downwards. From the height l of a heart of the length L follows the bending length (Peirce 1930)

    c = l0 (cos t/tan t)^(1/3),   t = 32.85 degrees (l - l0)/l0,   l0 = 0.1337 L,

which is up to 4 % more than that of the elastica (elastica.py).
"""

from dataclasses import dataclass

import numpy as np

import meshes
from shellform.fem.shell import Shell
from shellform.material.fabric import Fabric
from shellform.statics.load_stepping import Statics

from .cycle import hardly_pulled
from .elastica import curvature_of, loop_height
from .hang import G, in_plane, side

TURNS = {"heart": 1.5 * np.pi, "pear": 0.5 * np.pi}  # from the lowest point to the grip
LONG = 8.0  # loop over bending length
CELLS = 60
ROLL, CLOSE, LOAD = 16, 6, 12  # load steps


@dataclass(frozen=True)
class Loop:
    """Height l [m] of a loop of a length [m], that of the elastica, and c [m] by Peirce of hearts.

    The elastica bends as the fabric does on first loading: with friction inside the cloth, where
    some parts of a loop are bent back, it is not what the loop has to be.
    """

    kind: str
    yarn: str
    length: float
    height: float
    elastica: float
    peirce: float | None
    shape: np.ndarray  # (n, 2), x and z from the lowest point to the grip

    def results(self) -> dict:
        """For summary.json."""
        return {
            "kind": self.kind, "length": self.length, "height": self.height,
            "elastica": self.elastica, "bending_length": self.peirce, "shape": self.shape,
        }  # fmt: skip


def loop(fabric: Fabric, yarn: str, kind: str = "heart", length: float | None = None) -> Loop:
    """Hang up a loop of a yarn's strip, "warp" or "weft".

    kind : "heart" or "pear"; length [m], 8 bending lengths unless given

    Raises
    ------
    ValueError : another kind
    """
    if kind not in TURNS:
        raise ValueError(f"a loop is a heart or a pear, not {kind!r}")
    turn, weight = TURNS[kind], fabric.areal_mass * G
    row = 1 if yarn == "weft" else 0
    if length is None:
        length = LONG * float(fabric.bending[row, row] / weight) ** (1 / 3)
    shape = _hung(fabric, yarn, 0.5 * length, turn)
    height = float(shape[-1, 1] - shape[0, 1])
    exact = loop_height(curvature_of(fabric, yarn), weight, length, turn)
    c = peirce(height, length) if kind == "heart" else None
    return Loop(kind, yarn, length, height, exact, c, shape)


def peirce(height: float, length: float) -> float:
    """Bending length [m] from the height of a heart of a length [m]."""
    l0 = 0.1337 * length
    t = np.radians(32.85) * (height - l0) / l0
    return float(l0 * (np.cos(t) / np.tan(t)) ** (1 / 3))


def _hung(fabric, yarn, half, turn):
    """Points (n, 2), x and z, from the lowest point to the grip."""
    along = (1.0, 0.0, 0.0) if yarn == "warp" else (0.0, 1.0, 0.0)
    surface = meshes.rectangle(half, 2 * half / CELLS, (CELLS, 1)).replace(warp=along)
    shell = Shell(surface, hardly_pulled(fabric))
    in_plane(shell)
    shell.supports.hold("left", "x")
    shell.supports.hold_director("left")

    def grip(level):
        angle = turn * min(level, 1.0)
        reach = half * np.sinc(angle / np.pi)
        closed = min(max(level - 1.0, 0.0), 1.0)
        return np.array([(1 - closed) * reach - half, 0.0, 0.0])

    def director(level):
        angle = turn * min(level, 1.0)
        return np.array([-np.sin(angle), 0.0, np.cos(angle)])

    shell.supports.move("right", grip, director)
    shell.loads.gravity((0.0, 0.0, -G), amplitude=lambda level: max(level - 2.0, 0.0))
    levels = np.r_[
        np.linspace(0, 1, ROLL + 1)[1:],
        np.linspace(1, 2, CLOSE + 1)[1:],
        np.linspace(2, 3, LOAD + 1)[1:],
    ]
    with Statics(shell) as statics:
        statics.solve(levels)
    return side(shell)
