# SPDX-License-Identifier: LGPL-3.0-or-later
"""A scene as a TOML file: a table a part, keys with their units, paths relative to the file.

    title = "trousers over an obstacle"
    fabric = "stiff"                # a shipped card, a file, or a table as in a card
    belt_N = 20
    [motion]
    file = "walk.c3d"
    [person]
    stature_m = 1.80
    girths_m = { waist = 0.94 }
    [output]
    window_s = 0.02

Everything left out has its default; `write` puts down a scene in full.
"""

import difflib
import json
import os
import tomllib
from collections.abc import Mapping
from dataclasses import Field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from shellform.material.card import card_keys, fabric_of
from shellform.material.fabric import Fabric, FabricError
from shellform.material.laws import law_table
from shellform.results.files import write_atomically

from .parts import PARTS
from .scene import Scene

# what may be a file, relative to that of the scene
FILES = (
    ("motion", "file"),
    ("motion", "static"),
    ("motion", "map"),
    ("garment", "file"),
    ("person", "body"),
)
WORDS = ("synthetic", "ellipsoids", "mesh")  # in the place of a file


def key_of(item: Field) -> str:
    """Key of a dataclass field in the file: its name with its unit."""
    unit = item.metadata.get("unit", "")
    unit = unit.replace("1/", "per_").replace("/", "_per_").replace("^", "").replace(" ", "_")
    return f"{item.name}_{unit}".strip("_")


def as_scene(given: Scene | str | Path) -> Scene:
    """A scene as it is, or read from a file; ValueError for what is neither."""
    if not isinstance(given, Scene | str | Path):
        raise ValueError(f"a scene is a Scene or the name of its file, not {given!r}")
    return given if isinstance(given, Scene) else read_scene(given)


def read_scene(path: str | Path) -> Scene:
    """Scene of a file.

    Raises
    ------
    ValueError : unknown key or value out of range, naming file and mend; FileNotFoundError
    """
    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"{path}: no such file; `shellform new {path}` writes a scene")
    try:
        # editors on Windows put a byte-order mark first; names of files may be of any bytes
        data = tomllib.loads(path.read_text(encoding="utf-8-sig", errors="surrogateescape"))
    except tomllib.TOMLDecodeError as error:
        raise ValueError(f"{path}: not a TOML file: {error}") from None
    if any("\udc80" <= letter <= "\udcff" for letter in str(data.get("title", ""))):
        raise ValueError(f"{path}: the title is not in UTF-8: save the file in that encoding")
    return scene_from(data, str(path), path.parent)


def _spelt(text):
    """Name of a file as Python has it on this system, of the bytes that a scene's file has."""
    return os.fsdecode(text.encode("utf-8", "surrogateescape"))


def _is_file(key, path):
    """A map may be a name; what else names a file is told to be missing where it is read."""
    return key != "map" or path.is_file()


def scene_from(data: Mapping[str, Any], where: str = "scene", folder: Path = Path()) -> Scene:
    """Scene of the contents of a file; paths in it are relative to `folder`."""
    data = dict(data)
    values = {}
    for name, kind in PARTS.items():
        table = data.pop(name, {})
        if not isinstance(table, dict):
            raise ValueError(f"{where}: [{name}] is a table of keys, not {table!r}")
        values[name] = kind(**_named(table, fields(kind), f"{where} [{name}]"))
    top = [item for item in fields(Scene) if item.name not in PARTS]
    values |= _named(data, top, where, more=[f"[{name}]" for name in PARTS])
    for name, key in FILES:
        file = getattr(values[name], key)
        if isinstance(file, str) and file not in WORDS:
            path = folder / _spelt(file)
            if _is_file(key, path):
                values[name] = replace(values[name], **{key: str(path)})
    try:
        if "fabric" in values:
            fabric = values["fabric"]
            fabric = _spelt(fabric) if isinstance(fabric, str) else fabric
            values["fabric"] = fabric_of(fabric, folder, where)
        return Scene(**values)
    except FabricError:
        raise
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None


def _named(table, items, where, more=()):
    """Arguments by name from a table whose keys carry units."""
    keys = {key_of(item): item for item in items}
    values = {}
    for key, value in table.items():
        if key not in keys:
            known = [*keys, *more]
            close = difflib.get_close_matches(key, known, n=1, cutoff=0.5)
            mend = f"did you mean '{close[0]}'?" if close else f"there are {', '.join(known)}"
            raise ValueError(f"{where}: unknown key '{key}'; {mend}")
        values[keys[key].name] = value
    return values


def write_scene(scene: Scene, path: str | Path) -> None:
    """Write a scene in full, so that `read_scene` gives it back; a Fabric by its matrices."""
    lines = [f"title = {_toml(scene.title)}", f"fabric = {_fabric(scene.fabric)}"]
    for item in fields(Scene):
        value = getattr(scene, item.name)
        if item.name not in (*PARTS, "title", "fabric") and value is not None:
            lines.append(f"{key_of(item)} = {_toml(value)}")
    for name in PARTS:
        lines.append(f"\n[{name}]")
        part = getattr(scene, name)
        for item in fields(part):
            value = getattr(part, item.name)
            if (name, item.name) in FILES and value not in (None, *WORDS):
                whole = Path(value).absolute()
                value = str(whole if _is_file(item.name, whole) else value)
            if value is not None:
                lines.append(f"{key_of(item)} = {_toml(value)}")
    write_atomically(path, "\n".join(lines) + "\n")


def _fabric(fabric):
    """A card by name or file, or what it was made from, or its matrices."""
    if isinstance(fabric, str | Path):
        path = Path(fabric).absolute()
        return _toml(str(path if path.is_file() else fabric))
    if fabric.card is not None:
        return _toml(fabric.card)
    if fabric.friction is not None:
        raise FabricError(
            f"the friction of '{fabric.name}' stands in no file: make the fabric from a "
            "card with a table `measured`"
        )
    keys = card_keys(Fabric.from_stiffness)
    matrices = {key: np.asarray(getattr(fabric, p.name)).tolist() for key, p in keys.items()}
    law = {} if fabric.law is None else {"law": law_table(fabric.law)}
    known = fabric.provenance
    provenance = {} if known is None else {"provenance": known.table()}
    return _toml({"name": fabric.name, "stiffness": matrices} | law | provenance)


def _toml(value):
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_toml(k)} = {_toml(v)}" for k, v in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_toml(v) for v in value) + "]"
    if isinstance(value, str):
        # as JSON does, but for what that writes as two halves
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return json.dumps(value) if isinstance(value, bool) else repr(value)
