# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Cusick's drape test: a disc of cloth held between two smaller discs, its border hangs.

A specimen of 30 cm lies on a disc of 18 cm and is held down by another. What hangs, a ring clamped
at its inner edge, falls in folds; its shadow from above has the area A. The drape coefficient

    DC = (A - pi r^2)/(pi R^2 - pi r^2),   r = 9 cm, R = 15 cm,

is 1 where nothing bends. Folds are the maxima of the outline, of which harmonics up to 12 are kept.
Explicit steps (Eq. 13) with drag lead to rest; a small push at the start, the same smooth field on
every mesh, chooses among the states that cloth can hang in.

Source. Cusick, J. Text. Inst. 59 (1968); ISO 9073-9.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from mpi4py import MPI

import numpy as np
from scipy.interpolate import CubicSpline

import meshes
from shellform import Newmark, Shell, console
from shellform.bench.drape import DISC, HARMONICS, SPECIMEN, coefficient_of, drape
from shellform.bench.hang import G
from shellform.material.sheet import Sheet

ANGLES = 360
CELLS = (48, 5)  # around, across: folds of a ninth of the rim have 5 cells each
QUICK = (24, 3)
LEAST = 0.5e-3  # m, by which a fold stands out of the outline
PUSH = 0.02  # m/s, root mean square of the start
# men's winter suiting, means of Kawabata's KN-101 norms, quoted from memory: estimated
SUITING = {
    "tensile_warp_N_per_m": 8100.0, "tensile_weft_N_per_m": 8100.0,
    "G_N_per_m_per_radian": 54.4, "B_warp_uN_m": 13.3, "B_weft_uN_m": 13.3,
    "weight_g_per_m2": 263.5, "thickness_mm": 0.746,
}  # fmt: skip


@dataclass(frozen=True)
class Hanging:
    """How a specimen hangs.

    Attributes
    ----------
    coefficient : drape coefficient; folds : int
    radii : (ANGLES,) [m], of the outline of the shadow at even angles from the warp
    heights : (n,) [m], of the rim at its nodes, in the order of their angles at rest
    motion : kinetic over strain energy at the end; steps : int; dt : float [s], their mean
    """

    coefficient: float
    folds: int
    radii: np.ndarray
    heights: np.ndarray
    motion: float
    steps: int
    dt: float


def orthotropy(radii: np.ndarray) -> float:
    """Part of an outline (n,) at equal angles that goes with cos(2 angle), over the ring's width.

    Positive where the shadow is longer along the warp than along the weft.
    """
    angle = (np.arange(len(radii)) + 0.5) * 2 * np.pi / len(radii)
    return float(2 * np.mean(radii * np.cos(2 * angle)) / (SPECIMEN - DISC))


def ring(cells: tuple[int, int] = CELLS, degree: int = 1) -> meshes.Surface:
    """What hangs, flat, warp along x."""
    surface = meshes.annulus(DISC, SPECIMEN, cells, slit=False, degree=degree)
    return surface.replace(warp=(1.0, 0.0, 0.0))


def ring_shell(fabric: Sheet, cells: tuple[int, int] = CELLS) -> Shell:
    """The ring of a fabric, clamped at the disc, under its weight; on one rank."""
    shell = Shell(ring(cells), fabric, MPI.COMM_SELF)
    shell.supports.clamp("inner")
    shell.loads.gravity((0.0, 0.0, -G))
    return shell


def push(points: np.ndarray, start: int) -> np.ndarray:
    """Velocities up (n,) [m/s] of a start: random waves around the ring, growing outward."""
    random = np.random.default_rng(start)
    angle, order = np.arctan2(points[:, 1], points[:, 0]), np.arange(2, HARMONICS + 1)
    waves = np.cos(angle[:, None] * order + random.uniform(0, 2 * np.pi, len(order)))
    size = random.standard_normal(len(order))
    outward = (np.hypot(points[:, 0], points[:, 1]) - DISC) / (SPECIMEN - DISC)
    return PUSH * outward * (waves @ size) / np.sqrt(0.5 * size @ size)


def hang(
    fabric: Sheet,
    start: int = 1,
    cells: tuple[int, int] = CELLS,
    seconds: float = 1.5,
    drag: float = 5.0,
    damping: float = 2e-5,
) -> Hanging:
    """Let a specimen hang; `start` numbers the push, `drag` [1/s] and `damping` [s] see Newmark."""
    shell = ring_shell(fabric, cells)
    stepper = Newmark(shell, damping=damping, drag=drag)
    stepper.v[:, 2] = push(stepper.points, start)
    stepper.advance(seconds)
    balance = stepper.balance()
    return read(
        shell,
        motion=balance["kinetic"] / balance["strain"],
        steps=stepper.steps,
        dt=seconds / stepper.steps,
    )


def read(shell: Shell, motion: float = 0.0, steps: int = 0, dt: float = 0.0) -> Hanging:
    """Drape of a ring as it hangs now."""
    rim = np.unique(shell.surface.edges["outer"])
    at_rest = shell.surface.points[rim]
    rim = rim[np.argsort(np.arctan2(at_rest[:, 1], at_rest[:, 0]))]
    x = shell.positions()[rim]
    radii = outline(x)
    return Hanging(coefficient(radii), folds(radii), radii, x[:, 2], motion, steps, dt)


def outline(rim: np.ndarray) -> np.ndarray:
    """Radii (ANGLES,) [m] of the shadow of a closed line of points (n, 3), its farthest parts.

    Cubics join the points: chords would take 1.8 % off the coefficient of a circle of 24 cells.
    """
    closed = CubicSpline(
        np.arange(len(rim) + 1), np.vstack([rim, rim[:1]])[:, :2], bc_type="periodic"
    )
    line = closed(np.arange(40 * len(rim)) / 40)
    bins = np.round(np.arctan2(line[:, 1], line[:, 0]) * ANGLES / (2 * np.pi)).astype(int) % ANGLES
    radii = np.zeros(ANGLES)
    np.maximum.at(radii, bins, np.hypot(*line.T))
    met = np.flatnonzero(radii)
    return np.interp(np.arange(ANGLES), met, radii[met], period=ANGLES)


def coefficient(radii: np.ndarray) -> float:
    """Drape coefficient of an outline."""
    return coefficient_of(radii, np.array([SPECIMEN]))


def folds(radii: np.ndarray) -> int:
    """Maxima of an outline smoothed to its first harmonics that stand out by LEAST."""
    # only here: scipy.signal takes a second to load
    from scipy.signal import find_peaks

    waves = np.fft.rfft(radii)
    waves[HARMONICS + 1 :] = 0.0
    smooth = np.fft.irfft(waves, len(radii))
    smooth = np.roll(smooth, -int(smooth.argmin()))
    return len(find_peaks(np.append(smooth, smooth[0]), prominence=LEAST)[0])


def drapes(fabric: Sheet, asked: argparse.Namespace) -> dict[str, float]:
    """Mean and scatter over the starts that a command line asks for; DC in percent.

    The cloth is let down slowly, as by the bench: dropped, it hangs in another state each time.
    """
    found = [drape(fabric, start, asked.cells) for start in range(asked.starts)]
    of = 100 * np.array([one.coefficient for one in found])
    way = 100 * np.array([orthotropy(one.shadow) for one in found])
    return {
        "DC %": float(of.mean()),
        "SD": float(of.std(ddof=1)) if len(of) > 1 else 0.0,
        "folds": float(np.mean([one.folds for one in found])),
        "orthotropy %": float(way.mean()),
        "its SD": float(way.std(ddof=1)) if len(way) > 1 else 0.0,
    }


def options(given: Sequence[str] | None, description: str) -> argparse.Namespace:
    """Command line of a study: `out`, `starts` of each drape, `quick` for coarse cells."""
    parser = argparse.ArgumentParser(allow_abbrev=False, description=description)
    parser.add_argument("--out", default="out/reviewed", help="folder for results")
    parser.add_argument("--starts", type=console.positive(int), default=3, help="of each drape")
    parser.add_argument(
        "--cells", type=console.positive(int), nargs=2, default=CELLS, help="around, across"
    )
    parser.add_argument("--quick", action="store_true", help="coarse cells, one start")
    found = console.parse(parser, given)
    if found.quick:
        found.starts, found.cells = 1, QUICK
    found.cells = tuple(found.cells)
    Path(found.out).mkdir(parents=True, exist_ok=True)
    return found
