# SPDX-License-Identifier: LGPL-3.0-or-later
"""Nodal kernels of the explicit Newmark step (beta = 0, gamma = 1/2): Sec. 3.1.3.

Velocities live at half steps. A kick adds the impulse of the forces to them, a drift moves the
nodes by them: positions along straight lines, directors along great circles with their velocity
carried parallel. Both conserve momentum and angular momentum exactly.

Kernels work in place on arrays of the nodes of one rank.
"""

from typing import NamedTuple

import numpy as np

from contact.kernel import kernel

NEAR = 0.01  # of an angle squared: the first term left out of the series is below 1e-20


# one record per node: what steps do not change
NODE = np.dtype(
    [
        ("mass", float),  # [kg]
        ("inertia", float),  # [kg m^2]
        ("held", np.uint8, 4),  # 0 or 1: u_x, u_y, u_z and the whole director
        ("plane", float, 3),  # normal that a director may not turn towards, zero where none
    ],
    align=True,
)


class Forces(NamedTuple):
    """What pushes n nodes in a kick; kernels get the arrays, which numba takes in faster.

    internal : (n, 6), internal forces [N, N m]; external : (n, 3) [N]
    support : (n, 3), the supports' impulse on the nodes [N s]
    """

    internal: np.ndarray
    external: np.ndarray
    support: np.ndarray


@kernel
def kick(
    v: np.ndarray,
    q: np.ndarray,
    r: np.ndarray,
    force: np.ndarray,
    impulse: np.ndarray,
    d: np.ndarray,
    nodes: np.ndarray,
    drag: float,
    dt: float,
    work: np.ndarray,
) -> None:
    """Add the impulse of internal and external forces over dt to the velocities.

    Held components keep their velocity; the impulse that takes is the supports'. Work on directors
    is booked here, that on nodes by `book`, once contact has had its say.

    Parameters
    ----------
    v, q : (n, 3), velocities of nodes [m/s] and directors [1/s], changed
    r, force, impulse : see Forces; the last is overwritten
    d : (n, 3), directors
    nodes : (n,) NODE
    drag : float [1/s], decay rate of the velocities relative to still air
    dt : float [s]
    work : (5,) [J], see Books; added to
    """
    keep = (1.0 - 0.5 * dt * drag) / (1.0 + 0.5 * dt * drag)
    gain = dt / (1.0 + 0.5 * dt * drag)
    inner = slowed = 0.0  # sums in registers
    for i in range(v.shape[0]):
        node = nodes[i]
        by_mass, by_inertia = gain / node.mass, gain / node.inertia
        along = r[i, 3] * d[i, 0] + r[i, 4] * d[i, 1] + r[i, 5] * d[i, 2]
        out = 0.0
        for k in range(3):
            out += (r[i, 3 + k] - along * d[i, k]) * node.plane[k]
        for k in range(3):
            if node.held[k]:
                impulse[i, k] = dt * (r[i, k] - force[i, k])
            else:
                impulse[i, k] = 0.0
                v[i, k] = keep * v[i, k] + by_mass * (force[i, k] - r[i, k])
            if not node.held[3]:
                turn = r[i, 3 + k] - along * d[i, k] - out * node.plane[k]
                old = q[i, k]
                new = keep * old - by_inertia * turn
                q[i, k] = new
                mean = 0.5 * dt * (old + new)
                inner -= turn * mean
                slowed += drag * node.inertia * mean * 0.5 * (old + new)
    work[0] += inner
    work[2] += slowed


@kernel
def book(
    v_old: np.ndarray,
    free: np.ndarray,
    v: np.ndarray,
    r: np.ndarray,
    force: np.ndarray,
    impulse: np.ndarray,
    nodes: np.ndarray,
    drag: float,
    dt: float,
    work: np.ndarray,
    totals: np.ndarray,
) -> None:
    """Book a kick whose velocities went from v_old to v, contact included.

    Work is impulse . (v_old + v)/2 for every impulse: that of all of them is the change of kinetic
    energy, to roundoff.

    Parameters
    ----------
    v_old, v : (n, 3) [m/s], before the kick and when all have had their say
    free : (n, 3) [m/s], just after `kick`: tells what drag took
    r, force, impulse, nodes, drag, dt : see kick
    work (5,), totals (3, 3) : works and impulses, see Books; added to
    """
    inner = outer = lost = guided = 0.0
    for k in range(3):
        # over the nodes first: added to the totals one by one, each would be rounded as they are
        loads = supports = still = 0.0
        for i in range(v.shape[0]):
            mean = 0.5 * (v_old[i, k] + v[i, k])
            inner -= r[i, k] * dt * mean
            outer += force[i, k] * dt * mean
            guided += impulse[i, k] * mean
            loads += force[i, k] * dt
            supports += impulse[i, k]
            if drag > 0.0 and not nodes[i].held[k]:
                slowed = drag * nodes[i].mass * dt * 0.5 * (v_old[i, k] + free[i, k])
                lost += slowed * mean
                still -= slowed
        totals[0, k] += loads
        totals[1, k] += supports
        totals[2, k] += still
    work[0] += inner
    work[1] += outer
    work[2] += lost
    work[3] += guided


@kernel
def work_over(force: np.ndarray, v_old: np.ndarray, v: np.ndarray, dt: float) -> float:
    """Work [J] of forces (n, 3) over dt while velocities go from v_old to v (n, 3)."""
    work = 0.0
    for i in range(force.shape[0]):
        for k in range(3):
            work += force[i, k] * 0.5 * dt * (v_old[i, k] + v[i, k])
    return work


@kernel
def near_cosine(square: float) -> float:
    """Cosine of an angle whose square is below NEAR: the series, to roundoff."""
    x = square  # Horner's scheme; products, as quotients take ten times as long
    return 1.0 - x * (1 / 2) * (
        1.0 - x * (1 / 12) * (1.0 - x * (1 / 30) * (1.0 - x * (1 / 56) * (1.0 - x * (1 / 90))))
    )


@kernel
def near_sine(square: float) -> float:
    """Sine of an angle over the angle, whose square is below NEAR: the series, to roundoff."""
    x = square
    return 1.0 - x * (1 / 6) * (
        1.0 - x * (1 / 20) * (1.0 - x * (1 / 42) * (1.0 - x * (1 / 72) * (1.0 - x * (1 / 110))))
    )


@kernel
def drift(w: np.ndarray, v: np.ndarray, q: np.ndarray, dt: float) -> float:
    """Move nodes and directors by their velocities over dt.

    w : (n, 6), (u, d), changed; v : (n, 3); q : (n, 3), changed: carried along. Returns the sum of
    all moved coordinates: not finite if any of them is not.
    """
    total = 0.0
    for i in range(w.shape[0]):
        along = q[i, 0] * w[i, 3] + q[i, 1] * w[i, 4] + q[i, 2] * w[i, 5]
        square = 0.0
        for k in range(3):
            w[i, k] += dt * v[i, k]
            total += w[i, k]
            q[i, k] -= along * w[i, 3 + k]
            square += q[i, k] * q[i, k]
        angle = square * dt * dt
        if angle < NEAR:  # to roundoff; a step turns a director by far less
            c, s = near_cosine(angle), near_sine(angle)
        else:
            angle = np.sqrt(angle)
            c, s = np.cos(angle), np.sin(angle) / angle
        length = 0.0
        for k in range(3):
            d, turn = w[i, 3 + k], q[i, k]
            w[i, 3 + k] = c * d + s * dt * turn
            q[i, k] = c * turn - s * dt * square * d
            length += w[i, 3 + k] * w[i, 3 + k]
        length = 1.0 / np.sqrt(length)
        for k in range(3):
            w[i, 3 + k] *= length
            total += w[i, 3 + k]
    return total


@kernel
def ahead(w: np.ndarray, v: np.ndarray, q: np.ndarray, time: float, out: np.ndarray) -> None:
    """w + time (v, q): where the internal force is taken for stiffness-proportional damping."""
    for i in range(w.shape[0]):
        for k in range(3):
            out[i, k] = w[i, k] + time * v[i, k]
            out[i, 3 + k] = w[i, 3 + k] + time * q[i, k]


@kernel
def momenta(
    w: np.ndarray,
    points: np.ndarray,
    v: np.ndarray,
    q: np.ndarray,
    mass: np.ndarray,
    inertia: np.ndarray,
    out: np.ndarray,
) -> None:
    """Linear momentum, angular momentum about the origin and kinetic energy into out (7,)."""
    out[:] = 0.0
    for i in range(w.shape[0]):
        x0, x1, x2 = points[i, 0] + w[i, 0], points[i, 1] + w[i, 1], points[i, 2] + w[i, 2]
        m, j = mass[i], inertia[i]
        for k in range(3):
            out[k] += m * v[i, k]
            out[6] += 0.5 * (m * v[i, k] ** 2 + j * q[i, k] ** 2)
        out[3] += m * (x1 * v[i, 2] - x2 * v[i, 1]) + j * (w[i, 4] * q[i, 2] - w[i, 5] * q[i, 1])
        out[4] += m * (x2 * v[i, 0] - x0 * v[i, 2]) + j * (w[i, 5] * q[i, 0] - w[i, 3] * q[i, 2])
        out[5] += m * (x0 * v[i, 1] - x1 * v[i, 0]) + j * (w[i, 3] * q[i, 1] - w[i, 4] * q[i, 0])
