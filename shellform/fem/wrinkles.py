# SPDX-License-Identifier: LGPL-3.0-or-later
"""Wrinkles smaller than the cells of a sheet: when they form, cell by cell (material/wrinkling.py).

A cell gives way at N_c, that of the wave of two cells in the open, or of the shorter wave that beds
of flesh on both sides force on the sheet. Directors that tilt to and fro from node to node lengthen
the arcs of a sheet whose nodes stay where they are, at 12 D/h^2: about N_c in the open, but far
less than a sheet bears between beds, which do not feel them. Between beds that shorten the wave,
k >= D (pi/h)^4, the lengths are those of the chords; below, arcs count by 1 - k/(D (pi/h)^4), so
that energy is continuous in k.
"""

import numpy as np

from meshes import Surface
from shellform.material.sheet import Sheet
from shellform.material.wrinkling import wrinkling_load

KINDS = ("resolved", "relaxed")


class Wrinkles:
    """What a sheet that wrinkles below its cells needs to know of each.

    Parameters
    ----------
    fabric : Sheet; sizes : (m,), of the cells of this rank [m]

    Attributes
    ----------
    beds : (m,) float, stiffness [Pa/m] of what holds each cell flat
    load : (m,) float, N_c [N/m]; arcs : (m,) float, weight of arcs in lengths; both read anew by
        each evaluation of the membrane, `set_beds` writes them
    stiffest : float [Pa/m], beds that are stiffer are taken as this one
    """

    def __init__(self, fabric: Sheet, sizes: np.ndarray):
        self._bending = float(np.sqrt(fabric.bending[0, 0] * fabric.bending[1, 1]))
        # no wave is shorter than the sheet is thick on either side
        self.stiffest = self._bending * (np.pi / fabric.thickness) ** 4
        self._sizes, self.beds = sizes, np.zeros(len(sizes))
        self._shortening = self._bending * (np.pi / np.asarray(sizes, float)) ** 4
        self.load = wrinkling_load(self._bending, sizes)
        self.arcs = np.ones(len(sizes))

    def set_beds(self, stiffness: np.ndarray | float) -> None:
        """Take over the stiffness (m,) [Pa/m] of the beds that hold each cell; 0 in the open."""
        self.beds[:] = np.minimum(stiffness, self.stiffest)
        self.load[:] = wrinkling_load(self._bending, self._sizes, self.beds)
        self.arcs[:] = np.maximum(0.0, 1.0 - self.beds / self._shortening)


def folds_resolved(surface: Surface, fabric: Sheet) -> bool:
    """True if cells show the folds of a sheet under its own weight: armour rather than cloth.

    Folds are as large as the bending length; about eight cells make one.
    """
    length = min(fabric.bending_length(degrees=angle) for angle in (0.0, 90.0))
    return surface.mean_cell_size < 0.25 * length
