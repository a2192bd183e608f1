# SPDX-License-Identifier: LGPL-3.0-or-later
"""Nodal kernels of the explicit Newmark step (beta = 0, gamma = 1/2): Sec. 3.1.3.

Velocities live at half steps. A kick adds the impulse of the forces to them, a drift moves the
nodes by them: positions along straight lines, directors along great circles with their velocity
carried parallel. Both conserve momentum and angular momentum exactly.

Kernels work in place on plain arrays of the nodes of one rank.
"""

import numba
import numpy as np

compiled = numba.njit(
    # not finite stays not finite: no assumption that NaN or infinity do not occur
    cache=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz", "arcp"}
)  # fmt: skip

SMALL = 1e-2  # square of an angle below which the series of `drift` are exact to roundoff


@compiled
def kick(
    v, q, r, force, d, held, plane, mass, inertia, drag, dt, impulse, work, v_old
):  # fmt: skip
    """Add the impulse of internal and external forces over dt to the velocities.

    Held components keep their velocity; the impulse that takes is the supports'. Work on directors
    is booked here, that on nodes by `book`, once contact has had its say.

    Parameters
    ----------
    v, q : (n, 3), velocities of nodes [m/s] and directors [1/s], changed
    r : (n, 6), internal forces [N, N m]; force : (n, 3), external forces [N]
    d : (n, 3), directors
    held : (n, 4) bool, u_x, u_y, u_z and the whole director
    plane : (n, 3), normal that a director may not turn towards, zero where none
    mass, inertia : (n,) [kg, kg m^2]
    drag : float [1/s], decay rate of the velocities relative to still air
    dt : float [s]
    impulse : (n, 3) [N s], the supports' push on the nodes, overwritten
    work : (4,) [J], of internal and external forces, taken by drag, of supports; added to
    v_old : (n, 3), overwritten with v as it was
    """
    keep = (1.0 - 0.5 * dt * drag) / (1.0 + 0.5 * dt * drag)
    gain = dt / (1.0 + 0.5 * dt * drag)
    turned = slowed = 0.0
    for i in range(v.shape[0]):
        along = r[i, 3] * d[i, 0] + r[i, 4] * d[i, 1] + r[i, 5] * d[i, 2]
        out = 0.0
        for k in range(3):
            out += (r[i, 3 + k] - along * d[i, k]) * plane[i, k]
        light = gain / mass[i]
        for k in range(3):
            v_old[i, k] = v[i, k]
            if held[i, k]:
                impulse[i, k] = dt * (r[i, k] - force[i, k])
            else:
                impulse[i, k] = 0.0
                v[i, k] = keep * v[i, k] + light * (force[i, k] - r[i, k])
        if not held[i, 3]:
            light = gain / inertia[i]
            power = square = 0.0
            for k in range(3):
                turn = r[i, 3 + k] - along * d[i, k] - out * plane[i, k]
                old = q[i, k]
                new = keep * old - light * turn
                q[i, k] = new
                power += turn * (old + new)
                square += (old + new) * (old + new)
            turned += power
            slowed += inertia[i] * square
    work[0] -= 0.5 * dt * turned
    work[2] += 0.25 * dt * drag * slowed


@compiled
def book(v_old, v, r, force, held, mass, drag, dt, impulse, work, totals):
    """Book a kick whose velocities went from v_old to v, contact included.

    Work is impulse . (v_old + v)/2 for every impulse: that of all of them is the change of kinetic
    energy, to roundoff.

    Parameters
    ----------
    v_old, v : (n, 3) [m/s], before the kick and when all have had their say
    r, force, held, mass, drag, dt, impulse, work : see kick
    totals : (3, 3) [N s], rows: impulses of loads, supports and drag on the nodes; added to
    """
    # drag works on the mean of v_old and what `kick` made of it
    slow = 1.0 / (1.0 + 0.5 * dt * drag)
    half = 0.5 * dt * slow
    inner = outer = held_work = lost = 0.0
    l0 = l1 = l2 = s0 = s1 = s2 = 0.0
    for i in range(v.shape[0]):
        m0, m1, m2 = v_old[i, 0] + v[i, 0], v_old[i, 1] + v[i, 1], v_old[i, 2] + v[i, 2]
        inner += r[i, 0] * m0 + r[i, 1] * m1 + r[i, 2] * m2
        outer += force[i, 0] * m0 + force[i, 1] * m1 + force[i, 2] * m2
        held_work += impulse[i, 0] * m0 + impulse[i, 1] * m1 + impulse[i, 2] * m2
        l0, l1, l2 = l0 + force[i, 0], l1 + force[i, 1], l2 + force[i, 2]
        s0, s1, s2 = s0 + impulse[i, 0], s1 + impulse[i, 1], s2 + impulse[i, 2]
    work[0] -= 0.5 * dt * inner
    work[1] += 0.5 * dt * outer
    work[3] += 0.5 * held_work
    totals[0, 0] += dt * l0
    totals[0, 1] += dt * l1
    totals[0, 2] += dt * l2
    totals[1, 0] += s0
    totals[1, 1] += s1
    totals[1, 2] += s2
    if drag == 0.0:
        return
    l0 = l1 = l2 = 0.0
    for i in range(v.shape[0]):
        b0 = slow * mass[i] * v_old[i, 0] + half * (force[i, 0] - r[i, 0])
        b1 = slow * mass[i] * v_old[i, 1] + half * (force[i, 1] - r[i, 1])
        b2 = slow * mass[i] * v_old[i, 2] + half * (force[i, 2] - r[i, 2])
        b0, b1, b2 = b0 * (not held[i, 0]), b1 * (not held[i, 1]), b2 * (not held[i, 2])
        l0, l1, l2 = l0 + b0, l1 + b1, l2 + b2
        lost += b0 * (v_old[i, 0] + v[i, 0]) + b1 * (v_old[i, 1] + v[i, 1])
        lost += b2 * (v_old[i, 2] + v[i, 2])
    part = drag * dt
    work[2] += 0.5 * part * lost
    totals[2, 0] -= part * l0
    totals[2, 1] -= part * l1
    totals[2, 2] -= part * l2


@compiled
def work_over(force, v_old, v, dt):
    """Work [J] of forces (n, 3) over dt while velocities go from v_old to v (n, 3)."""
    work = 0.0
    for i in range(force.shape[0]):
        for k in range(3):
            work += force[i, k] * 0.5 * dt * (v_old[i, k] + v[i, k])
    return work


@compiled
def drift(w, v, q, dt):
    """Move nodes and directors by their velocities over dt.

    w : (n, 6), (u, d), changed; v : (n, 3); q : (n, 3), changed: carried along. Returns the sum of
    all moved coordinates: not finite if any of them is not.
    """
    total = 0.0
    for i in range(w.shape[0]):
        d0, d1, d2 = w[i, 3], w[i, 4], w[i, 5]
        along = q[i, 0] * d0 + q[i, 1] * d1 + q[i, 2] * d2
        q0, q1, q2 = q[i, 0] - along * d0, q[i, 1] - along * d1, q[i, 2] - along * d2
        for k in range(3):
            w[i, k] += dt * v[i, k]
        total += w[i, 0] + w[i, 1] + w[i, 2]
        square = q0 * q0 + q1 * q1 + q2 * q2
        t = dt * dt * square
        if t == 0.0:
            q[i, 0], q[i, 1], q[i, 2] = q0, q1, q2
            continue
        # cos a and (sin a)/a of the angle a = sqrt(t)
        if t < SMALL:
            c = 1.0 - t / 2 * (1.0 - t / 12 * (1.0 - t / 30 * (1.0 - t / 56 * (1.0 - t / 90))))
            s = 1.0 - t / 6 * (1.0 - t / 20 * (1.0 - t / 42 * (1.0 - t / 72 * (1.0 - t / 110))))
        else:
            angle = np.sqrt(t)
            c, s = np.cos(angle), np.sin(angle) / angle
        s *= dt
        x0, x1, x2 = c * d0 + s * q0, c * d1 + s * q1, c * d2 + s * q2
        s *= square
        q[i, 0], q[i, 1], q[i, 2] = c * q0 - s * d0, c * q1 - s * d1, c * q2 - s * d2
        length = 1.0 / np.sqrt(x0 * x0 + x1 * x1 + x2 * x2)
        x0, x1, x2 = length * x0, length * x1, length * x2
        w[i, 3], w[i, 4], w[i, 5] = x0, x1, x2
        total += x0 + x1 + x2
    return total


@compiled
def ahead(w, v, q, time, out):
    """w + time (v, q): where the internal force is taken for stiffness-proportional damping."""
    for i in range(w.shape[0]):
        for k in range(3):
            out[i, k] = w[i, k] + time * v[i, k]
            out[i, 3 + k] = w[i, 3 + k] + time * q[i, k]


@compiled
def momenta(w, points, v, q, mass, inertia, out):
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
