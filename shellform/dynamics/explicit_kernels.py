# SPDX-License-Identifier: LGPL-3.0-or-later
"""Nodal kernels of the explicit Newmark step (beta = 0, gamma = 1/2): Sec. 3.1.3.

Velocities live at half steps. A kick adds the impulse of the forces to them, the drift of
explicit_drift.py moves the nodes by them. Both conserve momentum and angular momentum exactly.

Kernels work in place on arrays of the nodes of one rank.
"""

from typing import NamedTuple

import numpy as np

from contact.kernel import kernel

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
    v_old: np.ndarray,
    free: np.ndarray,
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
    v_old, free : (n, 3) [m/s], filled: v before and after
    r, force, impulse : see Forces; the last is overwritten
    d : (n, 3), directors
    nodes : (n,) NODE
    drag : float [1/s], decay rate of the velocities relative to still air
    dt : float [s]
    work : (5,) [J], see Books; added to
    """
    keep = (1.0 - 0.5 * dt * drag) / (1.0 + 0.5 * dt * drag)
    gain = dt / (1.0 + 0.5 * dt * drag)
    # sums in registers, a node at a time: each addition waits for the one before it
    inner = slowed = 0.0
    for i in range(v.shape[0]):
        node = nodes[i]
        by_mass, by_inertia = gain / node.mass, gain / node.inertia
        along = r[i, 3] * d[i, 0] + r[i, 4] * d[i, 1] + r[i, 5] * d[i, 2]
        out = turned = swept = 0.0
        for k in range(3):
            out += (r[i, 3 + k] - along * d[i, k]) * node.plane[k]
        for k in range(3):
            before = after = v[i, k]
            if node.held[k]:
                impulse[i, k] = dt * (r[i, k] - force[i, k])
            else:
                impulse[i, k] = 0.0
                after = keep * before + by_mass * (force[i, k] - r[i, k])
            v[i, k] = free[i, k] = after
            v_old[i, k] = before
            if not node.held[3]:
                turn = r[i, 3 + k] - along * d[i, k] - out * node.plane[k]
                old = q[i, k]
                new = keep * old - by_inertia * turn
                q[i, k] = new
                turned += turn * (old + new)
                swept += (old + new) * (old + new)
        inner += turned
        slowed += node.inertia * swept
    work[0] -= 0.5 * dt * inner
    work[2] += 0.25 * dt * drag * slowed


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
    # over the nodes first: added to the totals one by one, each would be rounded as they are; one
    # sum a component, as sums that wait for each other take three times as long
    f0 = f1 = f2 = p0 = p1 = p2 = d0 = d1 = d2 = 0.0
    for i in range(v.shape[0]):
        w0, w1, w2 = v_old[i, 0] + v[i, 0], v_old[i, 1] + v[i, 1], v_old[i, 2] + v[i, 2]
        inner += r[i, 0] * w0 + r[i, 1] * w1 + r[i, 2] * w2
        outer += force[i, 0] * w0 + force[i, 1] * w1 + force[i, 2] * w2
        guided += impulse[i, 0] * w0 + impulse[i, 1] * w1 + impulse[i, 2] * w2
        f0, f1, f2 = f0 + force[i, 0], f1 + force[i, 1], f2 + force[i, 2]
        p0, p1, p2 = p0 + impulse[i, 0], p1 + impulse[i, 1], p2 + impulse[i, 2]
        if drag > 0.0:
            node = nodes[i]
            s0 = 0.0 if node.held[0] else node.mass * (v_old[i, 0] + free[i, 0])
            s1 = 0.0 if node.held[1] else node.mass * (v_old[i, 1] + free[i, 1])
            s2 = 0.0 if node.held[2] else node.mass * (v_old[i, 2] + free[i, 2])
            lost += s0 * w0 + s1 * w1 + s2 * w2
            d0, d1, d2 = d0 + s0, d1 + s1, d2 + s2
    slowing = 0.5 * drag * dt
    for k, load, support, still in ((0, f0, p0, d0), (1, f1, p1, d1), (2, f2, p2, d2)):
        totals[0, k] += dt * load
        totals[1, k] += support
        totals[2, k] -= slowing * still
    work[0] -= 0.5 * dt * inner
    work[1] += 0.5 * dt * outer
    work[2] += 0.5 * slowing * lost
    work[3] += 0.5 * guided


@kernel
def work_over(force: np.ndarray, v_old: np.ndarray, v: np.ndarray, dt: float) -> float:
    """Work [J] of forces (n, 3) over dt while velocities go from v_old to v (n, 3)."""
    work = 0.0
    for i in range(force.shape[0]):
        for k in range(3):
            work += force[i, k] * 0.5 * dt * (v_old[i, k] + v[i, k])
    return work


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
