# SPDX-License-Identifier: LGPL-3.0-or-later
r"""A curtain: a hanging sheet whose upper edge is drawn together into folds.

The upper edge follows a wave that keeps its length, the meander whose tangent turns by

    psi(s) = psi0 sin(2 pi k s / W),

so its ends come together by 1 - J0(psi0) of the width W; psi0 grows from 0 in a second. Folds hang
down from it as on a cylinder, which costs no stretch: what an element finds of membrane energy is
its own error. There is no contact and, with the waves given, one state to find: the scene measures
elements where a drape cannot. The edge is hinged: directors turn freely.

`pushed` is the scene of long runs: a flat sheet without weight, its ends moved together, which
buckles as it likes.
"""

import time
from dataclasses import dataclass

from mpi4py import MPI

import numpy as np

import meshes
from demos.studies.drape.square import G, fabric
from shellform import Shell
from shellform.dynamics.explicit import Newmark
from shellform.results.ledger import Ledger

COMM = MPI.COMM_WORLD
WIDTH, DROP, WAVES = 1.0, 0.5, 3  # m, m, folds of the upper edge
GATHER = 0.25  # of the width
ALONG = 2048  # points on which the meander is integrated


@dataclass(frozen=True)
class Curtain:
    """Cells along the width (even), membrane and distortion of the mesh, see drape's Scene."""

    cells: int = 24
    membrane: str = "arcs"
    distortion: float = 0.0
    factor: float = 0.9
    damping: float = 2e-4
    drag: float = 3.0
    seconds: float = 3.0


def sheet(curtain):
    """Shell of WIDTH x DROP in the plane y = 0, its lower edge at z = 0."""
    cells = (curtain.cells, curtain.cells // 2)
    upright = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    surface = meshes.rectangle(
        WIDTH, DROP, cells, parameters=meshes.distorted(cells, curtain.distortion, seed=1)
    ).transform(rotation=upright)
    return Shell(surface, fabric(), COMM, membrane=curtain.membrane)


def meander(s, psi):
    """Places (n, 3) [m] from the straight edge at arc lengths s (n,) of a meander about W/2."""
    line = (np.arange(ALONG) + 0.5) * WIDTH / ALONG
    turn = psi * np.sin(2 * np.pi * WAVES * line / WIDTH)
    at = np.linspace(0, WIDTH, ALONG + 1)
    step = WIDTH / ALONG
    x = np.append(0.0, np.cumsum(np.cos(turn)) * step)
    y = np.append(0.0, np.cumsum(np.sin(turn)) * step)
    x += 0.5 * (WIDTH - x[-1])
    y -= y.mean()
    return np.column_stack([np.interp(s, at, x) - s, np.interp(s, at, y), 0 * s])


def ramp(time):
    """0 to 1 in a second, smooth at both ends."""
    t = min(max(time, 0.0), 1.0)
    return t * t * (3 - 2 * t)


def full_turn():
    """psi0 [rad] that draws the ends together by GATHER."""
    from scipy.optimize import brentq
    from scipy.special import j0

    return brentq(lambda psi: j0(psi) - (1 - GATHER), 0.0, 2.0)


def run(curtain):
    """Hang a curtain.

    Returns
    -------
    dict of numbers for a table, and of `positions`, `directors`, `quads`. `depth` is the root mean
    square of y along the lower edge [m], `side` the force [N] along x on the left half of the
    upper edge, `membrane_energy` the membrane's part of the strain energy.
    """
    shell = sheet(curtain)
    edge = np.unique(shell.surface.edges["top"])
    s, psi = shell.surface.points[edge, 0], full_turn()
    shell.supports.move("top", lambda time: meander(s, psi * ramp(time)))
    shell.loads.gravity((0.0, 0.0, -G))
    stepper = Newmark(shell, curtain.factor, damping=curtain.damping, drag=curtain.drag)
    stepper.advance(stepper.dt)
    start, done = time.process_time(), stepper.steps
    stepper.advance(curtain.seconds)
    spent = COMM.allreduce(time.process_time() - start)
    x = shell.positions()
    z = (stepper.points + stepper.owned[:, :3])[:, 2]
    mass = COMM.allreduce(stepper.mass.sum())
    hem = x[np.unique(shell.surface.edges["bottom"])]
    hem = hem[np.argsort(hem[:, 0])]
    force = shell.partition.gather(stepper.internal_force()[:, :3].copy())[edge]
    half = np.where(np.isclose(s, 0.5 * WIDTH), 0.5, s < 0.5 * WIDTH)
    energy = shell.energy()
    return {
        "height": COMM.allreduce(stepper.mass @ z) / mass - 0.5 * DROP,
        "depth": float(np.sqrt(np.mean(hem[:, 1] ** 2))),
        "hem": float(np.ptp(hem[:, 0])),
        "side": float(half @ force[:, 0]),
        "strain": sum(energy.values()),
        "membrane_energy": energy["membrane"],
        "folds": folds(hem[:, 1]),
        "kinetic": stepper.momenta()[2],
        "steps": stepper.steps,
        "dt": curtain.seconds / stepper.steps,
        "us": 1e6 * spent / (stepper.steps - done) / len(x),
        "seconds": spent,
        "positions": x,
        "directors": shell.directors(),
        "quads": shell.surface.cells,
    }


def folds(y, deep=0.02):
    """Bulges to one side of a line of depths y [m] that stand out by more than `deep` [m]."""
    from scipy.signal import find_peaks

    ends = [y.min() - 1.0]
    return len(find_peaks(np.concatenate([ends, y, ends]), prominence=deep)[0])


def pushed(membrane, cells, steps, gather=GATHER, factor=0.9, damping=0.0):
    """Push a sheet without weight into folds, then let it swing for a number of steps.

    Returns
    -------
    dict: energies [J] at the end; `gained`, the most energy out of nothing since the ends stopped,
    as a part of what there was then (damping only takes); `finite` False if the steps broke down
    (then no energies)
    """
    from shellform.errors import Unstable

    shell = sheet(Curtain(cells, membrane))
    goal = np.array([0.5 * gather * WIDTH, 0.0, 0.0])
    shell.supports.move("left", lambda time: ramp(time) * goal)
    shell.supports.move("right", lambda time: -ramp(time) * goal)
    stepper = Newmark(shell, factor, damping=damping)
    # waves of one cell too, the same on any number of ranks
    noise = 1e-3 * np.random.default_rng(1).standard_normal(len(shell.surface.points))
    stepper.v[:, 1] = noise[shell.partition.owned_nodes]
    ledger = stepper.add(Ledger())
    out = {"steps": 0, "seconds": 0.0, "kinetic": None, "strain": None, "gained": None}
    try:
        stepper.advance(1.2)
        first = ledger.record()
        start, gained = first["kinetic"] + first["strain"], 0.0
        steps += stepper.steps
        while stepper.steps < steps:
            stepper.advance(stepper.time + min(2000, steps - stepper.steps) * stepper.dt)
            row = ledger.record()
            gained = max(gained, (row["energy_residual"] - first["energy_residual"]) / start)
    except (Unstable, FloatingPointError):
        return out | {"steps": stepper.steps, "seconds": stepper.time, "finite": False}
    return out | {
        "steps": stepper.steps,
        "seconds": stepper.time,
        "kinetic": row["kinetic"],
        "strain": row["strain"],
        "gained": gained,
        "finite": True,
    }
