# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fabric cards: the keys with their units, and what is wrong with a card."""

import pytest

from shellform.material.card import card_keys, fabric_from_card, read_fabric
from shellform.material.fabric import Fabric, FabricError
from tests.material.test_fabric import SUITING, close, moments

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
    f = read_fabric(write(tmp_path, CARD))
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
        (
            "1.33e-5",
            "0.12",
            r"bending_warp = 0.12 N m lies outside 1e-08 to 0.01 N m of cloth: num",
        ),
        ("warp_N_m", "warp_gf_cm2_per_cm", r"numbers in gf go into a table \[measured\]"),
        ("[kes]", "[kws]", r'cloth.toml: unknown key "kws"; did you mean "kes"\?'),
        ("[kes]", "", r'unknown key "tensile_warp_N_per_m"; valid are isotropic'),
        ("thickness_m = 0.746e-3", "", r'cloth.toml \[kes\]: key "thickness_m" is missing'),
        ("0.746e-3", "-1", r"cloth.toml \[kes\]: thickness = -1 m"),
        ("8100", "true", r"cloth.toml \[kes\]: tensile_warp_N_per_m = True N/m is not a pos"),
        ("8100", '"stiff"', r"cloth.toml \[kes\]: tensile_warp_N_per_m = 'stiff' N/m"),
        ("0.746e-3", "", r"cloth.toml: not a TOML file"),
        ("[kes]", "[isotropic]\n[kes]", r"needs exactly one table .* has \['isotropic', 'kes'\]"),
        ("[kes]", "[measured]\n[kes]", r"needs exactly one table .* has \['measured', 'kes'\]"),
        ("[kes]", "[ply]", r"write \[\[ply\]\] above each"),
        ("[kes]", "[[kes]]", r"this must be a table of keys"),
        ("[kes]", "[[ply]]", r'cloth.toml ply 1: unknown key "tensile_warp_N_per_m"'),
    ],
)
def test_card_errors_name_file_and_key(tmp_path, old, new, sentence):
    with pytest.raises(FabricError, match=sentence):
        read_fabric(write(tmp_path, CARD.replace(old, new, 1)))
