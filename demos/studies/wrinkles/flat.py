# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sheets that wrinkle but stay in their plane, against exact.py: bent, sheared, turned.

Nodes do not leave the plane and directors do not turn, so what is tested is the membrane alone; the
wrinkles are those that its law stands for. Each case gives rows of numbers for a table.
"""

import numpy as np

import meshes
from demos.studies.wrinkles import exact
from shellform import Fabric, Shell, Statics
from shellform.fem.dolfinx_compat import cell_nodes

STIFFNESS, NU = 1000.0, 0.3  # N/m, E t


def sheet(nu: float = NU) -> Fabric:
    """An isotropic sheet; what it weighs and how it bends does not matter here."""
    A = STIFFNESS / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, 0.5 * (1 - nu)]])
    return Fabric.from_stiffness(A, 1e-8 * A, 0.2, 1e-3)


def in_plane(surface: meshes.Surface, fabric: Fabric, load: float, wrinkles: str) -> Shell:
    """Shell whose nodes stay in the plane; wrinkles bear `load` [N/m]."""
    shell = Shell(surface, fabric, wrinkles=wrinkles)
    everywhere = np.arange(len(surface.points))
    shell.supports.hold(everywhere, "z")
    shell.supports.hold_director(everywhere)
    if shell.wrinkles is not None:
        shell.wrinkles.load[:] = load
    return shell


def cells_of(shell: Shell) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Middles (m, 2) [m], strains (m, 3) and stresses (m, 3) [N/m] of the cells of one rank."""
    membrane, partition = shell.cell_membrane, shell.partition
    E = membrane.strain(shell.w.x.array)
    _, N, _ = membrane.law(E)
    corners = shell.surface.points[partition.nodes][cell_nodes(partition.space)]
    return corners.mean(axis=1)[:, :2], E, N


def solve(shell: Shell, levels: int = 1) -> tuple[np.ndarray, int]:
    """Reactions (n, 3) [N] at the full load, and Newton iterations."""
    with Statics(shell) as statics:
        steps = statics.solve(levels)
        return statics.reactions(), sum(step.iterations for step in steps)


def bent_strip(
    cells: int, depth: float, load: float = 0.0, wrinkles: str = "relaxed", distortion: float = 0.0
) -> dict:
    """A square strip whose ends are turned and drawn so that it wrinkles over a depth b/H.

    Its ends are led as those of the exact solution; P, M are those of the reactions, what they
    should bend is compared with how it is bent. `cells` a side; `load` N_c over K kappa H.
    """
    height, kappa = 1.0, 1e-4
    load = load * STIFFNESS * kappa * height
    grid = meshes.distorted((cells, cells), distortion, seed=1)
    surface = meshes.rectangle(height, height, (cells, cells), parameters=grid)
    shell = in_plane(surface, sheet(), load, wrinkles)
    b = depth * height

    def led(points):
        x, y = points[:, 0] - 0.5 * height, points[:, 1]
        low = load / STIFFNESS
        along = kappa * (y - b) - low  # as deep in the wrinkles as on a line
        taut = 0.5 * kappa * np.maximum(y - b, 0.0) ** 2
        across = -NU * (taut - low * y)
        across -= 0.5 * kappa * (x**2 - 0.25 * height**2)
        return np.stack([x * along, across, 0.0 * x], axis=1)

    ends = {}
    for edge in ("left", "right"):
        ends[edge] = np.unique(surface.edges[edge])
        shell.supports.move(ends[edge], displacement=led(surface.points[ends[edge]]))
    reactions, iterations = solve(shell)
    pulls = reactions[ends["right"], 0]
    y = surface.points[ends["right"], 1]
    force, moment = pulls.sum(), pulls @ (y - 0.5 * height)
    middle, _, N = cells_of(shell)
    column = np.abs(middle[:, 0] - 0.5 * height) < 0.25 * height
    taut = column & (N[:, 0] + load > 0.2 * (N[:, 0] + load).max())
    slope, start = np.polyfit(middle[taut, 1], N[taut, 0] + load, 1)
    whole = force + load * height
    part = 1.0 - np.sqrt(2.0 * whole / (kappa * STIFFNESS * height**2))
    exact_moment = whole * height * (1.0 / 6.0 + part / 3.0)
    should = exact.bent_strip_curvature(force, moment, STIFFNESS, height, load)
    return {
        "cells": cells,
        "N_c": load / (STIFFNESS * kappa * height),
        "M/QH": moment / ((force + load * height) * height),
        "curvature": kappa * STIFFNESS * height**2 / (2 * (force + load * height)),
        "exact": should * STIFFNESS * height**2 / (2 * (force + load * height)),
        "off": kappa / should - 1,
        "moment off": moment / exact_moment - 1,
        "depth": -start / slope / height,
        "exact depth": exact.bent_strip_depth(force, moment, height, load),
        "iterations": iterations,
    }


def sheared_strip(
    cells: int,
    gamma: float = 2e-3,
    eps: float = 2e-4,
    load: float = 0.0,
    wrinkles: str = "relaxed",
    distortion: float = 0.2,
) -> dict:
    """A strip four times as long as high, its ends free, sheared and drawn; read in its middle.

    `load` is N_c over K gamma.
    """
    height, length = 1.0, 4.0
    load = load * STIFFNESS * gamma
    grid = meshes.distorted((4 * cells, cells), distortion, seed=1)
    surface = meshes.rectangle(length, height, (4 * cells, cells), parameters=grid)
    shell = in_plane(surface, sheet(), load, wrinkles)
    shell.supports.hold("bottom")
    top = np.unique(surface.edges["top"])
    shell.supports.move(top, displacement=(gamma * height, eps * height, 0.0))
    reactions, iterations = solve(shell)
    x = surface.points[top, 0]
    # the edge between 1.4 and 2.6 of 4 heights
    inside = np.abs(x - 0.5 * length) < 0.6
    share = np.gradient(np.sort(x))[np.argsort(np.argsort(x))]
    shear, normal = reactions[top][inside][:, :2].sum(axis=0) / share[inside].sum()
    exact_shear, exact_normal, angle = exact.sheared_strip(eps, gamma, STIFFNESS, NU, load)
    return {
        "cells": cells,
        "N_c": load / (STIFFNESS * gamma),
        "shear": shear,
        "exact shear": exact_shear,
        "off": shear / exact_shear - 1,
        "normal": normal,
        "exact normal": exact_normal,
        "angle": np.degrees(angle),
        "whole": reactions[top, 0].sum() / length / exact_shear,
        "iterations": iterations,
    }


def hub(
    cells: int,
    load: float = 0.0,
    stretch: float = 0.0,
    ratio: float = 3.0,
    wrinkles: str = "relaxed",
) -> dict:
    """A disc held at its rim, its hub turned; `cells` across the ring.

    `load` is N_c over K times the turn, `stretch` moves the rim outwards, over the hub's radius
    times the turn.
    """
    inner, turn = 1.0, 1e-3
    outer = ratio * inner
    load, stretch = load * STIFFNESS * turn, stretch * inner * turn
    around = int(np.ceil(2 * np.pi * cells / np.log(ratio)))
    radii = (ratio ** np.linspace(0, 1, cells + 1)[::-1] - 1) / (ratio - 1)
    a, b = np.meshgrid(np.linspace(0, 1, around + 1), 1 - radii, indexing="ij")
    grid = np.stack([a, b], axis=-1)
    surface = meshes.annulus(inner, outer, (around, cells), slit=False, parameters=grid)
    shell = in_plane(surface, sheet(), load, wrinkles)
    rim, core = (np.unique(surface.edges[name]) for name in ("outer", "inner"))
    X = surface.points
    shell.supports.move(rim, displacement=stretch * X[rim] / outer)
    turned = turn * np.stack([-X[core, 1], X[core, 0], 0 * X[core, 0]], axis=1)
    shell.supports.move(core, displacement=turned)
    reactions, iterations = solve(shell)
    f = reactions[core]
    torque = float(np.sum(X[core, 0] * f[:, 1] - X[core, 1] * f[:, 0]))
    should, edge = exact.hub(turn, inner, outer, STIFFNESS, NU, load, stretch)
    return {
        "cells": cells,
        "N_c": load / (STIFFNESS * turn),
        "stretch": stretch / (inner * turn),
        "torque": torque,
        "exact torque": should,
        "off": torque / should - 1,
        "radius": wrinkled_radius(shell, load),
        "exact radius": edge,
        "iterations": iterations,
    }


def wrinkled_radius(shell: Shell, load: float) -> float:
    """Radius [m] where the smaller stress that a taut disc would have, N_c added, changes sign."""
    middle, E, _ = cells_of(shell)
    n = E @ shell.fabric.membrane + load * np.array([1.0, 1.0, 0.0])
    least = 0.5 * (n[:, 0] + n[:, 1]) - np.hypot(0.5 * (n[:, 0] - n[:, 1]), n[:, 2])
    radius, ring = np.unique(np.round(np.hypot(*middle.T), 6), return_inverse=True)
    least = np.bincount(ring, least) / np.bincount(ring)
    k = int(np.flatnonzero(least < 0).max(initial=-1))
    if k < 0 or k + 1 == len(radius):
        return float(radius[0] if k < 0 else radius[-1])
    part = least[k] / (least[k] - least[k + 1])
    return float(radius[k] + part * (radius[k + 1] - radius[k]))
