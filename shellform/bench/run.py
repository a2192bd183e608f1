# SPDX-License-Identifier: LGPL-3.0-or-later
"""The bench: a fabric through the tests of a textile laboratory, and what they give.

    pull, shear, bend    KES, to and fro; the card's own curves beside what the sheet gives back
    hang                 ASTM D1388: bending length;   loop: Peirce's heart, against the elastica
    drape                Cusick: drape coefficient and folds

Each is computed on a mesh of its own, by the same shell that garments have. Only those asked for
are imported and computed.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from mpi4py import MPI

import numpy as np

from shellform.material.card import fabric_of
from shellform.material.fabric import Fabric
from shellform.results.report import Report

from . import inputs

TESTS = ("pull", "shear", "bend", "hang", "loop", "drape")
YARNS = ("warp", "weft")
UNITS = {"drape_coefficient": "%", "bending_length": "m"}


def fabric_tests(
    fabric: Fabric | str | Path,
    only: Sequence[str] = TESTS,
    *,
    starts: int = 1,
    bands: bool = True,
    out: str | Path | None = None,
) -> dict[str, Any]:
    """Results of a fabric's tests; with `out` also summary.json there.

    Parameters
    ----------
    fabric : Fabric, the name of a shipped card, or the path of one
    only : of TESTS; starts : drapes, whose means are reported
    bands : also the answers at the ends of what estimated inputs spread over
    out : folder, or None

    Returns
    -------
    dict with, by test and yarn, strains, loads, heights (see the specimens); `drape_coefficient`
    [%] and `folds`; `bending_length` [m] by yarn; `estimated`, `measured`, `source`; `bands`

    Raises
    ------
    ValueError for an unknown test or fabric; NotConverged where a specimen finds no equilibrium

    Examples
    --------
    >>> import shellform as sf
    >>> results = sf.fabric_tests("compliant", ["shear"])
    >>> results["shear"]["largest_error"] < 1e-3, results["measured"]
    (True, [])
    """
    for name in only:
        if name not in TESTS:
            raise ValueError(f"there is no test {name!r} of fabrics: {', '.join(TESTS)}")
    if starts < 1:
        raise ValueError(f"starts = {starts}: one drape at least")
    cloth = fabric_of(fabric)
    asked = [name for name in TESTS if name in only]
    settings = {"fabric": cloth.name, "only": asked, "starts": starts, "bands": bands}
    report = None if out is None else Report(out, "fabric", settings, MPI.COMM_WORLD)
    known = cloth.provenance
    results: dict[str, Any] = {
        "fabric": cloth.name,
        "source": None if known is None else known.source,
        "measured": None if known is None else list(known.measured),
        "estimated": None if known is None else list(known.estimated),
        "taken": inputs.taken(cloth),
        "units": {name: UNITS[name] for name in UNITS},
    }
    for name in asked:
        results |= _tested(cloth, name, starts)
    spread = inputs.spreads(cloth) if bands else {}
    wanted = [name for name in asked if name in ("hang", "drape")]
    if spread and wanted:
        results["bands"] = {
            what: _band(cloth, what, factors, wanted, results) for what, factors in spread.items()
        }
    if report is not None:
        report.summary["plan"] = {"tests": asked, "fabric": inputs.lines(cloth)[0]}
        report.write(results)
    return results


def _tested(fabric, name, starts):
    """Results of one test of a fabric."""
    # only here: what is not asked for is not loaded
    specimen = getattr(import_module(f"{__package__}.{name}"), name)
    if name == "shear":
        return {name: specimen(fabric).results()}
    if name != "drape":
        found = {yarn: specimen(fabric, yarn).results() for yarn in YARNS}
        if name != "hang":
            return {name: found}
        lengths = {yarn: found[yarn]["bending_length"] for yarn in YARNS}
        return {name: found, "bending_length": lengths}
    drapes = [specimen(fabric, start) for start in range(starts)]
    percent = [100 * one.coefficient for one in drapes]
    folds = [one.folds for one in drapes]
    several = starts > 1
    return {
        "drape": [one.results() for one in drapes],
        "drape_coefficient": float(np.mean(percent)),
        "folds": float(np.mean(folds)) if several else folds[0],
    } | ({"drape_coefficient_sd": float(np.std(percent, ddof=1))} if several else {})


def _band(fabric, what, factors, wanted, results):
    """Answers at both ends of what a quantity spreads over, and between them those of the card."""
    keys = [key for key in ("bending_length", "drape_coefficient", "folds") if key in results]
    if what == "shear":  # a strip hangs by its bending
        wanted = [name for name in wanted if name != "hang"]
        keys = [key for key in keys if key != "bending_length"]
    ends = []
    for factor in factors:
        cloth, found = inputs.scaled(fabric, what, factor), {}
        for name in wanted:
            found |= _tested(cloth, name, 1)
        ends.append(found)
    low, high = ends
    return {"factors": factors} | {key: [low[key], results[key], high[key]] for key in keys}


def summary_lines(fabric: Fabric, results: dict[str, Any]) -> list[str]:
    """Results for a person."""
    lines = inputs.lines(fabric)
    for name in ("pull", "shear", "bend"):
        if name in results:
            lines.append(f"{name:<8}{_loads(results[name])}")
    if "bending_length" in results:
        by = {yarn: 1e3 * value for yarn, value in results["bending_length"].items()}
        lines.append(f"bending length: warp {by['warp']:.1f} mm, weft {by['weft']:.1f} mm")
    if "loop" in results:
        one = {yarn: results["loop"][yarn] for yarn in YARNS}
        said = ", ".join(
            f"{yarn} {1e3 * loop['height']:.1f} mm (elastica {1e3 * loop['elastica']:.1f} mm)"
            for yarn, loop in one.items()
        )
        bent = "" if fabric.friction is None else ", whose yarns do not slip back"
        lines.append(f"height of a heart: {said}{bent}")
    if "drape_coefficient" in results:
        spread = results.get("drape_coefficient_sd")
        scatter = "" if spread is None else f" +- {spread:.1f} from start to start"
        lines.append(
            f"drape coefficient {results['drape_coefficient']:.1f} %{scatter}, "
            f"{results['folds']:g} folds"
        )
        if not all(one["settled"] for one in results["drape"]):
            lines.append("it still moved at the end: take this drape for a rough one")
    for what, band in results.get("bands", {}).items():
        lines.append(f"{what} is estimated; {_range(band)}")
    return lines


def _loads(found):
    """Largest loads of a test and how far they are from the card's."""
    parts = []
    for yarn, one in found.items() if "warp" in found else [("", found)]:
        strain, load = float(np.max(one["strain"])), float(np.max(one["load"]))
        error = one["largest_error"]
        off = "" if error is None else f", {100 * error:.2g} % from the card"
        units = one["units"]
        at = f"{strain:.3g} {units['strain']}".rstrip(" -")
        parts.append(f"{yarn} {load:.3g} {units['load']} at {at}{off}".strip())
    return "; ".join(parts)


def _range(band):
    low, high = band["factors"]
    said = [f"8 of 10 such fabrics have {low:.2g} to {high:.2g} times that"]
    if "drape_coefficient" in band:
        ends = band["drape_coefficient"]
        said.append(f"drape coefficient {ends[0]:.0f} to {ends[2]:.0f} %")
        said.append(f"folds {band['folds'][0]:g} to {band['folds'][2]:g}")
    if "bending_length" in band:
        ends = [1e3 * one["warp"] for one in band["bending_length"]]
        said.append(f"bending length along the warp {ends[0]:.1f} to {ends[2]:.1f} mm")
    return ", ".join(said)
