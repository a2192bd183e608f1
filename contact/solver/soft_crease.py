# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cloth in a crease between two parts of the body, which are soft.

Rigid ellipsoids that close over cloth, as calf and thigh do at a bent knee, squeeze it out of the
crease between them with any force, and tear it. Flesh gives way, keeps the cloth and flattens: at
the surface where the two meet, both press alike.

So a part of the body that presses a point against another, with normals more than a right angle
apart, lets it in: at a depth d below its skin it presses with

    p = k (d + tau d')     [Pa],   never pulling,

as an elastic layer of stiffness k with a little loss, until the point has come out again. From both
sides the point is led to where the two pressures balance, held there by the friction of both, and
the work of k d is given back when the parts open. Everywhere else the body is rigid.

What the two press on each other alike is there without the cloth too, flesh on flesh: pushes of
f_i n_i and f_j n_j are booked less c (n_i - n_j)/2 and c (n_j - n_i)/2, c the smaller of f_i, f_j.
Their sum, the force on the cloth, stays; of two equal opposite pushes nothing is left.

Ellipsoids on one and the same rigid segment (`mates`) make a hard crease, as one body does.
"""

from numba import njit

from contact.geometry.ellipsoid import foot_and_normal

from .segment_motion import turned_by
from .supporting_planes import set_plane

# tau [s]: brings cloth that swings between two soft sides to rest; in a walk it is no matter
RELAXATION = 5e-4
RESOLVED = 0.1  # of 1/dt^2, the greatest stiffness over mass that steps of dt follow


@njit(cache=True, error_model="numpy")
def soften(x, free, kick, dt, flesh, travel, offset, sunk, fresh, planes, start):
    """Soft parts that a point lies in: their pushes, of which `free` is changed.

    Parameters
    ----------
    x : (3,) float, point at t [m]; free : (3,) float, step without contact [m], changed
    kick : (3,) float, change of velocity by the forces of this step [m/s]
    dt : float [s]; flesh : float, k over the areal mass of the cloth [1/s^2]
    travel : (m,) TRAVEL; offset : float [m]
    sunk : int, set of the segments that let the point in; fresh : those that began in this step
    planes : PLANE, filled from `start` on

    Returns
    -------
    sunk, without those that the point has left; planes filled; greatest depth [m]
    """
    count, deepest, inside = 0, 0.0, 0
    flesh = min(flesh, RESOLVED / dt**2)
    loss = flesh * RELAXATION * dt
    for b in range(len(travel)):
        body = travel[b]
        if not (sunk >> body.bit) & 1:
            continue
        q0, q1, q2 = x[0] - body.centre[0], x[1] - body.centre[1], x[2] - body.centre[2]
        y0, y1, y2 = turned_by(body.axes, q0, q1, q2)
        r0, r1, r2 = body.radii[0], body.radii[1], body.radii[2]
        distance, _, _, _, n0, n1, n2 = foot_and_normal(y0, y1, y2, r0, r1, r2)
        depth = offset - distance
        if depth <= 0.0:
            continue
        inside |= 1 << body.bit
        u0, u1, u2 = turned_by(body.turn, q0, q1, q2)
        u0, u1, u2 = u0 + body.shift[0], u1 + body.shift[1], u2 + body.shift[2]
        plane = planes[start + count]
        set_plane(plane, b, body, n0, n1, n2, 0.0, depth, u0, u1, u2)
        n = plane.normal
        closing = 0.0
        for c in range(3):
            closing += (plane.drift[c] - free[c] + dt * kick[c]) * n[c]
        plane.push = max(0.0, flesh * dt * dt * depth + loss / (1.0 + loss) * closing)
        count, deepest = count + 1, max(deepest, depth)
    for k in range(start, start + count):
        for c in range(3):
            free[c] += planes[k].push * planes[k].normal[c]
    return sunk & (inside | fresh), count, deepest


@njit(cache=True, error_model="numpy")
def opposed(planes, count, travel, every):
    """Set of the segments whose planes are turned against one of another segment.

    planes : (m,) PLANE, the first `count` in use; those that push, or `every` one
    """
    out = 0
    for k in range(count):
        for j in range(k):
            if not every and (planes[k].push <= 0.0 or planes[j].push <= 0.0):
                continue
            one, other = travel[planes[k].owner], travel[planes[j].owner]
            if (one.mates >> other.bit) & 1:
                continue
            p, q = planes[k].normal, planes[j].normal
            if p[0] * q[0] + p[1] * q[1] + p[2] * q[2] < 0.0:
                out |= (1 << one.bit) | (1 << other.bit)
    return out


@njit(cache=True, error_model="numpy")
def from_cloth(planes, first, last, k, travel, out):
    """Push (3,) of plane k that is booked, into out: less what is flesh on flesh.

    planes : (m,) PLANE, from `first` to before `last` those of soft parts
    """
    n, push = planes[k].normal, planes[k].push
    for c in range(3):
        out[c] = push * n[c]
    if k < first:
        return
    for j in range(first, last):
        if j == k or (travel[planes[k].owner].mates >> travel[planes[j].owner].bit) & 1:
            continue
        common = 0.5 * min(push, planes[j].push)
        for c in range(3):
            out[c] -= common * (n[c] - planes[j].normal[c])
