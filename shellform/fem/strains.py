# SPDX-License-Identifier: LGPL-3.0-or-later
"""Shell strains in UFL: Eqs. 3, 5, 12.

With x = xbar + z d, the Green strain along the element axes (columns G_a of the Jacobian) is
E_ab(z) = eps_ab + z kap_ab + z^2 chi_ab, and gam_a = x,a . d - X,a . D shears the director.
Everything is polynomial in the nodal field w = (u, d). Vectors hold the components (11, 22, 12).

What keeps the elements from locking is what is measured, and where (element.py):

* shear at a corner from the two edges that meet there, each at its midpoint,
  gam_a = x,a . (d + s_a d,a), s = +-1/2. This is MITC4 (Dvorkin and Bathe, Eng. Comput. 1, 1984)
  on quads and MITC3 on triangles, evaluated at the corners.
* membrane "arcs": a segment of a bent sheet is longer than its chord. Its length is taken from
  positions and directors, l = |dx|^2/2 + (dx . dd)^2/24, so bending an irregular mesh stays free:
  three sides of a triangle; four sides and two diagonals of a quad, see six_lengths.py.
* curvature "turning": dx . dd of a segment that turns by phi is short by phi^2/12; the factor
  (1 + dd . dd/12) restores it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import ufl

from .arc import half_length_squared, turning
from .dolfinx_compat import Constant, Expr, Function, Mesh, cell_name

# s1, s2: from a corner to the midpoint of the edge along axis 1, 2, corners in tensor order
QUAD_CORNERS = np.array([[0.5, 0.5], [-0.5, 0.5], [0.5, -0.5], [-0.5, -0.5]])
# at a triangle's corners 1 and 2 one of the two edges is the diagonal: s is that of the edge
# along an axis and zero for the other, which the diagonal supplies
TRIANGLE_CORNERS = np.array([[0.5, 0.5], [-0.5, 0.0], [0.0, -0.5]])


@dataclass(frozen=True)
class Configuration:
    """Tangents g = (x,1, x,2), director d and its derivatives dd = (d,1, d,2), in element axes."""

    g: tuple[Expr, Expr]
    d: Expr
    dd: tuple[Expr, Expr]


Measure = Callable[[Configuration], Expr]  # a strain as a function of the configuration


def configuration(mesh: Mesh, w: Function) -> Configuration:
    """Configuration of the field w = (u, d) on a mesh embedded in 3-D, Eq. 5."""
    jacobian = ufl.Jacobian(mesh)
    slope = ufl.dot(ufl.grad(w), jacobian)
    tangents, turns = [], []
    for a in range(2):
        tangents.append(ufl.as_vector([jacobian[i, a] + slope[i, a] for i in range(3)]))
        turns.append(ufl.as_vector([slope[i, a] for i in range(3, 6)]))
    return Configuration(tuple(tangents), ufl.as_vector([w[i] for i in range(3, 6)]), tuple(turns))


def flat_configuration(mesh: Mesh, flat: Function) -> Configuration:
    """Configuration of cells in flat panels, of the field of their corners, directors upright."""
    slope = ufl.dot(ufl.grad(flat), ufl.Jacobian(mesh))
    g1, g2 = (ufl.as_vector([slope[i, a] for i in range(3)]) for a in range(2))
    level = ufl.as_vector([0.0, 0.0, 0.0])
    return Configuration((g1, g2), ufl.as_vector([0.0, 0.0, 1.0]), (level, level))


def area(tangents: Sequence[Expr]) -> Expr:
    """Area |G1 x G2| of two tangents."""
    normal = ufl.cross(*tangents)
    return ufl.sqrt(ufl.dot(normal, normal))


def lamina(mesh: Mesh, warp: Expr | None, tangents: Sequence[Expr] | None = None) -> Expr:
    """M[i, a] = l_i . G^a: covariant components to the warp and weft axes of the sheet (Eq. 12).

    `warp` is a UFL 3-vector, projected on the surface; None takes the first element axis, for
    fabrics without a preferred direction. `tangents` (G1, G2) of the sheet at rest, where they are
    not those of the mesh.
    """
    G1, G2 = mesh_tangents(mesh) if tangents is None else tangents
    a11, a12, a22 = ufl.dot(G1, G1), ufl.dot(G1, G2), ufl.dot(G2, G2)
    size = ufl.sqrt(a11 * a22 - a12 * a12)
    if warp is None:
        # l1 = G1/|G1|, l2 = n x l1: the dual vectors reduce to the metric
        root = ufl.sqrt(a11)
        return ufl.as_matrix([[1 / root, 0], [-a12 / (root * size), root / size]])
    p, q = ufl.dot(warp, G1), ufl.dot(warp, G2)
    # contravariant components of the warp's tangential part, then normalised
    c1, c2 = a22 * p - a12 * q, a11 * q - a12 * p
    length = ufl.sqrt(c1 * p + c2 * q)
    return ufl.as_matrix([[c1 / (size * length), c2 / (size * length)], [-q / length, p / length]])


def mesh_tangents(mesh: Mesh) -> tuple[Expr, Expr]:
    """Columns G_1, G_2 of the Jacobian."""
    jacobian = ufl.Jacobian(mesh)
    G1, G2 = (ufl.as_vector([jacobian[i, a] for i in range(3)]) for a in range(2))
    return G1, G2


def voigt(M: Expr) -> Expr:
    """Matrix V with V (e11, e22, e12) = (E11, E22, 2 E12) in lamina axes."""
    return ufl.as_matrix(voigt_rows(M[0, 0], M[0, 1], M[1, 0], M[1, 1]))


def voigt_rows(a: Any, b: Any, c: Any, d: Any) -> list[list]:
    """Rows of `voigt` for M = [[a, b], [c, d]]: numbers, arrays or UFL expressions."""
    return [
        [a**2, b**2, 2 * a * b],
        [c**2, d**2, 2 * c * d],
        [2 * a * c, 2 * b * d, 2 * (a * d + b * c)],
    ]


def _from_segments(measure, c):
    """Components (11, 22, 12) of a quadratic measure from the sides of a triangle."""
    (g1, g2), (d1, d2) = c.g, c.dd
    first, second = measure(g1, d1), measure(g2, d2)
    return ufl.as_vector([first, second, 0.5 * (first + second - measure(g1 - g2, d1 - d2))])


def membrane_arcs(c: Configuration) -> Expr:
    """Membrane strain from the arc lengths of the sides of a triangle."""

    def measure(p, q):
        return half_length_squared(ufl.dot(p, p), ufl.dot(p, q), ufl.dot(q, q))

    return _from_segments(measure, c)


def membrane_chords(c: Configuration) -> Expr:
    """Membrane strain eps_ab = x,a . x,b / 2."""
    g1, g2 = c.g
    return 0.5 * ufl.as_vector([ufl.dot(g1, g1), ufl.dot(g2, g2), ufl.dot(g1, g2)])


def curvature(c: Configuration) -> Expr:
    """Curvature kap_ab = (x,a . d,b + x,b . d,a) / 2."""
    (g1, g2), (d1, d2) = c.g, c.dd
    return ufl.as_vector(
        [ufl.dot(g1, d1), ufl.dot(g2, d2), 0.5 * (ufl.dot(g1, d2) + ufl.dot(g2, d1))]
    )


def _turning(p, q):
    return turning(ufl.dot(p, q), ufl.dot(q, q))


def curvature_turning(c: Configuration) -> Expr:
    """Curvature from turning angles along both axes and both diagonals."""
    (g1, g2), (d1, d2) = c.g, c.dd
    twist = (_turning(g1 + g2, d1 + d2) - _turning(g1 - g2, d1 - d2)) / 4
    return ufl.as_vector([_turning(g1, d1), _turning(g2, d2), twist])


def curvature_turning_sides(c: Configuration) -> Expr:
    """Curvature from turning angles along the three sides of a triangle."""
    return _from_segments(_turning, c)


def director_strain(c: Configuration) -> Expr:
    """chi_ab = d,a . d,b / 2, the part of the strain quadratic in z."""
    d1, d2 = c.dd
    return 0.5 * ufl.as_vector([ufl.dot(d1, d1), ufl.dot(d2, d2), ufl.dot(d1, d2)])


def shear(c: Configuration) -> Expr:
    """Transverse shear gam_a = x,a . d."""
    return ufl.as_vector([ufl.dot(g, c.d) for g in c.g])


def shear_quad_corner(s: Expr) -> Measure:
    """MITC4 shear at a corner from its two edges' midpoints (s: QUAD_CORNERS)."""
    return lambda c: ufl.as_vector([ufl.dot(c.g[a], c.d + s[a] * c.dd[a]) for a in range(2)])


def shear_triangle_corner(s: Expr) -> Measure:
    """MITC3 shear at a corner from its two edges' midpoints (s: TRIANGLE_CORNERS)."""

    def strain(c):
        (g1, g2), (d1, d2) = c.g, c.dd
        along1, along2 = ufl.dot(g1, c.d + s[0] * d1), ufl.dot(g2, c.d + s[1] * d2)
        # the diagonal from corner 1 to corner 2, midpoint seen from the present corner;
        # |s| - 1/2 vanishes for the edges that do not run along the diagonal
        at1, at2 = -2 * s[0] * (1 - 2 * s[1]), -2 * s[1] * (1 - 2 * s[0])
        middle = c.d + 0.5 * (at1 * (d2 - d1) + at2 * (d1 - d2))
        diagonal = ufl.dot(g2 - g1, middle)
        return ufl.as_vector(
            [
                along1 + at2 * (along2 - diagonal - along1),
                along2 + at1 * (along1 + diagonal - along2),
            ]
        )

    return strain


def shear_cap(mesh: Mesh, shear_over_bending: Constant | float) -> Expr:
    """Factor below one on a shear stiffness in cells larger than the sheet is thick.

    Three edge shears hold a thin triangle too tightly on irregular meshes, and so does the mixed
    product of a 9-node quad. The stiffness S / (1 + S h^2 / (40 D)), h the longest side, keeps the
    shear a constraint that the mesh can resolve (Lyly, Stenberg and Vihinen, Comput. Methods Appl.
    Mech. Engrg. 110, 1993: 0.1 h^2/t^2).

    Parameters
    ----------
    shear_over_bending : S/D [1/m^2]
    """
    G1, G2 = mesh_tangents(mesh)
    longest = ufl.max_value(ufl.dot(G1, G1), ufl.dot(G2, G2))
    if cell_name(mesh) == "triangle":
        longest = ufl.max_value(longest, ufl.dot(G1 - G2, G1 - G2))
    return 1 / (1 + longest * shear_over_bending / 40)
