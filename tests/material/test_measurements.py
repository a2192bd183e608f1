# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cards of measured cloth: units, what follows from a test, loops, and what is refused."""

import numpy as np
import pytest
from scipy.integrate import quad, trapezoid

from shellform.material.card import fabric_from_card, read_fabric
from shellform.material.curve import Curve
from shellform.material.energy import check_law
from shellform.material.fabric import FabricError
from shellform.material.friction import ClothFriction, follow
from shellform.material.loops import BENDING, SHEAR, TENSION, decrimping, loop, tension_loop
from shellform.material.measurements import measured_fabric

SUITING = {
    "EMT_warp_percent": 5.0, "LT_warp": 0.6, "EMT_weft_percent": 8.0, "LT_weft": 0.6,
    "G_gf_per_cm_degree": 0.968, "2HG_gf_per_cm": 1.204, "2HG5_gf_per_cm": 2.567,
    "B_warp_gf_cm2_per_cm": 0.1357, "2HB_warp_gf_cm_per_cm": 0.0622,
    "B_weft_gf_cm2_per_cm": 0.09, "weight_mg_per_cm2": 26.35, "thickness_mm": 0.746,
}  # fmt: skip
LOOP = {
    "angle_degrees": [0, 0.5, 2, 5, 8],
    "shear_load_gf_per_cm": [0, 0.9, 2.5, 5.6, 9.0],
    "shear_unload_gf_per_cm": [0, 0.1, 1.0, 3.6, 9.0],
}


def without(*names):
    return {k: v for k, v in SUITING.items() if not k.startswith(names)}


def test_instrument_units():
    """gf is the weight of a gram at 9.80665 m/s2, written out by hand."""
    f = measured_fabric(SUITING)
    assert "law         Measured" in f.summary()
    assert "friction    shear 0.516 N/m, bend warp 0.000305 N" in f.summary()
    assert f.bending[0, 0] == pytest.approx(0.1357 * 9.80665e-3 * 1e-4 / 1e-2, rel=1e-12)
    assert f.areal_mass == pytest.approx(0.2635) and f.thickness == pytest.approx(0.746e-3)
    assert f.friction.bend_warp[0][1] == pytest.approx(0.5 * 0.0622 * 9.80665e-3, rel=1e-12)
    G = 0.968 * 0.980665 * 180 / np.pi
    ((_, m, g),) = f.friction.shear
    assert f.membrane[2, 2] + g == pytest.approx(G, rel=1e-12)
    for angle, half in ((0.5, 0.602), (5.0, 1.2835)):
        assert m + g * np.radians(angle) == pytest.approx(half * 0.980665, rel=1e-12)


@pytest.mark.parametrize("more", [{}, {"RT_warp_percent": 60.0}, {"LT_warp": 0.45}])
def test_fabrics_start_as_their_curves(more):
    """Shells take them: the matrices are the slopes at rest of what the curves store."""
    for table in (SUITING | more, without("G_", "2HG") | LOOP | more):
        fabric = measured_fabric(table)
        check_law(fabric.law, fabric)


def test_si_and_instrument_units_agree():
    si = without("B_", "G_") | {
        "B_warp_uN_m": 13.3076, "B_weft_N_m": 8.826e-6, "G_N_per_m_per_radian": 54.390,
    }  # fmt: skip
    one, two = measured_fabric(SUITING), measured_fabric(si)
    np.testing.assert_allclose(one.bending, two.bending, rtol=1e-4)
    np.testing.assert_allclose(one.membrane, two.membrane, rtol=1e-4)


def test_fast_and_bending_length():
    """B = c^3 w g, G = 123/EB5; three points of the load curve."""
    f = measured_fabric(
        {
            "E5_warp_percent": 0.4, "E20_warp_percent": 1.2, "E100_warp_percent": 3.0,
            "E5_weft_percent": 0.5, "E20_weft_percent": 1.5, "E100_weft_percent": 4.0,
            "EB5_percent": 3.0, "bending_length_warp_mm": 17.2, "bending_length_weft_cm": 1.5,
            "weight_g_per_m2": 263.5, "thickness_mm": 0.7,
        }
    )  # fmt: skip
    assert f.bending[0, 0] == pytest.approx(0.0172**3 * 0.2635 * 9.80665)
    assert f.membrane[2, 2] == pytest.approx(41.0)
    assert f.law.warp(0.03) == pytest.approx(98.0665) and f.friction is None


@pytest.mark.parametrize("LT, RT", [(0.5, 1.0), (0.6, 0.6), (0.8, 0.75)])
def test_work_and_resilience(LT, RT):
    """The work of the curve and its slider up to EMT is LT F EMT/2; RT of it comes back."""
    x, y = decrimping(0.05, LT, 490.0, RT, "warp")
    curve, _, sliders = tension_loop(x, y, RT, "warp")
    e = np.linspace(0, 0.05, 20001)
    both = np.concatenate([e, e[-2::-1]])
    loads = curve(both) + sum(TENSION.lead(s, both) for s in sliders)
    up = trapezoid(loads[: len(e)], e)
    back = trapezoid(loads[len(e) - 1 :][::-1], e)
    assert up == pytest.approx(0.5 * LT * 490.0 * 0.05, rel=0.01)
    assert back / up == pytest.approx(RT, abs=0.01)


def test_loops_come_out_as_they_were_measured():
    """Loading through the points, unloading near them, from curve and sliders alone."""
    f = measured_fabric(without("G_", "2HG") | LOOP)
    x = np.radians(LOOP["angle_degrees"])
    fine = np.unique(np.concatenate([np.linspace(0, x[-1], 500), x]))
    path = np.concatenate([fine, fine[-2::-1]])
    loads = f.law.shear_angle(path) + sum(SHEAR.lead(s, path) for s in f.friction.shear)
    up = np.interp(x, fine, loads[: len(fine)])
    down = np.interp(x, fine, loads[len(fine) - 1 :][::-1])
    unit = 0.980665
    np.testing.assert_allclose(up, np.multiply(LOOP["shear_load_gf_per_cm"], unit), rtol=1e-3)
    np.testing.assert_allclose(
        down, np.multiply(LOOP["shear_unload_gf_per_cm"], unit), atol=0.1 * 2.0 * unit
    )


def test_sliders_are_recovered():
    """A loop made by one slider gives it back: the same yield stress."""
    truth = (6.1e-5, 6.1e-5 * 0.1 * 250, 0.0)
    x = np.linspace(0, 250, 26)
    path = np.concatenate([x, x[-2::-1]])
    loads = 1.3e-5 * path + follow(truth, path)
    _, slope, sliders = loop(x, loads[:26], loads[25:][::-1], BENDING, "bending")
    assert sum(m for _, m, _ in sliders) == pytest.approx(truth[1], rel=0.05)
    assert slope == pytest.approx(1.3e-5, rel=0.05)


def test_curve_is_monotone_and_exact():
    """Through its points, never falling; energy and slope are its integral and derivative."""
    for mirrored in (True, False):
        c = Curve((0, 0.01, 0.03, 0.05, 0.08), (0, 2, 12, 60, 300), mirrored)
        np.testing.assert_allclose(c(np.array(c.x)), c.y, rtol=1e-13)
        x = np.linspace(-0.12, 0.12, 961)
        assert (np.diff(c(x)) > 0).all()
        for at in (-0.1, -0.004, 0.02, 0.0799, 0.11):
            assert c(at, 0) == pytest.approx(quad(c, 0, at, points=[*c.x[1:-1]])[0], rel=1e-9)
            h = 1e-7
            assert c(at, 2) == pytest.approx((c(at + h) - c(at - h)) / (2 * h), rel=1e-5)
        steep = (c(0.08) - c(0.0799)) / 1e-4
        assert c(0.2) == pytest.approx(300 + 0.12 * c(0.08, 2)) and c.steepest >= 0.99 * steep
        assert c(-0.05) == pytest.approx(-60 if mirrored else -0.05 * c.at_rest)


def test_table_files(tmp_path):
    """Columns named as keys; shorter ones end in empty cells."""
    bent = {"curvature_warp_per_cm": [0, 1, 2.5], "moment_warp_gf_cm_per_cm": [0, 0.1, 0.2]}
    columns = LOOP | bent
    rows = [",".join(columns)]
    for k in range(5):
        rows.append(",".join(str(c[k]) if k < len(c) else "" for c in columns.values()))
    (tmp_path / "cloth.csv").write_text("\n".join(rows))
    head = "\n".join(f'"{k}" = {v}' for k, v in without("G_", "2HG", "B_warp", "2HB_warp").items())
    (tmp_path / "cloth.toml").write_text(f'[measured]\nfile = "cloth.csv"\n{head}\n')
    f = read_fabric(tmp_path / "cloth.toml")
    assert f.law.bend_warp.x == (0, 100, 250)
    assert f.law.bend_warp(250.0) == pytest.approx(0.2 * 9.80665e-3)


def test_biaxial_loads():
    """Loads at equal stretch come out, and those of one yarn stay what they are."""
    x = [0, 0.01, 0.02, 0.04]
    table = without("EMT", "LT") | {
        "stretch_warp": x, "load_warp_N_per_m": [0, 5, 20, 120],
        "stretch_weft": x, "load_weft_N_per_m": [0, 4, 12, 60],
        "biaxial_stretch": x, "biaxial_load_warp_N_per_m": [0, 7, 25, 135],
        "biaxial_load_weft_N_per_m": [0, 6, 17, 75],
    }  # fmt: skip
    f = measured_fabric(table)
    assert f.law.coupling.y == pytest.approx([0, 2, 5, 15])
    assert f.membrane[0, 1] == pytest.approx(f.law.coupling.at_rest)
    table["biaxial_load_weft_N_per_m"] = [0, 6, 22, 95]
    with pytest.raises(FabricError, match="what warp and weft gain differs by 20 of 35 N/m, while"):
        measured_fabric(table)


def test_what_is_not_measured_is_not_there():
    """Numbers alone make quadratic cloth, without law and friction."""
    f = measured_fabric(without("LT", "2H"))
    assert f.law is None and f.friction is None


def changed(*leave, **more):
    return without(*leave) | more


BAD = {
    "not closed": (
        changed("G_", "2HG", **LOOP | {"shear_unload_gf_per_cm": [0, 0.1, 1.0, 3.6, 8.0]}),
        r"the loop is not closed at the largest strain, where loading has 8.8.* and unloading 7.8",
    ),
    "unloading above loading": (
        changed("G_", "2HG", **LOOP | {"shear_unload_gf_per_cm": [0, 0.1, 2.6, 3.6, 9.0]}),
        r"at the strain 0.0349.* unloading, 2.5.*, lies above loading, 2.4.*: were the two",
    ),
    "negative slope": (
        changed("G_", "2HG", **LOOP | {"shear_load_gf_per_cm": [0, 0.9, 0.8, 5.6, 9.0]}),
        r"the slope is not positive at point 3, where the load goes from 0.88.* to 0.78.*: end the",
    ),
    "two units": (
        changed(B_warp_uN_m=13.3),
        r'"B_warp_gf_cm2_per_cm" and "B_warp_uN_m" are one quantity in two units: leave one out',
    ),
    "units mixed": (
        changed("B_warp", B_warp_N_m=11.8),
        r"B_warp_N_m = 11.8 lies outside .*: was it meant as B_warp_uN_m or B_warp_gf_cm2_per_cm\?",
    ),
    "a board": (
        changed("B_warp", B_warp_N_m=0.12),
        r"B_warp_N_m = 0.12 lies outside 1e-08 to 0.01, what cloth has: was it meant as B_warp_uN",
    ),
    "no conversion": (
        changed("G_", G_gf_per_cm=0.97),
        r'unknown key "G_gf_per_cm"; write G_N_per_m_per_radian or G_N_per_m_per_degree or G_gf',
    ),
    "bending length": (
        changed(bending_length_warp_mm=30.0),
        r"B = 1.33e-05 N m disagrees with c\^3 w g = 6.98e-05 N m of the bending length 30 mm",
    ),
    "work": (
        changed(WT_warp_gf_cm_per_cm2=3.0),
        r"WT = 2.94 J/m\^2 disagrees with LT EMT F/2 = 7.35 J/m\^2 at F = 490.3 N/m: give F",
    ),
    "2HG5": (changed("2HG5", **{"2HG5_gf_per_cm": 0.5}), r"2HG5 = 0.49 N/m .* is below 2HG = 1.18"),
    "missing": (without("weight"), r"weight is missing, give weight_kg_per_m2 or weight_g_per_m2"),
    "no shear": (without("G_", "2HG"), r"shear needs one of: angle, .*; EB5 .*; there is none"),
    "begins": (
        changed("G_", "2HG", angle_degrees=[1, 2], shear_load_gf_per_cm=[1, 2]),
        r"shear: begins at \(0.0174.*, 0.98.*\), not at \(0, 0\): take the load at rest off",
    ),
    "text": (
        changed("weight", weight_mg_per_cm2="heavy"),
        r"weight_mg_per_cm2 = 'heavy' is not a finite number",
    ),
    "a list": (changed(LT_warp=[0.6]), r"LT_warp = \[0.6\] is not a finite number\."),
    "no list": (
        changed("G_", "2HG", angle_degrees=5, shear_load_gf_per_cm=5.6),
        r"angle_degrees = 5 is not a list of finite numbers\.",
    ),
    "falling back": (
        changed("G_", "2HG", **LOOP | {"shear_unload_gf_per_cm": [0.5, 0.1, 1.0, 3.6, 9.0]}),
        r"shear: the slope of the unloading is negative at point 2, where the load goes from 0.49",
    ),
    "two loops": (
        changed("G_", "2HG5", **LOOP),
        r"shear is given by angle, to which 2HG does not belong: leave it out\.",
    ),
    "crimp of a line": (
        changed("EMT_warp", tensile_warp_N_per_m=8e3),
        r"tension along the warp is given by tensile_warp, to which LT_warp does not belong",
    ),
    "resilience of a line": (
        changed("LT_warp", RT_warp_percent=60),
        r"tension along the warp: RT goes with LT or WT, which are missing",
    ),
    "load of nothing": (
        changed(*(f"{n}_{y}" for n in ("EMT", "LT") for y in ("warp", "weft")),
                tensile_warp_N_per_m=8e3, tensile_weft_N_per_m=5e3, F_N_per_m=490),
        r"F is the load at EMT, which is missing: leave F out\.",
    ),
    "length beside a curve": (
        changed("B_warp", "2HB_warp", bending_length_warp_mm=30, curvature_warp_per_cm=[0, 1, 2.5],
                moment_warp_gf_cm_per_cm=[0, 0.1, 0.2]),
        r"c\^3 w g = 6.98e-05 N m of the bending length lies outside the stiffnesses of the curve, "
        r"6.54e-06 to 9.81e-06 N m: check both",
    ),
    "a stranger": (changed(gf=1.0), r'unknown key "gf"; there are stretch, load, .* with its unit'),
}  # fmt: skip


@pytest.mark.parametrize("what", BAD)
def test_bad_cards(what):
    """One sentence each: file, item, value, mend."""
    table, words = BAD[what]
    with pytest.raises(FabricError, match=rf"^cloth \[measured\].*{words}"):
        fabric_from_card({"measured": table}, "cloth")


def test_sliders_that_are_none_are_refused():
    with pytest.raises(FabricError, match="friction in shear: a stiffness k, a yield stress m and"):
        ClothFriction(shear=[(60.0, -1.0)])


def test_a_straight_line_meets_its_point():
    """EMT alone: the sheet bears 500 gf/cm at that stretch, of the length that it had."""
    fabric = measured_fabric(without("LT", "RT"))
    for axis, stretch in enumerate((0.05, 0.08)):
        strain = stretch + 0.5 * stretch**2
        load = (1.0 + stretch) * fabric.membrane[axis, axis] * strain
        assert load == pytest.approx(490.3325, rel=1e-6)
