# SPDX-License-Identifier: LGPL-3.0-or-later
"""The scene: wearer, motion, garment, fabric, belt, and how it is to be computed and told.

A Scene is a value, made in Python or read from a TOML file (scene_file.py). Everything in it is
checked when it is made; nothing is computed. `build.py` turns it into arrays and finite elements.
"""

from dataclasses import dataclass, field, fields, replace
from numbers import Integral, Real
from pathlib import Path
from typing import get_args

from shellform.accuracy.choice import choose, garment_length, relative_error
from shellform.material.fabric import Fabric
from shellform.material.sheet import Sheet


def _unit(default, unit):
    return field(default=default, metadata={"unit": unit})


@dataclass(frozen=True)
class Motion:
    """A captured motion, or the synthetic walk of `shellform.motion.gait.synthetic_walk`.

    file : 'synthetic' or a C3D, TRC or CSV file; map : name or file of a segment map, None: the one
    that fits; unit, up : of the file, where it does not tell; cutoff : of the low-pass [Hz];
    max_gap : longest gap filled [s]; start, end : part of the recording used [s]; lead_in : time
    from standing into its first frame [s]; strides, obstacle (height [m], 0 for none) : of the
    synthetic walk.
    """

    file: str | Path = "synthetic"
    map: str | Path | None = None
    unit: str | None = None
    up: str | None = None
    cutoff: float = _unit(6.0, "Hz")
    max_gap: float = _unit(0.1, "s")
    start: float | None = _unit(None, "s")
    end: float | None = _unit(None, "s")
    lead_in: float = _unit(1.0, "s")
    strides: int = 4
    obstacle: float = _unit(0.5, "m")


@dataclass(frozen=True)
class Person:
    """Size of the wearer: stature [m], None: from the recording; mass [kg]; girths by name [m]."""

    stature: float | None = _unit(None, "m")
    mass: float | None = _unit(None, "kg")
    girths: dict = field(default_factory=dict, metadata={"unit": "m"})


@dataclass(frozen=True)
class Garment:
    """Trousers by size or girths, or a mesh file.

    file : mesh of the user's own, with `unit` of its lengths and the name of its `waist` edge;
    size : of `meshes.trousers`; measures : arguments of it [m]; cell_size : of the cells [m], None:
    by the accuracy.
    """

    file: str | Path | None = None
    unit: str = "m"
    waist: str = "waist"
    size: str | None = None
    measures: dict = field(default_factory=dict, metadata={"unit": "m"})
    cell_size: float | None = _unit(None, "m")


@dataclass(frozen=True)
class Contact:
    """How cloth meets the body.

    friction, kinetic_friction : static and kinetic, None: the same; offset [m], None: half the
    thickness; flesh_stiffness : pressure over depth of parts of the body that press cloth against
    each other, as calf and thigh [Pa/m], 0 for hard parts; see contact/solver/soft_crease.py.
    """

    friction: float = 0.3
    kinetic_friction: float | None = None
    offset: float | None = _unit(None, "m")
    flesh_stiffness: float = _unit(2e5, "Pa/m")


@dataclass(frozen=True)
class Steps:
    """How motion is computed.

    accuracy : 'draft', 'standard', 'fine' or 'N%', see accuracy.py; time_step_factor : of the
    largest stable step; damping : stiffness-proportional [s]; drag : of the air [1/s]; dressing :
    'shell' or 'particles', the model that puts the garment on.
    """

    accuracy: str = "draft"
    time_step_factor: float = 0.9
    damping: float = _unit(0.0, "s")
    drag: float = _unit(0.3, "1/s")
    dressing: str = "shell"


@dataclass(frozen=True)
class Output:
    """What is told: window of the averages [s], pictures a second, which parts count for a joint.

    parts : 'distal', 'child' or a table, joint -> ellipsoids; pressure : side of a patch of the map
    of pressure on the skin [m], 0 for no map; checkpoint : time between them [s].
    """

    window: float = _unit(0.02, "s")
    frames: float = _unit(10.0, "1/s")
    parts: str | dict = "distal"
    pressure: float = _unit(0.03, "m")
    checkpoint: float = _unit(0.5, "s")


@dataclass(frozen=True)
class Scene:
    """A clothed wearer in motion; see the parts.

    Parameters
    ----------
    fabric : Fabric, or the name or path of a card; belt : tension [N]; gravity : [m/s^2]

    Raises
    ------
    ValueError naming the part, the item and the mend
    """

    fabric: Fabric | str | Path = "compliant"
    motion: Motion = Motion()
    person: Person = Person()
    garment: Garment = Garment()
    contact: Contact = Contact()
    steps: Steps = Steps()
    output: Output = Output()
    belt: float = _unit(20.0, "N")
    gravity: float = _unit(9.81, "m/s^2")
    title: str = "walk"

    def __post_init__(self):
        for part in fields(self):
            value = getattr(self, part.name)
            if part.name in PARTS and not isinstance(value, PARTS[part.name]):
                raise ValueError(f"{part.name} is a {PARTS[part.name].__name__}, not {value!r}")
        if not isinstance(self.fabric, Sheet | str | Path):
            raise ValueError(f"fabric is a Fabric or the name of a card, not {self.fabric!r}")
        _check_kinds(self)
        _check_numbers(self)

    @property
    def cell_size(self):
        """Size of the garment's cells [m]."""
        return self.garment.cell_size or self.choice.size

    @property
    def choice(self):
        """`accuracy.Choice` of the cells, with the errors they are predicted to leave."""
        from .scene_file import fabric_of

        length = garment_length(fabric_of(self.fabric))
        choice = choose("walk", self.steps.accuracy, length)
        given = self.garment.cell_size
        return replace(choice.at(given), asked=None, kept=True) if given else choice


PARTS = {
    "motion": Motion,
    "person": Person,
    "garment": Garment,
    "contact": Contact,
    "steps": Steps,
    "output": Output,
}

# what numbers may be, with what a number outside is likely to be
RANGES = {
    "belt": (0, 500, "a belt of 5 to 50 N is usual"),
    "gravity": (0, 30, "9.81 on earth"),
    "motion.cutoff": (0.5, 100, "6 Hz is usual for gait; none is not offered"),
    "motion.max_gap": (0, 1, "a gap is filled up to some tenths of a second"),
    "motion.lead_in": (0, 10, "a second is usual"),
    "motion.obstacle": (0, 0.6, "a height in m: 0.5 as in the paper"),
    "motion.strides": (1, 50, "four as in the paper"),
    "person.stature": (1.0, 2.3, "a stature in m, as 1.76"),
    "person.mass": (25, 250, "a mass in kg, as 80"),
    "garment.cell_size": (0.004, 0.1, "a length in m, as 0.025"),
    "contact.friction": (0, 10, "0.3 is usual for cloth on skin, 1 for rubber"),
    "contact.kinetic_friction": (0, 10, "not above the static friction"),
    "contact.flesh_stiffness": (0, 1e7, "2e5 Pa/m is soft flesh; 0 for hard parts"),
    "contact.offset": (0, 0.02, "half the thickness of the cloth, in m"),
    "steps.time_step_factor": (0.01, 1, "a part of the largest stable step"),
    "steps.damping": (0, 1e-2, "1e-5 s is much; it shortens the step"),
    "steps.drag": (0, 100, "0.3 1/s is usual"),
    "output.window": (1e-4, 1, "0.02 s is usual"),
    "output.frames": (0.1, 200, "pictures a second"),
    "output.pressure": (0, 0.2, "patches of 0.03 m, 0 for no map"),
    "output.checkpoint": (1e-3, 1e4, "0.5 s is usual"),
}


def check_accuracy(asked):
    """ValueError if steps.accuracy is none."""
    try:
        relative_error(asked)
    except ValueError as error:
        raise ValueError(f"steps.accuracy is {error}") from None


KINDS = {str: "a text", int: "a whole number", float: "a number", dict: "a table"}


def _check_kinds(scene):
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
    for where in ("person.girths", "garment.measures"):
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


def _check_numbers(scene):
    for where, (low, high, hint) in RANGES.items():
        part, _, name = where.rpartition(".")
        value = getattr(getattr(scene, part) if part else scene, name)
        if value is None:
            continue
        if not low <= value <= high:
            raise ValueError(f"{where} = {value:g} lies outside {low:g} to {high:g}: {hint}")
    check_accuracy(scene.steps.accuracy)
    if scene.steps.dressing not in ("shell", "particles"):
        raise ValueError(f"steps.dressing is shell or particles, not {scene.steps.dressing!r}")
    kinetic = scene.contact.kinetic_friction
    if kinetic is not None and kinetic > scene.contact.friction:
        raise ValueError(
            f"contact.kinetic_friction = {kinetic:g} is above the static friction "
            f"{scene.contact.friction:g}"
        )
    start, end = scene.motion.start, scene.motion.end
    if start is not None and end is not None and not start < end:
        raise ValueError(f"motion.start = {start:g} s is not before motion.end = {end:g} s")
