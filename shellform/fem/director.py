# SPDX-License-Identifier: LGPL-3.0-or-later
"""Nodal unit directors and their finite rotation: Eqs. 4-10.

A material point of the shell is X = sum N_A (Xbar_A + zeta D_A), x = sum N_A (xbar_A + zeta d_A)
(Eqs. 4-6): every node carries a unit director d that turns by two rotations (no drilling).

Two descriptions of that turn live here. Eqs. 7-9 turn the *initial* director by one rotation
vector; the map folds at |theta| = pi, so it serves as documentation and as an oracle. The stepping
uses the *updated* form: rotations a = t1 th1 + t2 th2 in the plane tangent to the present director,
d <- cos|a| d + sin|a| a/|a|, which has no singular angle and never adds up rotations. Its
derivative at a = 0 is the nodal block T = [t1 t2] of the map H of Eq. 10 (Simo, Fox and Rifai,
Comput. Methods Appl. Mech. Engrg. 79, 1990).
"""

import numpy as np


def rotation_matrix(theta: np.ndarray) -> np.ndarray:
    """Rotation matrix of a rotation vector, Eq. 7.

    Parameters
    ----------
    theta : (..., 3) float, rotation vector [rad]

    Returns
    -------
    R : (..., 3, 3) float, orthogonal
    """
    theta = np.asarray(theta, float)
    angle = np.linalg.norm(theta, axis=-1)[..., None, None]
    omega = np.zeros((*theta.shape, 3))
    omega[..., 2, 1], omega[..., 0, 2], omega[..., 1, 0] = np.moveaxis(theta, -1, 0)
    omega -= np.swapaxes(omega, -1, -2)
    # sin(x)/x and (1 - cos x)/x^2 by sinc: exact limits at zero, no cancellation
    return (
        np.eye(3)
        + np.sinc(angle / np.pi) * omega
        + 0.5 * np.sinc(angle / (2 * np.pi)) ** 2 * (omega @ omega)
    )


def rotated_director(
    theta: np.ndarray, e1: np.ndarray, e2: np.ndarray, e3: np.ndarray
) -> np.ndarray:
    """Director after the rotation theta1 e1 + theta2 e2 of the initial director e3, Eq. 8.

    The paper prints the last term as (1 - cos theta) e3; rotating e3 by Eq. 7 gives
    (cos theta - 1) e3, which is used here (it alone keeps the director's length).
    As a map from rotation vectors it is singular at |theta| = pi: the whole circle of rotations
    of that length leads to the one director -e3.

    Parameters
    ----------
    theta : (..., 2) float, rotations about e1 and e2 [rad]
    e1, e2, e3 : (..., 3) float, fibre basis of the node, e3 the initial director

    Returns
    -------
    d : (..., 3) float, unit
    """
    return np.asarray(e3, float) + director_tip(theta, e1, e2, e3)


def director_tip(theta: np.ndarray, e1: np.ndarray, e2: np.ndarray, e3: np.ndarray) -> np.ndarray:
    """Displacement of the director's tip d - e3, Eq. 9 (arguments as in Eq. 8)."""
    theta, e1, e2, e3 = (np.asarray(q, float) for q in (theta, e1, e2, e3))
    angle = np.linalg.norm(theta, axis=-1, keepdims=True)
    across = theta[..., 1:] * e1 - theta[..., :1] * e2
    return np.sinc(angle / np.pi) * across - 2 * np.sin(angle / 2) ** 2 * e3


def tangent_frames(d: np.ndarray, normal: np.ndarray | None = None) -> np.ndarray:
    """Two unit vectors that complete each director to a right-handed basis (t1, t2, d).

    Parameters
    ----------
    d : (n, 3) float, unit directors
    normal : (n, 3) float or None
        Where finite, a direction perpendicular to d that is to be t2 (a symmetry plane's normal:
        holding the second rotation then keeps the director in that plane). NaN rows: free choice.

    Returns
    -------
    T : (n, 3, 2) float, columns t1 and t2
    """
    axis = np.eye(3)[np.abs(d).argmin(axis=1)]
    if normal is not None:
        axis = np.where(np.isfinite(normal), normal, axis)
    t2 = axis - np.sum(axis * d, axis=1, keepdims=True) * d
    t2 /= np.linalg.norm(t2, axis=1, keepdims=True)
    return np.stack([np.cross(t2, d), t2], axis=2)


def exponential_map(
    d: np.ndarray, T: np.ndarray, theta: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Turn directors along the great circle of the tangent vector T theta, frames with them.

    The frame is carried parallel along the arc, so it stays continuous in theta and a held second
    rotation keeps its meaning over any number of turns.

    Parameters
    ----------
    d : (n, 3), T : (n, 3, 2), theta : (n, 2) rotations [rad] about the present director

    Returns
    -------
    d, T : the turned directors, renormalised, and their frames
    """
    angle = np.linalg.norm(theta, axis=1, keepdims=True)
    a = np.einsum("nij,nj->ni", T, theta)
    sinc = np.sinc(angle / np.pi)
    turned = np.cos(angle) * d + sinc * a
    turned /= np.linalg.norm(turned, axis=1, keepdims=True)
    # every t_a loses the part along a and gains that part turned by the same angle
    along = -0.5 * np.sinc(angle / (2 * np.pi)) ** 2 * a - sinc * d
    frames = T + along[:, :, None] * theta[:, None, :]
    t2 = frames[:, :, 1]
    t2 = t2 - np.sum(t2 * turned, axis=1, keepdims=True) * turned
    t2 /= np.linalg.norm(t2, axis=1, keepdims=True)
    return turned, np.stack([np.cross(t2, turned), t2], axis=2)


def logarithmic_map(d: np.ndarray, T: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Rotations theta with exponential_map(d, T, theta)[0] = target.

    Parameters
    ----------
    d, target : (n, 3) unit directors; T : (n, 3, 2) frames at d

    Returns
    -------
    theta : (n, 2) [rad], length in [0, pi]; for an opposite target any one of the half turns
    """
    across = np.einsum("nij,ni->nj", T, target)
    sine = np.linalg.norm(across, axis=1, keepdims=True)
    angle = np.arctan2(sine, np.sum(d * target, axis=1, keepdims=True))
    opposite = (sine == 0) & (angle > 1)
    across = np.where(opposite, [1.0, 0.0], across)
    return angle * across / np.where(sine == 0, 1.0, sine)


def pull_back(r: np.ndarray, T: np.ndarray, Q: np.ndarray | None = None) -> np.ndarray:
    """Nodal forces of the 5 unknowns from those of the 6: r5 = P^T r6 (Eq. 10 transposed).

    Parameters
    ----------
    r : (n, 6), forces work-conjugate to (u, d) [N, N m]; T : (n, 3, 2) frames
    Q : (n, 3, 3) or None, rows are the axes of the nodal displacement unknowns

    Returns
    -------
    (n, 5)
    """
    r5 = np.empty((len(r), 5))
    r5[:, :3] = along_axes(Q, r[:, :3])
    np.einsum("nij,ni->nj", T, r[:, 3:], out=r5[:, 3:])
    return r5


def push_forward(x: np.ndarray, T: np.ndarray, Q: np.ndarray | None = None) -> np.ndarray:
    """Change of (u, d) from the 5 unknowns to first order: dw6 = P x5 (Eq. 10).

    Parameters
    ----------
    x : (n, 5); T : (n, 3, 2); Q : (n, 3, 3) or None

    Returns
    -------
    (n, 6)
    """
    w = np.empty((len(x), 6))
    w[:, :3] = x[:, :3] if Q is None else np.einsum("nji,nj->ni", Q, x[:, :3])
    np.einsum("nij,nj->ni", T, x[:, 3:], out=w[:, 3:])
    return w


def along_axes(Q: np.ndarray | None, vectors: np.ndarray) -> np.ndarray:
    """Components of vectors (n, 3) along the rows of Q (n, 3, 3); Q None: the world's axes."""
    return vectors if Q is None else np.einsum("nij,nj->ni", Q, vectors)


def along(vectors: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Part of vectors (n, 3) along unit vectors d (n, 3)."""
    return np.sum(vectors * d, axis=1, keepdims=True) * d


def turn_to(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Turns (n, 3) [rad], tangent to `start`, that lead along great circles to `end`."""
    across = end - along(end, start)
    sine = np.linalg.norm(across, axis=1, keepdims=True)
    angle = np.arctan2(sine, np.sum(start * end, axis=1, keepdims=True))
    return across * np.where(sine > 0, angle / np.where(sine > 0, sine, 1.0), 1.0)


def carry(vectors: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Vectors (n, 3) tangent to `start`, carried parallel along the great circle to `end`."""
    both = start + end
    return vectors - np.sum(vectors * end, axis=1, keepdims=True) * both / (
        1 + np.sum(start * end, axis=1, keepdims=True)
    )
