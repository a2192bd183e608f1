# SPDX-License-Identifier: LGPL-3.0-or-later
"""Points and patches of cloth that meet bodies under extreme conditions; see bodies.py.

Points of mass meet a body by `VelocityCorrection`, a patch of cloth by `Contact` under explicit
and implicit steps.
What is measured: momentum changed but not booked, the deepest point at the end, the growth of
energy in each contact, slip against its closed form.
"""

import numpy as np

import meshes
from contact.body.segments import Body, Fixed, Segment, turned
from contact.geometry.ellipsoid import closest_points
from contact.solver.velocity_correction import VelocityCorrection
from shellform import Fabric, Shell
from shellform.contact_coupling.contact import Contact
from shellform.dynamics.explicit import Newmark
from shellform.dynamics.implicit import ImplicitNewmark
from shellform.results.ledger import Ledger

CLOTH = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "thickness": 1e-3, "density": 200.0}
G = 9.81


def depth(body, t, x, offset=0.0):
    """How far the deepest of the points x (n, 3) is inside at t [m], 0 if none is."""
    pose = body.new_pose(t)
    gaps = [
        closest_points(x, radii, centre, axes)[2].min()
        for radii, centre, axes in zip(body.radii, pose.centres, pose.axes, strict=True)
    ]
    return max(0.0, offset - min(gaps))


def points_on(body, x, v, dt, steps, friction=0.3, pull=(0.0, 0.0, 0.0), **options):
    """Points of 1 kg that fly at a body; what is left of the balances.

    Returns
    -------
    dict: momentum, largest part of it not booked in a step; growth, largest of a point's squared
    speed by contact [m^2/s^2]; inside [m], at the end; fastest [m/s], at the end; met, contacts;
    correction
    """
    mass, growth, momentum, met = np.ones(len(x)), -np.inf, 0.0, 0
    correction = VelocityCorrection(body, len(x), friction, **options)
    for step in range(steps):
        old = v.copy()
        v += dt * np.asarray(pull)
        free = v.copy()
        correction(x, v, mass, dt, step * dt, v_old=old)
        change = np.sum(v - free, axis=0)
        scale = max(np.abs(v).sum(), np.abs(free).sum(), 1e-300)
        for booked in (correction.last.impulse, correction.last.segment_impulse):
            momentum = max(momentum, np.abs(booked.sum(axis=0) - change).max() / scale)
        growth = max(growth, float((np.sum(v * v, axis=1) - np.sum(free * free, axis=1)).max()))
        met += correction.active
        x += dt * v
    return {
        "momentum": momentum,
        "growth": growth,
        "inside": depth(body, steps * dt, x, options.get("offset", 0.0)),
        "fastest": float(np.linalg.norm(v, axis=1).max()),
        "met": met,
        "correction": correction,
    }


def aimed(body, speed, count=300, seed=0):
    """Points around a body at rest that fly at it, a little astray; positions and velocities."""
    rng, far = np.random.default_rng(seed), 1.3 * body.radii.max()
    out = rng.standard_normal((count, 3))
    out /= np.linalg.norm(out, axis=1)[:, None]
    at = rng.uniform(-0.5, 0.5, (count, 3)) * body.radii[0] @ body.new_pose().axes[0]
    way = at - far * out
    return far * out, speed * way / np.linalg.norm(way, axis=1)[:, None]


def slender(aspect, speed=300.0):
    """Points at 300 m/s on an ellipsoid whose longest semi-axis is `aspect` times the shortest."""
    pose = Fixed(axes=turned(np.eye(3), np.array([0.3, 0.2, 0.1])))
    body = Body([Segment("blade", (0.1, 0.1 * aspect**-0.5, 0.1 / aspect), pose)])
    x, v = aimed(body, speed)
    return points_on(body, x, v, 1e-3, 8)


def incline(friction, slope, seconds=1.0, dt=1e-3):
    """Slip [m] of a point on an incline, and the exact one of a steady fall."""
    angle, radius = np.arctan(slope), 1e6
    body = Body([Segment("ground", [radius] * 3, Fixed((0.0, 0.0, -radius)))])
    x, v = np.zeros((1, 3)), np.zeros((1, 3))
    down = G * np.array([np.sin(angle), 0.0, -np.cos(angle)])
    points_on(body, x, v, dt, round(seconds / dt), friction, down)
    pull = max(0.0, np.sin(angle) - friction * np.cos(angle))
    return float(x[0, 0]), 0.5 * G * pull * seconds**2


def row_of_spheres(count):
    """A point falls on each of `count` spheres in a row; segments that met theirs, balances."""
    body = Body([Segment(f"s{k}", [0.1] * 3, Fixed((k, 0.0, 0.0))) for k in range(count)])
    x = np.array([[k, 0.0, 0.1005] for k in range(count)], float)
    out = points_on(body, x, np.tile([0.0, 0.0, -1.0], (count, 1)), 1e-3, 1)
    out["own"] = int(np.sum(out["correction"].segment == np.arange(count)))
    return out


def wall_of_points(side=0.4, count=15, x=0.0):
    s = np.linspace(-side / 2, side / 2, count)
    return np.array([[x, a, b] for a in s for b in s])


def moving(motion, dt, steps, radii=(0.1, 0.1, 0.1), x=None, **options):
    """Points at rest in the way of a body in motion."""
    x = wall_of_points() if x is None else x
    body = Body([Segment("body", radii, motion)])
    return points_on(body, x, np.zeros_like(x), dt, steps, **options)


def jump(size, at=0.1):
    """Motion that is set aside by `size` [m] at a time [s], its velocity zero."""
    return lambda t: (
        np.array([0.0, 0.0, -0.25 + (size if t >= at else 0.0)]),
        np.eye(3), np.zeros(3), np.zeros(3),
    )  # fmt: skip


def patch(side=0.1, cells=6, height=0.01, gravity=G, factor=0.9, dt=None, **options):
    """Stepper of a square of cloth over the origin, implicit where dt [s] is given."""
    surface = meshes.rectangle(side, side, (cells, cells))
    surface = surface.transform(translation=(-side / 2, -side / 2, height))
    shell = Shell(surface, Fabric.isotropic(**CLOTH))
    if gravity:
        shell.loads.gravity((0.0, 0.0, -gravity))
    return ImplicitNewmark(shell, dt) if dt else Newmark(shell, factor, **options)


def cloth_on(stepper, body, seconds, friction=0.3, **options):
    """Cloth meets a body; what its ledger and its places say at the end."""
    touch = stepper.add(Contact(body, friction, **options))
    ledger = stepper.add(Ledger())
    first = ledger.record()
    stepper.advance(stepper.time + seconds)
    row, x = ledger.record(), stepper.shell.positions()
    mass = stepper.shell.comm.allreduce(stepper.mass.sum())
    energy = max(first["kinetic"], row["kinetic"] + row["strain"])
    pushes = seconds * sum(abs(value) for name, value in row.items() if name.startswith("force_"))
    return {
        "first": first,
        "row": row,
        "points": x,
        "growth": (row["kinetic"] + row["strain"]) / max(first["kinetic"], 1e-300) - 1.0,
        "momentum": row["momentum_residual"] / (np.sqrt(2 * mass * energy) + pushes),
        "inside": depth(body, stepper.time, x, 0.5 * CLOTH["thickness"]),
        "touch": touch,
    }


def impact(speed, dt=None):
    """A patch of 0.1 m thrown at a sphere."""
    stepper = patch(gravity=0.0, factor=0.2, dt=dt, cells=4 if dt else 6)
    stepper.v[:, 2] = -speed
    body = Body([Segment("ball", [0.25] * 3, Fixed((0.0, 0.0, -0.25)))])
    return cloth_on(stepper, body, 0.02 / speed + (5 * dt if dt else 200 * stepper.dt))


def over_rod(radius, samples, seconds=0.12):
    """Cloth of cells of 40 mm falls on a rod that lies under the middle of a row of them."""
    stepper = patch(side=0.2, cells=5)
    body = Body([Segment("rod", (radius, 10.0, radius), Fixed((0.0, 0.0, -radius)))])
    out = cloth_on(stepper, body, seconds, samples=samples)
    free = 0.01 - 0.5 * G * seconds**2
    out["caught"] = bool(out["points"][:, 2].max() > free + 1e-3)
    return out


def closing(overlap, flesh=None, seconds=0.4):
    """Two spheres close over cloth until they overlap, or part again by as much."""

    def motion(sign):
        def pose(t):
            a = 2 * np.pi / seconds
            away = 0.1 + 0.5 * overlap * np.cos(a * t)
            speed = -0.5 * overlap * a * np.sin(a * t)
            up = sign * np.array([0.0, 0.0, 1.0])
            return away * up, np.eye(3), speed * up, np.zeros(3)

        return pose

    body = Body([Segment("low", [0.1] * 3, motion(-1)), Segment("high", [0.1] * 3, motion(1))])
    stepper = patch(side=0.1, cells=5, height=0.0, gravity=0.0)
    return cloth_on(stepper, body, seconds, flesh_stiffness=flesh)
