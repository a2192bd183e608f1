# SPDX-License-Identifier: LGPL-3.0-or-later
"""A shape of markers laid on each frame of a cluster, by least squares.

    x = y + R (a - s),    sum over i of |R (s_i - s) + y - y_i|^2 = min

with the shape s_i, the places y_i in a frame, both with their means s and y, and a point a
of the shape that goes to x. R is the best rotation by singular values (Soederkvist, Wedin, J.
Biomech. 26, 1993, 1473-1477). Markers that are not seen in a frame do not count in it.
"""

import numpy as np


def carried(
    marker: np.ndarray, cluster: np.ndarray, walking: np.ndarray
) -> tuple[np.ndarray, float]:
    """Track of a marker that is fixed to a cluster.

    Parameters
    ----------
    marker : (m, 3) float [m], in the static trial; cluster : (m, k, 3), the cluster there
    walking : (n, k, 3), the cluster in the walk; NaN where a marker is not seen

    Returns
    -------
    (n, 3) float [m], NaN where less than three of the cluster are seen; rms misfit [m]
    """
    shape = mean_shape(cluster)
    turn, here, there = _fit(shape, cluster)
    place = np.einsum("nba,nb->na", turn, marker - there) + here
    place = np.nanmedian(place, axis=0)
    turn, here, there = _fit(shape, walking)
    track = np.einsum("nab,nb->na", turn, place - here) + there
    off = np.einsum("nab,nkb->nka", turn, shape - here[:, None]) + there[:, None] - walking
    return track, float(np.sqrt(np.nanmean(np.sum(off**2, axis=2))))


def mean_shape(cluster: np.ndarray) -> np.ndarray:
    """Mean shape (k, 3) of a cluster's frames (n, k, 3), laid on one another."""
    first = np.nanmedian(cluster, axis=0)
    if not np.isfinite(first).all():
        return first
    turn, here, there = _fit(first, cluster)
    back = np.einsum("nba,nkb->nka", turn, cluster - there[:, None]) + here[:, None]
    mean = np.nanmean(back, axis=0) if np.isfinite(back).any() else first
    return np.where(np.isfinite(mean), mean, first)


def misfit(shape: np.ndarray, cluster: np.ndarray) -> np.ndarray:
    """Rms (k,) of each marker off the shape that fits all of them best."""
    turn, here, there = _fit(shape, cluster)
    off = np.einsum("nab,nkb->nka", turn, shape - here[:, None]) + there[:, None] - cluster
    with np.errstate(all="ignore"):
        return np.sqrt(np.nanmean(np.sum(off**2, axis=2), axis=0))


def _fit(shape, cluster):
    """Rotation (n, 3, 3) of a shape (k, 3) to each frame (n, k, 3), and the means of both."""
    weights = np.isfinite(cluster).all(axis=2) & np.isfinite(shape).all(axis=1)
    enough = weights.sum(axis=1) >= 3
    w = weights / np.maximum(weights.sum(axis=1, keepdims=True), 1)
    y, s = np.where(weights[..., None], cluster, 0.0), np.where(np.isfinite(shape), shape, 0.0)
    here, there = np.einsum("nk,kc->nc", w, s), np.einsum("nk,nkc->nc", w, y)
    a = s - here[:, None]
    b = y - there[:, None]
    u, _, vt = np.linalg.svd(np.einsum("nk,nka,nkb->nab", w, b, a))
    u[:, :, 2] *= np.linalg.det(u @ vt)[:, None]
    turn = u @ vt
    turn[~enough] = np.nan
    return turn, here, there
