# SPDX-License-Identifier: LGPL-3.0-or-later
"""Names of files that are not UTF-8, with the terminal and the locale of strangers."""

import json
import os
import subprocess
import sys
from dataclasses import replace

import pytest

import meshes
from shellform.motion.capture.formats import read_table
from shellform.scene.parts import Garment, Motion
from shellform.scene.scene import Scene
from shellform.scene.scene_file import read_scene, write_scene
from tests.motion.capture.c3d_bytes import write_c3d_bytes
from tests.motion.capture.made_up import BMC, walker
from tests.ranks import ROOT, outside
from tests.simulation.short_walk import WALK

LATIN = os.fsdecode(b"s\xe9jour")
LOCALES = {
    "UTF-8 alone": {"PYTHONIOENCODING": "utf-8:strict"},
    "C": {"LC_ALL": "C", "PYTHONUTF8": "0"},
}
pytestmark = pytest.mark.serial


def program(*words, **more):
    """A Python program outside of mpirun; what it printed as bytes."""
    return subprocess.run(
        [sys.executable, *map(str, words)],
        cwd=ROOT, env=outside() | more, capture_output=True, timeout=600, check=False,
    )  # fmt: skip


@pytest.fixture
def folder(tmp_path):
    (tmp_path / LATIN).mkdir()
    return tmp_path / LATIN


@pytest.mark.slow
@pytest.mark.parametrize("locale", LOCALES)
def test_a_scene_and_its_garment_are_checked(locale, folder):
    """A folder in Latin-1, a garment in UTF-8, in the locale of the user."""
    name = "Hose für Große.vtu"
    meshes.save(meshes.trousers(), folder / name)
    write_scene(replace(WALK, title="für Große"), folder / "scene.toml")
    contents = (folder / "scene.toml").read_text(encoding="utf-8")
    contents = contents.replace("[garment]", f'[garment]\nfile = "{name}"')
    (folder / "scene.toml").write_text(contents, encoding="utf-8")
    done = program("-m", "shellform", "check", folder / "scene.toml", **LOCALES[locale])
    assert done.returncode == 0 and not done.stderr, done.stderr
    assert b"Hose f" in done.stdout


@pytest.mark.thorough
@pytest.mark.slow
def test_a_run_writes_its_files(folder):
    """All that a run leaves, in such a folder, and the scene can be read again."""
    scene = replace(WALK, motion=replace(WALK.motion, end=1.54), belt=20.0)
    write_scene(scene, folder / "scene.toml")
    out = folder / "out"
    words = ("-m", "shellform", "run", folder / "scene.toml", "--out", out)
    done = program(*words, **LOCALES["C"])
    assert done.returncode == 0, done.stderr
    assert b"Traceback" not in done.stderr and b"wrote " + os.fsencode(out) in done.stdout
    assert json.loads((out / "summary.json").read_text())["results"]["joints"]
    assert read_scene(out / "scene.toml").motion == scene.motion


def test_names_in_a_scene_keep_their_bytes(folder):
    """Written in full and read again; so are scenes that an editor has left in Latin-1."""
    for name in (b"walk\xe8.trc", "für.trc".encode()):
        file = folder / os.fsdecode(name)
        scene = Scene(motion=Motion(file=str(file)), garment=Garment(file=str(folder / "a.obj")))
        write_scene(scene, folder / "scene.toml")
        assert name in (folder / "scene.toml").read_bytes()
        assert read_scene(folder / "scene.toml").motion.file == str(file)
    (folder / "scene.toml").write_bytes(b'# \xe0 pied\n[motion]\nfile = "walk\xe8.trc"\n')
    name = os.fsdecode(b"walk\xe8.trc")
    assert read_scene(folder / "scene.toml").motion.file == str(folder / name)
    (folder / "scene.toml").write_bytes(b'title = "\xe0 pied"\n')
    with pytest.raises(ValueError, match="the title is not in UTF-8"):
        read_scene(folder / "scene.toml")


@pytest.mark.parametrize("order", ["intel", "mips"])
def test_a_c3d_file(order, folder):
    pytest.importorskip({"intel": "ezc3d", "mips": "c3d"}[order], reason="not installed here")
    names, tracks, _ = walker(BMC, seconds=0.5)
    path = write_c3d_bytes(folder / os.fsdecode(b"\xe8.c3d"), names, 1000 * tracks, order=order)
    assert read_table(path).names == tuple(names)


@pytest.mark.parametrize("locale", LOCALES)
def test_names_are_printed_as_they_are(locale):
    """Bytes of a name as they are, other letters as the terminal has them; errors as sentences."""
    script = (
        "import sys\n"
        "from shellform import console\n"
        "def main(_):\n"
        "    print('im', sys.argv[1])\n"
        "    print('\\u20ac')\n"
        "    raise ValueError(f'{sys.argv[1]}: none')\n"
        "console.run(main)\n"
    )
    done = program("-c", script, LATIN, **LOCALES[locale])
    euro = "€".encode() if locale != "C" else b"\\u20ac"
    assert done.stdout == b"im " + os.fsencode(LATIN) + b"\n" + euro + b"\n"
    assert done.returncode == 2 and done.stderr == b"-c: s\\udce9jour: none\n"


def test_text_is_written_in_utf_8(tmp_path):
    """Whatever the locale is; it was that of the user."""
    script = (
        "from shellform.results.files import write_atomically\n"
        "import sys; write_atomically(sys.argv[1], '\\u20ac\\udce9')\n"
    )
    for locale in LOCALES.values():
        done = program("-c", script, tmp_path / "text", **locale)
        assert done.returncode == 0, done.stderr
        assert (tmp_path / "text").read_bytes() == "€".encode() + b"\xe9"
