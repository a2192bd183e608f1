# SPDX-License-Identifier: LGPL-3.0-or-later
"""Relaxation fades: cells that show the wrinkles need no relaxed law, and give the same with it.

N_c = D (pi/h)^2 grows as cells get smaller, so a relaxed cell comes to bear what the sheet does,
and the wrinkles are made by nodes. Two sheets, both ways, at sizes that come to show the wrinkles:
a sheared strip that is free to leave its plane, and the pinned drape of drape.py.
"""

import numpy as np

import meshes
from demos.studies.drape import square
from demos.studies.wrinkles.exact import sheared_strip
from demos.studies.wrinkles.flat import STIFFNESS, sheet
from shellform import Fabric, Newmark, Shell

HEIGHT, GAMMA, STRETCH, THICK = 0.1, 0.02, 2e-3, 1e-3  # m; shear, stretch; t of a solid sheet, m


def sheared(cells: int, wrinkles: str, seconds: float = 0.6) -> dict:
    """A strip three times as long as high, `cells` high, its long edges clamped and moved.

    Returns
    -------
    dict: `shear` [N/m], the mean over the last quarter of force per length over that of a sheet
    that stays flat (G gamma); `height`, root mean square of the waves [m]; `strain` [J]
    """
    surface = meshes.rectangle(3 * HEIGHT, HEIGHT, (3 * cells, cells))
    A = sheet().membrane
    fabric = Fabric.from_stiffness(A, THICK**2 / 12 * A, 0.2, THICK)
    shell = Shell(surface, fabric, wrinkles=wrinkles)
    shell.supports.clamp("bottom")
    shell.supports.hold_director("top")
    goal = np.array([GAMMA * HEIGHT, STRETCH * HEIGHT, 0.0])
    shell.supports.move("top", displacement=lambda t: min(t / (0.4 * seconds), 1.0) * goal)
    stepper = Newmark(shell, 0.9, drag=20.0)
    inside = ~stepper.held[:, 2]
    noise = 1e-5 * np.random.default_rng(1).normal(size=inside.sum())
    stepper.owned[inside, 2] += noise
    stepper.scatter()
    top = np.isclose(stepper.points[:, 1], HEIGHT)
    found = []
    for t in seconds * np.linspace(0.75, 1.0, 11):
        stepper.advance(t)
        found.append(stepper.internal_force()[top, 0].sum() / (3 * HEIGHT))
    flat = A[2, 2] * GAMMA
    return {
        "size": HEIGHT / cells,
        "wrinkles": wrinkles,
        "shear": float(np.mean(found)) / flat,
        "height": float(stepper.owned[:, 2].std()),
        "strain": float(sum(stepper.strain_energy().values())),
        "steps": stepper.steps,
    }


def draped(cells: int, wrinkles: str, bending: float = 2.29e-3) -> dict:
    """The pinned drape of a sheet of 1 m, at rest; a stiff one has a single state."""
    found = square.run(
        square.Scene(cells=cells, bending=bending, damping=2e-5, wrinkles=wrinkles, seconds=3.0)
    )
    keys = ("strain", "height", "folds", "steps")
    return {"size": 1.0 / cells, "wrinkles": wrinkles} | {k: found[k] for k in keys}


def tension_field() -> float:
    """Shear of an infinite strip with N_c = 0 over G gamma."""
    return sheared_strip(STRETCH, GAMMA, STIFFNESS, 0.3)[0] / (sheet().membrane[2, 2] * GAMMA)
