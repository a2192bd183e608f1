# SPDX-License-Identifier: LGPL-3.0-or-later
"""Checks on the values of a scene: their kinds, their ranges, and what goes together.

They run when a scene is made, before anything is read or computed, and name part, item, value and
mend in one sentence.
"""

from __future__ import annotations

from dataclasses import fields
from numbers import Integral, Real
from typing import TYPE_CHECKING, get_args

from shellform.accuracy.asked import relative_error

from .parts import PARTS

if TYPE_CHECKING:
    from shellform.material.sheet import Sheet

    from .scene import Scene

KINDS = {
    str: "a text",
    int: "a whole number",
    float: "a number",
    dict: "a table",
    list: "a list",
    bool: "true or false",
}
# what numbers may be, with what a number outside is likely to be
RANGES = {
    "belt": (0, 500, "a belt of 5 to 50 N is usual"),
    "gravity": (0, 30, "9.81 on earth"),
    "motion.cutoff": (0.5, 100, "6 Hz is usual for gait; none is not offered"),
    "motion.max_gap": (0, 1, "a gap is filled up to some tenths of a second"),
    "motion.initiation": (0, 10, "a second is usual"),
    "motion.obstacle": (0, 0.6, "a height in m: 0.5 as in the paper"),
    "motion.strides": (1, 50, "four as in the paper"),
    "person.stature": (1.0, 2.3, "a stature in m, as 1.76"),
    "person.mass": (25, 250, "a mass in kg, as 80"),
    "garment.weld": (0, 0.02, "a distance in m, as 1e-4; 0 joins nothing"),
    "garment.max_elongation": (0.01, 5, "0.18 for woven cloth; knitted cloth bears more"),
    "garment.seam_bending": (0.1, 100, "4 to 8 for cloth folded double; 1 as the cloth"),
    "garment.cell_size": (0.004, 0.1, "a length in m, as 0.025"),
    "contact.friction": (0, 10, "0.3 is usual for cloth on skin, 1 for rubber"),
    "contact.kinetic_friction": (0, 10, "not above the static friction"),
    "contact.flesh_stiffness": (0, 1e7, "2e5 Pa/m is soft flesh; 0 for hard parts"),
    "contact.offset": (0, 0.02, "half the thickness of the cloth, in m"),
    "steps.runs": (1, 1000, "3 for a draft, 1 for a single run"),
    "steps.time_step_factor": (0.01, 1, "a part of the largest stable step"),
    "steps.damping": (0, 1e-2, "1e-5 s is much; it shortens the step"),
    "steps.drag": (0, 100, "0.3 1/s is usual"),
    "output.window": (1e-4, 1, "0.02 s is usual"),
    "output.frames": (0.1, 200, "pictures a second"),
    "output.pressure": (0, 0.2, "patches of 0.03 m, 0 for no map"),
    "output.checkpoint": (1e-3, 1e4, "0.5 s is usual"),
}

WRINKLES = ("auto", "relaxed", "resolved")
HANGS = ("auto", "waist", "shoulders")


def check_kinds(scene: Scene) -> None:
    """ValueError for a text where a number belongs, and the like."""
    for part in (None, *PARTS):
        of = getattr(scene, part) if part else scene
        for item in fields(of):
            if item.name in (*PARTS, "fabric"):
                continue
            kinds = get_args(item.type) or (item.type,)
            name, value = f"{part}.{item.name}" if part else item.name, getattr(of, item.name)
            if not any(_is(value, kind) for kind in kinds):
                said = " or ".join(KINDS[kind] for kind in kinds if kind in KINDS)
                raise ValueError(f"{name} is {said}, not {value!r}")
    for where in ("person.girths", "garment.measures", "contact.flesh_bed"):
        part, _, name = where.partition(".")
        for key, value in getattr(getattr(scene, part), name).items():
            if not _is(value, float):
                raise ValueError(f"{where}: {key} is a number, not {value!r}")
    parts = scene.output.parts
    if isinstance(parts, str) and parts not in ("distal", "child"):
        raise ValueError(f"output.parts is 'distal', 'child' or a table, not {parts!r}")
    for joint, names in parts.items() if isinstance(parts, dict) else ():
        if not isinstance(names, list | tuple) or not all(isinstance(n, str) for n in names):
            raise ValueError(f"output.parts: {joint} is a list of ellipsoids, not {names!r}")


def _is(value, kind):
    if kind in (int, float):
        return isinstance(value, Integral if kind is int else Real) and not isinstance(value, bool)
    return isinstance(value, kind)


def check_numbers(scene: Scene) -> None:
    """ValueError for a number out of its range, and for values that exclude each other."""
    for where, (low, high, hint) in RANGES.items():
        part, _, name = where.rpartition(".")
        value = getattr(getattr(scene, part) if part else scene, name)
        if value is None:
            continue
        if not low <= value <= high:
            raise ValueError(f"{where} = {value:g} lies outside {low:g} to {high:g}: {hint}")
    for name in ("turn", "place"):
        value = getattr(scene.garment, name)
        if value is not None and not (
            len(value) == 3 and all(_is(v, float) and abs(v) <= 1e3 for v in value)
        ):
            what = "angles in degrees about x, y, z" if name == "turn" else "a shift in m"
            raise ValueError(f"garment.{name} is three numbers, {what}, not {value!r}")
    check_accuracy(scene.steps.accuracy)
    if scene.person.sex not in ("male", "female"):
        raise ValueError(f"person.sex is male or female, not {scene.person.sex!r}")
    if scene.steps.dressing not in ("shell", "particles"):
        raise ValueError(f"steps.dressing is shell or particles, not {scene.steps.dressing!r}")
    if scene.garment.wrinkles not in WRINKLES:
        raise ValueError(
            f"garment.wrinkles is {', '.join(WRINKLES[:-1])} or {WRINKLES[-1]}, not "
            f"{scene.garment.wrinkles!r}"
        )
    if scene.garment.hangs not in HANGS:
        raise ValueError(
            f"garment.hangs is {', '.join(HANGS[:-1])} or {HANGS[-1]}, not {scene.garment.hangs!r}"
        )
    kinetic = scene.contact.kinetic_friction
    if kinetic is not None and kinetic > scene.contact.friction:
        raise ValueError(
            f"contact.kinetic_friction = {kinetic:g} is above the static friction "
            f"{scene.contact.friction:g}"
        )
    start, end = scene.motion.start, scene.motion.end
    if start is not None and end is not None and not start < end:
        raise ValueError(f"motion.start = {start:g} s is not before motion.end = {end:g} s")


def check_dressing(dressing: str, fabric: Sheet) -> None:
    """ValueError where masses and springs are to put on cloth that they do not know."""
    if dressing == "particles" and fabric.law is not None:
        raise ValueError(
            "steps.dressing = 'particles': masses and springs do not know the law of "
            f"'{fabric.name}': take 'shell'"
        )


def check_accuracy(asked: str) -> None:
    """ValueError if steps.accuracy is none."""
    try:
        relative_error(asked)
    except ValueError as error:
        raise ValueError(f"steps.accuracy is {error}") from None
