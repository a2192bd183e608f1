# SPDX-License-Identifier: LGPL-3.0-or-later
"""The scene: wearer, motion, garment, fabric, belt, how it is to be computed and what is written.

A Scene is a value, made in Python or read from a TOML file (scene_file.py). Everything in it is
checked when it is made; nothing is computed. wearer.py and garment.py turn it into arrays.
"""

from dataclasses import dataclass, field, fields, replace
from pathlib import Path

from shellform.accuracy.choice import Choice, choose, cloth_family, garment_length
from shellform.accuracy.ensemble_size import runs_needed
from shellform.material.card import fabric_of, storing
from shellform.material.fabric import Fabric
from shellform.material.sheet import Sheet

from .checks import check_kinds, check_numbers
from .parts import PARTS, Contact, Garment, Motion, Output, Person, Steps, with_unit


@dataclass(frozen=True)
class Scene:
    """A clothed wearer in motion; see the parts.

    Parameters
    ----------
    fabric : Fabric, or the name or path of a card; belt : tension [N]; gravity : [m/s^2]
    law : what the cloth stores, a name or table as in a card, in place of the fabric's

    Raises
    ------
    ValueError naming the part, the item and the mend

    Examples
    --------
    >>> from shellform.scene.parts import Garment, Person
    >>> scene = sf.Scene("stiff", person=Person(stature=1.80), garment=Garment(cell_size=0.03))
    >>> scene.cell_size, scene.motion.file, scene.contact.friction
    (0.03, 'synthetic', 0.3)
    >>> sf.Scene(gravity=98.1)
    Traceback (most recent call last):
    ValueError: gravity = 98.1 lies outside 0 to 30: 9.81 on earth
    """

    fabric: Fabric | str | Path = "compliant"
    motion: Motion = field(default_factory=Motion)
    person: Person = field(default_factory=Person)
    garment: Garment = field(default_factory=Garment)
    contact: Contact = field(default_factory=Contact)
    steps: Steps = field(default_factory=Steps)
    output: Output = field(default_factory=Output)
    belt: float = with_unit(20.0, "N")
    gravity: float = with_unit(9.81, "m/s^2")
    law: str | dict | None = None
    title: str = "walk"

    def __post_init__(self):
        for part in fields(self):
            value = getattr(self, part.name)
            if part.name in PARTS and not isinstance(value, PARTS[part.name]):
                raise ValueError(f"{part.name} is a {PARTS[part.name].__name__}, not {value!r}")
        if not isinstance(self.fabric, Sheet | str | Path):
            raise ValueError(f"fabric is a Fabric or the name of a card, not {self.fabric!r}")
        check_kinds(self)
        check_numbers(self)
        if self.law is not None:
            storing(fabric_of(self.fabric), self.law)  # refuses what does not fit

    @property
    def cloth(self) -> Fabric:
        """The fabric with the law of the scene."""
        fabric = fabric_of(self.fabric)
        return fabric if self.law is None else storing(fabric, self.law)

    @property
    def cell_size(self) -> float:
        """Size of the garment's cells [m]."""
        return self.garment.cell_size or self.choice.size

    @property
    def runs(self) -> int:
        """Runs of the ensemble whose mean is reported."""
        return self.steps.runs or runs_needed(self.steps.accuracy)

    @property
    def choice(self) -> Choice:
        """`accuracy.Choice` of the cells, with the errors they are predicted to leave."""
        cloth = self.cloth
        length, families = garment_length(cloth), [cloth_family(cloth)]
        choice = choose("walk", self.steps.accuracy, length, families=families)
        choice = replace(choice, runs=self.runs)
        given = self.garment.cell_size
        return replace(choice.at(given), asked=None, kept=True) if given else choice
