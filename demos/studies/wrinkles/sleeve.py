# SPDX-License-Identifier: LGPL-3.0-or-later
"""A loose sleeve around a knee bent to 135 degrees, its crease pressed between calf and thigh.

The scene of demos/hinge_sleeve.py, made for a deep bend: the limb ends in round knees, the sleeve
is as wide as the limb a hand above and below, held by friction; the flesh of both parts yields.
Torque and strain energy against the angle, of relaxed coarse cells and of cells that are small
against the waves of pressed cloth, 2 pi (D/k)^(1/4) = 33 mm.
"""

import time
from typing import Any

import numpy as np

import meshes
from shellform import Fabric, Shell
from shellform.contact_coupling.contact import Contact
from shellform.dynamics.explicit import Newmark
from shellform.motion.recording import Recording
from shellform.motion.wearer import Wearer
from shellform.results.joint_torque import Torque
from shellform.results.ledger import Ledger

LENGTH, RADIUS, MIDDLE = 0.3, 0.06, 0.24  # m: ellipsoids of the limb; from the knee to a middle
REST, HALF = 0.055, 0.12  # m: radius of the sleeve, half its length
STILL, PERIOD = 0.05, 1.0  # s: to settle; of a bend, half of it here
FLESH, FRICTION = 2e5, 0.3  # Pa/m, of each part
BELOW = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -0.4], [0.0, -0.06, -0.4]])  # J1, J2, M of the shank
ABOVE = np.array([[0.0, 0.0, 0.4], [0.0, 0.0, 0.0], [0.0, -0.06, 0.0]])  # of the thigh


def knee(angle: float) -> Wearer:
    """A thigh that stands still, a shank that bends by `angle` [degrees] in half a period."""
    times = np.linspace(0.0, STILL + 0.5 * PERIOD, 401)
    flexion = np.radians(angle) * np.sin(np.pi * np.maximum(times - STILL, 0.0) / PERIOD) ** 2
    cos, sin = np.cos(flexion), np.sin(flexion)
    parts = np.outer(sin, BELOW[:, 2]), np.tile(BELOW[:, 1], (401, 1)), np.outer(cos, BELOW[:, 2])
    points = {"right_thigh": np.array([ABOVE] * 401), "right_shank": np.stack(parts, axis=-1)}
    radii, middle = (LENGTH, RADIUS, RADIUS), 0.2 - MIDDLE
    ellipsoids = [("thigh", "right_thigh", (middle, 0, 0), radii)]
    ellipsoids += [("shank", "right_shank", (-middle, 0, 0), radii)]
    return Wearer(Recording(times, points, "knee"), ellipsoids)


def sleeve(size: float, wrinkles: str) -> Shell:
    """The sleeve, clear of the limb, with cells of a size [m]."""
    around = round(2 * np.pi * REST / size)
    # an odd number along: a row of nodes in the crease would be caught there
    along = 2 * max(1, round(HALF / size - 0.5)) + 1
    surface = meshes.cylinder(REST, 2 * HALF, (around, along))
    surface = surface.transform(translation=(0, 0, -HALF)).replace(warp=(0.0, 0.0, 1.0))
    plane = np.diag([1.0, 1.0, 0.3])
    fabric = Fabric.from_stiffness(2e3 * plane, 3e-4 * plane, 0.2, thickness=1e-3)
    shell = Shell(surface, fabric, wrinkles=wrinkles)
    X = surface.points[shell.partition.nodes]
    limb = RADIUS * np.sqrt(1 - ((MIDDLE - np.abs(X[:, 2:])) / LENGTH) ** 2) + 1e-3
    shell.w.x.array.reshape(-1, 6)[:, :2] = (np.maximum(limb, REST) / REST - 1) * X[:, :2]
    return shell


def bend(
    size: float,
    wrinkles: str,
    angle: float = 135.0,
    windows: int = 27,
    flesh: float = FLESH,
    friction: float = FRICTION,
    start: int = 0,
) -> dict[str, Any]:
    """Bend once with cells of a size [m]; `start` other than 0 gives nodes random speeds.

    Returns
    -------
    dict: `angle` [degrees], `torque` [N m] (k,), means over equal angles; `strain` [J] (k,) at
    their ends; `size`, `nodes`, `steps`, `seconds`, `pinched`: most nodes pressed on both sides
    """
    shell, begin = sleeve(size, wrinkles), time.process_time()
    stepper = Newmark(shell, 0.9, drag=100.0)
    if start:
        stepper.v[:] += 2e-3 * np.random.default_rng(start).normal(size=stepper.v.shape)
    contact = stepper.add(Contact(knee(angle), friction, flesh_stiffness=flesh))
    stepper.advance(STILL)
    stepper.drag = 30.0
    contact.reset()
    torque, ledger = stepper.add(Torque()), stepper.add(Ledger())
    # the angle is A sin^2(pi t/T): times of equal angles
    degrees = angle * np.arange(1, windows + 1) / windows
    times = STILL + PERIOD / np.pi * np.arcsin(np.sqrt(degrees / angle))
    found, strain, pinched = [], [], 0
    for t in times:
        stepper.advance(t)
        (row,) = [r for r in torque.record(t) if r["joint"] == "right_knee"]
        found.append(row["torque_flexion"])
        strain.append(ledger.record()["strain"])
        pinched = max(pinched, contact.pinched)
    return {
        "size": size,
        "wrinkles": wrinkles,
        "angle": degrees - 0.5 * angle / windows,
        "torque": np.array(found),
        "strain": np.array(strain),
        "nodes": len(shell.surface.points),
        "steps": stepper.steps,
        "pinched": pinched,
        "seconds": time.process_time() - begin,
    }
