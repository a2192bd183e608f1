# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pages of the reference, one a room: every module of it with its public names."""

import importlib
import pkgutil
from pathlib import Path

PACKAGES = ("shellform", "contact", "meshes")
FOLDER = Path(__file__).parent / "api" / "rooms"


def modules_of(package: str) -> dict[str, list[str]]:
    """Room -> its modules; what lies in the package itself is in the room of its own name."""
    top = importlib.import_module(package)
    rooms: dict[str, list[str]] = {package: []}
    for found in pkgutil.walk_packages(top.__path__, f"{package}."):
        if found.name.endswith("__main__"):
            continue
        room = ".".join(found.name.split(".")[:2])
        if found.name.count(".") > 1 or found.ispkg:
            rooms.setdefault(room, []).append(found.name)
        else:
            rooms[package].append(found.name)
    return {room: names for room, names in rooms.items() if names}


def page(room: str, names: list[str]) -> str:
    """Markdown of a room's page; a name is described where it is made only."""
    lines = [f"# {room}", ""]
    for name in names:
        if name != room:
            lines += [f"## {name}", ""]
        lines += ["```{eval-rst}", f".. automodule:: {name}", "   :ignore-module-all:", "```", ""]
    return "\n".join(lines)


def write(app=None):
    """Write all pages and their list; a page that is as it was keeps its time."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    wanted = {}
    for package in PACKAGES:
        for room, names in modules_of(package).items():
            wanted[f"{room}.md"] = page(room, names)
    entries = "\n".join(name.removesuffix(".md") for name in wanted)
    wanted["index.md"] = f"# Rooms\n\n```{{toctree}}\n:maxdepth: 1\n\n{entries}\n```\n"
    for old in set(FOLDER.glob("*.md")) - {FOLDER / name for name in wanted}:
        old.unlink()
    for name, text in wanted.items():
        path = FOLDER / name
        if not path.is_file() or path.read_text() != text:
            path.write_text(text)


def setup(app):
    app.connect("builder-inited", write)
