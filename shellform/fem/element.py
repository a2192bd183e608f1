# SPDX-License-Identifier: LGPL-3.0-or-later
"""The elements: which strain is evaluated where in the cell, with which stiffness, Eqs. 3, 12.

Cell         shear               membrane                       bending
triangle     3 corners (MITC3)   arcs of the sides              turning of the sides
quad         4 corners (MITC4)   six lengths of the cell        turning at 2x2 Gauss
             or the same         chords at 2x2 Gauss            plain or turning at 2x2 Gauss
9-node quad  2 Gauss x 3         2x3 and 3x2 Gauss, mixed       3x3 Gauss
             Simpson lines       products at 2x2
             (mixed at 2x2, capped)

The places were chosen by measurement on distorted meshes: shear on Gauss lines locks there, so does
chord membrane under folds across the mesh; uniform 2x2 leaves 9-node quads four spurious modes.

FFCx 0.5 compiles a form that mixes directional rules into a wrong kernel, silently; so terms are
grouped by rule and every rule becomes a form of its own. The six lengths of a quad belong to the
cell, not to a point: cell_membrane.py has them.

A law that is not quadratic in a strain gives the density of that strain's Term (terms.py); measured
curves bend quads in their middle, friction inside the cloth acts there, see cell_stress.py. Where a
quadratic energy is shared out over several rules, or couples strains, it stays, and what the law
has beyond it is added at 2x2 Gauss points: modes that these do not see are held by the quadratic
part.
"""

from collections.abc import Callable

import numpy as np

import ufl

from meshes import Surface
from shellform.material.energy import StVenant
from shellform.material.sheet import Sheet

from . import strains
from .dolfinx_compat import Constant, Expr, Function, Mesh, cell_nodes, vector_space
from .partition import Partition
from .terms import Densities, Term, stacked, stacked_product

Pairs = tuple[tuple[float, float], ...]  # points and weights on [0, 1]

GAUSS2: Pairs = ((0.5 - 0.5 / np.sqrt(3), 0.5), (0.5 + 0.5 / np.sqrt(3), 0.5))
GAUSS3: Pairs = (
    (0.5 - 0.5 * np.sqrt(0.6), 5 / 18),
    (0.5, 4 / 9),
    (0.5 + 0.5 * np.sqrt(0.6), 5 / 18),
)
SIMPSON: Pairs = ((0.0, 1 / 6), (0.5, 4 / 6), (1.0, 1 / 6))
ENDS: Pairs = ((0.0, 0.5), (1.0, 0.5))


def product_rule(first: Pairs, second: Pairs) -> list[tuple[float, float, float]]:
    """Rows (p, q, weight) of the tensor rule of two one-dimensional rules on [0, 1]."""
    return [(p, q, a * b) for p, a in first for q, b in second]


RULES: dict[str, list[tuple[float, float, float]]] = {
    "centre": [(0.5, 0.5, 1.0)],
    "corners": product_rule(ENDS, ENDS),
    "gauss2": product_rule(GAUSS2, GAUSS2),
    "gauss23": product_rule(GAUSS2, GAUSS3),
    "gauss32": product_rule(GAUSS3, GAUSS2),
    "gauss3": product_rule(GAUSS3, GAUSS3),
    "lines1": product_rule(GAUSS2, SIMPSON),
    "lines2": product_rule(SIMPSON, GAUSS2),
    "vertices": [(0, 0, 1 / 6), (1, 0, 1 / 6), (0, 1, 1 / 6)],
    "centroid": [(1 / 3, 1 / 3, 1 / 2)],
}


def measure(mesh: Mesh, rule: str) -> ufl.Measure:
    """UFL measure that integrates with one of the RULES."""
    metadata = {
        "quadrature_rule": "custom",
        "quadrature_points": tuple((float(p), float(q)) for p, q, _ in RULES[rule]),
        "quadrature_weights": tuple(float(w) for *_, w in RULES[rule]),
        "quadrature_degree": 1,
    }
    return ufl.Measure("dx", domain=mesh, metadata=metadata)


def energy_terms(
    partition: Partition,
    fabric: Sheet,
    law: StVenant,
    membrane: str,
    curvature: str,
    thick: bool,
    stiffer: np.ndarray | None = None,
) -> list[Term]:
    """Terms of the strain energy that an element, a fabric and a law need.

    Parameters
    ----------
    partition : of the surface
    fabric, law, membrane, curvature, thick, stiffer : see `Shell`

    The membrane of quads by six lengths (`has_six_lengths`) is not among them.
    """
    mesh, surface = partition.mesh, partition.surface
    M = cell_axes(partition, fabric.directional)
    V = strains.voigt(M)
    matrices = ("membrane", "coupling", "bending", "third_moment", "fourth_moment", "shear")
    A, B, D, E, F, S = (Constant(mesh, np.array(getattr(fabric, m))) for m in matrices)
    if stiffer is not None:
        D = cell_numbers(partition, stiffer) * D
    b = B if np.any(fabric.coupling) else None
    ratio = np.trace(fabric.shear) / (fabric.bending[0, 0] + fabric.bending[1, 1])
    cap = strains.shear_cap(mesh, Constant(mesh, float(ratio)))
    of_law = Densities(law, V, M, {"membrane": A, "bending": D, "shear": S})
    if surface.degree == 2:
        return _nine_nodes(V, M, (A, b, D, E, F, S), cap, thick, of_law)
    triangle = surface.kind == "triangle"
    corners, inside = ("vertices", "vertices") if triangle else ("corners", "gauss2")
    if triangle:
        s = corner_offsets(mesh, strains.TRIANGLE_CORNERS)
        gamma, kappa = strains.shear_triangle_corner(s), strains.curvature_turning_sides
    else:
        s = corner_offsets(mesh, strains.QUAD_CORNERS)
        gamma, kappa = strains.shear_quad_corner(s), strains.curvature_turning
        cap = 1
    kappa = strains.curvature if curvature == "plain" else kappa
    shear = Term(
        *("shear", gamma, lambda p, q: cap * ufl.dot(M * p, S * (M * q)), corners),
        of_law.whole("shear", cap),
    )
    both = of_law.both()
    if both is not None:
        # sides of a triangle measure arcs at its corners; six lengths of a quad are of no point
        arcs = triangle and membrane == "arcs"
        pair = [strains.membrane_arcs if arcs else strains.membrane_chords, kappa]
        product = stacked_product(V, [[A, None], [None, D]])
        return [shear, Term("membrane and bending", stacked(pair), product, inside, both)]
    if b is not None or thick:
        # products of membrane and bending strain: a positive energy needs common points
        measures: list[Callable] = [strains.membrane_chords, kappa, strains.director_strain]
        blocks: list[list] = [[A, b, D], [b, D, E], [D, E, F]]
        if not thick:
            measures, blocks = measures[:2], [row[:2] for row in blocks[:2]]
        name = "membrane and bending"
        return [
            shear,
            Term(name, stacked(measures), stacked_product(V, blocks), inside),
            *of_law.beyond("membrane", name, measures[0], inside),
            *of_law.beyond("bending", name, measures[1], inside),
        ]
    product = stacked_product(V, [[D]])
    bent = [Term("bending", kappa, product, inside, of_law.whole("bending"))]
    if law.in_the_middle and not triangle:
        beyond = of_law.beyond("bending", "bending", kappa, "centre")
        bent = [Term("bending", kappa, product, inside), *beyond]
    if has_six_lengths(surface, fabric, membrane, thick, law):
        return [shear, *bent]
    arcs = membrane == "arcs"
    eps, place = (strains.membrane_arcs, corners) if arcs else (strains.membrane_chords, inside)
    stretching = Term("membrane", eps, stacked_product(V, [[A]]), place, of_law.whole("membrane"))
    return [shear, stretching, *bent]


def has_six_lengths(
    surface: Surface, fabric: Sheet, membrane: str, thick: bool, law: StVenant
) -> bool:
    """True if the membrane of a sheet is that of cell_membrane.py: options as for `Shell`."""
    uncoupled = not (thick or law.couples or np.any(fabric.coupling))
    return surface.cells.shape[1] == 4 and membrane == "arcs" and uncoupled


def _nine_nodes(V, M, stiffness, cap, thick, of_law):
    A, b, D, E, F, S = stiffness
    C = ufl.dot(ufl.transpose(V), ufl.dot(A, V))
    T = ufl.dot(ufl.transpose(M), ufl.dot(S, M))
    # the only shear term off the lines: in full it would lock thin sheets on distorted cells
    cross = cap * T[0, 1]
    eps, kap, gam = strains.membrane_chords, strains.curvature, strains.shear

    def mixed(p, q):
        pairs = ((0, 1), (0, 2), (1, 2))
        return C[2, 2] * p[2] * q[2] + sum(C[i, j] * (p[i] * q[j] + p[j] * q[i]) for i, j in pairs)

    terms = [
        Term("membrane", eps, lambda p, q: C[0, 0] * p[0] * q[0], "gauss23"),
        Term("membrane", eps, lambda p, q: C[1, 1] * p[1] * q[1], "gauss32"),
        Term("membrane", eps, mixed, "gauss2"),
        Term("shear", gam, lambda p, q: T[0, 0] * p[0] * q[0], "lines1"),
        Term("shear", gam, lambda p, q: T[1, 1] * p[1] * q[1], "lines2"),
        Term("shear", gam, lambda p, q: cross * (p[0] * q[1] + p[1] * q[0]), "gauss2"),
        Term("bending", kap, stacked_product(V, [[D]]), "gauss3", of_law.whole("bending")),
        *of_law.beyond("membrane", "membrane", eps, "gauss2"),
        *of_law.beyond("shear", "shear", gam, "gauss2", cap),
    ]
    both = of_law.both(beyond=True)
    if both is not None:
        return [*terms, Term("coupling", stacked([eps, kap]), None, "gauss2", both)]
    if thick:
        measures = [eps, kap, strains.director_strain]
        blocks = [[None, b, D], [b, None, E], [D, E, F]]
    elif b is not None:
        measures, blocks = [eps, kap], [[None, b], [b, None]]
    else:
        return terms
    return [*terms, Term("coupling", stacked(measures), stacked_product(V, blocks), "gauss2")]


def cell_axes(partition: Partition, directional: bool) -> Expr:
    """`strains.lamina` of the sheet at rest; `directional`: with the axes of its warp."""
    warp = warp_field(partition) if directional else None
    if partition.flat_field is None:
        return strains.lamina(partition.mesh, warp)
    at_rest = strains.flat_configuration(partition.mesh, partition.flat_field)
    return strains.lamina(partition.mesh, warp, at_rest.g)


def cell_numbers(partition: Partition, values: np.ndarray) -> Expr:
    """Numbers (m,) of the surface's cells as a field that is constant in each."""
    field = Function(vector_space(partition.mesh, "DG", 0, 1))
    # dolfinx renumbers cells; field numbering follows its own cells
    field.x.array[:] = values[partition.cells]
    return field[0]


def warp_field(partition: Partition) -> Expr:
    """UFL vector of the warp direction: one for all (3,), or one a cell (m, 3)."""
    mesh = partition.mesh
    if partition.flat is not None:
        return Constant(mesh, np.array([1.0, 0.0, 0.0]))
    warp = np.asarray(partition.surface.warp, float)
    if warp.ndim == 1:
        return Constant(mesh, warp)
    field = Function(vector_space(mesh, "DG", 0, 3))
    # dolfinx renumbers cells; field numbering follows its own cells
    field.x.array.reshape(-1, 3)[:] = warp[partition.cells]
    return field


def corner_offsets(mesh: Mesh, table: np.ndarray) -> Function:
    """Field with the same corner values in every cell: UFL knows no reference coordinates."""
    field = Function(vector_space(mesh, "DG", 1, 2))
    field.x.array.reshape(-1, 2)[cell_nodes(field.function_space)] = table
    return field


def check_warp(surface: Surface, fabric: Sheet) -> None:
    """ValueError if a warp direction is missing or stands up from the surface in some cell."""
    if surface.warp is None:
        raise ValueError(
            f"{surface.source} has no warp direction, which the fabric '{fabric.name}' needs: "
            "give surface.replace(warp=(x, y, z))"
        )
    corners = surface.points[surface.cells[:, : 3 if surface.kind == "triangle" else 4]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, -1] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    warp = np.broadcast_to(surface.warp, normal.shape)
    length = np.linalg.norm(warp, axis=1)
    lean = np.linalg.norm(np.cross(warp, normal), axis=1)
    bad = np.flatnonzero(~(lean > 0.1 * length))
    if len(bad):
        raise ValueError(
            f"the warp {warp[bad[0]].tolist()} of cell {bad[0]} of {surface.source} points along "
            "the surface's normal, not along the cloth: give one direction a cell, (cells, 3)"
        )


def terms_of(fabric: Sheet, thick: bool = False) -> list[str]:
    """Names of the strains whose energy a sheet of a fabric has; `thick` as for Shell."""
    terms = ["membrane", "bending", "transverse shear"]
    if np.any(fabric.coupling):
        terms.append("membrane with bending")
    if fabric.friction is not None:
        terms.append("friction inside the cloth")
    return [*terms, "chi"] if thick else terms
