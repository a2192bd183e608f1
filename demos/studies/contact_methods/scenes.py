# SPDX-License-Identifier: LGPL-3.0-or-later
"""Two scenes of the studies of contact, and their exact answers; the capstan is demos/capstan.py.

A sleeve, a tube stretched from its rest radius r to R on a cylinder, presses with the force 2 pi L
N, N = E t ((R/r)^2 - 1)/2 R/r being its hoop tension per length (nu = 0). A square that lies on a
ball weighs what it weighs.
"""

import numpy as np

import meshes
from shellform import Body, Fabric, Fixed, Segment, Shell

CLOTH = Fabric.isotropic(1e6, 0.0, 1e-3, 200.0)
G = 9.81  # m/s^2
REST, RADIUS, LONG = 0.048, 0.05, 0.1  # m, of the sleeve
BALL, SIDE = 0.25, 0.5  # m


def stretched_sleeve() -> tuple[Shell, Body]:
    """A tube stretched onto a cylinder, and that."""
    surface = meshes.cylinder(REST, LONG, (40, 6)).transform(translation=(0, 0, -0.5 * LONG))
    shell = Shell(surface.replace(warp=(0.0, 0.0, 1.0)), CLOTH)
    points = surface.points[shell.partition.nodes]
    shell.w.x.array.reshape(-1, 6)[:, :3] = (RADIUS / REST - 1) * points * [1.0, 1.0, 0.0]
    return shell, Body([Segment("arm", (RADIUS - 5e-4, RADIUS - 5e-4, 200.0), Fixed())])


def error_of_sleeve(force: np.ndarray, x: np.ndarray) -> float:
    """Relative error of the forces (n, 3) [N] on the nodes of a sleeve at x (n, 3) [m]."""
    # it may turn on the cylinder, there is no friction
    outward = np.sum(force[:, :2] * x[:, :2] / np.linalg.norm(x[:, :2], axis=1)[:, None])
    tension = 1e3 * 0.5 * ((RADIUS / REST) ** 2 - 1) * RADIUS / REST
    return float(outward / (2 * np.pi * LONG * tension) - 1)


def square_on_a_ball(cells: int) -> tuple[Shell, Body]:
    """A square of cells x cells a little above a ball, and that."""
    surface = meshes.rectangle(SIDE, SIDE, (cells, cells))
    surface = surface.transform(translation=(-0.24, -0.255, 2e-3))
    shell = Shell(surface, CLOTH)
    shell.loads.gravity((0.0, 0.0, -G))
    return shell, Body([Segment("ball", [BALL] * 3, Fixed((0.0, 0.0, -BALL)))])


def error_of_weight(up: float) -> float:
    """Relative error of a force [N] that bears the square."""
    return up / (CLOTH.areal_mass * SIDE**2 * G) - 1
