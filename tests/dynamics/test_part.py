# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a stepper takes as a part, in which order, and what it refuses with a sentence."""

import numpy as np
import pytest

import meshes
from contact.body.segments import Body, Fixed, Segment
from shellform import Fabric, Shell
from shellform.contact_coupling.contact import Contact
from shellform.contact_coupling.explicit_contact import ExplicitContact
from shellform.contact_coupling.implicit_contact import ImplicitContact
from shellform.dynamics.explicit import Newmark
from shellform.dynamics.implicit import ImplicitNewmark
from shellform.dynamics.part import AppliedForce, Part
from shellform.results.joint_torque import Torque
from shellform.results.ledger import Ledger
from tests.ranks import launch


def sheet(gravity=0.0):
    shell = Shell(meshes.rectangle(0.4, 0.4, (4, 4)), Fabric.isotropic(1e5, 0.3, 1e-3, 200.0))
    if gravity:
        shell.loads.gravity((0.0, 0.0, -gravity))
    return shell


def ball():
    return Body([Segment("ball", [0.3] * 3, Fixed((0.2, 0.2, -0.302)))])


class Counter(Part):
    """Counts the steps that were not taken back."""

    def __init__(self):
        self.count = 0

    def __call__(self, stepper, dt):
        self.count += 1

    def state(self):
        return self.count

    def restore(self, state):
        self.count = state


def test_parts_have_their_turn_in_the_order_of_adding():
    stepper, order = Newmark(sheet()), []
    one = stepper.add(lambda stepper, dt: order.append(("one", stepper.steps, dt)))
    counter = stepper.add(Counter())
    stepper.add(lambda stepper, dt: order.append(("two", counter.count, dt)))
    stepper.step(1e-4)
    stepper.remove(one)
    stepper.step(2e-4)
    assert order == [("one", 0, 1e-4), ("two", 1, 1e-4), ("two", 2, 2e-4)]
    assert counter.stepper is stepper


def test_a_part_goes_back_with_the_steps():
    """Steps that diverge are taken back: the part has counted those that led to the end."""
    stepper = Newmark(sheet())
    stepper.recheck, counter, late = 20, stepper.add(Counter()), []

    def lose_once(stepper, dt):
        if stepper.steps == 50 and not late:
            late.append(stepper.time)
            stepper.v[:] = np.nan

    stepper.add(lose_once)
    stepper.advance(100 * stepper.dt)
    assert stepper.rewind.cutbacks == 1 and late
    assert counter.count == stepper.steps


@pytest.mark.parametrize("implicit", [False, True])
def test_contact_is_that_of_the_stepper(implicit):
    stepper = ImplicitNewmark(sheet(), 1e-3) if implicit else Newmark(sheet())
    contact = stepper.add(Contact(ball(), friction=(0.5, 0.4)))
    assert type(contact) is (ImplicitContact if implicit else ExplicitContact)
    assert stepper.contact is contact
    assert stepper.describe()["contact"] == ["ball"]
    assert stepper.describe()["friction"] == [0.5, 0.4]
    with pytest.raises(ValueError, match="give all segments to one Body"):
        stepper.add(Contact(ball()))


@pytest.mark.parametrize("implicit", [False, True])
def test_a_ledger_without_contact(implicit):
    """Momentum of a falling sheet: weight times time, nothing left over."""
    shell = sheet(gravity=9.81)
    stepper = ImplicitNewmark(shell, 5e-3) if implicit else Newmark(shell)
    ledger = stepper.add(Ledger())
    stepper.advance(0.05)
    row = ledger.record()
    weight = 9.81 * stepper.shell.comm.allreduce(stepper.mass.sum())
    # explicit steps know velocities half a step before
    time = 0.05 if implicit else 0.05 - 0.5 * stepper.clock.last_dt
    assert row["momentum_z"] == pytest.approx(-weight * time, rel=1e-10)
    assert row["momentum_residual"] < 1e-12 * weight
    assert not any(name.startswith("force_") for name in row)


def test_wrong_orders_and_kinds_are_refused():
    stepper = Newmark(sheet())
    with pytest.raises(TypeError, match="functions of \\(stepper, dt\\), not 3"):
        stepper.add(3)
    with pytest.raises(ValueError, match=r"a Ledger runs with a stepper: stepper.add\(Ledger"):
        Ledger().record()
    with pytest.raises(ValueError, match="torque about the joints needs a contact"):
        stepper.add(Torque())
    ledger = stepper.add(Ledger())
    with pytest.raises(ValueError, match="add the contact before Ledger"):
        stepper.add(Contact(ball()))
    assert stepper.contact is None
    with pytest.raises(ValueError, match="runs with one stepper only"):
        Newmark(sheet()).add(ledger)


def test_torque_needs_a_wearer_and_explicit_steps():
    stepper = Newmark(sheet())
    stepper.add(Contact(ball()))
    with pytest.raises(ValueError, match="is a Body of ball: give Contact a Wearer"):
        stepper.add(Torque())
    implicit = ImplicitNewmark(sheet(), 1e-3)
    implicit.add(Contact(ball()))
    with pytest.raises(ValueError, match="in explicit steps only"):
        implicit.add(Torque())


def test_what_implicit_steps_do_not_know():
    stepper = ImplicitNewmark(sheet(), 1e-3)
    with pytest.raises(ValueError, match="at nodes, not at 2 samples a cell"):
        stepper.add(Contact(ball(), samples=2))
    with pytest.raises(ValueError, match="no soft flesh, as of 10000"):
        stepper.add(Contact(ball(), flesh_stiffness=1e4))
    with pytest.raises(ValueError, match=r"Wind pushes nodes .* explicit steps only"):
        stepper.add(type("Wind", (AppliedForce,), {})())


def test_loads_come_before_the_stepper():
    shell = sheet()
    Newmark(shell)
    with pytest.raises(ValueError, match="give all loads before the stepper is made"):
        shell.loads.gravity()


def test_a_shell_has_one_stepper():
    """The one made last; the other says so and moves nothing."""
    shell = sheet()
    first, second = Newmark(shell), Newmark(shell)
    second.advance(1e-3)
    with pytest.raises(ValueError, match="a newer solver has taken this shell over"):
        first.advance(2e-3)


@pytest.mark.parametrize(
    ("place", "said"), [(".", "is a folder"), ("none/l.csv", "no folder none")]
)
def test_files_have_a_folder(place, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError, match=said):
        Newmark(sheet()).add(Ledger(place))


@pytest.mark.serial
def test_an_error_that_is_kept_does_not_crash_at_exit():
    """Its traceback holds the frames of a step, and these the TS, which PETSc ends before."""
    program = (
        "import meshes, shellform as sf\n"
        "sheet = meshes.rectangle(0.2, 0.2, (2, 2))\n"
        "stepper = sf.Newmark(sf.Shell(sheet, sf.Fabric.isotropic(1e5, 0.3, 1e-3, 200.0)))\n"
        "def fails(stepper, dt):\n"
        "    raise sf.Unstable('made up')\n"
        "stepper.add(fails)\n"
        "kept = []\n"
        "try:\n"
        "    stepper.advance(0.01)\n"
        "except sf.Unstable as error:\n"
        "    kept.append(error)\n"
        "print(kept[0])\n"
    )
    done = launch(1, "-c", program)
    assert (done.returncode, done.stderr) == (0, "") and "made up" in done.stdout
