# SPDX-License-Identifier: LGPL-3.0-or-later
"""Captures and garments of the user's own in scenes; what does not go together is refused."""

import subprocess
import sys
from functools import partial

import numpy as np
import pytest

import meshes
import shellform as sf
from shellform.__main__ import main
from shellform.console import run
from shellform.dynamics.time_stepper import check_time
from shellform.material.card import fabric_of
from shellform.motion.capture import segment_map
from shellform.scene import wearer as build
from shellform.scene.garment import garment_of
from shellform.scene.parts import Garment, Motion, Output, Person
from shellform.scene.scene import Scene
from tests.motion.capture.made_up import BMC, walker, write_csv, write_trc

COARSE = Garment(cell_size=0.04)


@pytest.fixture(scope="module")
def captures(tmp_path_factory):
    """Folder with a capture and its faulty likes, and trousers in files."""
    folder = tmp_path_factory.mktemp("captures")
    names, tracks, _ = walker(BMC)
    trc, csv = partial(write_trc, names=names), partial(write_csv, names=names, unit="m")
    knee = names.index("R.Knee")
    trc(folder / "good.trc", tracks=1e3 * tracks)
    trc(folder / "unit.trc", tracks=1e3 * tracks, unit="m")
    fewer = names[:knee] + names[knee + 1 :]
    write_trc(folder / "missing.trc", fewer, np.delete(1e3 * tracks, knee, axis=1))
    other = [n.translate(str.maketrans("RL", "LR")) if n[1] == "." else n for n in names]
    write_trc(folder / "mirrored.trc", other, 1e3 * tracks)
    tracks[100:130, knee] = np.nan
    csv(folder / "gap.csv", tracks=tracks)
    tracks[:, knee] = np.nan
    csv(folder / "nan.csv", tracks=tracks)
    shipped = (segment_map.FOLDER / "medial.toml").read_text()
    (folder / "map.toml").write_text(shipped.replace('"{S}.Knee", ', '"{S}.Kneecap", '))
    mine = shipped[: shipped.index('"{side}_knee_lateral" = [')]
    rest = shipped[shipped.index('"{side}_knee_medial" = [') :]
    (folder / "kneecap.toml").write_text(mine + '"{side}_knee_lateral" = ["{S}.Cap"]\n' + rest)
    surface = meshes.trousers(cell_size=0.04)
    meshes.save(surface, folder / "good.vtu")
    meshes.save(surface, folder / "plain.obj")
    meshes.save(surface.transform(translation=(1.0, 0.0, 0.0)), folder / "aside.vtu")
    return folder


def of_capture(name, **more):
    return lambda folder: Scene(motion=Motion(file=str(folder / name), **more), garment=COARSE)


def of_garment(name, **more):
    return lambda folder: Scene(garment=Garment(file=str(folder / name), **more))


def of(**parts):
    return lambda folder: Scene(**{"garment": COARSE} | parts)


# what is wrong -> scene, words of the sentence: the file, the item, the time, the mend
WRONG = {
    "missing marker": (of_capture("missing.trc"), ("missing.trc", "R.Knee", "not there", "L.Knee")),
    "unknown label in a map": (
        lambda folder: of_capture("good.trc", map=str(folder / "kneecap.toml"))(folder),
        ("good.trc", "kneecap.toml", "R.Cap", "rename it, or write a map"),
    ),
    "column of NaN": (of_capture("nan.csv"), ("nan.csv", "'R.Knee' holds no numbers", "fill it")),
    "mm taken for m": (of_capture("unit.trc"), ("unit.trc", "'m'", "m", 'pass unit = "mm"')),
    "gap too long": (
        of_capture("gap.csv"),
        ("gap.csv", "'R.Knee'", "t = 1.000 s", "0.300 s", "max_gap = 0.1 s", "raise max_gap"),
    ),
    "window without frames": (
        of_capture("good.trc", start=10.0, end=11.0),
        ("good.trc", "10.0", "0 frames", "0.000 to 3.490 s"),
    ),
    "window without frames of a walk": (
        of(motion=Motion(start=10.0)),
        ("synthetic walk", "motion.start = 10.0", "5.8"),
    ),
    "no such capture": (of_capture("none.c3d"), ("none.c3d", "no such file")),
    "no capture": (of_capture("good.vtu"), ("good.vtu", "no marker file", ".c3d")),
    "no such map": (of_capture("good.trc", map="mine"), ("'mine'", "medial", "TOML file")),
    "waist aside": (of_garment("aside.vtu", place=[0, 0, 0]), ("aside.vtu", "waist", "pelvis")),
    "leg outside the garment": (
        of(garment=Garment(cell_size=0.04, measures={"stance": 0.2})),
        ("right hem", "right leg", "stance", "width"),
    ),
    "hips too big": (
        of(person=Person(girths={"hip": 1.3})),
        ("1.300 m around the hips", "larger size", "girths"),
    ),
    "thighs too big": (
        of(person=Person(girths={"thigh": 0.95})),
        ("around the right thigh", "larger size", "girths"),
    ),
    "calves too big": (
        of(person=Person(girths={"calf": 0.6}), garment=Garment(measures={"knee": 0.5})),
        ("0.600 m around the right shank", "larger size"),
    ),
    "no waist": (
        of_garment("plain.obj", waist="belt"),
        ("plain.obj", "no edge 'belt'", "waist='highest'"),
    ),
    "garment in another unit": (of_garment("good.vtu", unit="cm"), ("good.vtu", "unit='m'")),
    "no such garment": (of_garment("none.obj"), ("none.obj", "no such file")),
    "no such size": (of(garment=Garment(size="huge")), ("'huge'", "large-regular")),
    "no such measure": (of(garment=Garment(measures={"wast": 1.0})), ("'wast'", "waist, hip")),
    "no such girth": (of(person=Person(girths={"neck": 0.4})), ("'neck'", "waist, hip")),
    "girth in cm": (of(person=Person(girths={"hip": 102})), ("'hip'", "102", "metres")),
    "no such joint": (of(output=Output(parts={"knee": []})), ("'knee'", "right_knee")),
    "no such ellipsoid": (of(output=Output(parts={"left_knee": ["sock"]})), ("'sock'",)),
    "no such fabric": (of(fabric="silk"), ("'silk'", "compliant, denim")),
    "obstacle too high": (
        of(motion=Motion(obstacle=0.6)),
        ("obstacle of 0.6 m", "0.54 m"),
    ),
}  # fmt: skip


@pytest.mark.serial
@pytest.mark.filterwarnings("ignore:.*which no garment does")
@pytest.mark.parametrize("name", WRONG)
def test_wrong_scene(name, captures):
    make, words = WRONG[name]
    with pytest.raises((ValueError, OSError)) as caught:
        scene = make(captures)
        garment_of(scene, build.wearer_of(scene))
        fabric_of(scene.fabric)
    sentence = str(caught.value)
    for word in words:
        assert word in sentence
    assert "\n" not in sentence


@pytest.mark.serial
def test_mirrored_labels_are_repaired(captures):
    """Right and left change places again, which is noted; the torque's axes do not notice."""
    good, mirrored = (
        build.wearer_of(of_capture(name)(captures)) for name in ("good.trc", "mirrored.trc")
    )
    assert any("mirrored" in note for note in mirrored.recording.notes)
    assert not any("mirrored" in note for note in good.recording.notes)
    for t in (0.5, 2.0):
        assert np.array_equal(good.new_pose(t).centres, mirrored.new_pose(t).centres)


@pytest.mark.serial
def test_garments_of_the_users_own_fit(captures):
    """Trousers from a file lie where those of the same measures do, with or without names."""
    wearer = build.wearer_of(Scene())
    surface = garment_of(of_garment("good.vtu")(captures), wearer)
    named = garment_of(of_garment("plain.obj", waist="highest")(captures), wearer)
    sized = garment_of(Scene(garment=Garment(size="large-regular", cell_size=0.04)), wearer)
    for one in (surface, named):
        assert np.abs(one.points - sized.points).max() < 1e-7
        assert {"waist", "left_hem", "right_hem"} <= set(one.edges)


SCENES = {
    "missing file": (None, "nowhere.toml"),
    "unknown key": ("belt = 3", "did you mean 'belt_N'?"),
    "missing capture": ('[motion]\nfile = "walk.c3d"', "walk.c3d: no such file"),
    "window without frames": ("[motion]\nstart_s = 10", "less than two frames"),
    "body too big": ("[person]\ngirths_m = { hip = 1.3 }", "around the hips"),
    "no such ellipsoid": ('[output.parts]\nleft_knee = ["sock"]', "no segment 'sock'"),
}


@pytest.mark.serial
@pytest.mark.parametrize("do", ["check", "run"])
@pytest.mark.parametrize("name", SCENES)
def test_command_ends_with_the_sentence(name, do, tmp_path, capsys, monkeypatch):
    """Exit code 2 and one line on standard error; nothing computed."""
    contents, words = SCENES[name]
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "nowhere.toml"
    if contents:
        path = tmp_path / "scene.toml"
        path.write_text(contents)
    with pytest.raises(SystemExit) as end:
        run(main, [do, str(path)])
    said = capsys.readouterr()
    assert end.value.code == 2
    assert words in said.err and said.err.count("\n") == 1 and "Traceback" not in said.err
    assert said.out == ""
    assert not list(tmp_path.glob("out/*/*.npz"))


@pytest.mark.serial
def test_other_commands_that_cannot_be(tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "ezc3d", None)
    (tmp_path / "walk.c3d").write_bytes(b"\x02\x50" + bytes(1022))
    (tmp_path / "capture.toml").write_text('[motion]\nfile = "walk.c3d"')
    (tmp_path / "scene.toml").write_text("")
    for words, arguments in {
        "holds no checkpoint.npz: nothing has been computed": ["resume", tmp_path],
        "scene.toml exists already": ["new", tmp_path / "scene.toml"],
        "ezc3d": ["check", tmp_path / "capture.toml"],
    }.items():
        with pytest.raises(SystemExit) as end:
            run(main, [str(word) for word in arguments])
        said = capsys.readouterr().err
        assert end.value.code == 2 and words in said and said.count("\n") == 1
    assert (tmp_path / "scene.toml").read_text() == ""


def test_what_is_no_file_is_refused():
    """By the functions that take names of files; and what is no time, by steps."""
    for call, what in ((sf.check, "a scene is"), (sf.read_motion, "a capture is")):
        with pytest.raises(ValueError, match=f"{what} .* name of its file, not 3"):
            call(3)
    for until in ("1 s", None, float("nan")):
        with pytest.raises(ValueError, match=f"finite time in s, not to {until!r}"):
            check_time(until)


@pytest.mark.serial
def test_program_refuses(tmp_path):
    """As a user calls it: a wrong option, a wrong scene."""
    (tmp_path / "scene.toml").write_text("belt_N = -1")
    for arguments, words in {
        ("run", "scene.toml", "--ou", "x"): "unknown argument --ou",
        ("check", "scene.toml"): "scene.toml: belt = -1 lies outside 0 to 500",
    }.items():
        done = subprocess.run(
            [sys.executable, "-m", "shellform", *arguments],
            capture_output=True, text=True, timeout=300, cwd=tmp_path,
        )  # fmt: skip
        assert done.returncode == 2
        assert words in done.stderr.strip().splitlines()[-1] and "Traceback" not in done.stderr


@pytest.mark.serial
def test_checked_scene(tmp_path, capsys):
    """What `new` writes can be checked: body, garment, dofs, steps, memory."""
    path = tmp_path / "scene.toml"
    main(["new", str(path)])
    main(["check", str(path)])
    said = capsys.readouterr().out
    surface = garment_of(Scene(), build.wearer_of(Scene()))
    for words in (
        "trousers over an obstacle",
        f"{len(surface.cells)} cells",
        f"{5 * len(surface.points)} dofs",
        "stride 1.320 m",
        "belt of 20 N",
        "right_shank",
        "minutes on 1 rank",
        " MB",
    ):
        assert words in said


@pytest.mark.serial
def test_bodies_and_meshes_need_no_finite_elements():
    """Nothing of contact or meshes imports dolfinx, PETSc, MPI or the reader of C3D files."""
    code = (
        "import pkgutil, sys, importlib, contact, meshes\n"
        "for package in (contact, meshes):\n"
        "    for part in pkgutil.walk_packages(package.__path__, package.__name__ + '.'):\n"
        "        importlib.import_module(part.name)\n"
        "names = 'dolfinx', 'petsc4py', 'mpi4py', 'ezc3d', 'shellform', 'matplotlib'\n"
        "print([name for name in names if name in sys.modules])\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=300)
    assert done.stdout.strip() == "[]", done.stderr


@pytest.mark.serial
def test_what_is_not_asked_for_is_not_loaded(captures):
    """A wearer from a TRC file needs no reader of C3D files, pictures or finite elements."""
    code = (
        "import sys\n"
        "from shellform.scene import scene, wearer\n"
        "wearer.wearer_of(scene.Scene(motion=scene.Motion(file=sys.argv[1])))\n"
        "names = 'ezc3d', 'matplotlib', 'dolfinx'\n"
        "print([name for name in names if name in sys.modules])\n"
    )
    words = [sys.executable, "-c", code, str(captures / "good.trc")]
    done = subprocess.run(words, capture_output=True, text=True, timeout=300)
    assert done.stdout.strip() == "[]", done.stderr
