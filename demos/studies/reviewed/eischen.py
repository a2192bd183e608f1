# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Eischen, Deng and Clapp: moment against curvature as measured, arc length, contact by penalty.

Bending. A strip in pure bending must give back the curve M(kappa) it was given, between its points
too, where the curve is a monotone cubic.

Arc length. The thin hinged roof snaps through and back under a force at its middle; the path by
`shellform.follow` is compared with published points, distances in parts of the limit load and of
the largest deflection.

Contact. A strip let down onto a table, by penalties of several stiffnesses, and by contact that
lets no node in, against the exact curve (penalty_contact.py).

Source. IEEE Comput. Graph. Appl. 16(5), 1996, 71-80; their curves are plots, the one here is made
up, softening as cloth does. Roof: Sze, Liu and Lo, Finite Elem. Anal. Des. 40, 2004, Sec. 3.8.

    python -m demos.studies.reviewed.eischen --out out/reviewed
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

from mpi4py import MPI

import numpy as np

import meshes
from demos.studies.drape.figures import print_table, write_table
from demos.studies.reviewed import penalty_contact
from demos.studies.reviewed.cusick_drape import SUITING
from shellform import Fabric, Shell, Statics, console, follow
from shellform.material.measurements import measured_fabric
from shellform.material.sheet import Sheet

# curvature [1/m] and moment [N]: slope 1.8e-5 N m at rest, 0.8e-5 at the end
KAPPA = (0.0, 25.0, 50.0, 100.0, 175.0, 250.0)
MOMENT = (0.0, 4.4e-4, 8.3e-4, 15.2e-4, 23.5e-4, 30.4e-4)
STRIP = 0.012, 0.005  # m, turns by less than half a turn
# load over 3000 N, deflection [mm] of the middle
ROOF = (
    (0.0517, 1.846), (0.1182, 5.271), (0.1583, 8.257), (0.1837, 10.799), (0.1953, 12.892),
    (0.1901, 14.472), (0.1671, 15.501), (0.1323, 16.145), (0.0923, 16.602), (0.0504, 16.915),
    (0.0083, 17.008), (-0.0312, 16.697), (-0.0739, 15.206), (-0.1001, 14.520), (-0.1142, 14.451),
    (-0.1247, 14.862), (-0.1288, 15.778), (-0.1271, 16.961), (-0.1055, 19.817), (-0.0484, 23.100),
    (0.0626, 26.565), (0.2403, 30.023), (0.4898, 33.388), (1.0313, 38.450),
)  # fmt: skip
HEIGHT = 0.03  # m, of the clamp above the table


def cloth() -> Sheet:
    """The suiting, its bending by the curve."""
    card = {key: value for key, value in SUITING.items() if not key.startswith("B_")}
    for yarn in ("warp", "weft"):
        card |= {f"curvature_{yarn}_per_m": list(KAPPA), f"moment_{yarn}_N": list(MOMENT)}
    return measured_fabric(card, name="suiting that softens")


def bent(fabric: Sheet, moments: Sequence[float], cells: int = 16) -> np.ndarray:
    """Curvatures [1/m] of a strip under moments [N] at its end."""
    length, width = STRIP
    surface = meshes.rectangle(length, width, (cells, 2)).replace(warp=(1.0, 0.0, 0.0))
    shell, everywhere = Shell(surface, fabric, MPI.COMM_SELF), np.arange(len(surface.points))
    shell.supports.clamp("left")
    shell.supports.hold(everywhere, "y")
    shell.supports.hold_director(everywhere, plane=(0.0, 1.0, 0.0))
    most = max(moments)
    shell.loads.edge_moment("right", (0.0, -most, 0.0))
    tip, curvatures = shell.partition.find("right"), []
    with Statics(shell) as statics:
        for _ in statics.march(np.array(moments) / most):
            d = shell.directors()[tip]
            curvatures.append(abs(np.mean(np.arctan2(d[:, 0], d[:, 2]))) / length)
    return np.array(curvatures)


def bending_rows(cells: int = 16) -> list[dict]:
    """The curve that comes out of the strip beside the one that went in."""
    fabric = cloth()
    curve = fabric.law.bend_warp
    kappa = np.array([12.0, *KAPPA[1:3], 75.0, KAPPA[3], 140.0, KAPPA[4], 220.0])
    moments = curve(kappa)
    rows = []
    for k, M, found in zip(kappa, moments, bent(fabric, moments, cells), strict=True):
        straight = float(M) / curve.at_rest
        rows.append({
            "M [mN]": 1e3 * M, "kappa in [1/m]": k, "kappa out [1/m]": found,
            "off %": 100 * (found / k - 1), "with a constant B, off %": 100 * (straight / k - 1),
        })  # fmt: skip
    return rows


def roof_row(cells: int) -> dict:
    """The path of the thin isotropic roof, a quarter of it, against the published points."""
    radius, half_length, half_angle = 2540.0, 254.0, 0.1  # mm

    def place(a, b):
        angle = half_angle * a
        return radius * np.sin(angle), half_length * b, radius * (np.cos(angle) - 1)

    def normal(a, b):
        return np.array([np.sin(half_angle * a), 0 * a, np.cos(half_angle * a)])

    names = ("crown", "hinge", "middle", "free")
    surface = meshes.patch(place, (cells, cells), normal=normal, names=names)
    shell = Shell(surface, Fabric.isotropic(3102.75, 0.3, 6.35, 1.0), MPI.COMM_SELF)
    shell.supports.symmetry("crown", (1.0, 0.0, 0.0))
    shell.supports.symmetry("middle", (0.0, 1.0, 0.0))
    shell.supports.hold("hinge")
    middle = (0.0, 0.0, 0.0)
    shell.loads.point(middle, (0.0, 0.0, -750.0))
    path = follow(shell, ROOF[-1][0], watch={"middle": middle}, iterations=6, first=0.1)
    level, u = path.curve("middle", 4000)
    limits = path.limit_levels()
    points = np.array(ROOF)
    scale = np.array([limits[0], points[:, 1].max()])
    off = [
        np.linalg.norm((np.column_stack([level, -u[:, 2]]) - point) / scale, axis=1).min()
        for point in points
    ]
    return {
        "cells": f"{cells} x {cells}", "steps": len(path.levels), "solves": path.iterations.sum(),
        "limit": 3000 * limits[0], "lowest": 3000 * limits[1], "off %": 100 * max(off),
    }  # fmt: skip


def contact_rows(quick: bool) -> list[dict]:
    """Penalties and contact without one, beside the exact curve."""
    fabric = measured_fabric(SUITING)
    B, q = fabric.bending[0, 0], fabric.areal_mass * penalty_contact.G
    exact = penalty_contact.exact(B, q, HEIGHT)
    place = 1e3 * exact["x"]
    rows = [{"contact": "exact", "clamp [N/m]": exact["clamp"], "touches at [mm]": place}]
    cases = [(f"penalty {k:.0e} Pa/m", k) for k in ((1e4,) if quick else (1e3, 1e4, 1e5, 1e6))]
    for name, k in cases:
        rows.append(_laid(name, penalty_contact.by_penalty(fabric, HEIGHT, k), exact))
    for k, turns in ((1e3, 5),) if quick else ((1e3, 3), (1e3, 10), (1e4, 3), (1e4, 10)):
        laid = penalty_contact.by_penalty(fabric, HEIGHT, k, augmented=turns)
        rows.append(_laid(f"augmented {k:.0e} Pa/m, {turns} turns", laid, exact))
    if not quick:
        rows.append(_laid("no node inside", penalty_contact.kept_out(fabric, HEIGHT), exact))
    return rows


def _laid(name, laid, exact):
    return {
        "contact": name, "clamp [N/m]": laid.clamp,
        "off %": 100 * (laid.clamp / exact["clamp"] - 1),
        "touches at [mm]": 1e3 * laid.touch, "depth [mm]": 1e3 * laid.depth,
        "solves or steps": laid.solves,
    }  # fmt: skip


def main(given: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(
        allow_abbrev=False, description="Measured bending, arc length, contact by penalty."
    )
    parser.add_argument("--out", default="out/reviewed", help="folder for results")
    parser.add_argument("--quick", action="store_true", help="coarse cells, one penalty")
    asked = console.parse(parser, given)
    Path(asked.out).mkdir(parents=True, exist_ok=True)

    tables = (
        ("bending", "A strip in pure bending", bending_rows),
        ("roof", "Thin hinged roof by arc length", lambda: [roof_row(8 if asked.quick else 16)]),
        ("contact", "A strip laid on a table", lambda: contact_rows(asked.quick)),
    )
    for name, title, make in tables:
        rows = make()
        print_table(title, rows, list(dict.fromkeys(key for row in rows for key in row)))
        write_table(f"{asked.out}/eischen_{name}.csv", rows)


if __name__ == "__main__":
    console.run(main)
