# SPDX-License-Identifier: LGPL-3.0-or-later
"""Scenes: the same from Python and from a file; one clear sentence for what they may not say."""

import tomllib
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from shellform import Fabric, Ply
from shellform.__main__ import TEMPLATE
from shellform.material.card import CARDS, fabric_of, read_fabric
from shellform.material.sheet import MATRICES
from shellform.scene.parts import PARTS, Contact, Garment, Motion, Output, Person, Steps
from shellform.scene.scene import Scene
from shellform.scene.scene_file import key_of, read_scene, scene_from, write_scene

# every field away from its default, as `test_every_field_is_covered` makes sure
OTHER = Scene(
    fabric="stiff",
    motion=Motion(
        file="/captures/a walk.c3d", static="/captures/standing.c3d", map="lateral",
        unit="mm", up="y", cutoff=8.0, max_gap=0.25, start=0.5, end=2.25, initiation=0.75,
        strides=3, obstacle=0.1,
    ),
    person=Person(
        stature=1.8, mass=90.5, girths={"waist": 1.01, "calf": 0.4}, body="/bodies/scan.toml",
        sex="female",
    ),
    garment=Garment(
        turn=[0, 0, 90.0],
        place=[0.0, 0.1, 0.0],
        weld=1e-4,
        midsurface=True,
        file="/meshes/trousers.obj", unit="cm", waist="top", size="small-long",
        kind="skirt", measures={"hem": 0.5, "back_lift": 0.0}, cell_size=0.03,
        max_elongation=0.3, wrinkles="resolved", hangs="waist", seam_bending=4.0,
        stitches=[["front.side", "back.side"]], about={"front": "pelvis"},
    ),
    contact=Contact(
        friction=0.6, kinetic_friction=0.4, offset=1e-3, flesh_stiffness=3e5,
        flesh_bed={"body": 6.7e5, "left_calf": 1e5},
        self_contact=True,
    ),
    steps=Steps(
        accuracy="2.5%", time_step_factor=0.5, damping=1e-6, drag=1.0, dressing="particles", runs=5
    ),
    output=Output(
        window=0.01, frames=25.0, parts={"right_knee": ["right_shank", "right_foot"]},
        pressure=0.05, checkpoint=0.125,
    ),
    belt=12.5,
    gravity=1.62,
    law={"kind": "fung", "stiffening_load_N_per_m": 40.0},
    title='trousers "wide" \\ größer \U0001f456',
)  # fmt: skip


def values(scene):
    """(part, field) -> value."""
    rows = {("", f.name): getattr(scene, f.name) for f in fields(scene) if f.name not in PARTS}
    for part in PARTS:
        rows |= {(part, f.name): getattr(getattr(scene, part), f.name) for f in fields(PARTS[part])}
    return rows


def there_and_back(scene, folder):
    write_scene(scene, folder / "scene.toml")
    return read_scene(folder / "scene.toml")


def test_every_field_is_covered():
    default = values(Scene())
    assert [name for name, value in values(OTHER).items() if value == default[name]] == []


@pytest.mark.serial
@pytest.mark.parametrize("scene", [Scene(), OTHER], ids=["default", "other"])
def test_written_and_read_again(scene, tmp_path):
    """Every field comes back; a card's name comes back as the fabric of that card."""
    again = values(there_and_back(scene, tmp_path))
    for where, value in values(scene).items():
        if where == ("", "fabric"):
            assert again[where].name == value
            card = read_fabric(CARDS / f"{value}.toml")
            assert np.array_equal(again[where].membrane, card.membrane)
        else:
            assert again[where] == value, where
    assert not list(tmp_path.glob("*.part"))


@pytest.mark.serial
def test_a_fabric_made_in_python_comes_back(tmp_path):
    """A laminate, whose bending is coupled with stretching: all matrices to the last bit."""
    ply = Ply(3e6, 1e6, 0.2, 8e4, 6e4, 5e4, 300.0)
    fabric = Fabric.laminate([(ply, 1e-3, 0.0), (ply, 2e-3, 30.0)], name='"two" plies')
    again = there_and_back(Scene(fabric=fabric), tmp_path).fabric
    assert fabric.coupling.any()
    for name in (*MATRICES, "areal_mass", "thickness"):
        assert np.array_equal(getattr(again, name), getattr(fabric, name)), name
    assert again.name == fabric.name


@pytest.mark.serial
def test_paths_hold_from_anywhere(tmp_path, monkeypatch):
    """In a file paths are relative to it; written down for another folder they still hold."""
    here, away = tmp_path / "here", tmp_path / "away"
    here.mkdir()
    away.mkdir()
    card = (CARDS / "stiff.toml").read_text().replace('"stiff"', '"mine"')
    (here / "mine.toml").write_text(card)
    (here / "map.toml").write_text("")
    (here / "scene.toml").write_text(
        'fabric = "mine.toml"\n[motion]\nfile = "walk.c3d"\nmap = "map.toml"\n'
        '[garment]\nfile = "legs.obj"\n'
    )
    scene = read_scene(here / "scene.toml")
    assert scene.fabric.name == "mine"
    assert scene.motion.file == str(here / "walk.c3d") and scene.motion.map == str(
        here / "map.toml"
    )
    assert scene.garment.file == str(here / "legs.obj")
    monkeypatch.chdir(here)
    again = there_and_back(
        Scene(
            fabric="mine.toml",
            motion=Motion(file=Path("walk.c3d"), map="map.toml"),
            garment=Garment(file="legs.obj"),
        ),
        away,
    )
    assert again.fabric.name == "mine"
    assert again.motion == scene.motion and again.garment == scene.garment
    # a shipped map goes by its name
    assert there_and_back(Scene(motion=Motion(map="medial")), away).motion.map == "medial"


def test_template_says_the_defaults():
    """What is given is the default but for the title; what is commented out is a known key."""
    scene = scene_from(tomllib.loads(TEMPLATE))
    assert scene.title != Scene().title
    assert replace(scene, fabric="compliant", title=Scene().title) == Scene()
    assert scene.fabric.name == "compliant"
    lines = [line.removeprefix("# ") for line in TEMPLATE.splitlines()]
    lines = [line for line in lines[1:] if "=" in line or line.startswith("[")]
    filled = "\n".join(line.replace('map = "..."', 'map = "medial"') for line in lines)
    full = scene_from(tomllib.loads(filled))
    assert full.motion.end == 2.0 and full.person.girths and full.garment.measures


def test_keys_carry_their_units():
    keys = [key_of(item) for part in (Scene, *PARTS.values()) for item in fields(part)]
    for key in ("belt_N", "gravity_m_per_s2", "cutoff_Hz", "drag_per_s", "cell_size_m", "parts"):
        assert key in keys


def test_accuracy_and_cell_size():
    """Words are parts of the length that matters; a size of the user's own wins."""
    sizes = [Scene(steps=Steps(accuracy=word)).cell_size for word in ("draft", "standard", "fine")]
    assert sizes == sorted(sizes, reverse=True)
    compliant, stiff = (
        np.sqrt(cloth.bending_length() * cloth.bending_length(degrees=90.0))
        for cloth in (fabric_of("compliant"), fabric_of("stiff"))
    )
    assert sizes[2] == pytest.approx(compliant, rel=1e-12)
    # a stiffer cloth still lies on the same limbs
    assert sizes[2] < Scene("stiff", steps=Steps(accuracy="fine")).cell_size < 0.5 * stiff
    finer = Scene(steps=Steps(accuracy="fine"), garment=Garment(cell_size=0.03))
    assert finer.cell_size == 0.03
    for wrong in ("good", "3", "0%", "-1%", "100%", "", "nan%"):
        with pytest.raises(ValueError, match="draft, standard, fine or a percentage"):
            Scene(steps=Steps(accuracy=wrong))


# contents of a file, words that the sentence has: the item and the mend
WRONG = {
    "unknown key": ("belt_n = 3", ("'belt_n'", "did you mean 'belt_N'?")),
    "key without its unit": ("belt = 3", ("'belt'", "did you mean 'belt_N'?")),
    "unknown table": ("[walk]\nend_s = 1", ("'walk'", "belt_N", "[motion]")),
    "table for a number": ("[belt_N]\nx = 1", ("belt", "a number")),
    "number for a table": ("motion = 5", ("[motion]", "table", "5")),
    "key of another table": (
        "[motion]\nfriction = 0.3",
        ("[motion]", "'friction'", "initiation_s"),
    ),
    "not TOML": ("belt_N = ", ("not a TOML file",)),
    "not text": (b"\xff\xfe\x00", ("not a TOML file",)),
    "belt in g": ("belt_N = 2000", ("belt = 2000", "0 to 500", "5 to 50 N")),
    "negative belt": ("belt_N = -5", ("belt = -5", "0 to 500")),
    "belt as text": ('belt_N = "20"', ("belt is a number", "'20'")),
    "belt as truth": ("belt_N = true", ("belt is a number", "True")),
    "no number": ("belt_N = nan", ("belt = nan", "0 to 500")),
    "title as number": ("title = 5", ("title is a text", "5")),
    "fabric as number": ("fabric = 5", ("fabric", "name of a card", "5")),
    "unknown fabric": ('fabric = "silk"', ("'silk'", "compliant, denim", "file")),
    "fabric card at fault": (
        "[fabric.isotropic]\nE = 1",
        ("[fabric]", "unknown key", "youngs_modulus_Pa"),
    ),
    "file as number": ("[motion]\nfile = 5", ("motion.file is a text", "5")),
    "map as number": ("[motion]\nmap = 5", ("motion.map is a text",)),
    "half a stride": ("[motion]\nstrides = 2.5", ("motion.strides is a whole number", "2.5")),
    "start as text": ('[motion]\nstart_s = "0"', ("motion.start is a number", "'0'")),
    "start after end": ("[motion]\nstart_s = 2\nend_s = 1", ("start = 2 s", "end = 1 s")),
    "obstacle in cm": ("[motion]\nobstacle_m = 50", ("obstacle = 50", "m: 0.5")),
    "stature in cm": ("[person]\nstature_m = 176", ("stature = 176", "1.76")),
    "mass in g": ("[person]\nmass_kg = 80000", ("mass = 80000", "80")),
    "girths as number": ("[person]\ngirths_m = 5", ("person.girths is a table", "5")),
    "girth as text": ('[person]\ngirths_m = { hip = "1" }', ("person.girths: hip", "'1'")),
    "measure as text": ('[garment]\nmeasures_m = { hem = "1" }', ("garment.measures: hem", "'1'")),
    "cells in mm": ("[garment]\ncell_size_m = 25", ("cell_size = 25", "0.025")),
    "more kinetic friction": (
        "[contact]\nkinetic_friction = 0.5",
        ("kinetic_friction = 0.5", "static friction 0.3"),
    ),
    "step too long": ("[steps]\ntime_step_factor = 1.1", ("time_step_factor = 1.1", "0.01 to 1")),
    "accuracy as number": ("[steps]\naccuracy = 0.01", ("steps.accuracy is a text", "0.01")),
    "accuracy of no kind": ('[steps]\naccuracy = "good"', ("accuracy", "'2%'", "'good'")),
    "dressing by hand": (
        '[steps]\ndressing = "hand"',
        ("dressing", "shell or particles", "'hand'"),
    ),
    "parts of no kind": ('[output]\nparts = "all"', ("parts", "'distal', 'child'", "'all'")),
    "parts no list": ('[output.parts]\nright_knee = "x"', ("right_knee", "list", "'x'")),
}


@pytest.mark.serial
@pytest.mark.parametrize("name", WRONG)
def test_wrong_file(name, tmp_path):
    """One sentence that names the file, the item and the mend."""
    contents, words = WRONG[name]
    path = tmp_path / "scene.toml"
    path.write_bytes(contents if isinstance(contents, bytes) else contents.encode())
    with pytest.raises(ValueError) as caught:
        read_scene(path)
    sentence = str(caught.value)
    for word in (str(path), *words):
        assert word in sentence
    assert "\n" not in sentence and len(sentence.replace(str(path), "")) < 300


def test_wrong_things_in_python():
    for part in PARTS:
        with pytest.raises(ValueError, match=f"{part} is a {PARTS[part].__name__}, not 'x'"):
            Scene(**{part: "x"})
    with pytest.raises(ValueError, match="fabric is a Fabric or the name of a card, not 3"):
        Scene(fabric=3)
    numpy_values = Scene(belt=np.float32(12), motion=Motion(strides=np.int64(2)))
    assert numpy_values.belt == 12


@pytest.mark.serial
def test_missing_file(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"nowhere\.toml"):
        read_scene(tmp_path / "nowhere.toml")
