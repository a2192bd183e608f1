# SPDX-License-Identifier: LGPL-3.0-or-later
r"""One drape of the paper's Fig. 6, run to rest and put into numbers that can be compared.

The scene is that of drape.py. Two things are added. A small push at the start, the same smooth
field on every mesh, chooses among the states that a drape can end in. And the rim of the sheet is
read as a curve: its heights tell one state from another, the bulges of its outline seen from above
are the folds, as in Cusick's drape test.
"""

import time
from dataclasses import asdict, dataclass

from mpi4py import MPI

import numpy as np

import meshes
from contact.body.segments import Body, Fixed, Segment
from shellform import Fabric, Shell
from shellform.contact_coupling.contact import Contact
from shellform.dynamics.explicit import Newmark
from shellform.results.ledger import Ledger

COMM = MPI.COMM_WORLD
G, RADIUS, FRICTION, WINDOW = 9.81, 0.25, 0.3, 0.2  # m/s^2, m, 1, s
CENTRE = np.array([0.0, 0.0, -0.05 - RADIUS])
RIM = 256  # points read along the rim
DEEP = 0.02  # m, a bulge of the outline that counts as a fold


@dataclass(frozen=True)
class Scene:
    """A square of 1 m above the sphere.

    Attributes
    ----------
    cells : int, along a side; pinned : bool, node 0 is held
    bending : float [N m]; membrane, wrinkles : see Shell
    distortion : float, of the mesh, see meshes.distorted
    model : 'explicit', 'particles' or 'implicit'
    factor : float, of the largest stable step, or with 'implicit' the step [ms]
    damping : float [s]; drag : float [1/s]; seconds : float
    start : int, 0: let go from rest; else the number of a push of 0.02 m/s
    """

    cells: int = 24
    pinned: bool = True
    bending: float = 9.16e-5
    membrane: str = "arcs"
    wrinkles: str = "resolved"
    distortion: float = 0.0
    model: str = "explicit"
    factor: float = 0.9
    damping: float = 2e-4
    drag: float = 3.0
    seconds: float = 3.0
    start: int = 0


def fabric(bending=9.16e-5):
    """E t = 1000 N/m, nu = 0.3, 0.2 kg/m^2, 1 mm; `bending` [N m] is D (1 - nu^2)."""
    nu = 0.3
    plane = np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    return Fabric.from_stiffness(
        1000.0 / (1 - nu**2) * plane, bending * plane, 0.2, 1e-3, name="drape"
    )


def push(points, number):
    """Velocities up (n,) [m/s] of a start: random waves of the square, 0.02 m/s in the mean.

    points : (n, 3) in the unit square about the origin; the waves do not know the mesh
    """
    if not number:
        return np.zeros(len(points))
    size = np.random.default_rng(number).standard_normal((5, 5))
    wave = np.cos(np.pi * np.arange(5) * (points[:, :2, None] + 0.5))
    # each wave but the level one has the mean square 1/2 along its axis
    norm = np.sqrt(np.sum(size**2 * np.outer([1, 0.5, 0.5, 0.5, 0.5], [1, 0.5, 0.5, 0.5, 0.5])))
    return 0.02 * np.einsum("ni,nj,ij->n", wave[:, 0], wave[:, 1], size) / norm


def build(scene):
    """Stepper and contact of a scene."""
    n = scene.cells
    square = meshes.rectangle(
        1.0, 1.0, (n, n), parameters=meshes.distorted((n, n), scene.distortion, seed=1)
    ).transform(translation=(-0.5, -0.5, 0.0))
    options = {"membrane": scene.membrane, "wrinkles": scene.wrinkles}
    shell = Shell(square, fabric(scene.bending), COMM, **options)
    if scene.pinned:
        shell.supports.hold(np.array([0]))
    shell.loads.gravity((0.0, 0.0, -G))
    body = Body([Segment("body", [RADIUS] * 3, Fixed(CENTRE))])
    if scene.model == "implicit":
        from shellform.dynamics.implicit import ImplicitNewmark

        stepper = ImplicitNewmark(shell, 1e-3 * scene.factor, alpha=-0.1, drag=scene.drag)
        touch = stepper.add(Contact(body, FRICTION))
    else:
        if scene.model == "particles":
            from shellform.dynamics.mass_spring import Particles as Model
        else:
            Model = Newmark
        stepper = Model(shell, scene.factor, damping=scene.damping, drag=scene.drag)
        touch = stepper.add(Contact(body, FRICTION))
    free = ~shell.supports.held[: stepper.n_owned, 2]
    stepper.v[free, 2] = push(stepper.points, scene.start)[free]
    return stepper, touch


def run(scene):
    """Drape a scene.

    Returns
    -------
    dict: forces [N] and strain energy [J] are means over the last 0.2 s; `positions`, `directors`,
    `quads` and `rim` (RIM, 3) are arrays, all else numbers for a table
    """
    stepper, _ = build(scene)
    shell, ledger = stepper.shell, stepper.add(Ledger())
    stepper.advance(stepper.dt)  # compiles what is compiled when first used
    start, done = time.process_time(), stepper.steps
    stepper.advance(scene.seconds - WINDOW)
    ledger.record()
    pin = ledger.rows[-1]["support_impulse_z"]
    for k in range(1, 6):
        stepper.advance(scene.seconds - WINDOW * (1 - k / 5))
        ledger.record()
    spent = COMM.allreduce(time.process_time() - start)
    rows = ledger.rows[1:]
    mean = lambda key: float(np.mean([row[key] for row in rows]))  # noqa: E731
    x = shell.positions()
    mass = COMM.allreduce(stepper.mass.sum())
    z = (stepper.points + stepper.owned[:, :3])[:, 2]
    rim = rim_of(shell.surface, x)
    corner = x[shell.surface.points[:, :2].sum(axis=1).argmax()]
    nodes = len(x)
    return {
        "height": COMM.allreduce(stepper.mass @ z) / mass,
        "corner_z": corner[2],
        "corner_r": float(np.hypot(*corner[:2])),
        "force_side": float(np.hypot(mean("force_body_x"), mean("force_body_y"))),
        "force_up": mean("force_body_z"),
        "pin_up": (rows[-1]["support_impulse_z"] - pin) / WINDOW,
        "strain": mean("strain"),
        "kinetic": rows[-1]["kinetic"],
        "folds": folds(rim),
        "steps": stepper.steps,
        "dt": scene.seconds / stepper.steps,
        "us": 1e6 * spent / (stepper.steps - done) / nodes,
        "seconds": spent,
        "positions": x,
        "directors": shell.directors(),
        "quads": shell.surface.cells,
        "rim": rim,
    }


def row(options, label=(), **settings):
    """Run a scene with the drag and seconds of options: labels, settings and results."""
    scene = Scene(**{"drag": options.drag, "seconds": options.seconds} | settings)
    return dict(label) | asdict(scene) | run(scene)


def numbers(rows):
    """Rows without their arrays."""
    return [{k: v for k, v in row.items() if np.ndim(v) == 0} for row in rows]


def rim_of(surface, positions):
    """Points (RIM, 3) at even spacing along the rim of a square sheet, from its corner 0."""
    X = surface.points - surface.points.min(axis=0)
    x, y = X[:, 0] / X[:, 0].max(), X[:, 1] / X[:, 1].max()
    at = np.full(len(X), np.nan)
    for on, where in ((x < 1e-9, 4 - y), (y > 1 - 1e-9, 3 - x), (x > 1 - 1e-9, 1 + y)):
        at[on] = where[on]
    at[y < 1e-9] = x[y < 1e-9]
    nodes = np.flatnonzero(np.isfinite(at))
    nodes = nodes[np.argsort(at[nodes])]
    s = np.arange(RIM) * 4 / RIM
    return np.column_stack(
        [np.interp(s, at[nodes], column, period=4) for column in positions[nodes].T]
    )


def folds(rim, deep=DEEP):
    """Bulges of the rim's outline, seen from above, that stand out by more than `deep` [m]."""
    from scipy.signal import find_peaks

    radius = np.hypot(*(rim[:, :2] - CENTRE[:2]).T)
    first = int(radius.argmin())
    return len(find_peaks(np.append(np.roll(radius, -first), radius[first]), prominence=deep)[0])


def difference(one, other, pinned):
    """Root mean square of the difference of two rims' heights [m], sheets turned and mirrored.

    The scene is its own mirror image about the diagonal through the pin; without a pin it has the
    eight symmetries of the square.
    """
    a, b = one[:, 2], other[:, 2]
    turns = [0] if pinned else [0, RIM // 4, RIM // 2, 3 * RIM // 4]
    images = [np.roll(c, k) for k in turns for c in (b, np.roll(b[::-1], 1))]
    return min(float(np.sqrt(np.mean((a - image) ** 2))) for image in images)


def states(rims, pinned, apart=0.02):
    """Number (k,) of the state each of k rims is in, 0 the first met.

    Rims of one state differ by less than `apart` [m] (complete linkage).
    """
    from scipy.cluster.hierarchy import fcluster, linkage

    pairs = [
        difference(rims[i], rims[j], pinned)
        for i in range(len(rims))
        for j in range(i + 1, len(rims))
    ]
    label = fcluster(linkage(pairs, "complete"), apart, "distance")
    order = list(dict.fromkeys(label))
    return np.array([order.index(k) for k in label])
