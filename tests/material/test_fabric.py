# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fabric against closed forms: plane stress, laminates, rotation, units, and every refusal."""

import warnings

import numpy as np
import pytest

from shellform.material.card import card_keys, fabric_from_card
from shellform.material.fabric import Fabric, FabricError, Ply, UnitWarning, condense, lamina_matrix
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


# ---- closed forms ---------------------------------------------------------------------------


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


# ---- laminates ------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [1, 2, 5])
def test_equal_plies_are_one_sheet(n):
    stack = Fabric.laminate([(PLY, 3e-3 / n, 0.0)] * n)
    E1, E2, nu12, G12, G13, G23 = (
        getattr(PLY, k) for k in ("E1", "E2", "nu12", "G12", "G13", "G23")
    )
    sheet = Fabric.orthotropic(E1, E2, nu12, G12, G13, G23, 3e-3, PLY.density)
    close(moments(stack), moments(sheet))
    close(stack.shear, sheet.shear)
    assert stack.areal_mass == pytest.approx(4.5) and stack.thickness == pytest.approx(3e-3)


def test_cross_ply_by_hand():
    h = 1e-3  # each of three plies
    f = Fabric.laminate([(PLY, h, 0.0), (PLY, h, 90.0), (PLY, h, 0.0)])
    scale = 1 / (1 - 0.3 * 0.3 * PLY.E2 / PLY.E1)
    Q11, Q22, Q12 = scale * PLY.E1, scale * PLY.E2, scale * 0.3 * PLY.E2
    close(f.membrane[0], [h * (2 * Q11 + Q22), 3 * h * Q12, 0])
    close(f.membrane[1, 1], h * (2 * Q22 + Q11))
    # the middle ply holds 1/27 of t^3/12 = 27 h^3/12, the outer two 26/27
    close(f.bending[0], [h**3 / 12 * (26 * Q11 + Q22), 27 * h**3 / 12 * Q12, 0])
    close(f.bending[1, 1], h**3 / 12 * (26 * Q22 + Q11))
    # int z^4 = 2/5 (t/2)^5: 1/243 of it in the middle
    close(f.fourth_moment[0, 0], h**5 / 80 * (242 * Q11 + Q22))
    close(f.shear, 5 / 6 * h * np.diag([2 * PLY.G13 + PLY.G23, 2 * PLY.G23 + PLY.G13]))
    assert not f.coupling.any() and not f.third_moment.any() and f.directional


def test_unsymmetric_cross_ply_couples():
    h = 1e-3
    f = Fabric.laminate([(PLY, h, 0.0), (PLY, h, 90.0)])
    scale = 1 / (1 - 0.3 * 0.3 * PLY.E2 / PLY.E1)
    B11 = scale * (PLY.E2 - PLY.E1) * h**2 / 2  # the stiff ply lies below: z < 0
    close(f.coupling, np.diag([B11, -B11, 0]))
    close(f.third_moment[0, 0], scale * (PLY.E2 - PLY.E1) * h**4 / 4)
    assert np.linalg.eigvalsh(moments(f) / np.sqrt(np.outer(*[moments(f).diagonal()] * 2)))[0] > 0


def test_thin_skin_on_a_thick_core_keeps_its_digits():
    skin, core = (Ply(E, E, 0.0, E / 2, E / 2, E / 2, 100.0) for E in (1e11, 1e2))
    s, c = 1e-7, 5e-2
    f = Fabric.laminate([(core, c, 0.0), (skin, s, 0.0)])
    # about the middle of the skin, which lies at z = c/2
    D = f.bending[0, 0] - c * f.coupling[0, 0] + c**2 / 4 * f.membrane[0, 0]
    core_alone = 1e2 * (c**3 / 12 + c * (c + s) ** 2 / 4)
    assert D == pytest.approx(core_alone + 1e11 * s**3 / 12, rel=1e-11)


def test_quasi_isotropic_stack_is_directional_in_bending_only():
    f = Fabric.laminate([(PLY, 1e-3, a) for a in (0.0, 60.0, -60.0, -60.0, 60.0, 0.0)])
    close(f.rotated(17.0).membrane, f.membrane)
    assert f.directional and not f.coupling.any()


def test_ply_angle_turns_about_the_director():
    plus = Fabric.laminate([(PLY, 1e-3, 30.0)])
    assert plus.membrane[0, 2] > 0  # pulled along 1, it shears towards its fibres
    close(plus.rotated(30.0).membrane, Fabric.laminate([(PLY, 1e-3, 0.0)]).membrane)


# ---- rotation -------------------------------------------------------------------------------


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


# ---- measured data --------------------------------------------------------------------------


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


# ---- refusals -------------------------------------------------------------------------------

ISO = dict(youngs_modulus=1e6, poisson_ratio=0.3, thickness=1e-3, density=300.0)
SHEET = dict(membrane=np.eye(3), bending=1e-5 * np.eye(3), areal_mass=0.01, thickness=1e-3)


@pytest.mark.parametrize(
    "change, sentence",
    [
        (dict(thickness=0.0), r"thickness = 0 m is not a positive"),
        (dict(thickness=np.nan), r"thickness = nan m is not a positive"),
        (dict(density=-1.0), r"density = -1 kg/m\^3 is not a positive"),
        (dict(youngs_modulus=np.inf), r"youngs_modulus = inf Pa is not"),
        (dict(youngs_modulus="soft"), r"youngs_modulus = 'soft' Pa is not"),
        (dict(poisson_ratio=0.51), r"poisson_ratio = 0.51 is outside -1 < nu <= 0.5"),
        (dict(poisson_ratio=-1.0), r"poisson_ratio = -1 is outside"),
        (dict(shear_correction=0), r"shear_correction = 0"),
        (dict(bending_stiffness=0.0), r"A shell needs some bending stiffness: 1e-7 N m"),
        (dict(bending_stiffness=-1e-6), r"bending has a diagonal \[-1e-06"),
        (dict(bending_stiffness=np.ones(4)), r"not shape \(4,\)"),
    ],
)
def test_isotropic_refuses(change, sentence):
    with pytest.raises(FabricError, match=sentence):
        Fabric.isotropic(**ISO | change)


def test_orthotropic_bound_names_both_ratios():
    with pytest.raises(FabricError, match=r"nu12 = 3 .*nu21 = nu12 E2/E1 = 0.75.*E1/E2 = 4"):
        Fabric.orthotropic(4e6, 1e6, 3.0, 1e5, 1e5, 1e5, 1e-3, 300.0)
    Fabric.orthotropic(4e6, 1e6, 1.9, 1e5, 1e5, 1e5, 1e-3, 300.0)  # nu12 > 1 is legal here
    with pytest.raises(FabricError, match="G13 = 0 Pa"):
        Fabric.orthotropic(4e6, 1e6, 0.3, 1e5, 0.0, 1e5, 1e-3, 300.0)


@pytest.mark.parametrize(
    "change, sentence",
    [
        (dict(areal_mass=0.0), r"areal_mass = 0 kg/m\^2"),
        (dict(membrane=np.eye(2)), r"membrane has shape \(2, 2\), not \(3, 3\)"),
        (dict(membrane=[["a"]]), r"membrane = \[\['a'\]\] is not a matrix of numbers"),
        (dict(bending=np.full((3, 3), np.nan)), r"bending holds a value that is not finite"),
        (dict(membrane=[[2, 1, 0], [0, 2, 0], [0, 0, 1]]), r"not symmetric.* by 1 N/m"),
        (dict(membrane=[[2, 3, 0], [3, 2, 0], [0, 0, 1]]), r"membrane is not pos.*nu12 = 1.5"),
        (dict(bending=np.zeros((3, 3))), r"softer than any cloth"),
        (dict(bending=[[1, 2, 0], [2, 1, 0], [0, 0, 1]]), r"bending is not positive definite"),
        (dict(shear=-np.eye(2)), r"shear has a diagonal \[-1, -1\] N/m"),
        (dict(coupling=np.eye(3)), r"The coupling is too large"),
        (dict(fourth_moment=1e-12 * np.eye(3)), r"they must belong together"),
    ],
)
def test_stiffness_refuses(change, sentence):
    with pytest.raises(FabricError, match=sentence):
        Fabric.from_stiffness(**SHEET | change)


def test_condense_refuses():
    with pytest.raises(FabricError, match=r"shape \(6, 6\)"):
        condense(np.eye(3))
    with pytest.raises(FabricError, match="C33 = 0 Pa"):
        condense(np.diag([1.0, 1, 0, 1, 1, 1]))
    C = np.eye(6)
    C[0, 4] = C[4, 0] = 0.5
    with pytest.raises(FabricError, match="couples in-plane strain with transverse shear"):
        condense(C)


def test_laminate_refuses():
    with pytest.raises(FabricError, match="at least one ply"):
        Fabric.laminate([])
    with pytest.raises(FabricError, match="ply_thickness = -1 m"):
        Fabric.laminate([(PLY, 2.0, 0.0), (PLY, -1.0, 0.0)])


@pytest.mark.parametrize(
    "change, sentence",
    [
        (dict(thickness=0.2), "meant in mm"),
        (dict(density=200e3), r"meant in g/m\^2"),
        (dict(youngs_modulus=0.8), "meant in MPa"),
    ],
)
def test_unit_slips_are_told(change, sentence):
    with pytest.warns(UnitWarning, match=sentence):
        Fabric.isotropic(**ISO | change)


def test_good_values_are_silent_and_read_only():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        f = Fabric.isotropic(**ISO)
    with pytest.raises(ValueError):
        f.membrane[0, 0] = 0.0
    with pytest.raises(AttributeError):
        f.thickness = 1.0
    assert "alike in all directions" in f.summary() and "1 mm" in repr(f)


# ---- cards ----------------------------------------------------------------------------------

CARD = """
name = "suiting"
[kes]
tensile_warp_N_per_m = 8100
tensile_weft_N_per_m = 5000
shear_N_per_m_per_radian = 54.4
bending_warp_N_m = 1.33e-5
bending_weft_N_m = 0.9e-5
areal_mass_kg_per_m2 = 0.2635
thickness_m = 0.746e-3
"""


def write(tmp_path, text):
    path = tmp_path / "cloth.toml"
    path.write_text(text)
    return path


def test_card_is_the_constructor(tmp_path):
    f = Fabric.load(write(tmp_path, CARD))
    close(moments(f), moments(Fabric.from_kes(**SUITING, shear_N_per_m_per_radian=54.4)))
    assert f.name == "suiting"


def test_cards_of_every_kind():
    moduli = dict(E1_Pa=8e6, E2_Pa=5e6, nu12=0.2, G12_Pa=1e5, G13_Pa=2e5, G23_Pa=1.5e5)
    body = dict(density_kg_per_m3=300.0, thickness_m=1e-3)
    one = fabric_from_card({"orthotropic": moduli | body})
    assert fabric_from_card({"ply": [moduli | body | {"angle_degrees": 0}]}).areal_mass == 0.3
    two = fabric_from_card(
        {
            "stiffness": dict(
                membrane_N_per_m=one.membrane.tolist(),
                bending_N_m=one.bending.tolist(),
                shear_N_per_m=one.shear.tolist(),
                areal_mass_kg_per_m2=0.3,
                thickness_m=1e-3,
            )
        }
    )
    close(moments(one), moments(two))
    iso = dict(youngs_modulus_Pa=1e6, poisson_ratio=0.3, bending_stiffness_N_m=1e-5)
    assert fabric_from_card({"isotropic": iso | body}).bending[1, 1] == 1e-5


def test_card_keys_carry_their_units():
    assert list(card_keys(Fabric.from_stiffness)) == [
        "membrane_N_per_m",
        "bending_N_m",
        "areal_mass_kg_per_m2",
        "thickness_m",
        "shear_N_per_m",
        "coupling_N",
        "third_moment_N_m2",
        "fourth_moment_N_m3",
    ]


@pytest.mark.parametrize(
    "old, new, sentence",
    [
        ("thickness_m =", "thickness_mm =", r'cloth.toml \[kes\]: unknown key "thickness_mm"; did'),
        ("thickness_m =", "thickness_mm =", r'did you mean "thickness_m"\?'),
        ("[kes]", "[kws]", r'cloth.toml: unknown key "kws"; did you mean "kes"\?'),
        ("[kes]", "", r'unknown key "tensile_warp_N_per_m"; valid are isotropic'),
        ("thickness_m = 0.746e-3", "", r'cloth.toml \[kes\]: key "thickness_m" is missing'),
        ("0.746e-3", "-1", r"cloth.toml \[kes\]: thickness = -1 m"),
        ("8100", '"stiff"', r"cloth.toml \[kes\]: tensile_warp_N_per_m = 'stiff' N/m"),
        ("0.746e-3", "", r"cloth.toml: not a TOML file"),
        ("[kes]", "[isotropic]\n[kes]", r"needs exactly one table .* has \['isotropic', 'kes'\]"),
        ("[kes]", "[ply]", r"write \[\[ply\]\] above each"),
        ("[kes]", "[[kes]]", r"this must be a table of keys"),
        ("[kes]", "[[ply]]", r'cloth.toml ply 1: unknown key "tensile_warp_N_per_m"'),
    ],
)
def test_card_errors_name_file_and_key(tmp_path, old, new, sentence):
    with pytest.raises(FabricError, match=sentence):
        Fabric.load(write(tmp_path, CARD.replace(old, new, 1)))
