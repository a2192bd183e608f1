# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sheets that meet themselves: scenes, and the checks that all of them have to pass.

This file is also the program that ranks run: `python -m tests.contact_coupling.layers OUT STEPS`,
the latter on soft triangles with `triangles` after them.
"""

import sys
from pathlib import Path

import numpy as np

import meshes
from contact.body.flesh_bed import Flesh
from contact.body.rigid_surface import RigidSurface
from contact.body.segments import Body, Fixed, Segment
from contact.geometry.triangle_mesh.sphere import sphere
from shellform import Fabric, Shell
from shellform.contact_coupling.contact import Contact
from shellform.contact_coupling.explicit_self_contact import triangles_of
from shellform.contact_coupling.self_contact import SelfContact
from shellform.dynamics.explicit import Newmark
from shellform.fem.director import rotation_matrix
from tests.contact.self_contact.meshes_of_triangles import crossings

THICKNESS, G = 1e-3, 9.81


def cloth():
    return Fabric.isotropic(1e5, 0.3, THICKNESS, 200.0)


def together(*sheets):
    """One surface of several, and the node at which each begins."""
    begins = np.cumsum([0] + [len(s.points) for s in sheets])
    cells = [s.cells + begin for s, begin in zip(sheets, begins, strict=False)]
    return meshes.Surface(np.concatenate([s.points for s in sheets]), np.concatenate(cells)), begins


def square(cells, size=0.3, turn=(0.0, 0.0, 0.0), shift=(0.0, 0.0, 0.0), triangles=False):
    sheet = meshes.rectangle(size, size, (cells, cells), triangles=triangles)
    sheet = sheet.transform(translation=(-0.5 * size, -0.5 * size, 0.0))
    return sheet.transform(rotation=rotation_matrix(turn)).transform(translation=shift)


def stepper_of(surface, steps=Newmark, gravity=None, **options):
    shell = Shell(surface, cloth())
    if gravity is not None:
        shell.loads.gravity(gravity)
    return steps(shell, 0.8, **options)


def dropped(steps=Newmark, triangles=False, speed=1.0, cells=5):
    """A sheet that flies onto another, turned and tilted, both free."""
    kind = {"triangles": triangles}
    surface, begins = together(
        square(cells, **kind),
        square(cells + 1, 0.25, (0.02, 0.03, 0.5), (0.01, 0.02, 8e-3), **kind),
    )
    stepper = stepper_of(surface, steps)
    stepper.v[stepper.shell.partition.owned_nodes >= begins[1], 2] = -speed
    return stepper, stepper.add(SelfContact(0.3))


def ball():
    """A sphere of 0.2 m below the origin."""
    return Body([Segment("ball", [0.2] * 3, Fixed((0.0, 0.0, -0.2)))])


def ball_of_triangles(divisions=3):
    """The same as a surface."""
    return RigidSurface(*sphere(0.2, divisions), Fixed((0.0, 0.0, -0.2)), "ball")


def stacked(cells, layers=5, drag=8.0, body=ball, **options):
    """Layers turned against each other on a sphere, and the contact with both."""
    sheets = [
        square(
            cells + k % 2,
            turn=(0.0, 0.0, 0.15 * k),
            shift=(1e-3 * k, 2e-3, THICKNESS * (0.501 + 1.01 * k)),
        )
        for k in range(layers)
    ]
    stepper = stepper_of(together(*sheets)[0], gravity=(0.0, 0.0, -G), drag=drag, damping=1e-3)
    return stepper, stepper.add(Contact(body(), 0.3, self_contact=True, **options))


def on_an_incline(tangent, friction=0.5):
    """A patch on a held sheet, both tilted; the contact and whether nodes are of the patch."""
    a = np.arctan(tangent)
    surface, begins = together(
        square(4), square(3, 0.1, shift=(4e-3, 7e-3, THICKNESS * (1 + 1e-6)))
    )
    shell = Shell(surface, cloth())
    shell.loads.gravity((G * np.sin(a), 0.0, -G * np.cos(a)))
    shell.supports.hold(np.arange(begins[1]))
    stepper = Newmark(shell)
    return stepper, stepper.add(SelfContact(friction)), shell.partition.owned_nodes >= begins[1]


def smooth(share):
    """0 to 1 without a jerk."""
    s = min(max(share, 0.0), 1.0)
    return s**3 * (10 - 15 * s + 6 * s * s)


def folded(cells, seconds):
    """The right edge of a sheet is laid over its left half, which is held; it then hangs on it."""
    surface = meshes.rectangle(0.4, 0.2, (2 * cells, cells))
    shell = Shell(surface, cloth())
    shell.loads.gravity((0.0, 0.0, -G))
    shell.supports.hold(np.flatnonzero(surface.points[:, 0] < 0.15))

    def over(time):
        a, r = np.pi * smooth(time / seconds), 0.15
        return np.array([0.2 + r * np.cos(a) - 0.35, 0.0, r * np.sin(a) + 8e-3 * a / np.pi])

    shell.supports.move("right", over)
    stepper = Newmark(shell, 0.8, drag=1.0, damping=2e-4)
    return stepper, stepper.add(SelfContact(0.3))


def wrung(cells, seconds, turns=2.0):
    """A towel whose ends are turned against each other, coming closer meanwhile."""
    length, width = 0.4, 0.12
    surface = meshes.rectangle(length, width, (round(cells * length / width), cells))
    surface = surface.transform(translation=(-0.5 * length, -0.5 * width, 0.0))
    shell = Shell(surface, cloth())
    for edge, side in (("left", -1.0), ("right", 1.0)):
        nodes = shell.partition.find(edge)
        x = surface.points[nodes]

        def turn(time, x=x, side=side):
            s = smooth(time / seconds)
            a = side * np.pi * turns * s
            y, z = np.cos(a) * x[:, 1] - np.sin(a) * x[:, 2], np.sin(a) * x[:, 1]
            return np.stack([x[:, 0] - 0.06 * side * s, y, z + np.cos(a) * x[:, 2]], axis=1) - x

        shell.supports.move(nodes, turn)
    stepper = Newmark(shell, 0.8, drag=2.0, damping=2e-4)
    stepper.v[:, 2] = 0.02 * np.sin(31 * surface.points[shell.partition.owned_nodes, 0])
    return stepper, stepper.add(SelfContact(0.3))


def crossing_legs(size, seconds):
    """Trousers that hang by the waist while each hem goes to the other side: the legs cross."""
    surface = meshes.trousers(cell_size=size)
    shell = Shell(surface, cloth())
    shell.loads.gravity((0.0, 0.0, -G))
    shell.supports.hold("waist")
    hems = [name for name in surface.edges if "hem" in name]
    for edge in hems:
        side = np.sign(surface.points[np.unique(surface.edges[edge]), 1].mean())

        def go(time, side=side):  # past each other first, then across
            s = 2.0 * time / seconds
            across, up = -0.3 * side * smooth(s - 1.0), 0.05 * smooth(s - 1.0)
            return np.array([0.16 * side * smooth(s), across, up])

        shell.supports.move(edge, go)
    stepper = Newmark(shell, 0.8, drag=2.0, damping=2e-4)
    return stepper, stepper.add(SelfContact(0.3))


def check(stepper):
    """No edge through a triangle, by a checker of the tests' own; all ranks call.

    Returns positions (n, 3) [m] and triangles (m, 3).
    """
    shell = stepper.shell
    x, triangles = shell.positions(), triangles_of(shell.surface)
    found = stepper.self_contact.intersections()
    assert found == crossings(x, triangles) == 0
    return x, triangles


SCENES = {
    "folded": lambda: (folded(4, 0.5)[0], 0.6),
    "wrung": lambda: (wrung(4, 0.8)[0], 0.9),
    "fine folded": lambda: (folded(16, 0.6)[0], 0.8),
    "fine wrung": lambda: (wrung(16, 1.0)[0], 1.2),
    "fine sheets": lambda: (dropped(cells=20)[0], 0.05),
    "layers": lambda: (stacked(6)[0], 0.5),
    "legs": lambda: (crossing_legs(0.035, 0.8)[0], 1.0),
}
QUICK = ("folded", "wrung")


def frames(name, count=10):
    """Positions at the outputs of a scene, and its triangles; each is checked."""
    stepper, seconds = SCENES[name]()
    found = []
    for k in range(1, count + 1):
        stepper.advance(seconds * k / count)
        x, triangles = check(stepper)
        found.append(x)
    assert stepper.self_contact.most_pairs > 10
    assert stepper.self_contact.closest > 0.9 * THICKNESS
    return np.array(found), triangles


def state(stepper):
    gather = stepper.shell.partition.gather
    return np.hstack([gather(a) for a in (stepper.owned, stepper.v, stepper.q)])


def advance(stepper, count, dt=2e-4):
    for _ in range(count):
        stepper.step(dt)


def scene_of_ranks(**options):
    """Layers that fall on a ball, with all kinds of rows within a few steps."""
    stepper, contact = stacked(4, layers=3, drag=0.5, **options)
    own = stepper.shell.partition.owned_nodes
    stepper.v[:, 2] = -0.3 - 0.1 * (own > 20)
    return stepper, contact


def main(out, count, triangles=False):
    options = {"body": ball_of_triangles, "flesh": Flesh(1e5)} if triangles else {}
    stepper, contact = scene_of_ranks(**options)
    advance(stepper, count)
    whole = state(stepper)
    impulse = stepper.shell.partition.gather(contact.window.impulse)
    if stepper.shell.comm.rank == 0:
        np.savez(out, state=whole, impulse=impulse, losses=contact.cloth.losses,
                 pairs=contact.cloth.most_pairs)  # fmt: skip


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), "triangles" in sys.argv)
