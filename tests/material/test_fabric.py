# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fabric against closed forms: plane stress, laminates, rotation, units, and every refusal."""

import numpy as np
import pytest

from shellform.material.fabric import Fabric, FabricError, Ply, condense, lamina_matrix
from shellform.material.laminate import bending_matrix, turn

# E_L, E_T, nu_LT, G_LT of the laminated semi-cylinder (Sze, Liu, Lo 2004, Sec. 3.7), as pascal.
PLY = Ply(2068.5e6, 517.125e6, 0.3, 795.6e6, 795.6e6, 198.9e6, 1500.0)
WARP = dict(E1=8e6, E2=5e6, nu12=0.2, G12=1e5, G13=2e5, G23=1.5e5)
SUITING = dict(
    tensile_warp_N_per_m=8100.0,
    tensile_weft_N_per_m=5000.0,
    bending_warp_N_m=1.33e-5,
    bending_weft_N_m=0.9e-5,
    areal_mass_kg_per_m2=0.2635,
    thickness_m=0.746e-3,
)


def close(a, b, rtol=1e-12):
    np.testing.assert_allclose(a, b, rtol=rtol, atol=rtol * np.max(np.abs(b)))


def moments(fabric):
    """The (9, 9) matrix of the energy on [eps, kap, chi]."""
    A, B, D = fabric.membrane, fabric.coupling, fabric.bending
    E, F = fabric.third_moment, fabric.fourth_moment
    return np.block([[A, B, D], [B, D, E], [D, E, F]])


def test_isotropic_closed_form():
    E, nu, t, rho = 70e9, 0.3, 2e-3, 2700.0
    f = Fabric.isotropic(E, nu, t, rho)
    C = E / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    close(f.membrane, t * C)
    close(f.bending, t**3 / 12 * C)
    close(f.fourth_moment, t**5 / 80 * C)
    close(f.shear, 5 / 6 * t * E / (2 * (1 + nu)) * np.eye(2))
    assert not f.coupling.any() and not f.third_moment.any()
    assert f.areal_mass == pytest.approx(5.4) and not f.directional
    assert f.equivalent_thickness == pytest.approx(t, rel=1e-12)


def test_isotropic_with_its_own_bending_stays_isotropic():
    f = Fabric.isotropic(1e6, 0.3, 0.5e-3, 400.0, bending_stiffness=1e-5)
    assert f.bending[0, 0] == 1e-5 and not f.directional
    close(f.bending[2, 2], 0.35e-5)
    assert f.bending_length() == pytest.approx((1e-5 / (0.2 * 9.81)) ** (1 / 3))


def test_condensing_the_solid_gives_plane_stress():
    E1, E2, E3, G12, G13, G23 = 8e9, 2e9, 1e9, 0.9e9, 0.7e9, 0.4e9
    nu12, nu13, nu23 = 0.35, 0.25, 0.4
    S = np.diag([1 / E1, 1 / E2, 1 / E3, 1 / G23, 1 / G13, 1 / G12])
    S[0, 1] = S[1, 0] = -nu12 / E1
    S[0, 2] = S[2, 0] = -nu13 / E1
    S[1, 2] = S[2, 1] = -nu23 / E2
    Q, G = condense(np.linalg.inv(S))
    close(Q, lamina_matrix(E1, E2, nu12, G12))
    close(G, np.diag([G13, G23]))
    a = Fabric.homogeneous(Q, G, 1e-3, 1000.0)
    b = Fabric.orthotropic(E1, E2, nu12, G12, G13, G23, 1e-3, 1000.0)
    close(moments(a), moments(b))


def test_condensed_stress_is_that_of_the_solid_with_free_faces():
    rng = np.random.default_rng(3)
    M = rng.normal(size=(6, 6))
    C = M @ M.T + 6 * np.eye(6)
    C[np.ix_([0, 1, 2, 5], [3, 4])] = 0  # symmetric about the mid-surface
    C[np.ix_([3, 4], [0, 1, 2, 5])] = 0
    Q, _ = condense(C)
    strain = rng.normal(size=3)
    full = np.array([strain[0], strain[1], 0, 0, 0, strain[2]])
    full[2] = -C[2] @ full / C[2, 2]
    stress = C @ full
    assert abs(stress[2]) < 1e-12
    close(Q @ strain, stress[[0, 1, 5]])


def test_bending_matrix_takes_one_two_three_or_all_values():
    close(bending_matrix(2.0, 0.5), [[2, 1, 0], [1, 2, 0], [0, 0, 0.5]])
    close(bending_matrix((1.0, 4.0), 0.25), [[1, 0.5, 0], [0.5, 4, 0], [0, 0, 0.75]])
    close(bending_matrix((1.0, 4.0, 7.0)), np.diag([1.0, 4.0, 7.0]))
    close(bending_matrix(np.eye(3)), np.eye(3))


def test_rotation_keeps_invariants_and_returns_after_a_turn():
    f = Fabric.orthotropic(**WARP, thickness=1e-3, density=300.0)

    def invariants(g):
        A = g.membrane
        return [
            A[0, 0] + A[1, 1] + 2 * A[0, 1],
            A[2, 2] - A[0, 1],
            np.trace(g.shear),
            np.linalg.det(A),
        ]

    for angle in (10.0, 45.0, 77.0):
        close(invariants(f.rotated(angle)), invariants(f))
    g = f
    for _ in range(12):
        g = g.rotated(30.0)
    close(moments(g), moments(f), 1e-11)
    close(np.diag(f.rotated(90.0).membrane), f.membrane.diagonal()[[1, 0, 2]])


def test_energy_does_not_depend_on_the_axes():
    f = Fabric.from_kes(**SUITING, shear_N_per_m_per_radian=54.4)
    strain = np.array([[0.02, 0.007], [0.007, -0.01]])
    c, s = np.cos(0.4), np.sin(0.4)
    R = np.array([[c, s], [-s, c]])
    turned = R @ strain @ R.T

    def energy(A, e):
        v = np.array([e[0, 0], e[1, 1], 2 * e[0, 1]])
        return v @ A @ v

    assert energy(f.rotated(np.degrees(0.4)).membrane, turned) == pytest.approx(
        energy(f.membrane, strain), rel=1e-12
    )
    close(turn(turn(f.shear, 20.0), -20.0), f.shear)


@pytest.mark.parametrize(
    "fabric",
    [
        Fabric.isotropic(1e9, 0.5, 1e-2, 1000.0),
        Fabric.orthotropic(**WARP, thickness=1e-3, density=300.0, bending_stiffness=(1e-5, 2e-6)),
        Fabric.from_kes(**SUITING, shear_N_per_m_per_degree=0.95),
        Fabric.laminate([(PLY, 1e-3, 0.0), (PLY, 2e-3, 35.0)]),
        Fabric.from_stiffness(
            1e4 * np.eye(3), 1e-5 * np.eye(3), 0.2, 1e-3, coupling=0.3 * np.eye(3)
        ),
    ],
    ids=lambda f: f.name,
)
def test_energy_is_positive_for_any_strain(fabric):
    # a strain of order 1 times (1, 1/t, 1/t^2), so that every moment counts
    rng = np.random.default_rng(1)
    scale = np.repeat(float(fabric.thickness) ** -np.arange(3), 3)
    for strain in rng.normal(size=(200, 9)) * scale:
        assert strain @ moments(fabric) @ strain > 0
    assert (np.linalg.eigvalsh(fabric.shear) > 0).all()


def test_kes_shear_in_degrees_and_in_radians():
    gf_per_cm = 0.00980665 / 0.01  # N/m
    a = Fabric.from_kes(**SUITING, shear_N_per_m_per_degree=0.968 * gf_per_cm)
    b = Fabric.from_kes(**SUITING, shear_N_per_m_per_radian=0.968 * 56.188)
    assert a.membrane[2, 2] == pytest.approx(54.39, abs=0.01)
    close(a.membrane, b.membrane, 1e-5)
    close(a.membrane.diagonal()[:2], [8100.0, 5000.0])  # no contraction unless measured
    close(a.bending.diagonal(), [1.33e-5, 0.9e-5, 0.5 * np.sqrt(1.33e-5 * 0.9e-5)])
    assert a.directional


def test_kes_bending_unit():
    assert 1e-3 * 9.80665 * 1e-4 / 1e-2 == pytest.approx(9.80665e-5)  # gf cm^2/cm in N m


@pytest.mark.parametrize("shear", [{}, dict.fromkeys(("degree", "radian"), 1.0)])
def test_kes_wants_exactly_one_shear(shear):
    with pytest.raises(FabricError, match="exactly one of shear_N_per_m_per_degree"):
        Fabric.from_kes(**SUITING, **{f"shear_N_per_m_per_{k}": v for k, v in shear.items()})


def test_default_transverse_shear_does_not_soften_bending():
    for G in (1e-3, 54.0, 1e4):
        f = Fabric.from_kes(**SUITING, shear_N_per_m_per_radian=G)
        D, S = f.bending.diagonal()[:2], f.shear.diagonal()
        assert (np.sqrt(D / S) < 0.5 * f.thickness).all() and (S >= 5 / 6 * G).all()


def test_default_fourth_moment_is_exact_for_a_homogeneous_sheet():
    f = Fabric.orthotropic(**WARP, thickness=4e-3, density=300.0)
    again = Fabric.from_stiffness(f.membrane, f.bending, f.areal_mass, f.thickness, f.shear)
    close(again.fourth_moment, (4e-3) ** 5 / 80 * lamina_matrix(8e6, 5e6, 0.2, 1e5))
