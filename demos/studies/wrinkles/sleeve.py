# SPDX-License-Identifier: LGPL-3.0-or-later
"""The sleeve of hinge_sleeve.py bent to 135 degrees, its crease pressed between calf and thigh.

The flesh of both parts yields. Torque and strain energy against the angle, of relaxed coarse cells
and of cells that are small against the waves of the pressed cloth, 2 pi (D/k)^(1/4) = 33 mm.
"""

import time

import numpy as np

from demos import hinge_sleeve as hinge
from shellform.contact_coupling.contact import Contact
from shellform.dynamics.explicit import Newmark
from shellform.results.joint_torque import Torque
from shellform.results.ledger import Ledger

FLESH = 2e5  # Pa/m, of each part


def bend(
    size: float,
    wrinkles: str,
    angle: float = 135.0,
    period: float = 1.0,
    windows: int = 27,
    flesh: float = FLESH,
    start: int = 0,
) -> dict:
    """Bend once, in half a period [s], with cells of a size [m], without friction.

    Returns
    -------
    dict: `angle` [degrees], `torque` [N m] (k,), means over equal angles; `strain` [J] (k,) at
    their ends; `size`, `nodes`, `steps`, `seconds`, `pinched`: most nodes pressed on both sides
    """
    options = hinge.arguments(["--angle", str(angle), "--cycles", "1", "--period", str(period)])
    options.around = int(round(2 * np.pi * options.radius / size))
    shell = hinge.sleeve(options, wrinkles)
    begin = time.process_time()
    stepper = Newmark(shell, 0.9, drag=100.0)
    if start:
        stepper.v[:, :3] += 2e-3 * np.random.default_rng(start).normal(size=stepper.v.shape)
    contact = stepper.add(Contact(hinge.knee(options), 0.0, flesh_stiffness=flesh))
    stepper.advance(hinge.STILL)
    stepper.drag = 30.0
    contact.reset()
    torque, ledger = stepper.add(Torque()), stepper.add(Ledger())
    # the angle is A sin^2(pi t/T): times of equal angles
    degrees = angle * np.arange(1, windows + 1) / windows
    times = hinge.STILL + period / np.pi * np.arcsin(np.sqrt(degrees / angle))
    found, strain, pinched = [], [], 0
    for t in times:
        stepper.advance(t)
        (row,) = [r for r in torque.record(t) if r["joint"] == "right_knee"]
        found.append(row["torque_flexion"])
        strain.append(ledger.record()["strain"])
        pinched = max(pinched, contact.pinched)
    return {
        "size": hinge.size_of(options),
        "wrinkles": wrinkles,
        "angle": degrees - 0.5 * angle / windows,
        "torque": np.array(found),
        "strain": np.array(strain),
        "nodes": len(shell.surface.points),
        "steps": stepper.steps,
        "pinched": pinched,
        "seconds": time.process_time() - begin,
    }
