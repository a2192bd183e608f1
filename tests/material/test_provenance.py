# SPDX-License-Identifier: LGPL-3.0-or-later
"""What of a card is measured and what estimated; presets say it, and so do sheets of them."""

import tomllib
from pathlib import Path

import numpy as np
import pytest

import meshes
from shellform import Shell
from shellform.material.card import CARDS, fabric_from_card, fabric_of
from shellform.material.fabric import FabricError
from shellform.material.prior import SHEAR, bending_prior
from shellform.material.provenance import QUANTITIES, Provenance
from shellform.scene.scene import Scene
from shellform.scene.scene_file import read_scene, write_scene

PRESETS = ("suiting", "field_cloth", "denim", "canvas", "aramid", "knit", "compliant", "stiff")
KES = {
    "tensile_warp_N_per_m": 8100, "tensile_weft_N_per_m": 5000, "shear_N_per_m_per_radian": 54.4,
    "bending_warp_N_m": 1.33e-5, "bending_weft_N_m": 0.9e-5, "areal_mass_kg_per_m2": 0.2635,
    "thickness_m": 0.746e-3,
}  # fmt: skip
MEASURED = {
    "tensile_warp_N_per_m": 8100, "tensile_weft_N_per_m": 5000, "G_N_per_m_per_radian": 54.4,
    "B_warp_uN_m": 13.3, "B_weft_uN_m": 9, "weight_g_per_m2": 120, "thickness_mm": 0.4,
}  # fmt: skip


def card(table=KES, kind="kes", **provenance):
    return {"name": "cloth", kind: table, "provenance": {"source": "a test in May"} | provenance}


def without(table, *names):
    return {k: v for k, v in table.items() if not k.startswith(names)}


def test_all_shipped_cards_are_presets():
    assert {path.stem for path in CARDS.glob("*.toml")} == set(PRESETS)


@pytest.mark.parametrize("name", PRESETS)
def test_presets_say_what_they_are(name):
    """Source and spread of each; none claims a quantity to be measured, and prints say so."""
    known = fabric_of(name).provenance
    assert len(known.source) > 20
    assert known.estimated == QUANTITIES and known.measured == ()
    for quantity in ("bending", "shear"):
        low, high = known.spread[quantity]
        assert low < 1 < high
    assert "estimated, not measured" in fabric_of(name).summary()
    head = Path(CARDS / f"{name}.toml").read_text().split("\n[", 1)[0]
    assert "stimate" in head or "Guess" in head or "guess" in head or "means over" in head


@pytest.mark.parametrize("name", PRESETS)
def test_presets_make_sheets(name):
    fabric = fabric_of(name)
    shell = Shell(meshes.rectangle(0.1, 0.1, (2, 2), warp=(1.0, 0.0, 0.0)), fabric)
    assert shell.plan()["fabric"].startswith(f"{name}: estimated, not measured; ")


def test_measured_and_estimated():
    known = fabric_from_card(card(estimated=["thickness", "friction"])).provenance
    assert known == Provenance("a test in May", ("friction", "thickness"), {})
    assert known.measured == ("tension", "shear", "bending", "mass")
    assert fabric_from_card({"kes": KES}).provenance is None
    assert fabric_from_card({"measured": MEASURED}).provenance.estimated == ()


def test_it_stays_with_the_sheet():
    fabric = fabric_from_card(
        card(estimated="all") | {"law": {"kind": "fung", "stiffening_load_N_per_m": 40}}
    )
    assert fabric.law is not None and fabric.provenance.estimated == QUANTITIES
    assert fabric.with_friction(None).provenance is fabric.provenance


@pytest.mark.parametrize(
    "kind, table", [("kes", KES), ("measured", MEASURED | {"2HB_warp_N": 6e-4})]
)
def test_scene_files_keep_it(tmp_path, kind, table):
    fabric = fabric_from_card(
        card(table, kind, estimated=["bending"], spread={"bending": [0.5, 2.0]})
    )
    write_scene(Scene(fabric), tmp_path / "scene.toml")
    again = read_scene(tmp_path / "scene.toml").cloth
    assert again.provenance == fabric.provenance
    assert np.allclose(again.bending, fabric.bending, rtol=1e-12)


@pytest.mark.parametrize("mass, row", [(0.21, "class"), (0.12, "all"), (0.4, "all")])
def test_missing_bending_is_the_priors(mass, row):
    """Median of the fabrics of that mass; 10 and 90 % of all lie between measured percentiles."""
    low, middle, high = bending_prior(mass, "warp")
    assert middle == pytest.approx({"class": 19.7e-6, "all": 13.8e-6}[row], rel=1e-12)
    if row == "all":
        assert 1.1e-6 < low < 4.1e-6 and 35.9e-6 < high < 110e-6
    table = without(KES, "bending") | {"areal_mass_kg_per_m2": mass}
    fabric = fabric_from_card(card(table, estimated=["bending"]))
    assert fabric.bending[0, 0] == pytest.approx(middle, rel=1e-12)
    assert fabric.bending[1, 1] == pytest.approx(bending_prior(mass, "weft")[1], rel=1e-12)


def test_missing_numbers_of_measured_cards():
    table = without(MEASURED, "B_weft", "G_")
    fabric = fabric_from_card(card(table, "measured", estimated=["bending", "shear"]))
    assert fabric.membrane[2, 2] == SHEAR[1]
    assert fabric.bending[0, 0] == pytest.approx(13.3e-6)  # as given
    assert fabric.bending[1, 1] == pytest.approx(bending_prior(0.12, "weft")[1])


def test_what_is_not_called_an_estimate_is_not_filled_in():
    with pytest.raises(FabricError, match="bending_warp_N_m"):
        fabric_from_card(card(without(KES, "bending"), estimated=["shear"]))
    with pytest.raises(FabricError, match="shear needs one of"):
        fabric_from_card(card(without(MEASURED, "G_"), "measured", estimated=["bending"]))


@pytest.mark.parametrize(
    "text, said",
    [
        ("provenance = 'in May'", "must be a table of keys"),
        ("[provenance]\nsource = ''", "source = ''"),
        ("[provenance]\nestimated = 'all'", "source = None"),
        ("[provenance]\nsource = 'x'\nestimate = 'all'", 'did you mean "estimated"'),
        ("[provenance]\nsource = 'x'\nestimated = ['bend']", 'did you mean "bending"'),
        ("[provenance]\nsource = 'x'\nestimated = 'some'", 'a list of quantities, or "all"'),
        (
            "[provenance]\nsource = 'x'\nspread = {bending = [0.5, 2.0]}",
            "not among those estimated",
        ),
        (
            "[provenance]\nsource = 'x'\nestimated = 'all'\nspread = {bending = [2.0, 0.5]}",
            "two factors",
        ),
        ("[provenance]\nsource = 'x'\nestimated = 'all'\nspread = {bending = 2}", "two factors"),
    ],
)
def test_wrong_tables(text, said):
    with pytest.raises(FabricError, match=r"mine \[provenance\]") as error:
        fabric_from_card({"kes": KES} | tomllib.loads(text), "mine")
    assert said in str(error.value)
    assert str(error.value).count("\n") == 0
