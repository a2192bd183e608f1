# SPDX-License-Identifier: LGPL-3.0-or-later
"""A specimen sheared to and fro as by Kawabata's first instrument (KES-FB1), to 8 degrees.

Its edges follow a frame of yarns that keep their length, x = X + Y sin gamma, y = Y cos gamma, so
that all of it is sheared alike. The load is the work of the frame's forces R on the angle per area,

    load = sum R . dx/dgamma / (length width),

in which, unlike in the instrument, no tension of clamps counts: shear alone.
"""

import numpy as np

import meshes
from shellform.fem.shell import Shell
from shellform.material.fabric import Fabric
from shellform.statics.load_stepping import Statics

from .cycle import Cycle, expected_loads, largest_strain, path, says_its_loads

LENGTH, WIDTH, CELLS = 0.05, 0.05, (3, 3)


def shear(fabric: Fabric, points: int = 8) -> Cycle:
    """Shear to one side, to the other, and to the first again."""
    surface = meshes.rectangle(LENGTH, WIDTH, CELLS).replace(warp=(1.0, 0.0, 0.0))
    X, Y = surface.points[:, 0], surface.points[:, 1]
    nodes = np.flatnonzero(
        (np.minimum(X, LENGTH - X) < 1e-9) | (np.minimum(Y, WIDTH - Y) < 1e-9)
    )  # of the edges
    y = Y[nodes]

    def displacement(gamma):
        return np.column_stack([y * np.sin(gamma), y * (np.cos(gamma) - 1), 0 * y])

    def rate(gamma):
        return np.column_stack([y * np.cos(gamma), -y * np.sin(gamma), 0 * y])

    shell = Shell(surface, fabric)
    shell.supports.move(nodes, displacement)
    shell.supports.hold(np.arange(len(X)), "z")
    levels = path("shear", largest_strain(fabric, "shear"), points)
    loads = []
    with Statics(shell) as statics:
        for step in statics.march(levels):
            work = np.sum(statics.reactions()[nodes] * rate(step.level))
            loads.append(work / (LENGTH * WIDTH))
    expected = expected_loads(fabric, "shear", "", levels) if says_its_loads(fabric) else None
    return Cycle("shear", "", levels, np.array(loads), expected)
