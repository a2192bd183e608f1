# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tension fields of isotropic sheets that have exact or one-dimensional solutions.

All with the compression N_c that wrinkles bear; N_c = 0 is the classical tension field. Since the
relaxed law with N_c is that without at the strain e = E + N_c A^-1 (1, 1, 0), less N_c in all
directions (material/wrinkling.py), each solution with N_c follows from one without.

Bent strip (Stein and Hedgepeth, NASA TN D-813, 1961). Of a strip of height H, taut stress is linear
and what lies below y = b is wrinkled,

    N_x + N_c = K kappa (y - b)_+,  K = E t,  N_y = 0,

so with Q = P + N_c H the force and moment about the middle are Q = K kappa (H - b)^2/2 and
M = Q (H/6 + b/3):  b/H = 3 M/(Q H) - 1/2  once M/(Q H) > 1/6,  kappa K H^2/(2 Q) = 1/(1 - b/H)^2.

Sheared strip (Mansfield, Proc. R. Soc. A 316, 1970), infinite, its clamped edges moved apart by
eps and along by gamma: the strain is (0, eps, gamma) everywhere. Crests lie along the principal
strain e1, the shear force per length is (K e1 + (1 - nu) N_c) sin cos of their angle.

Turned hub (Reissner 1938). Disc held at the radius b, its hub a turned by phi. All wrinkled and
N_c = 0: rays are straight, tangent to a circle p, a ray's force F an angle spreads as F/s, s from
the point of tangency. It is drawn out by p phi = F/K ln(s_b/s_a), so the energy is

    U = max over p of  2 pi K (p phi)^2 / ln((b^2 - p^2)/(a^2 - p^2)),  torque 2 U/phi.

Anything else about the hub is `hub`: the energy of u(r), v(r) with e = (u', u/r, v' - v/r), whose
least is sought on many rings.
"""

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve


def bent_strip_curvature(
    force: float, moment: float, stiffness: float, height: float, load: float = 0.0
) -> float:
    """Curvature [1/m] of a strip under a force [N] in its middle line and a moment [N m]."""
    whole = force + load * height
    part = bent_strip_depth(force, moment, height, load)
    if part <= 0.0:
        return 12.0 * moment / (stiffness * height**3)
    return 2.0 * whole / (stiffness * height**2 * (1.0 - part) ** 2)


def bent_strip_depth(force: float, moment: float, height: float, load: float = 0.0) -> float:
    """Part b/H of the height that is wrinkled."""
    return max(3.0 * moment / ((force + load * height) * height) - 0.5, 0.0)


def sheared_strip(
    eps: float, gamma: float, stiffness: float, nu: float, load: float = 0.0
) -> tuple[float, float, float]:
    """Shear and normal force on a clamped edge [N/m], and angle of the crests from it [rad].

    Raises
    ------
    ValueError where the strip is taut
    """
    middle, radius = 0.5 * eps, 0.5 * np.hypot(eps, gamma)
    lift = load * (1.0 - nu) / stiffness
    one, two = middle + radius + lift, middle - radius + lift
    if two + nu * one >= 0.0:
        raise ValueError(f"taut at eps = {eps:g}, gamma = {gamma:g}, N_c = {load:g} N/m")
    angle = 0.5 * np.arctan2(gamma, -eps)
    pull = stiffness * one
    return (
        pull * np.sin(angle) * np.cos(angle),
        pull * np.sin(angle) ** 2 - load,
        angle,
    )


def wrinkled_hub(inner: float, outer: float, stiffness: float) -> tuple[float, float]:
    """Torque per angle [N m] of a wholly wrinkled disc, N_c = 0; radius p [m] its rays touch."""

    def energy(p):
        return p**2 / np.log((outer**2 - p**2) / (inner**2 - p**2))

    best = minimize_scalar(
        lambda p: -energy(p), bounds=(0.0, inner), method="bounded", options={"xatol": 1e-12}
    ).x
    return 4.0 * np.pi * stiffness * energy(best), float(best)


def isotropic_law(
    e: np.ndarray, stiffness: float, nu: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Tension field of an isotropic sheet: energy (n,), stress (n, 3), tangent (n, 3, 3).

    By principal strains one >= two of e (n, 3): taut where two + nu one >= 0, else
    stiffness one^2/2 where one > 0.
    """
    middle, half, shear = 0.5 * (e[:, 0] + e[:, 1]), 0.5 * (e[:, 0] - e[:, 1]), 0.5 * e[:, 2]
    radius = np.maximum(np.hypot(half, shear), 1e-300)
    one, two = middle + radius, middle - radius
    C = stiffness / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, 0.5 * (1 - nu)]])
    taut = two + nu * one >= 0.0
    energy, stress = 0.5 * stiffness * np.maximum(one, 0.0) ** 2, np.zeros_like(e)
    v = np.stack([1 + half / radius, 1 - half / radius, shear / radius], axis=1) * 0.5
    stress[:] = stiffness * np.maximum(one, 0.0)[:, None] * v
    # of `one` the first derivatives are v, the second those of the radius
    normal = np.stack([-shear, shear, half], axis=1) / radius[:, None]
    turned = normal[:, :, None] * normal[:, None, :] / (4.0 * radius[:, None, None])
    pull = stiffness * np.maximum(one, 0.0)[:, None, None]
    tangent = stiffness * (one > 0)[:, None, None] * v[:, :, None] * v[:, None, :] + pull * turned
    energy[taut] = 0.5 * np.einsum("ni,ij,nj->n", e[taut], C, e[taut])
    stress[taut], tangent[taut] = e[taut] @ C, C
    return energy, stress, tangent


def hub(
    turn: float,
    inner: float,
    outer: float,
    stiffness: float,
    nu: float,
    load: float = 0.0,
    stretch: float = 0.0,
    rings: int = 4000,
) -> tuple[float, float]:
    """Torque [N m] on a hub turned by an angle [rad]; radius [m] up to which the disc wrinkles.

    `stretch` moves the outer edge outwards [m].
    """
    r = inner * (outer / inner) ** (np.arange(rings + 1) / rings)
    middle, dr = 0.5 * (r[1:] + r[:-1]), np.diff(r)
    weight = 2 * np.pi * middle * dr
    # strains of ring k: rows of numbers times (u_k, v_k, u_k+1, v_k+1)
    G = np.zeros((rings, 3, 4))
    G[:, 0, 0], G[:, 0, 2] = -1 / dr, 1 / dr
    G[:, 1, 0] = G[:, 1, 2] = 0.5 / middle
    G[:, 2, 1], G[:, 2, 3] = -1 / dr - 0.5 / middle, 1 / dr - 0.5 / middle
    where = 2 * np.arange(rings)[:, None] + np.arange(4)
    x = np.zeros(2 * (rings + 1))
    x[1], x[-2] = turn * inner, stretch
    x[2:-2:2] = stretch * (r[1:-1] - inner) / (outer - inner)
    x[3:-1:2] = turn * inner * (outer - r[1:-1]) / (outer - inner)
    free = np.arange(2, len(x) - 2)
    lift = load * (1 - nu) / stiffness * np.array([1.0, 1.0, 0.0])

    def law(x):
        e = np.einsum("nij,nj->ni", G, x[where])
        return e + lift, *isotropic_law(e + lift, stiffness, nu), load * (e[:, 0] + e[:, 1])

    def total(x):
        _, energy, *_, paid = law(x)
        return np.sum(weight * (energy - paid))

    for _ in range(200):
        _, _, stress, tangent, _ = law(x)
        stress = stress - load * np.array([1.0, 1.0, 0.0])
        force = np.zeros(len(x))
        np.add.at(force, where, np.einsum("n,nij,ni->nj", weight, G, stress))
        # a little of the taut stiffness: rings that wrinkle have none along the hoop
        tangent = tangent + 1e-9 * stiffness * np.eye(3)
        blocks = np.einsum("n,nai,nab,nbj->nij", weight, G, tangent, G)
        rows = np.repeat(where, 4, axis=1).ravel(), np.tile(where, (1, 4)).ravel()
        K = coo_matrix((blocks.ravel(), rows), shape=(len(x), len(x))).tocsc()[free][:, free]
        step = -spsolve(K, force[free])
        slope, now, length = force[free] @ step, total(x), 1.0
        while length > 1e-6:
            trial = x.copy()
            trial[free] += length * step
            if total(trial) <= now + 1e-4 * length * slope:
                break
            length *= 0.5
        x = trial
        if abs(slope) < 1e-18 * abs(now):
            break
    e, *_ = law(x)
    one = 0.5 * (e[:, 0] + e[:, 1]) + 0.5 * np.hypot(e[:, 0] - e[:, 1], e[:, 2])
    wrinkled = e[:, 0] + e[:, 1] - one + nu * one < 0.0
    edge = r[1:][wrinkled].max(initial=inner)
    # shear force of the innermost ring times its arm and length
    return float(force[1] * inner), float(edge)
