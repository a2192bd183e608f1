# SPDX-License-Identifier: LGPL-3.0-or-later
"""Centre and axes of a segment from two joint points and a marker, Eq. 17."""

import numpy as np
from numpy.typing import ArrayLike

COLLINEAR = 1e-6  # of a marker's offset from the line J1-J2, over |J2 - J1|


def pose_from_markers(J1: ArrayLike, J2: ArrayLike, M: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Centre and axes of segments from two joint points and a marker, Eq. 17.

    Parameters
    ----------
    J1, J2 : (..., 3) float, joint points at the ends of the first axis [m]
    M : (..., 3) float, marker beside that axis; e2 points to its side [m]

    Returns
    -------
    centre (..., 3) [m]; axes (..., 3, 3), rows e1, e2, e3, determinant +1

    Raises
    ------
    ValueError
        When the three points do not span a plane, naming the first such row.
    """
    J1, J2, M = np.broadcast_arrays(*(np.asarray(p, float) for p in (J1, J2, M)))
    centre = 0.5 * (J1 + J2)
    length = np.linalg.norm(J2 - J1, axis=-1)
    _require(length > 0, "joint points J1 and J2 coincide or are not finite")
    e1 = (J2 - J1) / length[..., None]
    e2 = M - centre
    for _ in range(2):  # once more: a marker close to the line leaves roundoff along e1
        e2 = e2 - np.sum(e2 * e1, axis=-1, keepdims=True) * e1
    offset = np.linalg.norm(e2, axis=-1)
    _require(offset > COLLINEAR * length, "marker M lies on the line J1-J2 or is not finite")
    e2 = e2 / offset[..., None]
    return centre, np.stack([e1, e2, np.cross(e1, e2)], axis=-2)


def _require(good, message):
    if not np.all(good):
        where = np.argwhere(~np.atleast_1d(good))[0].tolist() if np.ndim(good) else ""
        raise ValueError(f"{message}{f' in row {where}' if where else ''}")
