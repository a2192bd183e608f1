# SPDX-License-Identifier: LGPL-3.0-or-later
"""Lumped inertia of the shell and the largest stable explicit step: Sec. 3.1.3.

Kinetic energy: sum over nodes of (m |u'|^2 + I |d'|^2)/2 with m = rho t A, I = rho t A t^2/12 at
least. In explicit steps I is raised to rho t A c h^2/12 (Hughes, Cohen and Haroun, Nucl. Eng. Des.
46, 1978), so that the membrane and not the thickness bounds the step.
"""

import numpy as np

from meshes import Surface
from shellform.material.sheet import Sheet

from .element import ENDS, SIMPSON, product_rule
from .shape_functions import shape_functions

ROTARY_SCALE = 2.0  # c: rotary inertia rho t A h^2/6, measured to leave the membrane in charge


def nodal_areas(surface: Surface) -> np.ndarray:
    """Area (n,) [m^2] that each node carries, by quadrature at the nodes; all positive."""
    width = surface.cells.shape[1]
    if width == 3:
        rows = [(0.0, 0.0, 1 / 6), (1.0, 0.0, 1 / 6), (0.0, 1.0, 1 / 6)]
    else:
        rows = product_rule(*((ENDS, ENDS) if width == 4 else (SIMPSON, SIMPSON)))
    areas = np.zeros(len(surface.points))
    corners = surface.corners_at_rest
    for p, q, weight in rows:
        shape, slope1, slope2 = shape_functions(width, p, q)
        g1, g2 = (np.einsum("i,kij->kj", s, corners) for s in (slope1, slope2))
        node = surface.cells[:, int(np.argmax(shape))]
        np.add.at(areas, node, weight * np.linalg.norm(np.cross(g1, g2), axis=1))
    return areas


def lumped(
    surface: Surface, fabric: Sheet, rotary_scale: float = ROTARY_SCALE
) -> tuple[np.ndarray, np.ndarray]:
    """Nodal masses (n,) [kg] and rotary inertias (n,) [kg m^2].

    Parameters
    ----------
    surface : meshes.Surface; fabric : Fabric
    rotary_scale : float, c of the header; 0 keeps the physical rotary inertia

    Raises
    ------
    ValueError for a rotary_scale that is negative or not finite
    """
    if not 0 <= rotary_scale < np.inf:
        raise ValueError(f"rotary_scale is a finite number, not negative, not {rotary_scale}")
    areas = nodal_areas(surface)
    mass = fabric.areal_mass * areas
    scale = np.maximum(fabric.thickness**2, rotary_scale * areas) / 12
    return mass, mass * scale
