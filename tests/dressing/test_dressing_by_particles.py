# SPDX-License-Identifier: LGPL-3.0-or-later
"""Trousers with friction inside the cloth, put on by masses and springs and handed to the shell."""

from functools import partial

from mpi4py import MPI

import numpy as np
import pytest

from shellform.dressing.procedure import Dressing
from shellform.dressing.saved_state import save
from shellform.material.measurements import measured_fabric
from shellform.scene.parts import Garment, Motion, Steps
from shellform.scene.scene import Scene
from shellform.simulation.model import Model
from tests.material.test_measurements import without

pytestmark = pytest.mark.serial
CLOTH = measured_fabric(without("LT_"), "suiting")
HURRIED = partial(Dressing, pull=0.3, belt=0.05, release=0.05, settle=0.2)


def model(fabric=CLOTH):
    return Model(
        Scene(
            fabric,
            Motion(end=0.4),
            garment=Garment(cell_size=0.04),
            steps=Steps(dressing="particles"),
        ),
        MPI.COMM_SELF,
    )


def test_a_scene_dresses_cloth_with_friction_by_particles(monkeypatch, tmp_path):
    """What sliders bear when the motion begins is kept in the dressed state, and put on again."""
    for place in ("shellform.dressing.dress", "shellform.simulation.model"):
        monkeypatch.setattr(f"{place}.Dressing", HURRIED)
    first = model()
    report = first.dress()
    stepper = first.stepper
    assert np.isfinite(stepper.owned).all() and stepper.rewind.cutbacks == 0
    assert stepper.time == first.wearer.start and report["depth"] < 1e-3
    assert first.shell.friction_loss() > 1e-3
    save(tmp_path / "dressed.npz", stepper, first.wearer)
    borne = first.shell.cell_stress.borne(stepper.w)
    most = CLOTH.friction.table()[:, 1]
    assert (np.abs(borne).max(axis=0) > 0.5 * most).all()  # folds are held

    looks = []
    monkeypatch.setattr(
        "shellform.dressing.saved_state.settle_again",
        lambda s, *_: looks.append(s.shell.cell_stress.borne(s.w)) or (None, {}),
    )
    model().put_on(tmp_path / "dressed.npz")
    np.testing.assert_allclose(looks[0], borne, atol=1e-9 * most.max())
    other = CLOTH.with_friction(type(CLOTH.friction)(shear=CLOTH.friction.shear))
    model(other).put_on(tmp_path / "dressed.npz")
    assert np.abs(looks[1]).max() < 1e-12
