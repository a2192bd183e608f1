# SPDX-License-Identifier: LGPL-3.0-or-later
"""Dry friction of a point on a surface, Eq. 16, as impulses over one step.

Eq. 16 takes the residual force F on a node and the slip velocity v_T. Over a step dt the node would
reach the velocity v_free = v + dt F / m; the normal impulse j_n takes its approach away, and the
tangential impulse that would end the slip is j* = -m v_free,T. Then

    |j*| <= mu_s j_n :  stick, j_T = j*                   (slip exactly zero)
    |j*| >  mu_s j_n :  slip,  j_T = mu_k j_n j* / |j*|   (against the slip)

With j = f dt this is Eq. 16 case by case: open, j_n = 0; at rest (v_T = 0), j* = -dt F_T and
j_n = dt |F_N| give f = -F as long as |F_T| <= mu_s |F_N|; sliding, j*/|j*| -> -v_T/|v_T| for
dt -> 0. Two things differ by one step, hence vanish with dt: a node that breaks loose meets mu_k at
once, where Eq. 16 still has mu_s at v_T = 0; and a sliding node is caught when m |v_T| falls below
mu_s j_n, not at exactly zero. As mu_k <= mu_s, kinetic friction never turns the slip around.
"""

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy")
def transmitted(normal, trial, mu_s, mu_k):
    """Fraction of the trial impulse that friction can transmit: 1 in stick, below 1 in slip.

    Parameters
    ----------
    normal : float, normal impulse j_n >= 0 [N s]
    trial : float, length |j*| of the impulse that would end the slip [N s]
    mu_s, mu_k : float, static and kinetic coefficients, mu_k <= mu_s
    """
    if trial <= mu_s * normal:
        return 1.0
    return mu_k * normal / trial


@njit(cache=True, error_model="numpy")
def tangential_impulse(normal, trial, mu_s, mu_k, impulse):
    """Friction impulse for a trial impulse vector.

    Parameters
    ----------
    normal : float, normal impulse j_n >= 0 [N s]
    trial : (3,) float, j* = -m v_T [N s]
    mu_s, mu_k : float
    impulse : (3,) float, filled: j_T [N s]

    Returns
    -------
    bool, True in stick
    """
    size = np.sqrt(trial[0] * trial[0] + trial[1] * trial[1] + trial[2] * trial[2])
    fraction = transmitted(normal, size, mu_s, mu_k)
    for k in range(3):
        impulse[k] = fraction * trial[k]
    return fraction == 1.0


def coefficients(friction):
    """Checked (mu_s, mu_k) from one number or a pair.

    Raises
    ------
    ValueError
        For a negative or non-finite coefficient, or mu_k > mu_s.
    """
    pair = np.atleast_1d(np.asarray(friction, float))
    if pair.shape == (1,):
        pair = np.repeat(pair, 2)
    if pair.shape != (2,):
        raise ValueError(f"friction is one coefficient or the pair (mu_s, mu_k), not {friction!r}")
    mu_s, mu_k = (float(mu) for mu in pair)
    if not (np.isfinite(pair).all() and mu_k >= 0):
        raise ValueError(f"friction coefficients are finite and not negative, not {mu_s}, {mu_k}")
    if mu_k > mu_s:
        raise ValueError(f"kinetic friction {mu_k} exceeds static friction {mu_s}")
    return mu_s, mu_k
