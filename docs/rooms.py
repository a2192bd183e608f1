# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pages of the reference, one a room: every module of it with its public names.

A name with a page in docs/api, as all of `shellform` and `meshes`, is referred to by its room.
"""

import importlib
import pkgutil
import re
from functools import cache
from pathlib import Path

PACKAGES = ("shellform", "contact", "meshes")
API = Path(__file__).parent / "api"
FOLDER = API / "rooms"
PUBLIC = re.compile(r"^\.\. auto\w+:: ([\w.]+)\.(\w+)$", re.M)


@cache
def public_names() -> dict[str, dict[str, str]]:
    """Module -> names that it makes and that have a page of their own -> that page."""
    found: dict[str, dict[str, str]] = {}
    for path in sorted(API.glob("*.md")):
        for package, name in PUBLIC.findall(path.read_text()):
            home = getattr(importlib.import_module(package), name).__module__
            found.setdefault(home, {})[name] = path.name
    return found


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
        lines += ["```{eval-rst}", f".. automodule:: {name}", "   :ignore-module-all:"]
        public = public_names().get(name, {})
        if public:
            lines += [f"   :exclude-members: {', '.join(public)}", "```", ""]
            lines += [f"{', '.join(f'[`{n}`](../{page})' for n, page in public.items())}"]
        else:
            lines += ["```"]
        lines += [""]
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
