# SPDX-License-Identifier: LGPL-3.0-or-later
"""Inverse dynamics of a lower body by OpenSim, with and without the loads of a folder.

    python opensim_program.py FOLDER

reads FOLDER/body.json: hip centres and joint offsets [m] in the axes of the bodies above; writes
the change of the torques to FOLDER/change.json, coordinate -> list, with `time`. Needs OpenSim
alone, whose numpy is newer than that of some systems: it runs in a Python of its own.
"""

import json
import os
import sys

import opensim

AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}


def joint(name, above, place, below, turns, shifts=()):
    """A joint that turns about z, x, y one after the other, and shifts along x, y, z.

    Those of a left hip turn about -x and -y, so that inward is positive on both sides.
    """
    inward = -1 if name.endswith("femur_l") else 1
    transform = opensim.SpatialTransform()
    for k, coordinate in enumerate([*turns, *[None] * (3 - len(turns)), *shifts]):
        sign = inward if k in (1, 2) else 1
        axis = opensim.Vec3(*(sign * component for component in AXES["zxyxyz"[k]]))
        transform.updTransformAxis(k).setAxis(axis)
        if coordinate is not None:
            names = opensim.ArrayStr()
            names.append(coordinate)
            transform.updTransformAxis(k).setCoordinateNames(names)
            transform.updTransformAxis(k).set_function(opensim.LinearFunction(1, 0))
    nought = opensim.Vec3(0)
    return opensim.CustomJoint(
        name, above, opensim.Vec3(*place), nought, below, nought, nought, transform
    )


def model(body):
    """Pelvis and legs; masses are of no account, as they drop out of the change."""
    made = opensim.Model()
    made.setName("legs")

    def part(name, above, place, turns, shifts=()):
        one = opensim.Body(name, 5.0, opensim.Vec3(0), opensim.Inertia(0.1, 0.1, 0.1))
        made.addBody(one)
        made.addJoint(joint(f"to_{name}", above, place, one, turns, shifts))
        return one

    turns = ["pelvis_tilt", "pelvis_list", "pelvis_rotation"]
    shifts = ["pelvis_tx", "pelvis_ty", "pelvis_tz"]
    pelvis = part("pelvis", made.getGround(), (0, 0, 0), turns, shifts)
    for side in "rl":
        hip = [f"hip_flexion_{side}", f"hip_adduction_{side}", f"hip_rotation_{side}"]
        femur = part(f"femur_{side}", pelvis, body[f"hip_{side}"], hip)
        tibia = part(f"tibia_{side}", femur, body[f"knee_{side}"], [f"knee_angle_{side}"])
        part(f"calcn_{side}", tibia, body[f"ankle_{side}"], [f"ankle_angle_{side}"])
    made.finalizeConnections()
    return made


def torques(made, loads, name, begin, end):
    """Table of joint torques with external loads, or without where there is no file."""
    tool = opensim.InverseDynamicsTool()
    tool.setModel(made)
    tool.setCoordinatesFileName("coordinates.mot")
    if loads:
        tool.setExternalLoadsFileName(loads)
    tool.setLowpassCutoffFrequency(-1)
    tool.setStartTime(begin)
    tool.setEndTime(end)
    tool.setResultsDir(".")
    tool.setOutputGenForceFileName(name)
    if not tool.run():
        raise SystemExit("inverse dynamics failed")
    return opensim.TimeSeriesTable(name)


def main(folder):
    os.chdir(folder)
    with open("body.json") as file:
        body = json.load(file)
    made = model(body)
    made.initSystem()
    names = {made.getCoordinateSet().get(i).getName() for i in range(made.getNumCoordinates())}
    forces = opensim.ForceSet("coordinate_forces.xml")
    assert forces.getSize() == body["forces"], forces.getSize()
    for i in range(forces.getSize()):
        one = opensim.ExpressionBasedCoordinateForce.safeDownCast(forces.get(i))
        assert one is not None and one.get_coordinate() in names
    assert opensim.TimeSeriesTable("coordinate_torques.sto").getNumRows() > 0
    times = opensim.TimeSeriesTable("external_loads.mot").getIndependentColumn()
    begin, end = times[3], times[len(times) - 4]
    without = torques(made, None, "without.sto", begin, end)
    loaded = torques(made, "external_loads.xml", "with.sto", begin, end)
    change = {"time": list(without.getIndependentColumn())}
    for label in without.getColumnLabels():
        a, b = (t.getDependentColumn(label).to_numpy() for t in (without, loaded))
        change[label.removesuffix("_moment")] = (b - a).tolist()
    # a model that carries the fitted forces can be made and evaluated
    for i in range(forces.getSize()):
        made.addForce(forces.get(i).clone())
    made.realizeDynamics(made.initSystem())
    with open("change.json", "w") as file:
        json.dump(change, file)


if __name__ == "__main__":
    main(sys.argv[1])
