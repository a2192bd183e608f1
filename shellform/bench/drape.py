# SPDX-License-Identifier: LGPL-3.0-or-later
"""A round specimen draped over a disc as by Cusick (J. Text. Inst. 59, T253, 1968; ISO 9073-9).

30 cm of cloth between discs of 18 cm: the ring outside them is computed, its inner edge held level.
As the table around the disc sinks it bears less and less of the cloth: the weight grows with time,
in still air that slows the cloth, until its shadow changes no more. Dropped at once it falls into
one or two folds more, as short waves grow fastest. With the areas of shadow, disc and specimen,
seen from above,

    drape coefficient = (shadow - disc)/(specimen - disc),

and folds are the maxima of the shadow's radius, of which harmonics up to 12 count. Real cloth falls
into other folds each time it is draped; here each `start` is another small random unevenness.
"""

from dataclasses import dataclass

import numpy as np

import meshes
from shellform.dynamics.explicit import Newmark
from shellform.fem.shell import Shell
from shellform.material.fabric import Fabric

from .hang import G

DISC, SPECIMEN = 0.09, 0.15  # radii [m]
UNEVEN = 1e-3  # m, at the rim
HARMONICS = 12
DRAG = 6.0  # 1/s
DAMPING = 1e-5  # s
LOWERING = 1.5  # s, of the table; by hand in 1 or 2
LOOK, WAIT = 0.1, 4.0  # s
STILL = 1e-3  # of the drape coefficient, over two looks
ANGLES = 720


@dataclass(frozen=True)
class Drape:
    """A draped specimen: coefficient (0 to 1), folds, rim radii and heights, and when it was still.

    shadow : (n,), radii [m] at equal angles from the warp; settled : False where it still moved at
    the end; points, cells : the cloth
    """

    coefficient: float
    folds: int
    shadow: np.ndarray
    seconds: float
    settled: bool
    points: np.ndarray
    cells: np.ndarray

    def results(self) -> dict:
        """For summary.json."""
        return {
            "drape_coefficient": self.coefficient, "folds": self.folds, "seconds": self.seconds,
            "settled": self.settled, "shadow": self.shadow,
        }  # fmt: skip


def cells_for(fabric: Fabric) -> tuple[int, int]:
    """Cells around and across: half a bending length across, but no fewer than 8 and 96."""
    size = 0.5 * min(fabric.bending_length(degrees=a) for a in (0, 90))
    across = int(np.clip(np.ceil((SPECIMEN - DISC) / size), 8, 16))
    return 12 * across, across


def drape(
    fabric: Fabric,
    start: int = 0,
    cells: tuple[int, int] | None = None,
    lowering: float = LOWERING,
    wait: float = WAIT,
) -> Drape:
    """Drape a specimen.

    Parameters
    ----------
    start : seed of its unevenness; cells : around and across, see `cells_for`
    lowering : time [s] in which the table sinks; 0: the cloth is dropped
    wait : time [s] after it at which the cloth is looked at whether it is still or not
    """
    cells = cells_for(fabric) if cells is None else cells
    surface = meshes.annulus(DISC, SPECIMEN, cells, slit=False, warp=(1.0, 0.0, 0.0))
    shell = Shell(surface, fabric)
    shell.supports.clamp("inner")
    shell.loads.gravity((0.0, 0.0, -G), (lambda t: min(1.0, t / lowering)) if lowering else None)
    stepper = Newmark(shell, damping=DAMPING, drag=DRAG)
    owned = shell.partition.owned_nodes
    stepper.owned[:, 2] += uneven(surface.points, start)[owned]
    stepper.scatter()
    flat, seen = shadow(surface.points, surface.cells), []
    while True:
        stepper.advance(stepper.time + LOOK)
        points = shell.positions()
        radii = shadow(points, surface.cells)
        seen.append(coefficient_of(radii, flat))
        free = stepper.time - lowering
        settled = free > 5.5 * LOOK and max(seen[-3:]) - min(seen[-3:]) < STILL
        if settled or free > wait - 0.5 * LOOK:
            break
    return Drape(
        seen[-1], folds_of(radii), radii, round(stepper.time, 3), settled, points, surface.cells
    )


def uneven(points: np.ndarray, start: int) -> np.ndarray:
    """Heights (n,) [m] of the specimen before it falls, from random waves around it."""
    random = np.random.default_rng(start)
    angle = np.arctan2(points[:, 1], points[:, 0])
    part = (np.hypot(points[:, 0], points[:, 1]) - DISC) / (SPECIMEN - DISC)
    waves = np.zeros(len(points))
    for k in range(2, HARMONICS + 1):
        a, b = random.normal(size=2) / np.sqrt(HARMONICS)
        waves += a * np.cos(k * angle) + b * np.sin(k * angle)
    return UNEVEN * part**2 * waves


def shadow(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Radii (ANGLES,) of the outline seen from above, of cloth and disc, at equal angles."""
    ends = np.stack([cells, np.roll(cells, -1, axis=1)], axis=-1).reshape(-1, 2)
    ends = np.unique(np.sort(ends, axis=1), axis=0)
    a, b = points[ends[:, 0], :2], points[ends[:, 1], :2]
    radii = np.full(ANGLES, DISC)
    longest = np.linalg.norm(b - a, axis=1).max()
    # two points an angle at least: no gaps
    along = np.linspace(0, 1, int(longest / DISC * ANGLES / np.pi) + 2)[:, None, None]
    at = (a + along * (b - a)).reshape(-1, 2)
    bins = np.floor(np.arctan2(at[:, 1], at[:, 0]) / (2 * np.pi) * ANGLES).astype(int) % ANGLES
    np.maximum.at(radii, bins, np.hypot(at[:, 0], at[:, 1]))
    return radii


def coefficient_of(radii: np.ndarray, flat: np.ndarray) -> float:
    """Drape coefficient of an outline (n,) [m] at equal angles; `flat`: that before it fell."""
    shadow, disc, specimen = np.mean(radii**2), DISC**2, np.mean(flat**2)
    return float((shadow - disc) / (specimen - disc))


def folds_of(radii: np.ndarray) -> int:
    """Maxima of an outline (n,), harmonics up to 12."""
    waves = np.fft.rfft(radii)
    waves[HARMONICS + 1 :] = 0
    smooth = np.fft.irfft(waves, len(radii))
    above = smooth > np.roll(smooth, 1)
    return int(np.sum(above & (smooth >= np.roll(smooth, -1))))
