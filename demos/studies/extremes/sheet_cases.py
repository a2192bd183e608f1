# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sheets under extreme conditions with known answers; see sheets.py.

Statics with an exact answer at any thickness, modulus, size and shape of cells; those that move are
in sheets_in_motion.py:

- `rolled`, the roll-up of Fig. 5 with the stretch that a thick sheet rolls up with,
- `pulled`, a uniform strain off the axes of an orthotropic fabric (a patch test),
- `turned_round`, an edge led round, which strains nothing; no load; a mechanism.
"""

import numpy as np

import meshes
from meshes.geometry import widest_corners
from meshes.shapes.grid import uniform
from shellform import Fabric, Shell, Statics
from shellform.material.laminate import turn

LENGTH = 12.0  # m, of the strip that is rolled up
MODULUS, DENSITY = 1.2e6, 1000.0


def strip(thickness=1e-3 * LENGTH, modulus=MODULUS, poisson=0.0, **options):
    """Isotropic fabric of the strip that is rolled up."""
    return Fabric.isotropic(modulus, poisson, thickness, DENSITY, **options)


def coil(fabric, length, turns, degrees=0.0):
    """Tip (3,) [m] of a strip under the end moment D k, k = 2 pi turns/length.

    With the stretch c and the turning rate k' of the director along the undeformed length the
    energy is A ((c^2 - 1)/2)^2/2 + D (c k')^2/2. No force acts along the strip, so that
    c^2 = 1 - 2 D k'^2/A, and the moment D c^2 k' is D k.
    """
    A, D = (turn(m, degrees)[0, 0] for m in (fabric.membrane, fabric.bending))
    k = 2 * np.pi * turns / length
    roots = np.roots([-2 * D / A, 0.0, 1.0, -k])
    rate = min(r.real for r in roots if abs(r.imag) < 1e-9 * abs(r) and r.real > 0)
    c, angle = np.sqrt(1 - 2 * D * rate**2 / A), rate * length
    return np.array(
        [
            c * length * np.sinc(angle / np.pi),
            0.0,
            0.5 * c * length * angle * np.sinc(angle / (2 * np.pi)) ** 2,
        ]
    )


def rolled(
    fabric, length=LENGTH, width=1.0, cells=(16, 1), turns=1.0, levels=None, origin=None,
    across=False, **mesh,
):  # fmt: skip
    """Roll a strip up; `across` lays the weft along it.

    Returns
    -------
    dict: error (of the tip, over the length), iterations (most of a step), cutbacks
    """
    warp = (0.0, 1.0, 0.0) if across else (1.0, 0.0, 0.0)
    surface = meshes.rectangle(length, width, cells, warp=warp, **mesh)
    if origin is not None:
        surface = surface.transform(translation=origin)
    shell = Shell(surface, fabric)
    degrees = 90.0 if across else 0.0
    D, k = turn(fabric.bending, degrees)[0, 0], 2 * np.pi * turns / length
    shell.supports.clamp("left")
    for edge in ("bottom", "top"):
        shell.supports.symmetry(edge, (0, 1, 0))
    shell.loads.edge_moment("right", (0, -k * D, 0))
    with Statics(shell) as statics:
        statics.solve(levels or max(2, int(np.ceil(20 * turns))))
        iterations = max(step.iterations for step in statics.steps)
        cutbacks = statics.cutbacks
    moved = shell.displacements()[shell.partition.find("right")].mean(axis=0)
    error = np.linalg.norm(moved + (length, 0, 0) - coil(fabric, length, turns, degrees)) / length
    return {"error": float(error), "iterations": iterations, "cutbacks": cutbacks}


def leaning(cells, degrees, length=1.0, width=1.0):
    """Corner parameters (n1 + 1, n2 + 1, 2) of cells with corners of so many degrees inside.

    The mesh lines across lean alternately to one side and the other, one row of cells a lean; the
    ends stay upright.
    """
    rows, counts = uniform(cells), np.array(cells)
    lean = np.tan(np.radians(degrees - 90.0)) * width / counts[1] / length
    a = rows[..., 0]
    room = np.minimum(1.0, np.minimum(a, 1 - a) / (abs(lean) + 1e-300))
    rows[..., 0] = a + lean * np.where(np.arange(cells[1] + 1) % 2, 0.5, -0.5) * room
    return rows


def pulled(fabric, degrees=30.0, cells=(4, 4), length=1.0, width=1.0, strain=1e-3, **mesh):
    """Pull a sheet whose warp lies at an angle along x, free to contract and to shear.

    Returns
    -------
    dict: error (largest, of the displacements, over the largest of them), widest [degrees]
    """
    angle = np.radians(degrees)
    warp = (np.cos(angle), np.sin(angle), 0.0)
    surface = meshes.rectangle(length, width, cells, warp=warp, **mesh)
    shell, compliance = Shell(surface, fabric), np.linalg.inv(turn(fabric.membrane, degrees))[:, 0]
    E = compliance * strain / np.abs(compliance).max()
    S = E[0] / compliance[0]  # second Piola-Kirchhoff force [N/m]: that of the loads over stretch
    force, every = S * np.sqrt(1 + 2 * E[0]), np.arange(len(surface.points))
    corners = [
        np.flatnonzero(np.linalg.norm(surface.points - (x, 0, 0), axis=1) < 1e-9 * length)
        for x in (0.0, length)
    ]
    shell.supports.hold(every, "z")
    shell.supports.hold_director(every)
    shell.supports.hold(corners[0], "xy")
    shell.supports.hold(corners[1], "y")
    shell.loads.line("right", (force, 0, 0))
    shell.loads.line("left", (-force, 0, 0))
    with Statics(shell) as statics:
        statics.solve(1)
    F = np.eye(3)
    F[0, 0] = np.sqrt(1 + 2 * E[0])
    F[0, 1] = E[2] / F[0, 0]
    F[1, 1] = np.sqrt(1 + 2 * E[1] - F[0, 1] ** 2)
    exact = surface.points @ (F - np.eye(3)).T
    error = np.abs(shell.displacements() - exact).max() / np.abs(exact).max()
    widest = float(widest_corners(surface.points, surface.cells).max())
    return {"error": float(error), "widest": widest}


def turned_round(turns):
    """Strain energy left when every node of a sheet is carried round, over that of a 1 % stretch.

    Statics by prescribed motion: the free edge of a strip is led around its held one.
    """
    fabric = strip()
    surface = meshes.rectangle(1.0, 0.25, (4, 1))
    shell = Shell(surface, fabric)
    shell.supports.hold("left")

    def place(level):
        a = 2 * np.pi * turns * level
        return np.array([np.cos(a) - 1, 0.0, np.sin(a)])

    def director(level):
        a = 2 * np.pi * turns * level
        return np.array([-np.sin(a), 0.0, np.cos(a)])

    shell.supports.move("right", place, director)
    with Statics(shell) as statics:
        statics.solve(int(np.ceil(12 * turns)))
        cutbacks = statics.cutbacks
    stretch = 0.5 * fabric.membrane[0, 0] * 0.01**2 * surface.area
    return {"strain": sum(shell.energy().values()) / stretch, "cutbacks": cutbacks}


def at_rest():
    """Largest displacement [m] of a held sheet under no load, and Newton iterations."""
    shell = Shell(meshes.rectangle(1.0, 1.0, (4, 4)), strip())
    shell.supports.clamp("left")
    with Statics(shell) as statics:
        statics.solve(2)
        iterations = max(step.iterations for step in statics.steps)
    return float(np.abs(shell.displacements()).max()), iterations


def loose(joined):
    """Load a sheet that is free to move: as a whole, or a half hung on one point (a mechanism)."""
    if joined:
        points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 1, 0], [2, 2, 0], [1, 2, 0]]
        surface = meshes.Surface(np.array(points, float), np.array([[0, 1, 2, 3], [2, 4, 5, 6]]))
        shell = Shell(surface, strip())
        every = np.arange(len(points))
        shell.supports.hold(every, "z")
        shell.supports.hold_director(every)
        shell.supports.hold(np.array([0, 1, 3]), "xy")
        shell.loads.point(np.array([5]), (1.0, -1.0, 0.0))
    else:
        shell = Shell(meshes.rectangle(1.0, 1.0, (2, 2)), strip())
        shell.loads.gravity()
    with Statics(shell) as statics:
        statics.solve(2)
    return float(np.abs(shell.displacements()).max())
