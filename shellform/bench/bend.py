# SPDX-License-Identifier: LGPL-3.0-or-later
"""A specimen bent to and fro as by Kawabata's second instrument (KES-FB2), to 2.5 per cm.

1 cm long, one end held, the director of the other turned by the curvature times the length: the
moment that this takes, per width, is the same all along, and the specimen the arc of a circle, flat
across. A sheet that is bent contracts a little, by M kappa/A; in the instrument clamps keep its
length, here its tension is made a hundred times as stiff, without curve and friction.
"""

from dataclasses import replace

import numpy as np

import meshes
from shellform.fem.shell import Shell
from shellform.material.fabric import Fabric
from shellform.material.measured import Measured
from shellform.statics.load_stepping import Statics

from .cycle import Cycle, expected_loads, hardly_pulled, largest_strain, path, says_its_loads

LENGTH, WIDTH, CELLS = 0.01, 0.005, (12, 1)
TURN = 3.0  # rad, the most that an end is turned by: a shorter specimen for larger curvatures
STIFFER = 100.0  # tension, so that the length is kept


def bend(fabric: Fabric, yarn: str, points: int = 8) -> Cycle:
    """Bend a yarn, "warp" or "weft", to one side, to the other, and to the first again."""
    most = largest_strain(fabric, "bend", yarn)
    length = min(LENGTH, TURN / most)
    surface = meshes.rectangle(length, WIDTH, CELLS)
    along = (1.0, 0.0, 0.0) if yarn == "warp" else (0.0, 1.0, 0.0)
    shell = Shell(surface.replace(warp=along), of_constant_length(fabric))
    everywhere = np.arange(len(surface.points))
    shell.supports.clamp("left")
    shell.supports.hold(everywhere, "y")
    shell.supports.hold_director(everywhere, plane=(0.0, 1.0, 0.0))

    def director(kappa):
        return np.array([-np.sin(kappa * length), 0.0, np.cos(kappa * length)])

    shell.supports.move("right", director=director)
    end = np.flatnonzero(surface.points[:, 0] > length - 1e-9)
    levels, moments = path("bend", most, points), []
    with Statics(shell) as statics:
        for _ in statics.march(levels):
            # from x to z is a turn about -y
            moments.append(-statics.reaction_moments()[end, 1].sum() / WIDTH)
    expected = expected_loads(fabric, "bend", yarn, levels) if says_its_loads(fabric) else None
    return Cycle("bend", yarn, levels, np.array(moments), expected)


def of_constant_length(fabric: Fabric) -> Fabric:
    """The fabric with stiff tension; as it is, but for friction of tension, if its law couples."""
    if not (fabric.law is None or isinstance(fabric.law, Measured)) or fabric.coupling.any():
        return hardly_pulled(fabric)
    if isinstance(fabric.law, Measured):
        bending = replace(fabric.law, warp=None, weft=None, shear_angle=None, coupling=None)
        fabric = fabric.with_law(bending)
    stiff = STIFFER * np.array(fabric.membrane)
    return hardly_pulled(replace(fabric, membrane=stiff))
