# SPDX-License-Identifier: LGPL-3.0-or-later
"""Scenes that were not used for the fit: what their errors were predicted to be, and what they are.

Other numbers of turns, sheets, frictions, angles, radii and fabrics than those of cases.py.
Each gives the choice made for an error asked for and the error reached, against the exact value
where there is one and against a mesh of about half the cells' size where there is none.
`python -m demos.studies.accuracy.run --held-out` prints the table.
"""

import argparse
import math

import numpy as np

from demos import capstan, hinge_sleeve, roll_up, strip_over_cylinder
from demos.studies.accuracy.cases import neighbours
from demos.studies.drape.square import RADIUS, G, Scene, run
from shellform import Statics
from shellform.accuracy.choice import LEADING, choose

WITHIN = 2.0  # factor between errors predicted and reached


def rolled(turns, length, thickness, asked):
    """Another roll-up: position of the tip, exact."""
    options = argparse.Namespace(
        turns=turns, length=length, thickness=thickness, accuracy=asked, degree=1, cells=None
    )
    choice = roll_up.cells_for(options)
    shell, kappa = roll_up.strip(options)
    with Statics(shell) as statics:
        for _ in statics.march(math.ceil(20 * turns)):
            pass
        tip = shell.displacement_at((length, 0, 0)) + (length, 0, 0)
    goal = roll_up.circle(kappa, np.array([length]))[0]
    return choice, float(np.linalg.norm(tip - goal) / length)


def pulled(mu, radius, angle, asked):
    """Another belt on a cylinder: force at its end, exact."""
    arc = angle * radius
    choice = choose("capstan", asked, radius, capstan.sensitivity(mu, angle))
    cells = math.ceil(arc / choice.size)
    choice = choice.at(arc / cells)
    stepper, out = capstan.belt(cells, mu, radius, angle)
    found = capstan.ratios(stepper, out, arc / cells)
    return choice, capstan.deviation(found, capstan.exact(mu, angle))


def hung(radius, length, bending_length, asked):
    """Another strip over a cylinder: position of its tip, exact; averaged as in cases.py."""
    scene = strip_over_cylinder.Scene(radius, length, bending_length)
    choice = choose("strip", asked, min(radius, bending_length))
    cells = math.ceil(length / choice.size)
    choice = choice.at(length / cells)
    exact = strip_over_cylinder.elastica(scene)
    tips = [
        strip_over_cylinder.measure(exact, *strip_over_cylinder.strip(scene, n, 0))["tip"]
        for n in neighbours(cells)
    ]
    return choice, float(np.sqrt(np.mean(np.square(tips))))


def bent(radius, angle, asked):
    """Another knee in a sleeve: course of the torque, against more than twice the cells."""
    options = argparse.Namespace(
        friction=[0.0], angle=angle, period=0.3, cycles=1, radius=radius, accuracy=asked,
        around=None, time_step_factor=0.9, rotary_scale=hinge_sleeve.ROTARY_SCALE,
        mass_scale=1.0,
    )  # fmt: skip
    choice = hinge_sleeve.cells_for(options)
    fine = hinge_sleeve.replace_around(options, 2 * options.around + 4)
    runs = (hinge_sleeve.cycles(one, 0.0) for one in (fine, options))
    return choice, hinge_sleeve.apart(*runs)


def draped(stiffer, asked):
    """The square of another fabric on the sphere: mean height, against twice the cells."""
    scene = Scene()
    bending = stiffer * scene.bending
    length = min(RADIUS, (bending / (0.2 * G)) ** (1 / 3))
    choice = choose("drape", asked, length)
    cells = math.ceil(1 / choice.size)
    choice = choice.at(1 / cells)
    heights = [run(Scene(cells=n, bending=bending))["height"] for n in (2 * cells, cells)]
    return choice, abs(heights[1] - heights[0]) / abs(heights[0])


# (name, what is asked of it, function, arguments)
SCENES = [
    ("2 turns, 5 m, t/L = 1/1000", "roll_up", rolled, (2.0, 5.0, 0.005, 0.003)),
    ("1/2 turn, 1 m, t/L = 1/500", "roll_up", rolled, (0.5, 1.0, 0.002, 0.01)),
    ("1 1/2 turns, 3 m, t/L = 1/100", "roll_up", rolled, (1.5, 3.0, 0.03, 0.003)),
    ("belt, friction 0.5 on 115 degrees of 60 mm", "capstan", pulled, (0.5, 0.06, 2.0, 0.01)),
    ("belt, friction 0.2 on 229 degrees of 150 mm", "capstan", pulled, (0.2, 0.15, 4.0, 0.003)),
    ("strip of 0.3 m, 35 mm, on 70 mm, 3 meshes", "strip", hung, (0.07, 0.3, 0.035, 0.003)),
    ("strip of 0.35 m, 50 mm, on 80 mm, 3 meshes", "strip", hung, (0.08, 0.35, 0.05, 0.003)),
    ("sleeve on a knee of 50 mm, 15 degrees", "sleeve", bent, (0.05, 15.0, 0.04)),
    ("sleeve on a knee of 75 mm, 25 degrees", "sleeve", bent, (0.075, 25.0, 0.04)),
    ("square 25 times as stiff on a sphere", "drape", draped, (25.0, 0.03)),
]


def measure(name, case, function, given):
    """Row of a table: scene, asked, predicted, reached, their ratio, whether both are kept."""
    choice, error = function(*given)
    ratio = error / choice.error
    return {
        "scene": name,
        "of": LEADING[case],
        "asked": given[-1],
        "cell_size": choice.size,
        "promised": choice.kept,
        "predicted": choice.error,
        "reached": error,
        "ratio": ratio,
        "asked_kept": error <= given[-1],
        "within": 1 / WITHIN <= ratio <= WITHIN,
    }


def line(row):
    """A row for a person."""
    numbers = "  ".join(f"{100 * row[key]:9.2g}" for key in ("asked", "predicted", "reached"))
    kept = "yes" if row["within"] else "no"
    return f"{row['scene']:45} {row['of']:9} {numbers}  {row['ratio']:5.2f}  {kept}"


HEAD = f"{'scene':45} {'of':9}   asked %  predict %  reached %  ratio  within a factor 2"
