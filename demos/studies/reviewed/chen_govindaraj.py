# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Chen and Govindaraj: when does orthotropic cloth drape in an orthotropic shape?

Their degenerated shell takes its bending from moduli and thickness, D = t^3/12 Q, the twist of it
from the shear modulus. In their parametric study the shadow is orthotropic only where shear modulus
and thickness are large enough, and Poisson's ratio does nothing, contrary to Collier. The director
shell of the same solid sheet is draped (Cusick's test) while one of the three is varied. The
orthotropy is the part of the outline that goes with cos(2 angle), over the width of the ring,
positive where the stiffer warp lies along the longer axis of the shadow.

Moduli: a wool of about 8 MPa, 0.5 mm, quoted from memory; the weft, the shear modulus and the mass
are estimated. What is compared are trends.

Source. Textile Res. J. 65(6), 1995, 324-330; 66(1), 1996, 17-24 (as the paper's Sec. 2 has them).

    python -m demos.studies.reviewed.chen_govindaraj --out out/reviewed
"""

from collections.abc import Sequence

from demos.studies.drape.figures import print_table, write_table
from demos.studies.reviewed.cusick_drape import drapes, options
from shellform import Fabric, console
from shellform.material.sheet import Sheet

E1, E2, NU, SHEAR = 8.2e6, 4.1e6, 0.33, 0.3e6  # Pa
THICKNESS, MASS = 0.4e-3, 0.25  # m, kg/m^2
VARIED = {
    "thickness": (0.2e-3, 0.3e-3, 0.4e-3, 0.5e-3),
    "shear modulus": (0.05e6, 0.3e6, 1.0e6, 2.0e6),
    "Poisson's ratio": (0.0, 0.25, 0.5),
}


def wool(thickness: float = THICKNESS, shear: float = SHEAR, nu: float = NU) -> Sheet:
    """A solid orthotropic sheet of `thickness` [m] and shear modulus [Pa]; its mass is kept."""
    density = MASS / thickness
    return Fabric.orthotropic(E1, E2, nu, shear, shear, shear, thickness, density, name="wool")


def varied(what: str, value: float) -> Sheet:
    """The wool with one of the VARIED numbers changed."""
    return wool(**{{"thickness": "thickness", "shear modulus": "shear"}.get(what, "nu"): value})


def main(given: Sequence[str] | None = None) -> None:
    asked = options(given, "Orthotropy of the drape against thickness, shear modulus and nu.")
    rows = []
    for what, values in VARIED.items():
        for value in values[:: len(values) - 1] if asked.quick else values:
            fabric = varied(what, value)
            D = 1e6 * fabric.bending.diagonal()
            row = {"varied": what, "value": f"{value:g}"}
            row |= {"D11 [uN m]": D[0], "D66 [uN m]": D[2]}
            rows.append(row | drapes(fabric, asked))
    title = f"Cusick's drape of a solid sheet, E2 = E1/2, {asked.starts} starts each"
    print_table(title, rows, list(rows[0]))
    write_table(f"{asked.out}/chen_govindaraj.csv", rows)


if __name__ == "__main__":
    console.run(main)
