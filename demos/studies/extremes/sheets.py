# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sheets and solvers at the extremes: what converges, degrades, or is refused.

    python -m demos.studies.extremes.sheets           a minute or two
    python -m demos.studies.extremes.sheets --long    a million cells, a million steps, 20 turns
    python -m demos.studies.extremes.sheets --every   each value tried on its own line

prints a table in Markdown, one line a direction, and leaves every row (direction, value, verdict,
figure) in out/extremes_of_sheets/summary.json. `converges` is said where the exact
answer is met (that of the mesh within its known error, momenta to roundoff); `degrades` names what
is lost; `refused` gives the sentence a user reads.
"""

import warnings

import numpy as np

from demos.studies.extremes.motion_cases import million, rung, spun, swung, tumbled
from demos.studies.extremes.sheet_cases import (
    LENGTH,
    at_rest,
    leaning,
    loose,
    pulled,
    rolled,
    strip,
    turned_round,
)
from demos.studies.extremes.table import arguments, tell
from shellform import Fabric
from shellform.console import run
from shellform.errors import NotConverged, Unstable
from shellform.material.sheet import UnitWarning

REFUSALS = (ValueError, NotConverged, Unstable)
OF_MESH = 1e-4  # of the tip of a turn of 16 cells: 0.0066 (2 pi/16)^6 = 2.4e-5
OF_NOTE = 3e-3  # of a period by 16 cells of lumped mass, and more by shear of a thick strip
PATCH = 1e-8  # of a uniform strain, which any mesh must show
ROUNDOFF, EPS = 1e-12, np.finfo(float).eps
ENERGY = 1e-3  # swing of the energy of central differences at 0.9 of the stable step


def row(direction, value, measure):
    """One row of strings; `measure` returns (good, figure), or refuses."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            good, figure = measure()
            verdict = "converges" if good is True else f"degrades: {good}"
        except REFUSALS as refusal:
            verdict, figure = f"refused: {refusal}", "-"
    said = [str(one.message) for one in caught if one.category is UserWarning]
    if said and not verdict.startswith("refused"):
        verdict += f", told: {said[0]}"
    return direction, value, verdict, figure


def judged(error, bar, loss="misses the exact answer"):
    """(True or what is lost, figure) of an error and its bar; not-a-number is no success."""
    return (True if error <= bar else loss), f"error {error:.1e}"


def rolls(fabric, bar=OF_MESH, loss="misses the circle", **options):
    """A measure of `row`: the strip rolled up."""

    def measure():
        out = rolled(fabric() if callable(fabric) else fabric, **options)
        good, figure = judged(out["error"], bar, loss)
        return good, f"{figure}, cut back {out['cutbacks']} times"

    return measure


def pulls(fabric, loss="misses the uniform strain", **options):
    """A measure of `row`: the uniform strain off the axes."""
    return lambda: judged(pulled(fabric(), **options)["error"], PATCH, loss)


def flies(fabric, **options):
    """A measure of `row`: free flight of 500 steps."""

    def measure():
        out = tumbled(fabric() if callable(fabric) else fabric, **options)
        drift = max(out["momentum"], out["turning"])
        # roundoff adds up as a random walk at best, steadily at worst: judged as the latter
        good = drift < max(ROUNDOFF, EPS * out["steps"]) and out["energy"] < ENERGY
        return (True if good else "balances do not close"), (
            f"momenta {drift:.0e}, energy {out['energy']:.0e} in {out['steps']} steps"
        )

    return measure


def rings(ratio):
    """A measure of `row`: the lowest note of a strip held at one end."""

    def measure():
        out = rung(ratio)
        return judged(max(out["error"], abs(out["swing"] - 1)), OF_NOTE, "misses the note")

    return measure


def like(one, other):
    """(True or loss, figure) of two flights that only units or place tell apart."""
    error = np.abs(one["places"] - other["places"]).max() / np.abs(other["places"]).max()
    return judged(float(error), 1e-9, "not the same flight")


def ortho(E1, E2, nu, thickness=1e-3):
    """Fabric whose shear is a hundredth of the warp's stiffness."""
    G = 0.01 * E1
    return Fabric.orthotropic(E1, E2, nu, G, G, G, thickness, 100.0)


def fabrics():
    for ratio in (1e-1, 1e-2, 1e-4, 1e-6, 1e-7, 1e-8, 1e-11):
        thin = strip(ratio * LENGTH)
        yield row("thickness/length, rolled up", f"{ratio:g}", rolls(thin))
        yield row("thickness/length, in flight", f"{ratio:g}", flies(strip(ratio)))
        if ratio >= 1e-6:  # below, steps are cut back again and again: see `rolled up`
            yield row("thickness/length, lowest note", f"{ratio:g}", rings(ratio))
    base = tumbled(strip(1e-3), steps=400)
    for modulus in (1e2, 1e6, 1e12):
        yield row("modulus, rolled up", f"{modulus:g} Pa", rolls(strip(modulus=modulus)))
        yield row(
            "modulus, in flight", f"{modulus:g} Pa",
            lambda E=modulus: like(tumbled(strip(1e-3, modulus=E), steps=400), base),
        )  # fmt: skip
    for density in (1.0, 100.0, 1e4):
        cloth = Fabric.isotropic(1.2e6, 0.0, 1e-3, density)
        yield row(
            "density", f"{density:g} kg/m3", lambda f=cloth: like(tumbled(f, steps=400), base)
        )
    for ratio in (1.0, 1e2, 1e4):
        weak = ortho(1e7, 1e7 / ratio, 0.0, 1e-3 * LENGTH)
        yield row("warp/weft, bent along warp", f"{ratio:g}", rolls(weak))
        yield row("warp/weft, bent along weft", f"{ratio:g}", rolls(weak, across=True))
        yield row(
            "warp/weft, pulled at 30 degrees", f"{ratio:g}",
            pulls(lambda r=ratio: ortho(1e7, 1e7 / r, 0.3)),
        )  # fmt: skip
    for D in (0.0, 1e-9, 1e-13, 1e-20, 1e-32):
        yield row(
            "bending given", f"{D:g} N m",
            rolls(lambda d=D: strip(1e-3, 1e6, bending_stiffness=d), length=1.0, width=0.1),
        )  # fmt: skip
    wide = {"width": LENGTH, "cells": (16, 4)}
    for nu in (-1.0, -1 + 1e-6, -0.9, 0.4999999, 0.5, 0.51):
        yield row("Poisson's ratio", f"{nu:.8g}", rolls(lambda n=nu: strip(poisson=n), **wide))
    for short in (1e-3, 1e-9, 1e-12, 0.0):
        yield row(
            "nu12^2 E2/E1, pulled at 30 degrees", f"1 - {short:g}",
            pulls(
                lambda e=short: ortho(4e7, 1e7, 2.0 * np.sqrt(1 - e)),
                "loads and stiffness keep only the digits that 1 - nu12 nu21 leaves",
            ),
        )  # fmt: skip


def cells():
    for count in (1, 2, 4):
        phi = 0.2 * np.pi / count
        yield row(
            "cells of a tenth of a turn", f"{count}",
            rolls(strip(), turns=0.1, cells=(count, 1), bar=2 * 0.0066 * phi**6 + 1e-6),
        )  # fmt: skip
    for aspect in (10, 100):
        yield row(
            "cells wide against the bend", f"{aspect}", rolls(strip(), width=aspect * LENGTH / 16)
        )
        yield row(
            "cells long along the bend", f"{aspect}", rolls(strip(), width=LENGTH / 16 / aspect)
        )
        yield row("aspect of cells, in flight", f"{aspect}", flies(strip(1e-3), aspect=aspect))
    for aspect in (1.0, 100.0):
        for degrees in (120.0, 170.0, 179.0):
            size = {"length": LENGTH if aspect == 1 else 100.0, "cells": (8, 4)}
            size["width"] = size["length"] / 15 if aspect == 1 else 0.5
            lines = leaning(size["cells"], degrees, size["length"], size["width"])
            yield row(
                "corners, pulled at 30 degrees", f"{degrees:g} degrees, aspect {aspect:g}",
                pulls(lambda: ortho(1e7, 1e6, 0.3), parameters=lines, **size),
            )  # fmt: skip
    for degrees in (120.0, 150.0, 170.0):
        for triangles in (False, True):
            lines = leaning((16, 2), degrees, LENGTH, 0.2)
            kind = "triangles" if triangles else "quads"
            yield row(
                "corners, rolled up", f"{degrees:g} degrees, {kind}",
                rolls(
                    strip(), 1e-2, "leaning cells are too stiff in bending", cells=(16, 2),
                    width=0.2, parameters=lines, triangles=triangles,
                ),
            )  # fmt: skip


def places():
    base = tumbled(strip(1e-3), steps=400)
    for size in (1e-6, 1e-3, 1e3, 1e6):
        small = {"length": size, "width": size / 12}
        yield row("length, rolled up", f"{size:g} m", rolls(strip(1e-3 * size), **small))
        yield row(
            "length, in flight", f"{size:g} m",
            lambda s=size: like(tumbled(strip(1e-3 * s), steps=400, size=s), base),
        )  # fmt: skip
    for far in (1e3, 1e6, 1e8):
        away = far * np.array([0.6, 0.64, 0.48])
        digits = f"{far:g} lengths, coordinates to {np.spacing(far):.0e}"
        yield row("origin, rolled up", digits, rolls(strip(), length=11.7, origin=11.7 * away))
        yield row(
            "origin, in flight", digits,
            lambda o=away: judged(
                np.abs(
                    tumbled(strip(1.1e-3), steps=400, size=1.1, origin=1.1 * o)["places"]
                    - tumbled(strip(1.1e-3), steps=400, size=1.1)["places"]
                ).max(), 1e-6, "digits of the coordinates are lost",
            ),
        )  # fmt: skip


def turns():
    for count in (1, 20):
        yield row(
            "edge led round, statics", f"{count} turns",
            lambda n=count: judged(turned_round(n)["strain"], 1e-12, "strained by turning"),
        )  # fmt: skip

        def spin(n=count):
            out = spun(n)
            good = out["strain"] <= out["bound"] and out["turning"] < 1e-11
            return (True if good else "strained by turning"), (
                f"strain energy {out['strain']:.0e} of the kinetic, centrifugal up to "
                f"{out['bound']:.0e}; angular momentum {out['turning']:.0e}"
            )

        yield row("spun, explicit", f"{count} turns", spin)


def steps():
    fine = {until: swung(0.05, until)[0] for until in (0.1, 0.01)}

    def swing(part, bar, loss, until=0.1, **kind):
        out, stepper = swung(part, until, **kind)
        error = np.abs(out - fine[until]).max() / np.abs(fine[until]).max()
        good, figure = judged(float(error), bar, loss)
        back = stepper.cutbacks if kind.get("implicit") else stepper.rewind.cutbacks
        return good, f"{figure}, {stepper.steps} steps, cut back {back} times"

    loss = "the motion is not resolved"
    for part in (1e-2, 0.3, 1.0, 1.5, 10.0):
        yield row("explicit step/stable step", f"{part:g}", lambda p=part: swing(p, 1e-3, loss))
    yield row("explicit, forced past the check", "10", lambda: swing(10.0, 1e-3, loss, forced=True))
    for part, until in ((0.1, 0.01), (1.0, 0.1), (10.0, 0.1), (80.0, 0.1)):
        yield row(
            "implicit step/stable step", f"{part:g}",
            lambda p=part, t=until: swing(p, 1e-2, loss, t, implicit=True),
        )  # fmt: skip
    for levels in (20, 2, 1):
        yield row("load steps of a turn", f"{levels}", rolls(strip(), levels=levels))
    yield row("no load", "0 N", lambda: judged(at_rest()[0], 0.0))
    yield row("unsupported sheet", "-", lambda: ("not refused", f"{loose(False):.1e} m"))
    yield row("half a sheet on one point", "-", lambda: ("not refused", f"{loose(True):.1e} m"))


def long():
    def fall():
        out = million()
        good, figure = judged(out["error"], 1e-12)
        return good, f"{figure} of free fall, {out['bytes']:.0f} bytes a node"

    yield row("cells, explicit", "1e6", fall)
    yield row(
        "explicit step/stable step", "0.001",
        lambda: judged(np.abs(swung(1e-3)[0] - swung(0.01)[0]).max(), 1e-6),
    )  # fmt: skip
    yield row("steps, explicit", "1e6", flies(strip(1e-3), steps=1_000_000, cells=(1, 1)))
    yield row(
        "rolled up, 8 cells a turn", "20 turns",
        rolls(strip(), 5e-3, turns=20.0, cells=(160, 1), levels=400),
    )  # fmt: skip


def rows(with_long=False):
    """Rows (direction, value, verdict, figure)."""
    warnings.simplefilter("ignore", UnitWarning)
    parts = (fabrics, cells, places, turns, steps, *((long,) if with_long else ()))
    return [line for part in parts for line in part()]


def main(given=None):
    options = arguments("extremes_of_sheets", given, long="a million cells, steps, 20 turns, too")
    tell(rows(options.long), options)


if __name__ == "__main__":
    run(main)
