# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Proofs of the relaxed membrane: tables of docs/wrinkles.md.

    python -m demos.studies.wrinkles.run bent       # Stein and Hedgepeth's strip
    python -m demos.studies.wrinkles.run sheared    # Mansfield's strip
    python -m demos.studies.wrinkles.run hub        # a disc turned about its hub
    python -m demos.studies.wrinkles.run beds       # cloth pressed between two beds
    python -m demos.studies.wrinkles.run fading     # a strip that shows its wrinkles, h -> 0
    python -m demos.studies.wrinkles.run drape      # strain energy of a drape, h -> 0
    python -m demos.studies.wrinkles.run sleeve     # a knee bent to 135 degrees (half an hour)

On one rank each; `--quick` takes the coarsest cells only. Seconds to a minute, but for the drape
(three minutes) and the sleeve.
"""

import argparse

import numpy as np

from demos.studies.drape.figures import print_table
from demos.studies.wrinkles import beds, fading, flat, sleeve
from shellform import console

KINDS = ("resolved", "relaxed")


def bent(quick: bool) -> None:
    """Curvature and depth of a bent strip against the exact ones."""
    meshes = (10,) if quick else (10, 20, 40)
    rows = [
        flat.bent_strip(n, depth, load)
        for depth in (0.4, 0.7)
        for load in (0, 0.05)
        for n in meshes
    ]
    print_table("Bent strip: 2 P/(K H^2), moments and N_c (over K kappa H)", rows, list(rows[0]))


def sheared(quick: bool) -> None:
    """Forces on the edge of a sheared strip against the exact ones."""
    meshes = (4,) if quick else (4, 8, 16)
    rows = [
        {"wrinkles": kind} | flat.sheared_strip(n, load=load, wrinkles=kind)
        for kind in KINDS
        for load in ((0,) if kind == "resolved" else (0, 0.2))
        for n in meshes
    ]
    print_table("Sheared strip: forces [N/m] in its middle, N_c over K gamma", rows, list(rows[0]))


def hub(quick: bool) -> None:
    """Torque and wrinkled radius of a disc turned about its hub against the exact ones."""
    meshes = (8,) if quick else (8, 16, 24)
    cases = ((0.0, 0.0), (0.1, 0.0), (0.0, 0.1), (0.1, 0.3))
    rows = [flat.hub(n, load, stretch) for load, stretch in cases for n in meshes]
    print_table("Disc turned about its hub: torque [N m], radius [hubs]", rows, list(rows[0]))


def pressed(quick: bool) -> None:
    """Compression of cloth pressed between beds, as it is shortened."""
    cases = [(12, "relaxed"), (4, "relaxed"), (4, "resolved"), (12, "resolved"), (48, "resolved")]
    at = (1, 3, 10, 20)  # readings, of 0.1 % each
    rows = []
    for cells, kind in cases[: 2 if quick else None]:
        for state in beds.ANGLES:
            found = beds.patch(cells, state, kind)
            row = {"wrinkles": kind, "cells [mm]": 1e3 * found["size"], "shortened": state}
            rows.append(row | {f"{k / 10:g} %": found["load"][k - 1] for k in at})
    print_table(f"Pressed cloth: N/m, 2 sqrt(k D) = {beds.theory():.2f}", rows, list(rows[0]))


def fades(quick: bool) -> None:
    """Shear of a strip that may leave its plane, over that of a flat one."""
    sizes = (3,) if quick else (3, 4, 5, 6, 8, 16)
    rows = [fading.sheared(n, kind) for n in sizes for kind in KINDS]
    title = f"Sheared strip out of its plane; tension field {fading.tension_field():.3f}"
    print_table(title, rows, list(rows[0]))


def drape(quick: bool) -> None:
    """Strain energy of a stiff and of a soft drape."""
    sizes = (8,) if quick else (8, 12, 16, 24)
    for bending in (2.29e-3, 9.16e-5):
        rows = [fading.draped(n, kind, bending) for n in sizes for kind in KINDS]
        print_table(f"Drape, D (1 - nu^2) = {bending:g} N m", rows, list(rows[0]))


def knee(quick: bool) -> None:
    """Torque of a sleeve on a knee bent to 135 degrees, means over 15 degrees."""
    cases = [(20, "relaxed"), (15, "relaxed"), (10, "relaxed"), (7.5, "relaxed")]
    cases += [(15, "resolved"), (10, "resolved"), (6, "resolved"), (4, "resolved"), (3, "resolved")]
    for friction in (0.0, sleeve.FRICTION):
        rows = []
        for size, kind in cases[: 1 if quick else None]:
            for start in (0,) if quick or size < 6 else (0, 1, 2):
                found = sleeve.bend(1e-3 * size, kind, friction=friction, start=start)
                mean = -np.reshape(found["torque"], (-1, 3)).mean(axis=1)
                row = {"wrinkles": kind, "cells [mm]": size, "start": start}
                rows.append(row | {f"{15 * k:d}": mean[k - 1] for k in range(1, 10)})
        print_table(f"Sleeve, friction {friction:g}: torque [N m]", rows, list(rows[0]))


STUDIES = {
    "bent": bent,
    "sheared": sheared,
    "hub": hub,
    "beds": pressed,
    "fading": fades,
    "drape": drape,
    "sleeve": knee,
}


def main(given: list[str] | None = None) -> None:
    """Print the tables of a study."""
    parser = argparse.ArgumentParser(allow_abbrev=False, description="Proofs of relaxed wrinkles.")
    parser.add_argument("study", choices=STUDIES)
    parser.add_argument("--quick", action="store_true", help="the coarsest cells only")
    options = console.parse(parser, given)
    STUDIES[options.study](options.quick)


if __name__ == "__main__":
    console.run(main)
