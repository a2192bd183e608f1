# SPDX-License-Identifier: LGPL-3.0-or-later
"""A shell in contact: weight carried, momentum closed, turned scenes, incline, belt."""

import numpy as np
import pytest

import meshes
from contact.body.segments import Body, Fixed, Segment
from shellform import Fabric, Shell
from shellform.contact_coupling.contact import Contact
from shellform.dynamics.explicit import Newmark
from shellform.fem.director import rotation_matrix
from shellform.fem.lumped_mass import nodal_areas
from shellform.results.ledger import Ledger
from tests.contact.solver.surfaces import ball, box, tube

CLOTH = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "thickness": 1e-3, "density": 200.0}
G = 9.81


# the same bodies of triangles, with a sagitta of 2 mm
KINDS = pytest.mark.parametrize(
    "kind", ["ellipsoid", pytest.param("triangles", marks=pytest.mark.serial)]
)


def sphere(radius=0.25, centre=(0.0, 0.0, -0.25)):
    return Body([Segment("sphere", [radius] * 3, Fixed(centre))])


def over_sphere(cells=10, turn=None, friction=0.3, height=2e-3, body=None, **damping):
    """A square of 0.5 m a little above a limb, the whole scene turned by a rotation."""
    turn = np.eye(3) if turn is None else turn
    surface = meshes.rectangle(
        0.5, 0.5, (cells, cells), parameters=meshes.distorted((cells, cells), 0.1, seed=1)
    ).transform(translation=(-0.24, -0.255, height))
    surface = surface.transform(rotation=turn)
    shell = Shell(surface, Fabric.isotropic(**CLOTH))
    shell.loads.gravity(turn @ [0.0, 0.0, -G])
    place = Fixed(turn @ [0, 0, -0.25], turn.T)
    limb = body(place) if body else Body([Segment("limb", (0.2, 0.3, 0.25), place)])
    stepper = Newmark(shell, 0.8, **damping)
    return stepper, stepper.add(Contact(limb, friction))


def test_momentum_closes_in_every_step():
    """Loads, supports, drag and contact leave 1e-10 of the weight's impulse over."""
    stepper, touch = over_sphere(drag=1.0, damping=1e-4)
    comm, weight = stepper.shell.comm, stepper.shell.fabric.areal_mass * 0.25 * G
    contact = 0
    for _ in range(300):
        before = comm.allreduce(stepper.mass @ stepper.v)
        booked = [stepper.external_total.copy(), stepper.drag_total.copy()]
        dt = stepper.dt
        stepper.step(dt)
        impulse = touch.correction.last.impulse.sum(axis=0)
        impulse = impulse + stepper.external_total - booked[0] + stepper.drag_total - booked[1]
        change = comm.allreduce(stepper.mass @ stepper.v) - before
        assert np.abs(change - comm.allreduce(impulse)).max() < 1e-10 * weight * dt
        contact += comm.allreduce(touch.correction.active)
    assert contact > 100


def test_free_sheet_rests_with_its_weight_on_the_body():
    """Mean contact force at rest is the weight, to 0.1 % up and aside."""
    stepper, _ = over_sphere(drag=8.0, damping=1e-3)
    ledger = stepper.add(Ledger())
    stepper.advance(3.0)
    ledger.record()
    stepper.drag = 0.0  # what rests must stay so by itself
    stepper.advance(3.6)
    row = ledger.record()
    force = np.array([row[f"force_limb_{a}"] for a in "xyz"])
    weight = stepper.shell.fabric.areal_mass * 0.25 * G
    assert row["active"] > 3
    assert np.abs(force - [0, 0, weight]).max() < 1e-3 * weight
    assert row["momentum_residual"] < 1e-10 * weight
    assert row["kinetic"] < 1e-6


def test_forces_turn_with_the_scene():
    """200 steps of a turned scene give the turned forces and places."""
    R = rotation_matrix([0.7, -1.1, 0.4])
    runs = []
    for turn in (np.eye(3), R):
        stepper, touch = over_sphere(turn=turn, height=1e-3)
        stepper.recheck = 10**9
        stepper.dt = 2e-4
        stepper.advance(200 * 2e-4)
        shell = stepper.shell
        runs.append((shell.partition.gather(touch.correction.window.impulse), shell.positions()))
        assert stepper.steps == 200
    (impulse, place), (turned_impulse, turned_place) = runs
    assert np.abs(impulse).max() > 0
    assert np.abs(turned_impulse - impulse @ R.T).max() < 1e-9 * np.abs(impulse).max()
    assert np.abs(turned_place - place @ R.T).max() < 1e-9


@pytest.mark.parametrize(
    ("kind", "speed"),
    [
        *[("ellipsoid", v) for v in (0.1, 1.0, 10.0, 100.0)],
        ("triangles", 1.0),
        ("triangles", 100.0),
    ],
)
def test_impact_of_a_patch(kind, speed):
    """No tunnelling, momentum exact, energy never grows, at any speed."""
    surface = meshes.rectangle(0.1, 0.1, (6, 6)).transform(translation=(-0.05, -0.05, 0.01))
    shell = Shell(surface, Fabric.isotropic(**CLOTH))
    stepper = Newmark(shell, 0.2)
    stepper.v[:, 2] = -speed
    # a large sphere: a patch thrown at it at this speed would cross it many times over
    centre = (0.0, 0.0, -0.3)
    body = sphere(0.3, centre) if kind == "ellipsoid" else ball(0.3, 3, centre)
    stepper.add(Contact(body, friction=0.3))
    ledger = stepper.add(Ledger())
    first = ledger.record()
    last = start = first["kinetic"] + first["strain"]
    steps = min(5000, int(0.05 / speed / stepper.dt) + 500)
    for k in range(10):
        stepper.advance(stepper.time + steps / 10 * stepper.dt)
        row = ledger.record()
        energy = row["kinetic"] + row["strain"]
        # central differences let the sum of both energies swing by (omega dt)^2/8 of the vibration
        # that an impact leaves in the sheet; it falls as the square of the step
        assert energy < 1.01 * last, k
        assert energy < start * (1 + 1e-9)
        last = min(last, energy)
        assert row["momentum_residual"] < 1e-12 * first["momentum_z"] * -1 + 1e-15
        inside = np.linalg.norm(shell.positions() - [0, 0, -0.3], axis=1).min()
        assert inside > 0.3 + 0.5 * CLOTH["thickness"] - 1e-9
    assert ledger.rows[-1]["time"] > 0.01 / speed  # it has met the body


@pytest.mark.parametrize(
    ("kind", "slope"), [("ellipsoid", 0.4), ("ellipsoid", 0.6), ("triangles", 0.6)]
)
def test_patch_on_an_incline(kind, slope):
    """mu = 0.5: below it sticks for good, above it slides by (sin - mu cos) g t^2/2."""
    radius, mu = 1e4, 0.5
    surface = meshes.rectangle(0.02, 0.02, (2, 2)).transform(translation=(-0.01, -0.01, 5e-4))
    shell = Shell(surface, Fabric.isotropic(1e5, 0.3, 1e-3, 200.0))
    angle = np.arctan(slope)
    shell.loads.gravity(G * np.array([np.sin(angle), 0.0, -np.cos(angle)]))
    stepper = Newmark(shell, 0.9)
    body = sphere(radius, (0.0, 0.0, -radius))
    if kind == "triangles":
        body = box([3.0, 1.0, 0.1], 20, Fixed((1.0, 0.0, -0.1)))
    touch = stepper.add(Contact(body, friction=mu))
    seconds = 10.0 if slope < mu else 1.0
    stepper.advance(seconds)
    travel = shell.displacements()[:, 0]
    if slope < mu:
        assert np.abs(travel).max() < 1e-9
        assert touch.correction.sticking == touch.correction.active
    else:
        exact = 0.5 * G * (np.sin(angle) - mu * np.cos(angle)) * seconds**2
        assert travel.mean() == pytest.approx(exact, rel=1e-3)


def belt_ratio(cells, kind="ellipsoid", mu=0.3, radius=0.1, width=0.02):
    """Tension pulled over tension held of a belt that slides over half a cylinder."""
    tail = 0.1
    arc = np.pi * (radius + 5e-4)
    length = arc + 2 * tail

    def place(a, b):
        s = a * length - tail
        phi = np.clip(s / arc, 0, 1) * np.pi
        down = np.where(s < 0, s, np.where(s > arc, arc - s, 0.0))
        r = radius + 5e-4
        return -r * np.cos(phi), width * (b - 0.5), r * np.sin(phi) + down

    # nodes on both tangent points: a whole number of cells on the arc and on the tails
    ends = max(2, round(cells * tail / arc))
    s = np.concatenate(
        [
            np.linspace(-tail, 0, ends + 1)[:-1],
            np.linspace(0, arc, cells + 1)[:-1],
            np.linspace(arc, arc + tail, ends + 1),
        ]
    )
    a = (s + tail) / length
    parameters = np.stack(np.meshgrid(a, [0.0, 1.0], indexing="ij"), axis=-1)
    surface = meshes.patch(place, (len(a) - 1, 1), parameters=parameters)
    fabric = Fabric.from_stiffness(
        1e4 * np.diag([1, 1, 0.5]), 1e-6 * np.diag([1, 1, 0.5]), areal_mass=0.2, thickness=1e-3
    )
    shell = Shell(surface, fabric)
    held, speed = 2.0, 0.05
    for edge in ("bottom", "top"):
        shell.supports.symmetry(edge, (0, 1, 0))
    shell.loads.line("left", (0, 0, -held / width), lambda t: min(1.0, t / 0.02))
    shell.supports.hold("right")
    shell.supports.move("right", lambda t: np.array([0.0, 0.0, -speed * t]))
    stepper = Newmark(shell, 0.9, damping=2e-4, drag=2.0)
    body = Body([Segment("cylinder", (radius, 100.0, radius), Fixed())])
    if kind == "triangles":
        body = tube(radius, 0.3, 16, 9, axis=1)
    stepper.add(Contact(body, friction=mu))
    # held nodes are left alone by contact: let the sides slide in their planes by the load only
    stepper.contact.correction.fixed[:] = False
    stepper.advance(0.25)
    comm = shell.comm
    before = comm.allreduce(stepper.support_total).copy()
    held_before = stepper.time
    stepper.advance(0.35)
    pull = -(comm.allreduce(stepper.support_total) - before)[2] / (stepper.time - held_before)
    # what air drag and the weight of the two tails add is small and known to be so
    return pull / held


@pytest.mark.slow
@pytest.mark.parametrize(
    "kind", ["ellipsoid", pytest.param("triangles", marks=pytest.mark.thorough)]
)
def test_capstan(kind):
    """A sliding belt: T2/T1 = exp(mu phi) within 1 %, closing in with the square of the cells."""
    mu, angle = 0.3, np.pi
    ratios = [belt_ratio(cells, kind, mu) for cells in (8, 16, 24)]
    errors = np.abs(np.array(ratios) / np.exp(mu * angle) - 1)
    assert errors[-1] < 3e-3
    assert np.log2(errors[0] / errors[1]) > 1.8


def stretched_onto(surface, body, stretch, clamped=()):
    """A sheet put on a body, nodes where `stretch` sends them, settled; mean contact forces."""
    fabric = Fabric.from_stiffness(
        1e3 * np.diag([1, 1, 0.5]), 1e-7 * np.diag([1, 1, 0.5]), areal_mass=0.2, thickness=1e-3
    )
    shell = Shell(surface, fabric)
    shell.w.x.array.reshape(-1, 6)[:, :3] = stretch(surface.points[shell.partition.nodes])
    for edge in clamped:
        shell.supports.clamp(edge)
    stepper = Newmark(shell, 0.9, damping=2e-4, drag=60.0)
    touch = stepper.add(Contact(body, friction=0.0))
    stepper.advance(0.08)
    touch.correction.reset()
    stepper.advance(0.12)
    window = touch.correction.window
    return shell.partition.gather(window.impulse / window.seconds)


@KINDS
def test_sleeve_stretched_over_a_cylinder(kind):
    """Normal force: hoop tension over radius, N/R, within 1 %."""
    rest, radius, long = 0.048, 0.05, 0.1
    surface = meshes.cylinder(rest, long, (40, 6)).transform(translation=(0, 0, -0.5 * long))
    surface = surface.replace(warp=(0.0, 0.0, 1.0))
    limb = Body([Segment("arm", (radius - 5e-4, radius - 5e-4, 200.0), Fixed())])
    if kind == "triangles":
        limb = tube(radius - 5e-4, 0.3, 11, 9)
    force = stretched_onto(surface, limb, lambda X: (radius / rest - 1) * X * [1.0, 1.0, 0.0])
    # second Piola-Kirchhoff force per rest length, pushed forward: N = E t e (R/r), e Green's
    hoop = 1e3 * 0.5 * ((radius / rest) ** 2 - 1) * radius / rest
    outward = surface.points * [1, 1, 0] / rest
    total = np.sum(force * outward)
    assert total == pytest.approx(2 * np.pi * long * hoop, rel=1e-2)
    assert np.abs(np.sum(force, axis=0)).max() < 1e-3 * total


@KINDS
def test_cap_stretched_over_a_sphere(kind):
    """Normal pressure of a sheet under equal tension N: N (1/R + 1/R), within 1 %."""
    rest, radius = 0.195, 0.2
    surface = meshes.spherical_cap(rest, (0.6, 2.4), cells=(32, 16))
    surface = surface.replace(warp=(0.0, 0.0, 1.0))
    body = Body([Segment("head", [radius - 5e-4] * 3, Fixed())])
    if kind == "triangles":
        body = ball(radius - 5e-4, 3)
    scale = radius / rest
    # the rims are held where the stretch puts them: the cap stays in equal tension
    force = stretched_onto(surface, body, lambda X: (scale - 1) * X, clamped=("bottom", "top"))
    tension = 1e3 * 0.5 * (scale**2 - 1)
    outward = surface.points / rest
    normal = np.sum(force * outward, axis=1)
    free = np.ones(len(normal), bool)
    free[np.unique([*surface.edges["bottom"].ravel(), *surface.edges["top"].ravel()])] = False
    area = nodal_areas(surface) * scale**2
    pressure = normal[free].sum() / area[free].sum()
    assert pressure == pytest.approx(2 * tension / radius, rel=1e-2)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"body": 3}, "takes a Body"),
        ({"friction": "a"}, "not 'a'"),
        ({"friction": None}, "not None"),
        ({"friction": (0.1, 0.5)}, "the larger one first"),
        ({"offset": -1.0}, "offset of a contact is a finite number >= 0, not -1.0"),
        ({"flesh_stiffness": -5.0}, "flesh_stiffness of a contact .* not -5.0"),
        ({"recovery": 0.0}, "recovery speed is positive, in m/s, not 0.0"),
    ],
)
def test_a_contact_that_is_none_is_refused_where_it_is_written(settings, said):
    body = Body([Segment("ball", (0.1, 0.1, 0.1), Fixed())])
    with pytest.raises((ValueError, TypeError), match=said):
        Contact(**{"body": body} | settings)
