# SPDX-License-Identifier: LGPL-3.0-or-later
"""Only what a scene needs is allocated and computed: counted, not assumed."""

import numpy as np
import pytest

from contact.body.segments import Body, Fixed, Segment
from contact.solver import correction_step, one_segment, velocity_correction
from contact.solver.velocity_correction import VelocityCorrection
from shellform import Fabric, Statics
from shellform.dynamics import explicit_kernels
from shellform.dynamics import time_stepper as stepper
from shellform.dynamics.explicit import Newmark
from shellform.fem import lumped_mass as inertia
from shellform.fem.internal_force import by_segments
from tests.simulation.test_only_what_is_loaded import CLOTH, sheet


def test_statics_has_no_mass(monkeypatch, comm):
    """Its weight needs areas, no nodal mass: the function that makes masses is never called."""
    calls = []
    for home in (inertia, stepper):
        lumped = home.lumped
        monkeypatch.setattr(home, "lumped", lambda *a, f=lumped: calls.append(1) or f(*a))
    shell = sheet(comm=comm)
    shell.supports.clamp("left")
    shell.loads.gravity((0.0, 0.0, -1e-3))
    with Statics(shell) as statics:
        statics.solve(1)
        held = {*vars(shell), *vars(statics), *vars(statics.equilibrium)}
        assert statics.equilibrium.inertia is None
    assert calls == [] and not held & {"mass", "v", "q"}
    Newmark(sheet(comm=comm))
    assert calls == [1]


def test_coupling_only_where_stretching_bends(comm):
    """B enters the energy, and takes the quads off their fast kernel, only where it is not zero."""
    rows = {}
    A, D, S = CLOTH.membrane, CLOTH.bending, CLOTH.shear
    for name, B in (("plain", None), ("coupled", 1e-4 * A)):
        fabric = Fabric(A, D, S, CLOTH.areal_mass, CLOTH.thickness, coupling=B)
        shell = sheet(fabric=fabric, comm=comm)
        total = 0
        for over, terms in shell.weak_form.by_rule():
            for term in terms:
                strain = shell.weak_form.strain(term, shell.w)
                total += over(term.product(strain, strain))
        rows[name] = shell.plan()["terms"], len(total.constants()), by_segments(shell)
    strains = ["membrane", "bending", "transverse shear"]
    assert rows["plain"] == (strains, 2, True)  # D, S; the membrane is that of cells
    assert rows["coupled"] == ([*strains, "membrane with bending"], 4, False)


def test_no_array_nor_kernel_of_damping_without_it(monkeypatch, comm):
    """Without damping no field ahead of the nodes, no rates; with it one call a force."""
    calls, ahead = [], explicit_kernels.ahead
    monkeypatch.setattr(explicit_kernels, "ahead", lambda *a: calls.append(1) or ahead(*a))
    shell = sheet(comm=comm)
    plain = Newmark(shell)
    plain.advance(20 * plain.dt)
    assert calls == []
    assert plain.force_model._field is shell.w and not plain.force_model.internal.damped
    assert not {"before", "step"} & set(vars(shell))  # of tangents and of rates
    damped = Newmark(sheet(comm=comm), damping=1e-5)
    damped.advance(20 * damped.dt)
    assert len(calls) == damped.steps > 0 and damped.force_model._field is not damped.shell.w


def test_loads_of_zero_are_none(comm):
    shell = sheet(comm=comm)
    loads = shell.loads
    loads.gravity((0.0, 0.0, 0.0))
    loads.point(np.array([0]), (0.0, 0.0, 0.0))
    loads.line("left", (0.0, 0.0, 0.0))
    loads.surface((0.0, 0.0, 0.0))
    loads.edge_moment("left", (0.0, 0.0, 0.0))
    loads.point_moment(np.array([0]), (0.0, 0.0, 0.0))
    loads.pressure(0.0, amplitude=np.cos)
    assert loads.forces == loads.moments == loads.pressures == [] and loads.steady()
    assert loads.kinds() == shell.plan()["loads"] == {}
    loads.gravity()
    loads.pressure(1.0)
    assert loads.kinds() == {"gravity": 1, "pressure": 1}
    with pytest.raises(ValueError, match="amplitude"):
        loads.gravity((0.0, 0.0, 0.0), amplitude=3.0)


def on_records(kernel):
    """A function for numba run by Python, which wants records with attributes."""

    def run(*given):
        records = lambda a: isinstance(a, np.ndarray) and a.dtype.names  # noqa: E731
        return kernel(*(a.view(np.recarray) if records(a) else a for a in given))

    return run


@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_no_friction_kernel_without_friction(monkeypatch, friction):
    """Points that press on a slope ask for the cone of friction only if there is friction."""
    calls, build = [], one_segment.cone_kernel

    def counted(law):
        transmitted = build(law)
        return lambda *given: calls.append(1) or transmitted(*given)

    monkeypatch.setattr(one_segment, "cone_kernel", counted)
    # the loop over nodes, and what each of them does, by Python itself
    for module in (one_segment, correction_step):
        monkeypatch.setattr(module, "kernel", lambda **options: lambda function: function)
    meet, correct = (
        one_segment.one_segment_kernel.__wrapped__,
        correction_step.correction_kernel.__wrapped__,
    )
    monkeypatch.setattr(correction_step, "one_segment_kernel", meet)
    monkeypatch.setattr(
        velocity_correction, "correction_kernel", lambda law: on_records(correct(law))
    )
    contact = VelocityCorrection(ball(), 2, friction)
    x, v = np.array([[0.3, 0.0, 1.0], [0.0, 0.0, 1.5]]), np.zeros((2, 3))
    x[0] /= np.linalg.norm(x[0])
    v[:, 2] = -1.0
    contact(x, v, np.ones(2), 1e-3, 0.0)
    assert contact.active == 1  # the other one is high above
    assert len(calls) == (1 if friction else 0)
    slip = v[0] - v[0] @ x[0] * x[0]
    expected = np.sqrt(1 - x[0, 2] ** 2) - friction * x[0, 2]  # down the slope, less mu N
    assert np.linalg.norm(slip) == pytest.approx(expected, rel=1e-9)


def ball(*more):
    places = [(0.0, 0.0, 0.0), *more]
    return Body([Segment(f"ball {k}", (1.0, 1.0, 1.0), Fixed(c)) for k, c in enumerate(places)])


def test_bodies_out_of_reach_are_not_evaluated():
    """A body far away costs no closest point and changes nothing, to the last bit."""
    seen = {}
    for name, more in (("alone", ()), ("far", ((9.0, 0.0, 0.0),)), ("near", ((0.0, 0.5, 0.0),))):
        random = np.random.default_rng(5)
        x = random.normal(size=(200, 3))
        x *= (1.0 + 0.01 * random.random(200) ** 2)[:, None] / np.linalg.norm(x, axis=1)[:, None]
        v, count = random.normal(size=(200, 3)), 0
        contact = VelocityCorrection(ball(*more), 200, 0.3)
        for step in range(10):
            contact(x, v, np.ones(200), 1e-3, 1e-3 * step)
            count += contact.evaluated
            x += 1e-3 * v
        seen[name] = count, x
    assert seen["far"][0] == seen["alone"][0] > 0
    assert np.array_equal(seen["far"][1], seen["alone"][1])
    assert seen["near"][0] > seen["alone"][0]


def test_bodies_that_are_not_allowed_are_not_evaluated():
    x, v = np.array([[0.0, 0.0, 1.0]]), np.array([[0.0, 0.0, -1.0]])
    contact = VelocityCorrection(ball(), 1, 0.3, allowed=np.zeros(1, int))
    contact(x, v, np.ones(1), 1e-3, 0.0)
    assert contact.evaluated == 0 and v[0, 2] == -1.0
