# SPDX-License-Identifier: LGPL-3.0-or-later
"""A strip slid over an edge until its tip has fallen by 41.5 degrees, as by ASTM D1388.

Half of that overhang is the bending length c; of a strip that bends in proportion to its moment

    c = (B/(rho g))^(1/3).

Each overhang is that of a new strip, held level, whose weight comes on in steps; between them the
angle goes about as the cube of the overhang, by which the next one is chosen. Yarns are hardly
pulled: friction of tension, which yields at any strain, is left out.
"""

from dataclasses import dataclass

import numpy as np

import meshes
from shellform.errors import NotConverged
from shellform.fem.shell import Shell
from shellform.material.fabric import Fabric
from shellform.statics.load_stepping import Statics

from .cycle import hardly_pulled
from .elastica import CHORD, curvature_of, overhang_of

G = 9.80665
CELLS, LEVELS, CLOSE, TRIES = 40, 8, 1e-5, 12


@dataclass(frozen=True)
class Hang:
    """Bending length [m] of a yarn's strip, that of the elastica, and (B/(rho g))^(1/3) at rest."""

    yarn: str
    bending_length: float
    elastica: float
    at_rest: float
    shape: np.ndarray  # (n, 2), x and z along the strip

    def results(self) -> dict:
        """For summary.json."""
        names = "bending_length", "elastica", "at_rest", "shape"
        return {name: getattr(self, name) for name in names}


def hang(fabric: Fabric, yarn: str) -> Hang:
    """Bending length of a strip along a yarn, "warp" or "weft".

    Raises
    ------
    NotConverged : no overhang found
    """
    row = 1 if yarn == "weft" else 0
    weight = fabric.areal_mass * G
    at_rest = float(fabric.bending[row, row] / weight) ** (1 / 3)
    exact = overhang_of(curvature_of(fabric, yarn), weight, 2 * at_rest)
    length, seen = exact, []
    for _ in range(TRIES):
        shape = fallen(fabric, yarn, length)
        reach, fall = shape[-1, 0], -shape[-1, 1]
        seen.append((np.log(length), np.log(fall / reach)))
        if abs(np.arctan2(fall, reach) - CHORD) < CLOSE:
            return Hang(yarn, 0.5 * length, 0.5 * exact, at_rest, shape)
        (l1, t1), power = seen[-1], 3.0
        if len(seen) > 1 and seen[-1][0] != seen[-2][0]:
            power = (t1 - seen[-2][1]) / (l1 - seen[-2][0])
        length = float(np.exp(l1 + (np.log(np.tan(CHORD)) - t1) / power))
    raise NotConverged(f"no overhang of '{fabric.name}' along the {yarn} falls by 41.5 degrees")


def fallen(fabric: Fabric, yarn: str, overhang: float) -> np.ndarray:
    """Points (n, 2), x and z [m], of a strip under its weight, from its edge to its tip."""
    width = 2 * overhang / CELLS

    def place(a, b):
        # finer towards the edge, where it bends
        return overhang * (0.5 * a + 0.5 * a**2), width * b, 0 * a

    along = (1.0, 0.0, 0.0) if yarn == "warp" else (0.0, 1.0, 0.0)
    surface = meshes.patch(place, (CELLS, 1)).replace(warp=along)
    shell = Shell(surface, hardly_pulled(fabric))
    in_plane(shell, "left")
    shell.loads.gravity((0.0, 0.0, -G))
    with Statics(shell) as statics:
        statics.solve(LEVELS)
    return side(shell)


def in_plane(shell: Shell, clamped: str | None = None) -> None:
    """Let a strip move in the xz plane alone; hold an edge of it."""
    everywhere = np.arange(len(shell.surface.points))
    if clamped is not None:
        shell.supports.clamp(clamped)
    shell.supports.hold(everywhere, "y")
    shell.supports.hold_director(everywhere, plane=(0.0, 1.0, 0.0))


def side(shell: Shell) -> np.ndarray:
    """Points (n, 2), x and z [m], of one long edge of a strip, in the order it has at rest."""
    points = shell.surface.points
    edge = np.flatnonzero(points[:, 1] < 1e-9)
    edge = edge[np.argsort(points[edge, 0])]
    return shell.positions()[edge][:, [0, 2]]
