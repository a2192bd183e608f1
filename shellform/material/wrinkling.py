# SPDX-License-Identifier: LGPL-3.0-or-later
"""A membrane that wrinkles below the size of its cells: relaxed energy, stress and tangent.

A cell cannot show wrinkles smaller than itself, and answers compression with stiffness that cloth
does not have. The relaxed energy per area lets it shorten by wrinkles,

    psi_r(E) = min over W of  psi(E + W) + N_c tr W,    W symmetric, no eigenvalue negative,

E = (E11, E22, 2 E12) the strain of the mid-surface, W what wrinkles take up, N_c [N/m] the
compression at which the sheet gives way (Pipkin, IMA J. Appl. Math. 36, 1986; Steigmann, Proc. R.
Soc. A 429, 1990: N_c = 0). For psi = E.A.E/2 the problem with N_c is that without at the strain
e = E + N_c A^-1 (1, 1, 0), and its stress N + N_c (1, 1, 0) is

    taut      A e, where that has no negative eigenvalue
    wrinkled  (v.e)/(v.A^-1 v) v, v = (c^2, s^2, c s), in the direction that maximises the energy
              (v.e)_+^2 / (2 v.A^-1 v)
    slack     0, where v.e is negative in all directions.

Cloth, soft in shear and stiff along its yarns, has several maxima: the best of many angles is
refined. They lie closest about the yarns, where peaks are as narrow as sqrt(G/E). Where nearly all
is slack no trial may have any tension: directions about that of the largest e are tried, too.

N_c of an inextensible sine of wave number q, held in the plane by a bed of k [Pa/m] on both sides,
is D q^2 + k/q^2; waves are no shorter than two cells as long as cells show them:

    N_c = min over q >= pi/h of (D q^2 + k/q^2)      `wrinkling_load`
"""

import numpy as np

TAUT, WRINKLED, SLACK = 0, 1, 2


def wrinkling_load(
    bending: float, cell_size: np.ndarray, bed_stiffness: np.ndarray | float = 0.0
) -> np.ndarray:
    """N_c [N/m] of cells of a size [m] between beds of a stiffness [Pa/m].

    Parameters
    ----------
    bending : D [N m]; cell_size : (m,); bed_stiffness : (m,) or number, 0 in the open, finite
    """
    shortest = (np.pi / np.asarray(cell_size, float)) ** 2
    squared = np.maximum(np.sqrt(np.asarray(bed_stiffness, float) / bending), shortest)
    return bending * squared + bed_stiffness / squared


def trial_angles(membrane: np.ndarray) -> np.ndarray:
    """Angles (k,) [rad] from the warp at which the search of a wrinkle's direction starts.

    Parameters
    ----------
    membrane : (3, 3), stiffness A [N/m]
    """
    compliance = np.linalg.inv(membrane)
    width = np.sqrt(min(compliance[0, 0], compliance[1, 1]) / compliance[2, 2])
    away = np.geomspace(min(0.4 * width, 0.15), np.pi / 4, 14)
    about = np.concatenate([-away[:0:-1], [-away[0], 0.0], away])
    return np.unique(np.concatenate([about[:-1], about[:-1] + np.pi / 2]))
