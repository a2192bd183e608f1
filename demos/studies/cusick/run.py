# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cusick's drape of five measured fabrics: folds and scatter, with and without friction inside.

Five fabrics of the figures in "Bayesian Differentiable Physics for Cloth Digitalization" (Gong and
others; realcrane's repository on GitHub, no licence: figures only): mass, drape coefficient with
the scatter of one specimen draped again, and folds. Neither bending nor shear of them is known. So

    B is fitted to the drape coefficient, alike in warp and weft,
    G = 54 N/m and, with friction, 2HG, 2HG5 and 2HB/B are those of men's suiting: estimates,

and what is compared is what was not fitted: the folds, and the scatter from start to start.

    python -m demos.studies.cusick.run --starts 5 --out out/cusick
    python -m demos.studies.cusick.run --lowering 0 --out out/cusick_dropped
    python -m demos.studies.cusick.run --fabrics cotton_blue --cells 48 --starts 2

prints a table and leaves summary.json in the folder.
"""

import argparse
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from shellform import Fabric, console
from shellform.bench.drape import LOWERING, drape
from shellform.material.measurements import measured_fabric
from shellform.results.report import Report

TRIES, CLOSE = 8, 0.5  # of the fit; points of the coefficient


class Real(NamedTuple):
    """A fabric as measured: kg/m2, coefficient [%], SD of one specimen draped again, folds."""

    mass: float
    coefficient: float
    redrape: float
    folds: float


REAL = {
    "viscose_white": Real(0.213, 16.2, 1.1, 10.5),
    "cotton_white": Real(0.059, 47.5, 3.2, 8.5),
    "cotton_pink": Real(0.114, 62.3, 4.6, 8.0),
    "cotton_blue": Real(0.192, 70.1, 6.4, 7.6),
    "wool_red": Real(0.274, 77.8, 1.9, 7.7),
}


def cloth(mass: float, B: float, friction: bool) -> Fabric:
    """Cloth of a mass [kg/m2] and a bending stiffness [N m], the rest estimated."""
    table = {
        "tensile_warp_N_per_m": 1000.0, "tensile_weft_N_per_m": 1000.0,
        "G_N_per_m_per_radian": 54.4, "B_warp_N_m": B, "B_weft_N_m": B,
        "weight_kg_per_m2": mass, "thickness_mm": 0.4,
    }  # fmt: skip
    if friction:
        loops = {"2HG_N_per_m": 1.18, "2HG5_N_per_m": 2.52}
        table |= loops | {f"2HB_{yarn}_N": 45.8 * B for yarn in ("warp", "weft")}
    return measured_fabric(table)


def fit(coefficient: Callable[[float], float], wanted: float, first: float) -> tuple[float, float]:
    """B [N m] whose coefficient [%] is nearest to the one wanted, and that coefficient.

    Secants in log B; the answer of one start is rough, so the nearest of all is taken.
    """
    seen: list[tuple[float, float]] = []
    log_b, slope = np.log(first), 20.0
    for _ in range(TRIES):
        found = coefficient(float(np.exp(log_b)))
        seen.append((log_b, found))
        if abs(found - wanted) < CLOSE:
            break
        if len(seen) > 1:
            (x0, y0), (x1, y1) = seen[-2:]
            slope = np.clip((y1 - y0) / (x1 - x0), 5.0, 60.0)
        log_b += float(np.clip((wanted - found) / slope, -1.5, 1.5))
    log_b, found = min(seen, key=lambda pair: abs(pair[1] - wanted))
    return float(np.exp(log_b)), found


def study(name: str, friction: bool, starts: int, around: int, lowering: float) -> dict:
    """Fit a fabric by its first start, then drape it from several."""
    real, cells = REAL[name], (around, around // 12)

    def fallen(B, start=0):
        return drape(cloth(real.mass, B, friction), start, cells, lowering)

    # that of the bending length which drapes to half at this size
    first = real.mass * 9.81 * 0.018**3 * np.exp((real.coefficient - 50) / 20)
    B, _ = fit(lambda B: 100 * fallen(B).coefficient, real.coefficient, first)
    drapes = [fallen(B, start) for start in range(starts)]
    percent = [100 * one.coefficient for one in drapes]
    folds = [one.folds for one in drapes]
    return {
        "fabric": name, "friction": friction, "lowering": lowering, "B": B,
        "measured": real._asdict(),
        "coefficients": percent, "folds": folds,
        "coefficient": float(np.mean(percent)), "mean_folds": float(np.mean(folds)),
        "scatter": float(np.std(percent, ddof=1)) if starts > 1 else None,
        "settled": all(one.settled for one in drapes),
    }  # fmt: skip


def line(row: dict) -> str:
    """Row of the table."""
    real = row["measured"]
    scatter = "   -" if row["scatter"] is None else f"{row['scatter']:4.1f}"
    return (
        f"{row['fabric']:<14} {'yes' if row['friction'] else 'no':<8} {1e6 * row['B']:7.2f} "
        f"{real['coefficient']:6.1f} +- {real['redrape']:3.1f} {row['coefficient']:6.1f} "
        f"{scatter} {real['folds']:9.1f} {row['mean_folds']:6.1f}"
    )


def arguments(given=None):
    parser = argparse.ArgumentParser(allow_abbrev=False, description="Cusick's drape, five fabrics")
    parser.add_argument("--fabrics", nargs="+", choices=REAL, default=list(REAL))
    parser.add_argument("--cells", type=console.positive(int), default=96, help="around the ring")
    parser.add_argument("--starts", type=console.positive(int), default=5)
    parser.add_argument(
        "--lowering", type=float, default=LOWERING, help="s, of the table; 0: the cloth is dropped"
    )
    parser.add_argument("--out", default="out/cusick")
    options = console.parse(parser, given)
    if options.cells < 24:
        parser.error("--cells: 24 at least, or folds have no cells")
    if not 0 <= options.lowering < np.inf:
        parser.error(f"--lowering: a time in s, 0 or more, not {options.lowering}")
    return options


def main(given=None):
    options = arguments(given)
    report = Report(options.out, "cusick", vars(options), console.COMM)
    console.say(["fabric         friction  B uN m   measured %  sheet %  SD  folds: real  sheet"])
    rows = []
    for name in options.fabrics:
        for friction in (False, True):
            with report.stage("solve"):
                rows.append(study(name, friction, options.starts, options.cells, options.lowering))
            console.say([line(rows[-1])])
            # what has been computed stays when the rest is not
            report.write({"rows": rows, "estimated": ["tension", "shear", "friction"]})


if __name__ == "__main__":
    console.run(main)
