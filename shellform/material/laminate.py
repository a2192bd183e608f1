# SPDX-License-Identifier: LGPL-3.0-or-later
"""From elastic moduli to stiffness through the thickness (Eq. 12 with S33 = 0).

The St. Venant-Kirchhoff law S = C E is written in the lamina axes: 1 along the warp, 2 along the
weft, 3 along the director.  The thickness stress is condensed in the reference configuration,
S33 = 0 (Sec. 3.1.2), which leaves a 3x3 matrix for the strains [E11, E22, 2 E12] and a 2x2 matrix
for the transverse shears [2 E13, 2 E23].  A layered sheet is integrated exactly through its
thickness, ply by ply.  Everything here is a pure function of its arguments; SI units.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from reprlib import repr as brief

import numpy as np
from numpy.typing import ArrayLike

SHEAR_CORRECTION = 5.0 / 6.0  # parabolic shear stress over a rectangular section
RANGE = (1e-40, 1e40)  # cubes of a thickness and products of stiffnesses stay numbers


class FabricError(ValueError):
    """A material that no sheet can have, or a card that cannot be read.

    Examples
    --------
    >>> import shellform as sf
    >>> try:
    ...     sf.Fabric.isotropic(1e6, 0.7, 1e-3, 400.0)
    ... except sf.FabricError as error:
    ...     print(error)
    poisson_ratio = 0.7 is outside -1 < nu <= 0.5 of a solid material.
    """


def positive(unit: str, **values: float) -> None:
    """Raise FabricError for the first of the named values that is not a finite number above 0.

    Numbers whose cubes and products doubles cannot hold (beyond `RANGE`) are none of any sheet.
    """
    for name, value in values.items():
        try:
            good = np.ndim(value) == 0 and np.isfinite(value) and value > 0.0
        except TypeError:
            good = False
        if not good or isinstance(value, bool):
            # 1000-digit integers are no floats
            whole = isinstance(value, int) and not isinstance(value, bool) and abs(value) < 1e300
            shown = f"{value:g}" if whole or isinstance(value, float) else brief(value)
            raise FabricError(f"{name} = {shown} {unit} is not a positive finite number.")
        if not RANGE[0] <= value <= RANGE[1]:
            raise FabricError(
                f"{name} = {value:g} {unit} is out of the range of numbers, {RANGE[0]:g} to "
                f"{RANGE[1]:g}: check its unit."
            )


def symmetric(name: str, value: ArrayLike, size: int, unit: str) -> np.ndarray:
    """Read-only copy of a finite symmetric matrix (size, size); FabricError when it is not one."""
    try:
        matrix = np.array(value, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise FabricError(f"{name} = {brief(value)} is not a matrix of numbers.") from None
    if matrix.shape != (size, size):
        raise FabricError(f"{name} has shape {matrix.shape}, not ({size}, {size}).")
    # beyond 1e30 products overflow, and no cloth is stiffer than 1e12
    if not (np.abs(matrix) < 1e30).all():
        raise FabricError(
            f"{name} holds a value that is not finite or beyond 1e30: {matrix.tolist()} {unit}."
        )
    gap = abs(matrix - matrix.T).max()
    if gap > 1e-9 * abs(matrix).max():
        raise FabricError(f"{name} is not symmetric: mirrored entries differ by {gap:g} {unit}.")
    matrix = 0.5 * (matrix + matrix.T)
    matrix.setflags(write=False)
    return matrix


def check_definite(name: str, matrix: np.ndarray, unit: str, hint: str = "") -> None:
    """Raise FabricError unless the matrix is positive definite, whatever the units of its rows."""
    diagonal = np.diag(matrix)
    if not (diagonal > 0.0).all():
        shown = ", ".join(f"{value:g}" for value in diagonal)
        raise FabricError(f"{name} has a diagonal [{shown}] {unit} that is not all positive.{hint}")
    scale = np.sqrt(diagonal)
    lowest = np.linalg.eigvalsh(matrix / np.outer(scale, scale))[0]
    if lowest < 1e-12:  # above roundoff; steel foil on the softest foam stays above it
        raise FabricError(
            f"{name} is not positive definite: with its diagonal scaled to 1 the lowest "
            f"eigenvalue is {lowest:.3g}.{hint}"
        )


def lamina_matrix(E1: float, E2: float, nu12: float, G12: float, unit: str = "Pa") -> np.ndarray:
    """Plane-stress stiffness of an orthotropic lamina.

    Parameters
    ----------
    E1, E2, G12 : Young's moduli along warp and weft, in-plane shear modulus [Pa] (or, for a sheet,
        the same times thickness [N/m]; then say so with `unit`, which only enters messages).
    nu12 : contraction along 2 when pulled along 1; nu21 = nu12 E2 / E1 follows by symmetry.

    Returns
    -------
    Q : (3, 3) float, [unit], acting on [E11, E22, 2 E12].

    Raises
    ------
    FabricError : a modulus is not positive, or nu12^2 < E1 / E2 is broken.
    """
    positive(unit, E1=E1, E2=E2, G12=G12)
    nu21 = nu12 * E2 / E1
    if not abs(nu12 * nu21) < 1.0:  # also catches nan
        raise FabricError(
            f"nu12 = {nu12:g} (so nu21 = nu12 E2/E1 = {nu21:g}) breaks nu12^2 < E1/E2 = "
            f"{E1 / E2:g} for E1 = {E1:g} {unit}, E2 = {E2:g} {unit}: "
            "the membrane stiffness would not be positive definite."
        )
    scale = 1.0 / (1.0 - nu12 * nu21)
    return np.array(
        [[scale * E1, scale * nu21 * E1, 0.0], [scale * nu12 * E2, scale * E2, 0.0], [0, 0, G12]]
    )


def condense(C6: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Condense S33 = 0 out of a three-dimensional stiffness (Eq. 12).

    Parameters
    ----------
    C6 : (6, 6) float [Pa], symmetric, order [11, 22, 33, 23, 13, 12], engineering shears.

    Returns
    -------
    Q : (3, 3) float [Pa] on [E11, E22, 2 E12];  G : (2, 2) float [Pa] on [2 E13, 2 E23].

    Raises
    ------
    FabricError : wrong shape, no stiffness through the thickness, or a material that is not
        symmetric about its mid-surface, so that bending would come with transverse shear.
    """
    C6 = np.asarray(C6, dtype=float)
    if C6.shape != (6, 6):
        raise FabricError(f"A solid's stiffness has shape (6, 6), not {C6.shape}.")
    positive("Pa", C33=C6[2, 2])
    keep = [0, 1, 5, 4, 3]  # 11, 22, 12, then 13, 23
    K = C6[np.ix_(keep, keep)] - np.outer(C6[keep, 2], C6[2, keep]) / C6[2, 2]
    if abs(K[:3, 3:]).max() > 1e-9 * abs(K).max():
        raise FabricError(
            f"The stiffness couples in-plane strain with transverse shear (up to "
            f"{abs(K[:3, 3:]).max():g} Pa): turn it so that axis 3 is a plane normal of symmetry."
        )
    return K[:3, :3].copy(), K[3:, 3:].copy()


def turn(stiffness: np.ndarray, degrees: float) -> np.ndarray:
    """Stiffness of a material lying at an angle.

    Parameters
    ----------
    stiffness : (3, 3) on [E11, E22, 2 E12] or (2, 2) on [2 E13, 2 E23], in the material's axes.
    degrees : from axis 1 to the material's own axis 1, positive about the director.

    Returns
    -------
    The same matrix in the axes, same shape and unit.
    """
    # 15 decimals: a ply at 90 degrees must not leave 1e-17 of coupling behind.
    c, s = np.round([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))], 15)
    if len(stiffness) == 2:
        T = np.array([[c, s], [-s, c]])
    else:
        T = np.array(
            [[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]]
        )
    return T.T @ stiffness @ T


def bending_matrix(stiffness: ArrayLike, poisson_ratio: float = 0.0) -> np.ndarray:
    """Bending stiffness matrix from the few values that are measured.

    Parameters
    ----------
    stiffness : one number D1 = D2, or (D1, D2), or (D1, D2, D66), or the whole (3, 3); [N m].
        D1 and D2 are moment per width over curvature with the other curvature held at zero.
    poisson_ratio : sqrt(nu12 nu21), used for D12 = poisson_ratio sqrt(D1 D2).

    Returns
    -------
    D : (3, 3) float [N m].  A missing twisting stiffness is Huber's estimate
    D66 = (1 - poisson_ratio) / 2 sqrt(D1 D2), exact for an isotropic sheet.
    """
    given = np.asarray(stiffness, dtype=float)
    if given.shape == (3, 3):
        return given
    if given.ndim > 1 or given.size not in (1, 2, 3):
        raise FabricError(
            "bending stiffness takes D, (D1, D2), (D1, D2, D66) or a (3, 3) matrix in N m, "
            f"not shape {given.shape}."
        )
    d1, d2, *twist = np.resize(given, 2) if given.size == 1 else given
    mean = np.sqrt(d1 * d2) if d1 > 0.0 and d2 > 0.0 else 0.0  # refused later, with its message
    d12, d66 = poisson_ratio * mean, (twist[0] if twist else 0.5 * (1.0 - poisson_ratio) * mean)
    return np.array([[d1, d12, 0.0], [d12, d2, 0.0], [0.0, 0.0, d66]])


@dataclass(frozen=True)
class Ply:
    """Material of one ply: moduli [Pa] in its own axes (1 along its fibres), density [kg/m^3].

    Examples
    --------
    >>> import shellform as sf
    >>> ply = sf.Ply(E1=3e8, E2=1e7, nu12=0.3, G12=8e6, G13=6e6, G23=5e6, density=300.0)
    >>> fabric = sf.Fabric.laminate([(ply, 2e-4, 0.0), (ply, 2e-4, 90.0)])
    >>> print(f"{1e3 * fabric.thickness:.1f} mm")
    0.4 mm
    """

    E1: float
    E2: float
    nu12: float
    G12: float
    G13: float
    G23: float
    density: float


def through_thickness(
    plies: Sequence[tuple[Ply, float, float]], shear_correction: float = SHEAR_CORRECTION
) -> dict:
    """Integrate plies over z, exactly, about the middle of the stack.

    Parameters
    ----------
    plies : (ply, thickness [m], angle [degrees]) from the bottom (z = -t/2) to the top; the angle
        runs from the warp direction, positive about the director.
    shear_correction : factor on the summed transverse shear stiffness.

    Returns
    -------
    Keyword arguments of Fabric: stiffness moments of order 0 to 4, shear, areal mass, thickness.
    """
    if not plies:
        raise FabricError("A laminate needs at least one ply.")
    z = -0.5 * sum(thickness for _, thickness, _ in plies)
    total, mass = -2.0 * z, 0.0
    moments, shear = np.zeros((5, 3, 3)), np.zeros((2, 2))
    for ply, thickness, angle in plies:
        positive("m", ply_thickness=thickness)
        positive("kg/m^3", ply_density=ply.density)
        positive("Pa", G13=ply.G13, G23=ply.G23)
        Q = turn(lamina_matrix(ply.E1, ply.E2, ply.nu12, ply.G12), angle)
        # integrals of z^k over the ply, about its middle m: differences of powers would cancel
        m, hh = z + 0.5 * thickness, thickness**2
        powers = 1.0, m, m**2 + hh / 12, m**3 + m * hh / 4, m**4 + m**2 * hh / 2 + hh**2 / 80
        moments += np.multiply.outer(np.array(powers) * thickness, Q)
        shear += shear_correction * thickness * turn(np.diag([ply.G13, ply.G23]), angle)
        mass += ply.density * thickness
        z += thickness
    for k in (1, 3):  # a symmetric stack has no coupling: drop what roundoff leaves of it
        if abs(moments[k]).max() < 1e-12 * abs(moments[0]).max() * total**k:
            moments[k] = 0.0
    names = ("membrane", "coupling", "bending", "third_moment", "fourth_moment")
    return dict(zip(names, moments, strict=True)) | {
        "shear": shear,
        "areal_mass": mass,
        "thickness": total,
    }
