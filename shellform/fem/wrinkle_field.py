# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where a relaxed sheet is taut, wrinkled or slack, cell by cell, at one configuration.

The stress N of the relaxed law (material/wrinkling.py) is that of an elastic strain A^-1 N, which
differs from the strain E of the cell by what wrinkles take up:

    W = A^-1 N - E,    no eigenvalue negative.

A wrinkled cell is taut along its crests; W shortens it across them. The larger eigenvalue of W is
told, the wrinkle strain: 0 in taut cells, (pi a/l)^2 of a shallow wave of amplitude a and length l.
As all of these are Green strains, it is 1/2 where an unstretched cell has shrunk to nothing.
"""

from typing import NamedTuple

import numpy as np

from shellform.material.wrinkling import TAUT


class Wrinkling(NamedTuple):
    """Wrinkles of the m cells of a sheet.

    state : (m,) int, 0 taut, 1 wrinkled, 2 slack
    crest : (m, 3), unit vectors along the crests of wrinkled cells as they lie now; 0 in others
    strain : (m,), largest strain that wrinkles take up
    """

    state: np.ndarray
    crest: np.ndarray
    strain: np.ndarray


def wrinkle_strain(
    E: np.ndarray, stress: np.ndarray, membrane: np.ndarray, state: np.ndarray
) -> np.ndarray:
    """Larger eigenvalue (m,) of W.

    Parameters
    ----------
    E : (m, 3), strains (E11, E22, 2 E12); stress : (m, 3), of the relaxed law [N/m]
    membrane : (3, 3), stiffness A [N/m]; state : (m,), those of taut cells get 0
    """
    W = stress @ np.linalg.inv(membrane) - E  # A is symmetric
    larger = 0.5 * (W[:, 0] + W[:, 1] + np.hypot(W[:, 0] - W[:, 1], W[:, 2]))
    return np.where(state == TAUT, 0.0, np.maximum(larger, 0.0))


def crests(
    rest: np.ndarray, now: np.ndarray, axes: tuple[np.ndarray, np.ndarray], angle: np.ndarray
) -> np.ndarray:
    """Unit vectors (m, 3) of directions at rest, carried along by the middle of the cells.

    Parameters
    ----------
    rest, now : (m, 4, 3), corners in tensor order [m]; axes : warp and weft at rest, (m, 3) each
    angle : (m,), from the warp at rest [rad]; 0 where a cell has shrunk to nothing along it
    """
    line = np.cos(angle)[:, None] * axes[0] + np.sin(angle)[:, None] * axes[1]
    G, g = _tangents(rest), _tangents(now)
    metric = G @ G.transpose(0, 2, 1)
    parts = np.linalg.solve(metric, np.einsum("mai,mi->ma", G, line)[:, :, None])[:, :, 0]
    carried = np.einsum("ma,mai->mi", parts, g)
    size = np.linalg.norm(carried, axis=1, keepdims=True)
    return np.divide(carried, size, out=np.zeros_like(carried), where=size > 0.0)


def _tangents(corners):
    """Tangents (m, 2, 3) in the middle of cells."""
    first = corners[:, 1] - corners[:, 0] + corners[:, 3] - corners[:, 2]
    second = corners[:, 2] - corners[:, 0] + corners[:, 3] - corners[:, 1]
    return 0.5 * np.stack([first, second], axis=1)
