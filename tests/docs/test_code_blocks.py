# SPDX-License-Identifier: LGPL-3.0-or-later
"""README and docs are run: Python from top to bottom of a page, commands parsed or run, TOML read.

A comment before a block says what is done with it, else Python is run and commands are parsed:

    <!-- page: slow -->              the page's Python takes more than some seconds
    <!-- block: runs with ARGS -->   the commands are run, with these arguments added
    <!-- block: not ours -->         commands of other programs, not looked at
    <!-- block: file NAME -->        the block is written to a file of the page's folder
    <!-- block: scene NAME -->       the same, and it is read as a scene
"""

import importlib.util
import re
import shlex
import subprocess
import sys
import tomllib
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest

import meshes
import shellform
from shellform.__main__ import parser
from shellform.scene.scene_file import read_scene
from tests.ranks import outside

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
MADE = ("_build", "gallery_pages", "rooms")  # folders that the build writes
PAGES = [page for page in PAGES if not set(MADE) & set(page.parts)]
LANGUAGES = {"python", "sh", "toml", "text", "bibtex", "{toctree}", "{eval-rst}"}
FENCE = re.compile(
    r"(?:<!-- block: (?P<marker>[^\n]*?) -->\n)?^```(?P<language>\S*)[^\n]*\n(?P<text>.*?)^```$",
    re.S | re.M,
)

pytestmark = pytest.mark.serial


class Block(NamedTuple):
    """A fenced block: language, text, line of its first line in the page, marker."""

    language: str
    text: str
    line: int
    marker: str


def blocks_of(page):
    text = page.read_text(encoding="utf-8")
    return [
        Block(m["language"], m["text"], text.count("\n", 0, m.start("text")) + 1, m["marker"] or "")
        for m in FENCE.finditer(text)
    ]


def named(page):
    return str(page.relative_to(ROOT))


def with_blocks(*languages):
    """Parameters of a test: pages that have blocks of these languages."""
    found = []
    for page in PAGES:
        if any(block.language in languages for block in blocks_of(page)):
            slow = "<!-- page: slow -->" in page.read_text(encoding="utf-8")
            marks = (
                [pytest.mark.slow, pytest.mark.thorough] if slow and "python" in languages else []
            )
            found.append(pytest.param(page, id=named(page), marks=marks))
    return found


def commands_of(block):
    """Command lines of a shell block, without comments."""
    lines = (shlex.split(line, comments=True) for line in block.text.splitlines())
    return [line for line in lines if line]


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_blocks_are_of_a_known_kind(page):
    """No block slips through: every fence is closed and its language is one that is looked at."""
    text = page.read_text(encoding="utf-8")
    assert len(re.findall(r"^```", text, re.M)) == 2 * len(blocks_of(page))
    assert {block.language for block in blocks_of(page)} <= LANGUAGES
    assert text.count("<!-- block:") == sum(bool(block.marker) for block in blocks_of(page))


@pytest.mark.parametrize("page", with_blocks("python", "toml"))
def test_python_and_toml(page, tmp_path, monkeypatch):
    """A page's blocks in one namespace, in a folder of their own; lines are those of the page."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    namespace = {"__name__": "__main__"}
    for block in blocks_of(page):
        kind, _, name = block.marker.partition(" ")
        if block.language == "toml":
            tomllib.loads(block.text)
            assert kind in ("file", "scene"), f"{named(page)}:{block.line}: say what it is"
            Path(name).write_text(block.text)
            if kind == "scene":
                read_scene(name)
        elif block.language == "python":
            if kind == "file":
                Path(name).write_text(block.text)
                monkeypatch.syspath_prepend(str(tmp_path))
                continue
            code = compile("\n" * (block.line - 1) + block.text, named(page), "exec")
            exec(code, namespace)


def parse_make(words):
    done = subprocess.run(
        ["make", "-n", *words[1:]], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


@cache
def help_of(*program):
    """What a program says of itself; it ends before anything is computed."""
    done = subprocess.run(
        [sys.executable, *program, "-h"],
        cwd=ROOT,
        env=outside(),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def parse_arguments(program, arguments):
    """Options and the name of what is to be done must be known to the program's own parser."""
    known = help_of(*program)
    for k, word in enumerate(arguments):
        if word.startswith("--") or (k == 0 and not word.startswith("-")):
            assert re.search(rf"(?<![\w-]){word}(?![\w-])", known), f"{program} takes no {word}"


def parse(words):
    """Refuse a command that would be refused; nothing is computed."""
    if words[0].endswith("mpirun"):
        words = words[words.index("python") :]
    program, *rest = words
    program = program.removeprefix(".venv/bin/")
    if program == "make":
        parse_make(words)
    elif program.startswith(".ci/"):
        assert (ROOT / program).is_file()
    elif program == "python" and rest[:2] == ["-m", "shellform"]:
        parser().parse_args(rest[2:])
    elif program == "python" and rest[:2] == ["-m", "pytest"]:
        files = [word.partition("::")[0] for word in rest[2:] if word.startswith("tests")]
        assert files and all((ROOT / file).exists() for file in files), files
    elif program == "python" and rest[0] == "-m" and rest[1].startswith("demos."):
        parse_arguments(rest[:2], rest[2:])
    elif program == "python" and rest[0].endswith(".py"):
        parse_arguments(rest[:1], rest[1:])
    else:
        pytest.fail(f"{shlex.join(words)} is no command of ours: mark the block")


def run(words, more, folder):
    words = [sys.executable if w == "python" else w for w in words]
    words = [str(ROOT / w) if w.startswith("demos/") else w for w in words]
    done = subprocess.run(
        [*words, *more], cwd=folder, env=outside(), capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("page", with_blocks("sh"))
def test_commands(page, tmp_path):
    for block in blocks_of(page):
        if block.language != "sh" or block.marker == "not ours":
            continue
        for words in commands_of(block):
            if block.marker.startswith("runs"):
                more = shlex.split(block.marker.removeprefix("runs").removeprefix(" with"))
                run(words, more, tmp_path)
            else:
                parse(words)


NAMED = re.compile(r"`((?:shellform|contact|meshes|demos|tests|docs)/[\w./*-]+)`")
FILE = re.compile(r"`(\w+\.(?:py|toml))`")
LINK = re.compile(r"\[[^\]]*\]\(([^)#:\s]+)(?:#[^)]*)?\)")


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_files_that_a_page_names_exist(page):
    """Paths in backquotes that begin with a folder of ours, and links to files."""
    text = page.read_text(encoding="utf-8")
    named_here = [ROOT / path.rstrip("/") for path in NAMED.findall(text)]
    named_here += [page.parent / link for link in LINK.findall(text)]
    named_here = [path for path in named_here if not set(MADE) & set(path.parts)]
    assert [str(path) for path in named_here if not path.exists()] == []


def test_files_that_contributing_names_alone_exist():
    """`capsule.py` beside its folder."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    ours = {
        p.name for room in ("shellform", "contact", "meshes") for p in ROOT.glob(f"{room}/**/*")
    }
    assert {"capsule.py", "formats.py"} <= set(FILE.findall(text)) <= ours


@pytest.mark.parametrize("package", [shellform, meshes])
def test_public_names_stand_in_the_reference(package):
    """All but plain tables, whose text is where they are used."""
    pages = "".join(path.read_text() for path in (ROOT / "docs/api").glob("*.md"))
    listed = set(re.findall(r"^\.\. auto\w+:: \w+\.(\w+)$", pages, re.M))
    names = {name for name in package.__all__ if callable(getattr(package, name))}
    assert len(names) > 10 and names <= listed


def test_names_of_a_page_are_not_described_by_their_room_too():
    """Sphinx takes a name that is described twice for a fault."""
    spec = importlib.util.spec_from_file_location("rooms", ROOT / "docs/rooms.py")
    rooms = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(rooms)
    pages = "".join(path.read_text() for path in (ROOT / "docs/api").glob("*.md"))
    named = set(re.findall(r"^\.\. auto(?:class|function|exception):: \S+\.(\w+)$", pages, re.M))
    assert named == {name for names in rooms.public_names().values() for name in names}
    for module, names in rooms.public_names().items():
        assert f":exclude-members: {', '.join(names)}\n" in rooms.page("room", [module])


def test_messages_of_the_page_of_troubles_are_those_of_the_code():
    """Pieces of every message between its dots, in sources whose texts are joined over lines."""
    page = (ROOT / "docs/troubles.md").read_text(encoding="utf-8")
    messages = re.findall(r"^`([^`\n]+)`[^\n]*\n: ", page.partition("## Messages")[2], re.M)
    sources = (
        p for room in ("shellform", "contact", "meshes") for p in ROOT.glob(f"{room}/**/*.py")
    )
    code = re.sub(r'"\s+f?"', "", "".join(p.read_text(encoding="utf-8") for p in sources))
    pieces = [x.strip("'") for m in messages for x in re.split(r"\s*\.\.\.\s*", m) if len(x) > 8]
    assert len(messages) > 10
    assert [piece for piece in pieces if piece not in code] == []


def test_readme_is_two_screens():
    assert len((ROOT / "README.md").read_bytes()) <= 8192
