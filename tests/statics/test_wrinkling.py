# SPDX-License-Identifier: LGPL-3.0-or-later
"""A relaxed sheet against exact tension fields: bent strip, sheared strip, disc turned at its hub.

N_c is the compression wrinkles bear, 0 or a share of what the sheet would have without them. The
exact solutions are themselves held against others: closed forms against rings, rings against the
brute force of test_relaxed_stress.py's law.
"""

import numpy as np
import pytest

from demos.studies.wrinkles import beds, exact, fading, flat

MESHES = {"bent": (10, 20, 40), "sheared": (4, 8, 16), "hub": (8, 16, 24)}


def test_hub_of_rings_is_the_closed_form():
    """All wrinkled, without Poisson's ratio: torque of straight rays, radius of the whole disc."""
    for ratio in (2.0, 4.0, 8.0):
        torque, _ = exact.wrinkled_hub(1.0, ratio, 1000.0)
        rings, edge = exact.hub(1e-3, 1.0, ratio, 1000.0, 0.0, rings=1000)
        assert rings / 1e-3 == pytest.approx(torque, rel=1e-5)
        assert edge == pytest.approx(ratio)


def test_law_of_the_rings_is_the_derivative_of_its_energy():
    e = 1e-2 * np.random.default_rng(0).normal(size=(500, 3))
    _, stress, _ = exact.isotropic_law(e, 1000.0, 0.3)
    for i, step in enumerate(1e-7 * np.eye(3)):
        ahead, back = (exact.isotropic_law(e + s, 1000.0, 0.3)[0] for s in (step, -step))
        assert stress[:, i] == pytest.approx((ahead - back) / 2e-7, abs=1e-6)


@pytest.mark.serial
@pytest.mark.parametrize("load", [0.0, 0.05])
@pytest.mark.parametrize("cells", MESHES["bent"])
def test_bent_strip(cells, load):
    """Stein and Hedgepeth: curvature within 2 %, depth within 3 %, two fifths wrinkled."""
    found = flat.bent_strip(cells, 0.4, load)
    assert found["exact depth"] > 0.3
    assert abs(found["off"]) <= 0.02
    assert found["depth"] == pytest.approx(found["exact depth"], rel=0.03)


@pytest.mark.serial
def test_bent_strip_converges():
    """Deep wrinkles, seven tenths: the moment's error falls with the square of the cells."""
    errors = [abs(flat.bent_strip(n, 0.7, 0.05)["moment off"]) for n in (10, 20, 40)]
    assert errors[2] <= 0.003
    assert np.log2(errors[0] / errors[2]) / 2 >= 1.7


@pytest.mark.serial
def test_resolved_strip_does_not_wrinkle():
    """Without relaxation the same ends meet the full stiffness: the bar above can fail."""
    found = flat.bent_strip(20, 0.4, wrinkles="resolved")
    assert abs(found["off"]) > 0.1


@pytest.mark.serial
@pytest.mark.parametrize("load", [0.0, 0.2])
@pytest.mark.parametrize("cells", MESHES["sheared"])
def test_sheared_strip(cells, load):
    """Mansfield: shear force in the middle of a long strip within 3 %, the cells distorted."""
    found = flat.sheared_strip(cells, load=load)
    assert abs(found["off"]) <= 0.03
    assert found["normal"] == pytest.approx(found["exact normal"], rel=0.03)


@pytest.mark.serial
@pytest.mark.parametrize(("load", "stretch"), [(0.0, 0.0), (0.1, 0.0), (0.0, 0.1), (0.1, 0.3)])
@pytest.mark.parametrize("cells", MESHES["hub"])
def test_hub(cells, load, stretch):
    """Disc turned about its hub: torque and radius of the wrinkles within 3 % (4 % of 8 cells)."""
    found = flat.hub(cells, load, stretch)
    assert abs(found["off"]) <= 0.03
    assert found["radius"] == pytest.approx(found["exact radius"], rel=0.04 if cells == 8 else 0.03)


@pytest.mark.serial
@pytest.mark.parametrize("state", ["along", "both", "bias"])
@pytest.mark.parametrize("cells", [12, 4])
def test_pressed_between_beds(cells, state):
    """Cells of 10 and 30 mm bear 2 sqrt(k D) within 10 % up to 2 % of shortening."""
    found = beds.patch(cells, state)
    assert found["shortening"][-1] == pytest.approx(0.02)
    assert found["load"] == pytest.approx(beds.theory(), rel=0.1)


@pytest.mark.serial
def test_relaxation_fades():
    """A sheared strip whose cells show its waves: the same relaxed; coarse cells differ."""
    fine = [fading.sheared(8, kind)["shear"] for kind in ("resolved", "relaxed")]
    assert fine[1] == pytest.approx(fine[0], rel=0.01)
    coarse = [fading.sheared(3, kind)["shear"] for kind in ("resolved", "relaxed")]
    assert coarse[0] > 1.2 * fine[0]
    assert coarse[1] == pytest.approx(fine[0], rel=0.12)
