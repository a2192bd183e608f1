# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sheets in motion under extreme conditions with known answers; see sheets.py.

- `tumbled`, free flight: momenta and energy are kept, and E, rho and L only set the units,
- `spun`, a rigid turning, which strains by the centrifugal force alone,
- `rung`, the lowest note of a strip held at one end, at any thickness,
- `swung`, a sheet under its weight at any time step, against small steps,
- `million`, free fall of as many cells.
"""

import numpy as np

import meshes
from demos.studies.extremes.sheet_cases import DENSITY, MODULUS, strip
from shellform import Fabric, Shell
from shellform.dynamics.explicit import Newmark
from shellform.dynamics.implicit import ImplicitNewmark
from shellform.fem.lumped_mass import ROTARY_SCALE

G = 9.81
FIRST = 1.8751040687119611  # lowest root of cos a cosh a = -1: a strip held at one end


def thrown(fabric, size=1.0, speed=0.02, cells=(4, 4), origin=None, aspect=1.0, **settings):
    """Newmark stepper of a free square that flies, spins about a skew axis, and rings.

    speed : of its corner over that of its waves, sqrt(A/(areal mass))
    """
    surface = meshes.rectangle(size, size / aspect, cells)
    if origin is not None:
        surface = surface.transform(translation=origin)
    shell = Shell(surface, fabric)
    stepper = Newmark(shell, **settings)
    fast = speed * np.sqrt(fabric.membrane[0, 0] / fabric.areal_mass)
    spin = np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0) * fast / size
    arms = stepper.points - surface.points.mean(axis=0)
    stepper.v[:] = np.cross(spin, arms) + 0.3 * fast
    # a part that strains it: each point against the middle, along x
    stepper.v[:, 0] += 0.1 * fast * (arms[:, 0] / size) ** 2
    stepper.q[:] = np.cross(spin, stepper.owned[:, 3:])
    return stepper


def balances(stepper):
    """Momentum (3,), angular momentum (3,) about the middle of the mesh, energy, of free flight."""
    p, j, kinetic = stepper.momenta()
    middle = stepper.shell.surface.points.mean(axis=0)
    return p, j - np.cross(middle, p), kinetic + sum(stepper.strain_energy().values())


def tumbled(fabric, steps=500, **thrown_so):
    """Let a sheet fly free for so many equal steps.

    Returns
    -------
    dict: places (n, 3), displacements over the size; momentum, turning, energy, what they drifted
    by over what they are; cutbacks
    """
    stepper = thrown(fabric, **thrown_so)
    before, size = balances(stepper), thrown_so.get("size", 1.0)
    stepper.advance(steps * stepper.dt)
    drift = [
        float(np.abs(b - a).max() / np.abs(a).max())
        for a, b in zip(before, balances(stepper), strict=True)
    ]
    out = dict(zip(("momentum", "turning", "energy"), drift, strict=True))
    places = stepper.shell.displacements() / size
    return out | {"places": places, "steps": stepper.steps, "cutbacks": stepper.rewind.cutbacks}


def spun(turns, speed=0.03, cells=(4, 1), modulus=1e6, density=200.0):
    """Spin a strip about its short axis through its middle, so many turns at steady speed.

    Centrifugal force strains it: at rest in the turning frame by 2/5 (tip speed/wave speed)^2 of
    its kinetic energy. Set spinning at once it swings about that, up to four times as much.

    Returns
    -------
    dict: strain (energy at the end over the kinetic), bound (four times the above), turned (of
    the director, in turns, wound up), turning (drift of angular momentum)
    """
    length = 1.0
    fabric = Fabric.isotropic(modulus, 0.0, 0.01, density)
    surface = meshes.rectangle(length, 0.25, cells)
    shell = Shell(surface.transform(translation=(-0.5 * length, -0.125, 0.0)), fabric)
    stepper = Newmark(shell)
    wave = np.sqrt(modulus / density)
    spin = np.array([0.0, speed * wave / (0.5 * length), 0.0])
    stepper.v[:] = np.cross(spin, stepper.points)
    stepper.q[:] = np.cross(spin, stepper.owned[:, 3:])
    _, before, _ = stepper.momenta()
    goal = 2 * np.pi * turns / spin[1]
    stepper.advance(goal)
    _, after, kinetic = stepper.momenta()
    strain = sum(stepper.strain_energy().values()) / kinetic
    drift = np.abs(after - before).max() / np.abs(before).max()
    return {
        "strain": float(strain), "bound": 1.6 * speed**2, "turning": float(drift),
        "steps": stepper.steps,
    }  # fmt: skip


def curtain():
    """A sheet held by one edge, level, about to swing down."""
    shell = Shell(meshes.rectangle(0.5, 0.25, (4, 2)), Fabric.isotropic(1e6, 0.3, 1e-3, 200.0))
    shell.supports.clamp("left")
    shell.loads.gravity((0.0, 0.0, -G))
    return shell


def swung(part, until=0.1, implicit=False, forced=False):
    """Places of a curtain after a time by steps that are a part of the stable one.

    forced : explicit steps that are set behind the back of the check of settings

    Returns
    -------
    places (n, 3) [m], stepper
    """
    shell = curtain()
    if implicit:
        stable = Newmark(curtain(), 1.0).critical_dt
        stepper = ImplicitNewmark(shell, part * stable, rotary_scale=ROTARY_SCALE)
    else:
        stepper = Newmark(shell, 0.3 if forced else part)
        if forced:
            stepper.factor, stepper.dt = part, part * stepper.critical_dt
    stepper.advance(until)
    places = shell.displacements()
    if implicit:
        stepper.destroy()
    return places, stepper


def million(side=1000, steps=5):
    """Explicit free fall of side x side cells, which is exact; bytes a node it took."""
    import resource

    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    shell = Shell(meshes.rectangle(1.0, 1.0, (side, side)), strip(1e-3))
    shell.loads.gravity((0.0, 0.0, -G))
    stepper = Newmark(shell)
    end = steps * stepper.dt
    stepper.advance(end)
    fallen = shell.w.x.array.reshape(-1, 6)[: shell.partition.n_owned, 2]
    # half a step late: velocities start at the first half step
    exact = -0.5 * G * end**2
    error = shell.comm.allreduce(np.abs(fallen / exact - 1).max())
    used = 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
    return {"error": float(error), "steps": stepper.steps, "bytes": used / (side + 1) ** 2}


def shape(x):
    """Lowest shape of a strip held at x = 0, 2 at its end x = 1, and the slope of it."""
    s = (np.cosh(FIRST) + np.cos(FIRST)) / (np.sinh(FIRST) + np.sin(FIRST))
    a = FIRST * x
    bent = np.cosh(a) - np.cos(a) - s * (np.sinh(a) - np.sin(a))
    return bent, FIRST * (np.sinh(a) + np.sin(a) - s * (np.cosh(a) - np.cos(a)))


def rung(ratio, cells=16, steps=100, swing=1e-3):
    """Period of the lowest note of a strip, of thickness `ratio` of its length of 1 m.

    Exact: omega^2 = FIRST^4 D/(rho t L^4) of a thin one; one that also shears has, by Dunkerley,
    1/omega^2 more of it by that of shear alone, (pi/2L)^2 (5/6) G/rho.

    Parameters
    ----------
    cells : int, along the strip; steps : int, implicit, a period
    swing : float, of the end over the length

    Returns
    -------
    dict: error (of the period, over the exact one), swing (largest, over the exact one), cutbacks
    """
    shell = Shell(meshes.rectangle(1.0, 1.0 / cells, (cells, 1)), strip(ratio))
    shell.supports.clamp("left")
    bends = FIRST**4 * MODULUS * ratio**2 / 12 / DENSITY
    shears = (0.5 * np.pi) ** 2 * 5 / 12 * MODULUS / DENSITY
    omega = 1 / np.sqrt(1 / bends + 1 / shears)
    period = 2 * np.pi / omega
    # the membrane is far too stiff for steps that resolve the note: its modes are damped
    stepper = ImplicitNewmark(shell, period / steps, alpha=-0.05)
    bent, slope = shape(stepper.points[:, 0])
    free = stepper.points[:, 0] > 0
    stepper.v[free, 2] = 0.5 * swing * omega * bent[free]
    stepper.q[free, 0] = -0.5 * swing * omega * slope[free]
    end, times, places = shell.partition.find("right"), [0.0], [0.0]
    while stepper.time < 1.1 * period:
        stepper.advance(stepper.time + period / steps)
        times.append(stepper.time)
        places.append(shell.displacements()[end, 2].mean())
    cutbacks = stepper.cutbacks
    stepper.destroy()
    t, z = np.array(times), np.array(places)
    up = np.flatnonzero((z[1:-1] < 0) & (z[2:] >= 0))[0] + 1
    measured = t[up] - z[up] * (t[up + 1] - t[up]) / (z[up + 1] - z[up])
    return {
        "error": abs(float(measured / period - 1)), "swing": float(z.max() / swing),
        "cutbacks": cutbacks,
    }  # fmt: skip
