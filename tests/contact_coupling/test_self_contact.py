# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cloth on cloth in explicit steps: momenta, energy, weight, friction, ranks, going on."""

import os
import subprocess
import sys

import numpy as np
import pytest

from contact.body.flesh_bed import Flesh
from contact.body.segments import Body, Fixed, Segment
from shellform import Shell
from shellform.contact_coupling.contact import Contact
from shellform.contact_coupling.self_contact import SelfContact
from shellform.dynamics import checkpoint
from shellform.dynamics.explicit import Newmark
from shellform.dynamics.implicit import ImplicitNewmark
from shellform.dynamics.mass_spring import Particles
from shellform.results.ledger import Ledger
from tests.contact_coupling.layers import (
    QUICK,
    SCENES,
    THICKNESS,
    G,
    advance,
    ball,
    ball_of_triangles,
    check,
    cloth,
    dropped,
    frames,
    main,
    on_an_incline,
    scene_of_ranks,
    square,
    stacked,
    state,
)
from tests.ranks import launch, needs_mpirun

ALL = [pytest.param(n, marks=() if n in QUICK else pytest.mark.thorough) for n in SCENES]


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"triangles": True},
        pytest.param({"steps": Particles}, marks=pytest.mark.serial),  # they know one rank
    ],
)
def test_two_sheets_meet(options):
    """Momenta to roundoff, the books of energy closed, no edge through a triangle."""
    stepper, contact = dropped(**options)
    ledger, comm = stepper.add(Ledger()), stepper.shell.comm
    ledger.record()
    before, spin, energy = stepper.momenta()
    size = comm.allreduce(stepper.mass.sum()) * 1.0
    for k in range(1, 7):
        stepper.advance(0.005 * k)
        check(stepper)
    now, turned, _ = stepper.momenta()
    row = ledger.record()
    assert contact.most_pairs > 30
    assert contact.closest > 0.99 * THICKNESS
    assert np.abs(now - before).max() < 1e-13 * size
    assert np.abs(turned - spin).max() < 1e-13 * size
    assert row["momentum_residual"] < 1e-13 * size
    lost = row["self_impact_loss"] + row["self_friction_loss"]
    assert lost > 0.1 * energy and row["self_friction_loss"] > 0
    # what time steps of this length leave; a twentieth of what contact took
    assert abs(row["energy_residual"]) < 0.05 * lost


def test_error_of_energy_is_that_of_the_steps():
    """With a fifth of the step the residual of the ledger falls with it."""
    left = []
    for part in (1.0, 0.2):
        stepper, _ = dropped(cells=3)
        stepper.factor *= part
        stepper.dt *= part
        ledger = stepper.add(Ledger())
        ledger.record()
        stepper.advance(0.02)
        row = ledger.record()
        left.append(abs(row["energy_residual"]) / row["self_impact_loss"])
    assert left[1] < 0.5 * left[0] + 1e-4


def layers_rest(cells, until, closest=0.9, **options):
    stepper, contact = stacked(cells, **options)
    ledger = stepper.add(Ledger())
    comm, weight = stepper.shell.comm, stepper.shell.fabric.areal_mass * 5 * 0.09 * G
    for time in np.linspace(0.0, until, 6)[1:]:
        stepper.advance(time)
        check(stepper)
    ledger.record()
    stepper.drag = 0.0  # what rests must stay so by itself
    stepper.advance(until + 0.2)
    check(stepper)
    row = ledger.record()
    force = np.array([row[f"force_ball_{a}"] for a in "xyz"])
    assert np.abs(force - [0, 0, weight]).max() < 1e-3 * weight
    assert comm.allreduce(contact.active) > 3 and contact.cloth.pairs > 50
    assert contact.cloth.closest > closest * THICKNESS
    assert row["momentum_residual"] < 1e-10 * weight


def test_five_layers_rest_on_a_sphere():
    """The ball bears all of them, to 0.1 %."""
    layers_rest(3, 1.0)


@pytest.mark.thorough
@pytest.mark.parametrize("body", [ball, ball_of_triangles])
@pytest.mark.parametrize("flesh", [None, Flesh(1e5)])
def test_five_layers_rest_on_triangles_and_on_flesh(body, flesh):
    # flesh throws layers up a little as they come to lie on it: 0.14 mm closer on both bodies
    layers_rest(3, 1.0, 0.9 if flesh is None else 0.8, body=body, flesh=flesh)


@pytest.mark.parametrize("flesh", [None, Flesh(1e5)])
def test_layers_fall_on_triangles(flesh):
    """A quick twin: momentum is booked and nothing passes while they come to lie on each other."""
    stepper, contact = scene_of_ranks(body=ball_of_triangles, flesh=flesh)
    ledger = stepper.add(Ledger())
    ledger.record()
    advance(stepper, 400)
    check(stepper)
    row = ledger.record()
    weight = stepper.shell.fabric.areal_mass * 3 * 0.09 * G
    assert row["momentum_residual"] < 1e-10 * weight
    assert row["force_ball_z"] > 0.5 * weight
    # as on a sphere: layers that fall at 0.4 m/s come 0.15 mm closer in one step
    assert contact.cloth.most_pairs > 30 and contact.cloth.closest > 0.8 * THICKNESS


@pytest.mark.thorough
def test_five_fine_layers_rest_on_a_sphere():
    layers_rest(10, 2.0, 0.85)


@pytest.mark.parametrize("name", ALL)
def test_nothing_passes(name):
    """No edge through a triangle at any output, by a checker that knows nothing of ours."""
    frames(name)


@pytest.fixture
def ipctk():
    """A Python that has ipctk: this one, or that of IPCTK_PYTHON."""
    for path in filter(None, (sys.executable, os.environ.get("IPCTK_PYTHON"))):
        if not subprocess.run([path, "-c", "import ipctk"], capture_output=True).returncode:
            return path
    pytest.skip("no ipctk: name a Python with `pip install ipctk` in IPCTK_PYTHON")


JUDGE = """
import sys, ipctk, numpy as np
file = np.load(sys.argv[1])
triangles = file["triangles"]
mesh = ipctk.CollisionMesh(file["x"][0], ipctk.edges(triangles), triangles)
print([bool(ipctk.has_intersections(mesh, x)) for x in file["x"]])
"""


@pytest.mark.serial
@pytest.mark.parametrize("name", ALL)
def test_ipctk_finds_nothing(name, ipctk, tmp_path):
    """Another program's checker agrees; it does see sheets that pass through each other."""
    x, triangles = frames(name)
    through = x[-1].copy()
    a, b, c = through[triangles[0]]
    node = np.setdiff1d(np.arange(len(through)), triangles[0])[-1]
    edge = triangles[(triangles == node).any(axis=1)][0]
    other = edge[edge != node][0]
    through[other] = (a + b + c) / 3 - 0.01 * np.cross(b - a, c - a) / np.linalg.norm(b - a) ** 2
    through[node] = 2 * (a + b + c) / 3 - through[other]
    np.savez(tmp_path / "x.npz", x=[*x, through], triangles=triangles)
    done = subprocess.run(
        [ipctk, "-c", JUDGE, tmp_path / "x.npz"], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == str([False] * len(x) + [True])


@pytest.mark.parametrize("seconds", [0.5, pytest.param(10.0, marks=pytest.mark.thorough)])
def test_friction_holds(seconds):
    """tan 0.4 under 0.5: no slip of 1e-6 m."""
    stepper, contact, patch = on_an_incline(0.4)
    stepper.advance(0.1)
    place = stepper.owned[patch, :3].copy()
    stepper.advance(0.1 + seconds)
    assert stepper.shell.comm.allreduce(len(place)) and contact.pairs > 10
    assert np.abs(stepper.owned[patch, :3] - place).max(initial=0.0) < 1e-6


def test_friction_slides():
    """tan 0.6 over 0.5: x = g (sin - 0.5 cos) t^2 / 2, to 2 %."""
    stepper, _, patch = on_an_incline(0.6)
    stepper.advance(0.2)
    a = np.arctan(0.6)
    gone = stepper.shell.comm.allgather(stepper.owned[patch, 0])
    exact = 0.5 * G * (np.sin(a) - 0.5 * np.cos(a)) * 0.2**2
    assert np.concatenate(gone) == pytest.approx(exact, rel=0.02)


def test_goes_on_bit_for_bit(shared_tmp_path, comm):
    stepper, contact = scene_of_ranks()
    advance(stepper, 60)
    checkpoint.save(shared_tmp_path / "c.npz", stepper)
    comm.Barrier()
    other, other_contact = scene_of_ranks()
    checkpoint.load(shared_tmp_path / "c.npz", other)
    for one in (stepper, other):
        advance(one, 60)
    assert contact.cloth.pairs > 10
    assert np.array_equal(state(other), state(stepper))
    assert np.array_equal(other_contact.cloth.losses, contact.cloth.losses)
    assert other_contact.cloth.most_pairs == contact.cloth.most_pairs


def test_a_file_without_it_is_refused(shared_tmp_path, comm):
    body = Body([Segment("ball", [0.2] * 3, Fixed((0.0, 0.0, -0.3)))])
    steppers = [Newmark(Shell(square(2), cloth())) for _ in range(2)]
    steppers[0].add(Contact(body))
    steppers[1].add(Contact(body, self_contact=True))
    checkpoint.save(shared_tmp_path / "c.npz", steppers[0])
    comm.Barrier()
    with pytest.raises(ValueError, match="no state of cloth on cloth"):
        checkpoint.load(shared_tmp_path / "c.npz", steppers[1])


@needs_mpirun
@pytest.mark.serial
@pytest.mark.parametrize("body", [(), pytest.param(("triangles",), marks=pytest.mark.thorough)])
def test_same_on_ranks(body, tmp_path):
    """1, 2 and 3 ranks agree to 1e-9 after 200 steps."""
    main(tmp_path / "1.npz", 200, *body)
    found = [dict(np.load(tmp_path / "1.npz"))]
    for ranks in (2, 3):
        out = tmp_path / f"{ranks}.npz"
        done = launch(ranks, "-m", "tests.contact_coupling.layers", out, 200, *body)
        assert done.returncode == 0, done.stderr[-2000:]
        found.append(dict(np.load(out)))
    assert found[0]["pairs"] > 30 and found[0]["losses"].min() > 0
    for other in found[1:]:
        for name, value in found[0].items():
            scale = np.abs(value).max(axis=0) + 1e-12
            assert (np.abs(other[name] - value) / scale).max() < 1e-9, name


def test_refusals():
    body = Body([Segment("ball", [0.2] * 3, Fixed((0.0, 0.0, -0.3)))])
    implicit = ImplicitNewmark(Shell(square(2), cloth()), 1e-3)
    for part in (Contact(body, self_contact=True), SelfContact()):
        with pytest.raises(ValueError, match="implicit steps know no contact of cloth with cloth"):
            implicit.add(part)
    stepper = Newmark(Shell(square(2), cloth()))
    stepper.add(SelfContact())
    with pytest.raises(ValueError, match="meets itself already"):
        stepper.add(Contact(body))
    with pytest.raises(ValueError, match="meets itself already"):
        stepper.add(SelfContact())
    stepper = Newmark(Shell(square(2), cloth()))
    stepper.add(Contact(body))
    with pytest.raises(ValueError, match=r"Contact\(body, self_contact=True\)"):
        stepper.add(SelfContact())
    stepper = Newmark(Shell(square(2), cloth()))
    stepper.add(Ledger())
    with pytest.raises(ValueError, match="add the contact before Ledger"):
        stepper.add(SelfContact())
    with pytest.raises(ValueError, match="a length above 0"):
        SelfContact(thickness=0.0)
    with pytest.raises(ValueError, match="True, False or a SelfContact"):
        Contact(body, self_contact=0.3)


@pytest.mark.serial
def test_nothing_of_it_is_loaded_unless_asked_for():
    code = (
        "import sys, meshes, shellform as sf\n"
        "from contact.body.segments import Body, Fixed, Segment\n"
        "fabric = sf.Fabric.isotropic(1e5, 0.3, 1e-3, 200.0)\n"
        "shell = sf.Shell(meshes.rectangle(0.1, 0.1, (1, 1)), fabric)\n"
        "body = Body([Segment('ball', [0.2] * 3, Fixed((0.0, 0.0, -0.3)))])\n"
        "stepper = sf.Newmark(shell)\n"
        "contact = stepper.add(sf.Contact(body))\n"
        "stepper.step(stepper.dt)\n"
        "assert contact.cloth is stepper.self_contact is None\n"
        "print([m for m in sys.modules if 'self_contact' in m and 'coupling.self' not in m])\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_contact_that_is_removed_takes_the_one_of_its_cloth_along():
    stepper, contact = stacked(2, layers=2)
    stepper.remove(contact)
    assert stepper.self_contact is None
    again = stepper.add(Contact(ball(), 0.3, self_contact=True))
    assert stepper.self_contact is again.cloth
