# SPDX-License-Identifier: LGPL-3.0-or-later
"""From runs to rows of a table: references where no exact value is known, errors, spreads.

A reference is extrapolated from the finest meshes (Richardson) where three of them show an order,
and is the finest itself where they do not; its uncertainty is what it differs from the finest, or
what the two finest differ by, and what another start changes. The finest is off by that, too.
"""

import numpy as np
from scipy.optimize import brentq

LEAST, MOST = 0.1, 8.0  # orders that are looked for
FAR = 3.0  # times the difference of the two finest meshes that a reference may lie beyond them
WORDS = ("kind", "family", "name")


def rows_of(case, runs):
    """Rows of all runs of a case; runs : list of (settings, found with repeats and memory_mb)."""
    make = case.rows or (exact_rows if "errors" in runs[0][1] else reference_rows)
    rows = make(case, runs)
    return [{"case": case.name, "length": case.length} | row for row in rows]


def exact_rows(case, runs):
    """Errors against exact values, with what half a step or a trick changes them to."""
    rows = []
    for settings, found in runs:
        for quantity, error in found["errors"].items():
            one = _row(settings, found, quantity) | {"error": error, "reference": "exact"}
            one["uncertainty"] = found.get("uncertainty", 0.0)
            if settings["kind"] in ("step", "trick"):
                base = _base(settings, runs)
                if base is None:
                    continue
                one |= {"error": abs(error - base["errors"][quantity])} | _against(found, base)
            rows.append(one)
    return rows


def reference_rows(case, runs):
    """Errors against references made from the finest meshes of the first family."""
    first, rows = runs[0][0]["family"], []
    for quantity in runs[0][1]["values"]:
        # other starts of a mesh count for it: their mean is what folds repeat
        meshes = {}
        for settings, found in runs:
            if settings["kind"] in ("mesh", "start"):
                key = settings["family"], found["ratio"]
                meshes.setdefault(key, []).append(found["values"][quantity])
        ratios = sorted((ratio for family, ratio in meshes if family == first), reverse=True)
        ladder = [np.mean(meshes[first, ratio], axis=0) for ratio in ratios]
        reference, doubt = reference_of(ratios, ladder)
        # a mean over few starts is no better known than these repeat
        spread = spread_of(meshes.values())
        doubt = float(np.hypot(doubt, spread / np.sqrt(len(meshes[first, ratios[-1]]))))
        size = rms(reference)
        scalar = float(reference) if np.ndim(reference) == 0 else f"curve of rms {size:.4g}"
        same, entered = {"reference": scalar, "uncertainty": doubt / size}, set()
        for settings, found in runs:
            one = _row(settings, found, quantity) | same
            if settings["kind"] in ("step", "trick"):
                base = _base(settings, runs)
                if base is not None:
                    apart = found["values"][quantity] - base["values"][quantity]
                    rows.append(one | {"error": rms(apart) / size} | _against(found, base))
                continue
            key = settings["family"], found["ratio"]
            if key in entered:
                continue
            entered.add(key)
            error = np.sqrt(np.mean([rms(v - reference) ** 2 for v in meshes[key]]))
            if key == (first, ratios[-1]):
                error = max(error, doubt)
            one |= {"kind": "mesh", "error": float(error / size), "starts": len(meshes[key])}
            rows.append(one)
        if spread:
            one = _row(*runs[0], quantity) | same | {"kind": "spread", "settings": "other starts"}
            rows.append(one | {"error": spread / size})
    return rows


def spread_of(groups):
    """Standard deviation of a quantity over starts of one mesh, root mean square over the meshes.

    groups : lists of numbers or curves, one a mesh; those of a single start say nothing
    """
    squares = [
        sum(rms(v - np.mean(values, axis=0)) ** 2 for v in values) / (len(values) - 1)
        for values in groups
        if len(values) > 1
    ]
    return float(np.sqrt(np.mean(squares))) if squares else 0.0


def reference_of(ratios, values):
    """Best value of a quantity and its uncertainty, from meshes in order of falling size.

    ratios : (k,); values : k floats or curves (m,)
    """
    if len(values) == 1:
        return np.asarray(values[0]), rms(values[0])
    fine, apart = np.asarray(values[-1], float), rms(values[-1] - values[-2])
    if len(values) > 2:
        order = observed_order(ratios[-3:], values[-3:])
        if 0.5 < order < MOST:
            by = ratios[-2] / ratios[-1]
            # meshes too much alike say too little of what lies beyond them
            if FAR * (by**order - 1) > 1:
                best = fine + (fine - values[-2]) / (by**order - 1)
                return best, rms(best - fine)
    return fine, apart


def observed_order(ratios, values):
    """p for which the differences of three meshes go with h^p; NaN if they do not shrink alike."""
    before, after = values[1] - values[0], values[2] - values[1]
    if np.vdot(before, after) < 0.5 * rms(before) * rms(after) * np.size(before):
        return np.nan
    shrunk = rms(before) / rms(after)
    a, b, c = ratios

    def off(p):
        return (a**p - b**p) / (b**p - c**p) - shrunk

    if off(LEAST) * off(MOST) > 0:
        return np.nan
    return brentq(off, LEAST, MOST, xtol=1e-10)


def rms(value):
    return float(np.sqrt(np.mean(np.square(value))))


def named(settings):
    """Settings as a text."""
    said = [f"{k} {v:g}" for k, v in settings.items() if k not in WORDS and not isinstance(v, str)]
    return ", ".join([settings.get("name", settings["family"]), *said])


def _row(settings, found, quantity):
    keys = ("ratio", "core_seconds", "nodes", "steps", "time_step", "memory_mb", "repeats")
    return {"family": settings.get("name", settings["family"]), "quantity": quantity} | {
        "kind": settings["kind"], "settings": named(settings), **{key: found[key] for key in keys}
    }  # fmt: skip


def _base(settings, runs):
    """The run on the same mesh that changes nothing, or None."""
    mesh = [key for key in ("cells", "around", "cell_size") if key in settings]
    for other, result in runs:
        same = all(other.get(key) == settings[key] for key in [*mesh, "family"])
        if same and other["kind"] == "mesh":
            return result
    return None


def _against(found, base):
    """Cost over that of the run without."""
    return {"relative_cost": found["core_seconds"] / base["core_seconds"]}
