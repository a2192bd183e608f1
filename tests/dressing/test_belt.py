# SPDX-License-Identifier: LGPL-3.0-or-later
"""The belt against a cable on rigid sections, the hands against momentum and free fall."""

from mpi4py import MPI

import numpy as np
import pytest

import meshes
from contact.body.segments import Body, Fixed, Segment
from contact.geometry.ellipsoid import closest_points
from meshes.garments.ring import ring
from shellform import Fabric, Shell
from shellform.contact_coupling.contact import Contact
from shellform.dressing.belt import Belt, Hands, Ring, add_tension
from shellform.dynamics.explicit import Newmark
from shellform.results.ledger import Ledger

RADIUS, TENSION, G = 0.1, 20.0, 9.81
LONG = 1e4  # an ellipsoid so long is a cylinder here


def stepper_of(surface, comm=MPI.COMM_WORLD, gravity=0.0, **damping):
    fabric = Fabric.from_stiffness(
        1e3 * np.diag([1, 1, 0.5]), 1e-5 * np.diag([1, 1, 0.5]), areal_mass=0.2, thickness=1e-3
    )
    shell = Shell(surface.replace(warp=(0.0, 0.0, 1.0)), fabric, comm)
    if gravity:
        shell.loads.gravity((0.0, 0.0, -gravity))
    return Newmark(shell, 0.8, **damping)


def tube(cells=24, rows=2, radius=RADIUS):
    """A short tube about the z axis whose upper edge is its waist."""
    surface = meshes.cylinder(radius, 0.05, (cells, rows))
    return surface.with_edges(waist=surface.edges["top"])


def limb(radii=(RADIUS, RADIUS)):
    """A cylinder whose skin, half the cloth's thickness included, has the given radii."""
    return Body([Segment("hip", (radii[0] - 5e-4, radii[1] - 5e-4, LONG), Fixed())])


def around(surface):
    """Rows of the waist's nodes."""
    return np.unique(surface.edges["waist"])


def test_cable_of_any_shape():
    """Pull is tension times the difference of unit directions; no net force, no net moment."""
    rng = np.random.default_rng(3)
    x = rng.standard_normal((17, 3)) + [5.0, -3.0, 8.0]
    x[4] = x[5]  # two nodes in one place pull each other nowhere
    force = np.zeros_like(x)
    add_tension(x, 3.0, force)
    ahead = np.roll(x, -1, axis=0) - x
    length = np.linalg.norm(ahead, axis=1, keepdims=True)
    unit = ahead / np.where(length > 0, length, 1)
    assert np.abs(force - 3.0 * (unit - np.roll(unit, 1, axis=0))).max() < 1e-14
    assert np.abs(force.sum(axis=0)).max() < 1e-13
    assert np.abs(np.cross(x, force).sum(axis=0)).max() < 1e-12
    # minus the slope of tension times perimeter
    h, move = 1e-6, rng.standard_normal(x.shape)
    move[4] = move[5]

    def perimeter(x):
        return np.linalg.norm(np.roll(x, -1, axis=0) - x, axis=1).sum()

    slope = 3.0 * (perimeter(x + h * move) - perimeter(x - h * move)) / (2 * h)
    assert np.vdot(force, move) == pytest.approx(-slope, rel=1e-8)


@pytest.mark.parametrize("cells", [8, 24])
def test_belt_on_a_cylinder(cells):
    """At rest k nodes press with 2 k T sin(pi/k), 2 pi T of a circle; nothing is left over."""
    surface = tube(cells)
    stepper = stepper_of(surface)
    belt = stepper.add(Belt("waist", TENSION))
    touch = stepper.add(Contact(limb(), friction=0.0))
    ledger = stepper.add(Ledger())
    stepper.advance(0.02)
    row = ledger.record()
    window = touch.correction.window
    assert len(belt.ring.nodes) == cells
    stepper.advance(0.04)
    force = stepper.shell.partition.gather(window.impulse / window.seconds)
    radial = np.sum(force * surface.points * [1, 1, 0], axis=1) / RADIUS
    exact = 2 * TENSION * np.sin(np.pi / cells)
    waist = around(surface)
    assert np.abs(radial[waist] - exact).max() < 1e-6 * exact
    assert np.abs(np.delete(force, waist, axis=0)).max() < 1e-6 * exact
    assert np.abs(force.sum(axis=0)).max() < 1e-9 * TENSION
    if cells == 24:
        assert radial.sum() == pytest.approx(2 * np.pi * TENSION, rel=0.01)
    assert row["momentum_residual"] < 1e-12 * TENSION
    # slack again: no force without tension
    belt.tension = 0.0
    touch.correction.reset()
    stepper.advance(0.05)
    assert np.abs(window.impulse).max() < 1e-6 * exact * window.seconds


def test_belt_on_an_ellipse():
    """On any convex section the normal forces add up to 2 pi T; without friction T is even."""
    radii, cells = np.array([0.16, 0.10]), 96
    # as many equal chords, with corners on the ellipse
    corners = ring(1.0, radii[1] / radii[0], cells)[:, :2]
    corners = corners * radii / np.abs(corners).max(axis=0)
    corners = np.concatenate([corners, corners[:1]])
    surface = meshes.patch(
        lambda a, b: (
            *np.moveaxis(corners[np.rint(cells * a).astype(int)], -1, 0),
            0.02 * b,
        ),
        (cells, 1),
        closed=(True, False),
        names=(None, None, "bottom", "waist"),
    )
    stepper = stepper_of(surface, drag=200.0)
    stepper.add(Belt("waist", TENSION))
    touch = stepper.add(Contact(limb(radii), friction=0.0))
    stepper.advance(0.1)
    stepper.drag = 0.0  # still air takes drag dt/2 of every push, also of what rests
    touch.correction.reset()
    stepper.advance(0.15)
    window, partition = touch.correction.window, stepper.shell.partition
    force = partition.gather(window.impulse / window.seconds)
    place = stepper.shell.positions()
    _, normals, _ = closest_points(place, touch.correction.body.radii[0])
    pressed = np.sum(force * normals, axis=1)
    waist = around(surface)
    assert pressed.sum() == pytest.approx(2 * np.pi * TENSION, rel=0.01)
    assert np.abs(force - pressed[:, None] * normals).max() < 1e-6 * TENSION
    assert np.abs(force.sum(axis=0)).max() < 1e-3 * TENSION
    # where the section is most and least curved: curvature a/b^2 and b/a^2 times the length a node
    length = np.linalg.norm(np.diff(np.vstack([place[waist], place[waist[:1]]]), axis=0), axis=1)
    for axis in (0, 1):
        tip = np.abs(place[waist, axis]).argmax()
        curvature = radii[axis] / radii[1 - axis] ** 2
        share = 0.5 * (length[tip] + length[tip - 1])
        assert pressed[waist][tip] == pytest.approx(TENSION * curvature * share, rel=0.02)


def perimeter(belt, stepper):
    x = belt.ring.look(stepper)
    return np.linalg.norm(np.roll(x, -1, axis=0) - x, axis=1).sum()


def test_work_of_a_belt_is_tension_times_what_it_takes_in():
    """A tube in the air drawn together: momentum stays, energy closes, T (L0 - L) is booked."""
    surface = tube()
    errors = []
    for cut in (0.5, 0.25):
        stepper = stepper_of(surface)
        stepper.recheck, stepper.dt = 10**9, cut * stepper.dt
        belt = stepper.add(Belt("waist", 1.0))
        ledger = stepper.add(Ledger())
        start, worst, left = perimeter(belt, stepper), 0.0, 0.0
        for time in (0.002, 0.004, 0.006):
            stepper.advance(time)
            row = ledger.record()
            gained = start - perimeter(belt, stepper)
            worst = max(worst, abs(row["external_work"] / gained - 1))
            left = max(left, abs(row["energy_residual"] / row["external_work"]))
            assert np.abs([row[f"momentum_{a}"] for a in "xyz"]).max() < 1e-12
        errors.append((worst, left))
    assert gained > 0.01 * start
    # the trapezium of the steps
    for coarse, fine in zip(*errors, strict=True):
        assert fine < 1e-3 and coarse / fine > 3


@pytest.mark.skipif(MPI.COMM_WORLD.size == 1, reason="compares many ranks with one")
def test_belt_on_many_ranks():
    """The ring is whole on every rank; places after 100 steps as on one rank to 1e-9."""
    places = []
    for comm in (MPI.COMM_SELF, MPI.COMM_WORLD):
        stepper = stepper_of(tube(), comm)
        belt = stepper.add(Belt("waist", TENSION))
        stepper.recheck, stepper.dt = 10**9, 2e-5
        stepper.advance(100 * 2e-5)
        places.append((belt.ring.look(stepper).copy(), stepper.shell.positions(), belt.ring.nodes))
    for one, many in zip(*places, strict=True):
        assert np.abs(one - many).max() < 1e-9


def test_ring_runs_around_once():
    """Nodes in order whatever order the edge came in; an open edge or two are refused."""
    surface = tube(12)
    segments = np.random.default_rng(1).permutation(surface.edges["top"])
    segments[::2] = segments[::2, ::-1]
    surface = surface.with_edges(waist=segments)
    both = np.concatenate([surface.edges["bottom"], surface.edges["top"]])
    surface = surface.with_edges(part=surface.edges["top"][:-1], both=both)
    stepper = stepper_of(surface)
    nodes = Ring(stepper, "waist").nodes
    assert sorted(nodes) == sorted(around(surface))
    angle = np.unwrap(np.arctan2(*surface.points[nodes, 1::-1].T))
    assert np.abs(np.abs(np.diff(angle)) - np.pi / 6).max() < 1e-12
    assert np.abs(angle[-1] - angle[0]) == pytest.approx(11 * np.pi / 6)
    for edge in ("part", "both"):
        with pytest.raises(ValueError, match=f"edge '{edge}' of cylinder is not one closed line"):
            Ring(stepper, edge)
    with pytest.raises(ValueError, match="has no edge 'belt'; it has "):
        stepper.add(Belt("belt"))


def lift(height, seconds):
    """Least-jerk motion up, at rest at both ends."""

    def places(time):
        s = min(max(time / seconds, 0.0), 1.0)
        up = height * s**3 * (10 - 15 * s + 6 * s * s)
        speed = height / seconds * 30 * s * s * (1 - s) ** 2
        return np.array([0.0, 0.0, up]), np.array([0.0, 0.0, speed])

    return places


def test_hands_lift_and_let_go():
    """Up around a limb that it rubs on, released: momentum is what hands, weight, limb gave."""
    surface = tube().transform(translation=(0.0, 0.0, -0.05))
    stepper = stepper_of(surface, gravity=G)
    # a slim ellipsoid: at its middle it is wider than the tube
    body = Body([Segment("leg", (0.108, 0.108, 0.4), Fixed((0.0, 0.0, 0.2)))])
    touch = stepper.add(Contact(body, friction=0.3))
    ledger = stepper.add(Ledger())
    places, stiffness, damping = lift(0.1, 0.1), 50.0, 0.05
    hands = stepper.add(Hands("waist", places, stiffness, damping))
    comm, given = stepper.shell.comm, np.zeros((2, 3))

    def follow(stepper, dt):
        """Impulses of hands and limb in this step, from their own laws."""
        shift, velocity = places(stepper.time)
        own = hands.own
        pull = stiffness * (shift - stepper.owned[own, :3])
        pull += damping * (velocity - stepper.v_old[own])
        given[0] += 0.5 * (last[0] + dt) * hands.hold * pull.sum(axis=0)
        given[0, 2] -= 0.5 * (last[0] + dt) * G * stepper.mass.sum()
        given[1] += touch.correction.last.impulse.sum(axis=0)
        last[0] = dt

    last = [0.0]
    stepper.add(follow)
    weight = G * comm.allreduce(stepper.mass.sum())
    for time in (0.03, 0.06, 0.1, 0.15, 0.2):
        if time > 0.15:
            hands.hold = 0.0
        stepper.advance(time)
        row = ledger.record()
        hand, limb = comm.allreduce(given)
        external = comm.allreduce(stepper.external_total)
        momentum = comm.allreduce(stepper.mass @ stepper.v)
        assert np.abs(hand - external).max() < 1e-9 * weight
        assert np.abs(momentum - external - limb).max() < 1e-9 * weight
        assert row["momentum_residual"] < 1e-9 * weight
        assert np.abs(row["energy_residual"]) < 0.02 * row["external_work"]
    assert np.abs(limb[2]) > 0.01 * weight  # it rubs on the way


def test_hands_hold_the_weight():
    """A tube hung from the hands, brought to rest: they sag by m g/(n k hold) and carry m g."""
    surface = tube()
    stepper = stepper_of(surface, gravity=G, damping=1e-4)
    hands = stepper.add(Hands("waist", lift(0.1, 0.1), stiffness=40.0, damping=0.08))
    hands.hold = 0.5
    stepper.advance(0.1)
    stepper.drag = 30.0
    stepper.advance(0.6)
    comm = stepper.shell.comm
    weight = G * comm.allreduce(stepper.mass.sum())
    waist = around(surface)
    up = stepper.shell.displacements()[waist, 2]
    assert np.abs(up - (0.1 - weight / (0.5 * 40.0 * len(waist)))).max() < 1e-5 * 0.1
    before = comm.allreduce(stepper.external_total)
    stepper.advance(0.7)
    # with the weight, which is booked in the same place
    left = (comm.allreduce(stepper.external_total) - before) / 0.1
    assert np.abs(left).max() < 1e-3 * weight
    # let go: free fall of the centre of mass from there
    height = stepper.mass @ stepper.owned[:, 2]
    stepper.drag, hands.hold = 0.0, 0.0
    stepper.advance(0.8)
    fallen = comm.allreduce(height - stepper.mass @ stepper.owned[:, 2]) * G / weight
    # velocities of half steps: they began to grow half a step earlier
    seconds = 0.1 + 0.5 * stepper.clock.last_dt
    assert fallen == pytest.approx(0.5 * G * seconds**2, rel=1e-5)
