# SPDX-License-Identifier: LGPL-3.0-or-later
"""The skin between the legs, drawn smooth: thighs turn apart there within a few triangles.

Where the thighs meet the trunk in the middle, a step over an obstacle turns neighbours by 100
degrees against each other, and triangles would fold. There each point goes a number of times half
way to the mean of its neighbours, by a weight that fades out along the skin. As a matrix M, the
identity elsewhere, this is the same in every pose (`contact.body.skinned_surface`). Weights of
segments are drawn smooth in the same way, farther out.
"""

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, diags, identity

from shellform.motion.proportions import STATURE

from .rigging import along_skin
from .surface import BodySurface

LEAST = 1e-3  # parts of a point below which are left out


class Extent(NamedTuple):
    """Where points are drawn smooth, at a stature of STATURE, and how often.

    reach : along the skin from the middle plane [m], fully so up to the first, not beyond the last
    top : over the hip centres [m], alike
    """

    reach: tuple[float, float]
    top: tuple[float, float]
    steps: int


SHAPE = Extent((0.030, 0.060), (0.030, 0.050), 30)  # of a body that is worn under trousers
SKIN = Extent((0.050, 0.120), (0.030, 0.080), 30)
WEIGHTS = Extent((0.090, 0.150), (0.030, 0.080), 30)


def between_legs(surface: BodySurface, extent: Extent) -> csr_matrix:
    """Matrix M (n, n) of a standing body, rows of sum 1: the identity but between the legs.

    The middle plane is that of the hip centres, wherever the wearer looks.
    """
    scale = surface.stature / STATURE
    arm = surface.points - surface.middle
    far = along_skin(surface.points, surface.triangles, arm @ surface.left)
    part = _fading(far, extent.reach, scale) * _fading(arm[:, 2], extent.top, scale)
    t, n = surface.triangles, len(surface.points)
    pairs = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])
    pairs = np.unique(np.concatenate([pairs, pairs[:, ::-1]]), axis=0)
    mean = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(n, n)).tocsr()
    mean = diags(1.0 / np.asarray(mean.sum(axis=1)).ravel()) @ mean
    same = identity(n, format="csr")
    step = same + diags(0.5 * part) @ (mean - same)
    out = same
    for _ in range(extent.steps):
        out = step @ out
    out.data[out.data < LEAST] = 0.0
    out.eliminate_zeros()
    return csr_matrix(diags(1.0 / np.asarray(out.sum(axis=1)).ravel()) @ out)


def _fading(value, limits, scale):
    """1 below the first limit times the scale, 0 above the second."""
    u = np.clip((limits[1] * scale - value) / ((limits[1] - limits[0]) * scale), 0.0, 1.0)
    return u * u * (3.0 - 2.0 * u)
