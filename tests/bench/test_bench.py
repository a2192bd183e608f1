# SPDX-License-Identifier: LGPL-3.0-or-later
"""The whole bench: results, bands, files, the command, and that nothing else is computed."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from shellform import Fabric, fabric_tests
from shellform.__main__ import TESTS as OFFERED
from shellform.__main__ import main
from shellform.bench import inputs
from shellform.bench.run import TESTS, summary_lines
from shellform.material.card import fabric_from_card, fabric_of
from shellform.material.friction import ClothFriction
from shellform.material.measurements import measured_fabric
from shellform.material.prior import bending_prior
from tests.bench.test_cycles import BENT, SHEARED
from tests.material.test_measurements import SUITING
from tests.material.test_provenance import KES, without

pytestmark = pytest.mark.serial  # specimens of a few cells

ROOT = Path(__file__).resolve().parents[2]
HALF_KNOWN = {
    "name": "half",
    "kes": without(KES, "bending"),
    "provenance": {"source": "a test in May", "estimated": ["bending"]},
}


def test_the_command_offers_all_tests():
    assert OFFERED == TESTS


@pytest.mark.thorough
def test_bands_of_what_is_not_measured():
    """Bending of the prior: its 10 and 90 % give c by the cube root; shear is measured, no band."""
    fabric = fabric_from_card(HALF_KNOWN)
    results = fabric_tests(fabric, ["hang"])
    band = results["bands"]
    assert list(band) == ["bending"]
    low, middle, high = bending_prior(fabric.areal_mass, "warp")
    assert band["bending"]["factors"] == pytest.approx((low / middle, high / middle))
    lengths = [one["warp"] for one in band["bending"]["bending_length"]]
    assert lengths == pytest.approx(
        np.cbrt(np.array([low, middle, high]) / (fabric.areal_mass * 9.80665)), rel=2e-3
    )
    said = "\n".join(summary_lines(fabric, results))
    assert "half: estimated: bending; measured: tension, shear" in said
    assert "bending is estimated; 8 of 10" in said and "bending length: warp" in said
    assert "bands" not in fabric_tests(fabric, ["shear"])
    assert "bands" not in fabric_tests(fabric, ["hang"], bands=False)


def test_spreads_of_a_card_go_before_the_prior():
    assert inputs.spreads(fabric_of("denim")) == {"bending": (0.3, 2.5), "shear": (0.35, 2.0)}
    assert inputs.spreads(Fabric.isotropic(1e6, 0.3, 1e-3, 400.0)) == {}
    assert inputs.spreads(measured_fabric(SUITING)) == {}


@pytest.mark.parametrize("quantity", ["bending", "shear"])
def test_scaled_cloth(quantity):
    """Curve, slope at rest and friction of one strain by the factor, and nothing else."""
    table = without(SUITING, "G_", "2HG", "B_weft") | SHEARED | BENT
    friction = ClothFriction(shear=[(60.0, 0.5)], bend_warp=[(6e-5, 3e-4)])
    fabric = measured_fabric(table).with_friction(friction)
    more = inputs.scaled(fabric, quantity, 3.0)
    bends = quantity == "bending"
    D, A = np.array(fabric.bending), np.array(fabric.membrane)
    D *= 3.0 if bends else 1.0
    A[2, 2] *= 1.0 if bends else 3.0
    assert np.allclose(more.bending, D) and np.allclose(more.membrane, A)
    for name, factor in (("bend_weft", 3.0 if bends else 1.0), ("shear_angle", 1 if bends else 3)):
        curve, before = getattr(more.law, name), getattr(fabric.law, name)
        assert curve(0.05) == pytest.approx(factor * before(0.05))
    for name, factor in (("bend_warp", 3.0 if bends else 1.0), ("shear", 1.0 if bends else 3.0)):
        sliders, before = getattr(more.friction, name), getattr(fabric.friction, name)
        assert len(before) and np.allclose(sliders, factor * np.array(before))
    assert more.law.warp == fabric.law.warp


def test_what_a_card_leaves_open():
    taken = " ".join(inputs.taken(measured_fabric(SUITING)))
    assert "curve of tension" in taken and "bending, 5 per metre" in taken and "Huber" in taken
    full = without(SUITING, "LT", "2H") | {"B_twist_uN_m": 5.0, "2HB_weft_N": 4e-4}
    assert "curve of tension" not in " ".join(inputs.taken(measured_fabric(full)))


@pytest.mark.parametrize("wrong, said", [
    ({"only": ["stretch"]}, "no test 'stretch' of fabrics: pull, shear"),
    ({"starts": 0}, "starts = 0"),
    ({"fabric": "silk"}, "no fabric 'silk'"),
])  # fmt: skip
def test_wrong_calls(wrong, said):
    with pytest.raises(ValueError, match=said):
        fabric_tests(**({"fabric": "denim"} | wrong))


@pytest.mark.serial
def test_the_command(tmp_path, capsys):
    """Lines, summary.json and a picture of a card that is an estimate."""
    main(["fabric", "knit", "--only", "shear", "bend", "--out", str(tmp_path)])
    said = capsys.readouterr().out
    assert said.startswith("knit: estimated, not measured; ")
    assert "from the card" in said and f"wrote {tmp_path}/summary.json, fabric.png" in said
    summary = json.loads((tmp_path / "summary.json").read_text())
    results = summary["results"]
    assert summary["scene"] == "fabric" and summary["settings"]["only"] == ["shear", "bend"]
    assert "estimated, not measured" in summary["plan"]["fabric"]
    assert set(results["estimated"]) == {
        "tension", "shear", "bending", "friction", "mass", "thickness"
    }  # fmt: skip
    assert results["bend"]["weft"]["largest_error"] < 1e-3
    assert "drape_coefficient" not in results and "hang" not in results
    assert (tmp_path / "fabric.png").read_bytes()[:4] == b"\x89PNG"
    assert not list(tmp_path.glob("*.part"))


@pytest.mark.serial
def test_only_what_is_asked_for():
    """A pull loads no explicit steps and no picture; a scene loads no bench."""
    code = (
        "import sys, shellform as sf; sf.fabric_tests('compliant', ['shear']);"
        "print([m for m in ('shellform.dynamics.explicit', 'shellform.bench.drape',"
        " 'shellform.bench.loop', 'matplotlib') if m in sys.modules])"
    )
    run = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=300
    )
    assert run.stdout.split("\n")[-2] == "[]", run.stderr
    code = (
        "import sys; from shellform.scene.scene import Scene; import shellform.simulation.run;"
        "print([m for m in sys.modules if m.startswith('shellform.bench')])"
    )
    run = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=300
    )
    assert run.stdout.split("\n")[-2] == "[]", run.stderr


def test_several_drapes(monkeypatch):
    """Mean and scatter of starts, and the bands of the rest, of drapes that cost nothing here."""
    from shellform.bench import drape as specimen

    def fall(fabric, start=0):
        part = min(1.0, 0.5 * fabric.bending[0, 0] / 6e-5 + 0.01 * start)
        return specimen.Drape(part, 6 + start, np.full(8, 0.1), 1.0, start < 2, None, None)

    monkeypatch.setattr(specimen, "drape", fall)
    results = fabric_tests("denim", ["drape"], starts=3)
    assert results["drape_coefficient"] == pytest.approx(51.0)
    assert results["drape_coefficient_sd"] == pytest.approx(1.0)
    assert results["folds"] == pytest.approx(7.0)
    assert results["bands"]["bending"]["drape_coefficient"] == pytest.approx([15.0, 51.0, 100.0])
    assert results["bands"]["shear"]["drape_coefficient"] == pytest.approx([50.0, 51.0, 50.0])
    said = "\n".join(summary_lines(fabric_of("denim"), results))
    assert "drape coefficient 51.0 % +- 1.0 from start to start, 7 folds" in said
    assert "it still moved at the end" in said
