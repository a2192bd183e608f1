# SPDX-License-Identifier: LGPL-3.0-or-later
"""A specimen pulled to and fro as by Kawabata's first instrument (KES-FB1).

5 cm between the clamps, and so much wider that it does not narrow: the sides keep their distance.
The load is the work of the clamps' forces R on the elongation, per area of the specimen,

    load = sum R . dx/de / (length width).
"""

import numpy as np

import meshes
from shellform.fem.shell import Shell
from shellform.material.fabric import Fabric
from shellform.statics.load_stepping import Statics

from .cycle import Cycle, expected_loads, largest_strain, path, says_its_loads

LENGTH, WIDTH, CELLS = 0.05, 0.02, (4, 2)


def pull(fabric: Fabric, yarn: str, points: int = 10) -> Cycle:
    """Pull along a yarn, "warp" or "weft", to the largest strain of its test and back."""
    surface = meshes.rectangle(LENGTH, WIDTH, CELLS)
    along = (1.0, 0.0, 0.0) if yarn == "warp" else (0.0, 1.0, 0.0)
    shell = Shell(surface.replace(warp=along), fabric)
    shell.supports.clamp("left")
    shell.supports.hold(np.arange(len(surface.points)), "y")
    shell.supports.move("right", lambda level: (level * LENGTH, 0.0, 0.0))
    pulled = np.flatnonzero(surface.points[:, 0] > LENGTH - 1e-9)
    levels = path("pull", largest_strain(fabric, "pull", yarn), points)
    loads = []
    with Statics(shell) as statics:
        for _ in statics.march(levels):
            loads.append(statics.reactions()[pulled, 0].sum() / WIDTH)
    expected = expected_loads(fabric, "pull", yarn, levels) if says_its_loads(fabric) else None
    return Cycle("pull", yarn, levels, np.array(loads), expected)
