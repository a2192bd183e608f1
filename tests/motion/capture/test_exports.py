# SPDX-License-Identifier: LGPL-3.0-or-later
"""Text files as Motive, Nexus, QTM and animation programs export them, against a known walker."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from shellform.motion.capture.bvh_file import Joint, joint_places
from shellform.motion.capture.formats import read_table
from shellform.motion.capture.read_motion import read_motion
from tests.motion.capture.made_up import BMC, SHANK, THIGH, walker, write_csv, write_trc, y_up

RATE = 120.0


def rows(names, tracks, first, separator=","):
    return [
        separator.join([*first(k), *(f"{v:.6f}" for v in frame.ravel())])
        for k, frame in enumerate(tracks)
    ]


def motive(names, tracks, kind="Marker"):
    """Format 1.23; a rigid body's rotation before the markers, an unlabeled one behind them."""
    three = [n for n in names for _ in "xyz"]
    pad = lambda word, label, last: ",".join(  # noqa: E731
        ["", "", *[word] * 4, *label, *[last] * 3]
    )
    lines = [
        "Format Version,1.23,Take Name,walk,Capture Frame Rate,240.0,Export Frame Rate,"
        f"{RATE:.6f},Total Exported Frames,{len(tracks)},Rotation Type,Quaternion,"
        "Length Units,Meters,Coordinate Space,Global",
        "",
        pad("Rigid Body", [kind] * len(three), "Marker"),
        pad("wand", [f"Ann:{n}" for n in three], "Unlabeled 2034"),
        pad("AB", ["CD"] * len(three), "EF"),
        pad("Rotation", ["Position"] * len(three), "Position"),
        ",".join(["Frame", "Time (Seconds)", *"XYZW", *"XYZ" * (len(names) + 1)]),
    ]
    extra = np.concatenate([tracks, np.ones((len(tracks), 1, 3))], axis=1)
    start = lambda k: (str(k), f"{k / RATE:.6f}", "0", "0", "0", "1")  # noqa: E731
    return "\n".join([*lines, *rows(names, extra, start)]) + "\n"


def nexus(names, tracks):
    """Forces before and model outputs, angles and a joint, behind the trajectories."""
    head = ",".join(["", "", *(f"Ann:{n},," for n in names)])
    section = [
        "Trajectories",
        f"{RATE:g}",
        head,
        ",".join(["Frame", "Sub Frame", *"XYZ" * len(names)]),
        ",".join(["", "", *["mm"] * 3 * len(names)]),
        *rows(names, 1000 * tracks, lambda k: (str(k + 5), "0")),
    ]
    devices = ["Devices", "1000", ",,Plate - Force,,", "Frame,Sub Frame,Fx,Fy,Fz", ",,N,N,N"]
    devices += ["1,0,1.0,2.0,3.0", "1,1,1.0,2.0,3.0", ""]
    model = ["", "Model Outputs", f"{RATE:g}", ",,Ann:RKneeAngles,,,Ann:PELO,,"]
    model += ["Frame,Sub Frame,X,Y,Z,X,Y,Z", ",,deg,deg,deg,mm,mm,mm"]
    model += [f"{k + 5},0,1,2,3,4,5,6" for k in range(len(tracks))]
    return "\r\n".join([*devices, *section, *model]) + "\r\n"


def qtm(names, tracks, columns=2):
    head = [
        f"NO_OF_FRAMES\t{len(tracks)}",
        "NO_OF_CAMERAS\t8",
        f"NO_OF_MARKERS\t{len(names)}",
        f"FREQUENCY\t{RATE:g}",
        "DATA_INCLUDED\t3D",
        "EVENT\tstart\t12\t0.1",
        "MARKER_NAMES\t" + "\t".join(names),
    ]
    if columns:
        axes = [f"{n} {a}" for n in names for a in "XYZ"]
        head.append("\t".join([*("Frame", "Time")[:columns], *axes]))
    start = lambda k: (str(k + 1), f"{k / RATE:.5f}")[:columns]  # noqa: E731
    return "\n".join([*head, *rows(names, 1000 * tracks, start, "\t")]) + "\n"


PROGRAMS = {
    "motive": ("csv", lambda n, t: motive(n, y_up(t))),
    "motive bones": ("csv", lambda n, t: motive(n, y_up(t), "Bone Marker")),
    "nexus": ("csv", nexus),
    "qtm": ("tsv", qtm),
    "qtm frames": ("tsv", lambda n, t: qtm(n, t, 1)),
    "qtm bare": ("tsv", lambda n, t: qtm(n, t, 0)),
}


@pytest.mark.parametrize("program", PROGRAMS)
def test_exports_are_read(tmp_path, program):
    """Joint centres to 2e-6 m, six decimals of a metre, whatever else is in the file."""
    ending, write = PROGRAMS[program]
    names, tracks, truth = walker(BMC, rate=RATE)
    path = tmp_path / f"walk.{ending}"
    path.write_text(write(names, tracks), newline="")
    rec = read_motion(path, cutoff=None, rigid=False)
    assert rec.rate == pytest.approx(RATE) and len(rec.times) == len(tracks)
    for side in ("right", "left"):
        for joint in ("hip", "knee", "ankle"):
            off = rec.joint_centre(f"{side}_{joint}") - truth[side][joint]
            assert np.abs(off).max() < 3e-6, joint
    if program == "motive":
        assert any("unlabeled" in note for note in rec.notes)


@pytest.mark.parametrize("program", PROGRAMS)
def test_exports_cut_in_half(tmp_path, program):
    """Refused, or told: which line, or how many frames there should be."""
    ending, write = PROGRAMS[program]
    names, tracks, _ = walker(BMC, rate=RATE)
    text = write(names, tracks)
    path = tmp_path / f"walk.{ending}"
    path.write_text(text[: len(text) // 2], newline="")
    try:
        notes = read_motion(path).notes
    except ValueError as error:
        assert str(error).startswith(f"{path}: ") and "\n" not in str(error)
    else:
        assert any("header says" in note or "no end" in note for note in notes), notes


HEADED = ("motive", "nexus", "qtm")


@pytest.mark.parametrize("program", [*HEADED, "trc", "bvh"])
@pytest.mark.parametrize("lost", [1, 40])
def test_cut_at_the_end_of_a_line(tmp_path, program, lost):
    """Whole lines that are missing are told where the header, or another section, has more: a
    number of frames in all formats but CSV of one's own; the devices in Nexus'."""
    names, tracks, _ = walker(BMC, rate=RATE)
    path = tmp_path / "walk.txt"
    if program in HEADED:
        ending, write = PROGRAMS[program]
        text = write(names, tracks)
    elif program == "trc":
        ending, text = "trc", write_trc(path, names, 1000 * tracks, rate=RATE).read_text()
    else:
        ending, text = "bvh", skeleton()[0]
    if program == "nexus":
        head, rest = text.split("\r\n\r\nModel")[0].split("Trajectories")
        more = "".join(f"{k + 5},0,1,2,3\r\n" for k in range(len(tracks)))
        text = head.replace("1,1,1.0,2.0,3.0\r\n", more) + "Trajectories" + rest + "\r\n"
    path = tmp_path / f"walk.{ending}"
    path.write_text(text, newline="")
    words = ("header says", "may be cut off", "the file is cut off")
    if program != "bvh":
        assert not any(w in n for n in read_table(path).notes for w in words)
    lines = text.splitlines(keepends=True)
    path.write_text("".join(lines[:-lost]), newline="")
    try:
        notes = read_table(path).notes
    except ValueError as error:
        notes = (str(error),)
    assert any(w in n for n in notes for w in words), notes


ENCODINGS = ("utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32", "cp1252")


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_encodings(tmp_path, encoding):
    names, tracks, _ = walker(BMC, seconds=0.5)
    for write, ending in ((write_trc, "trc"), (write_csv, "csv")):
        path = write(tmp_path / f"walk.{ending}", [*names[:-1], "größe"], 1000 * tracks)
        want = read_table(path)
        path.write_bytes(path.read_text().encode(encoding))
        raw = read_table(path)
        assert raw.names == want.names and np.array_equal(raw.positions, want.positions)
        assert bool(raw.notes) == (encoding != "utf-8-sig")


@pytest.mark.parametrize("separator", [",", ";", " "])
def test_separators(tmp_path, separator):
    names, tracks, _ = walker(BMC, seconds=0.5)
    path = write_trc(tmp_path / "walk.trc", names, 1000 * tracks)
    want = read_table(path)
    text = path.read_text()
    if separator == " ":
        text = "\n".join(" ".join(line.split("\t")) for line in text.splitlines()) + "\n"
    path.write_text(text.replace("\t", separator))
    raw = read_table(path)
    assert raw.names == want.names and np.array_equal(raw.positions, want.positions)
    assert any("separated by" in note for note in raw.notes)


def test_decimal_commas(tmp_path):
    """As spreadsheets of half the world write them: between semicolons and tabs."""
    names, tracks, _ = walker(BMC, seconds=0.5)
    for write, ending in ((write_trc, "trc"), (write_csv, "csv")):
        path = write(tmp_path / f"walk.{ending}", names, 1000 * tracks)
        want = read_table(path)
        lines = path.read_text().replace(",", ";").splitlines()
        head = 6 if ending == "trc" else 1
        body = [line.replace(".", ",") for line in lines[head:]]
        path.write_text("\n".join([*lines[:head], *body]) + "\n")
        raw = read_table(path)
        assert np.array_equal(raw.positions, want.positions)
        assert "decimal commas read as points" in raw.notes


def skeleton(names=("Hips", "{side}UpLeg", "{side}Leg", "{side}Foot", "{side}ToeBase", "Neck")):
    """A BVH file in cm, y up, of legs that swing, and joint centres as matrices make them."""
    n, rate = 120, 60.0
    t = np.arange(n) / rate
    root, hip, knee, ankle, toe, neck = names
    lines, values, truth = ["HIERARCHY", f"ROOT {root}", "{"], [], {}
    lines += [
        "OFFSET 0 0 0",
        "CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation",
    ]
    turn = 10 * np.sin(2 * np.pi * t)
    place = np.stack([0 * t, 95 + 2 * np.cos(4 * np.pi * t), 120 * t], axis=1)
    values += [*place.T, 0 * t, 0 * t, turn]
    pelvis = Rotation.from_euler("Y", turn[:, None], degrees=True)
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        phase = 2 * np.pi * t + (np.pi if sign > 0 else 0.0)
        swing, flex = -20 * np.sin(phase), 20 * (1 + np.cos(phase))
        at = {w: w.replace("{side}", side) for w in (hip, knee, ankle, toe)}
        for word, offset in ((hip, f"{9 * sign} -5 0"), (knee, f"0 {-100 * THIGH} 0"),
                             (ankle, f"0 {-100 * SHANK} 0"), (toe, "0 -7 15")):  # fmt: skip
            lines += [f"JOINT {at[word]}", "{", f"OFFSET {offset}"]
            lines += ["CHANNELS 3 Zrotation Xrotation Yrotation"]
        lines += ["End Site", "{", "OFFSET 0 0 5", "}"] + ["}"] * 4
        zero = 0 * t
        values += [zero, swing, zero, zero, flex, zero, zero, zero, zero, zero, zero, zero]
        thigh = pelvis * Rotation.from_euler("X", swing[:, None], degrees=True)
        shank = thigh * Rotation.from_euler("X", flex[:, None], degrees=True)
        h = place + pelvis.apply([9 * sign, -5, 0])
        k = h + thigh.apply([0, -100 * THIGH, 0])
        truth[side.lower()] = {"hip": h, "knee": k, "ankle": k + shank.apply([0, -100 * SHANK, 0])}
    lines += [f"JOINT {neck}", "{", "OFFSET 0 50 0", "CHANNELS 3 Zrotation Xrotation Yrotation"]
    lines += ["End Site", "{", "OFFSET 0 10 0", "}", "}", "}"]
    values += [0 * t] * 3
    lines += ["MOTION", f"Frames: {n}", f"Frame Time: {1 / rate:.9f}"]
    lines += [" ".join(f"{v:.8f}" for v in row) for row in np.stack(values, axis=1)]
    return "\n".join(lines) + "\n", truth


SKELETONS = {
    "motionbuilder": ("Hips", "{side}UpLeg", "{side}Leg", "{side}Foot", "{side}ToeBase", "Neck"),
    "mixamo": tuple(
        f"mixamorig:{n}"
        for n in ("Hips", "{side}UpLeg", "{side}Leg", "{side}Foot", "{side}ToeBase", "Neck")
    ),
    "joints": ("Hips", "{side}Hip", "{side}Knee", "{side}Ankle", "{side}Toe", "Neck"),
    "bones": ("Hip", "{side}Thigh", "{side}Shin", "{side}Foot", "{side}Toe", "Neck"),
}


@pytest.mark.parametrize("key", SKELETONS)
def test_skeletons_in_bvh(tmp_path, key):
    """Joint centres against the same chain of rotations by scipy, cm and y up found: to 1e-8 m."""
    text, truth = skeleton(SKELETONS[key])
    path = tmp_path / "walk.bvh"
    path.write_text(text)
    rec = read_motion(path, cutoff=None, rigid=False)
    for side in ("right", "left"):
        for joint, centre in truth[side].items():
            x, y, z = 0.01 * centre.T
            want = np.stack([x, -z, y], axis=1)
            assert np.abs(rec.joint_centre(f"{side}_{joint}") - want).max() < 1e-8, joint
        assert f"{side}_foot" in rec.points
    assert any("unit cm" in note for note in rec.notes)
    assert any("taken for joint centres" in note for note in rec.notes)


def test_order_of_turns_in_bvh():
    """Channels in any order, positions of a joint that is no root: as matrices multiply."""
    rng = np.random.default_rng(4)
    values = rng.uniform(-170, 170, (7, 9))
    joints = [
        Joint("a", -1, np.array([1.0, 2.0, 3.0]), [(c, "rotation") for c in "yxz"]),
        Joint("b", 0, np.array([0.5, -1.0, 2.0]), [(c, "position") for c in "xyz"]
              + [(c, "rotation") for c in "xzy"]),
        Joint("c", 1, np.array([0.0, 3.0, 0.0]), []),
    ]  # fmt: skip
    found = joint_places(joints, values)
    first = Rotation.from_euler("YXZ", values[:, :3], degrees=True)
    second = first * Rotation.from_euler("XZY", values[:, 6:], degrees=True)
    b = joints[0].offset + first.apply(joints[1].offset + values[:, 3:6])
    assert found[:, 1] == pytest.approx(b, abs=1e-10)
    assert found[:, 2] == pytest.approx(b + second.apply(joints[2].offset), abs=1e-10)


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ("HIERARCHY", "HIERARCHIE", "no BVH file"),
        ("MOTION", "MOTIONS", "no BVH file, or cut off"),
        ("Frames: 120", "Frames: 121", "numbers for 121 frames.*cut off"),
        ("Frame Time: 0.0", "Frame Time: -0.0", "Frame Time"),
        ("OFFSET 0 50 0", "OFFSET 0 50", "3 numbers are missing"),
        ("JOINT Neck", "JOIN Neck", "unknown word 'JOIN'"),
        ("CHANNELS 3", "CHANNELS 7", "channels of"),
        ("Xposition", "Wposition", "channels of Hips"),
    ],
)
def test_bvh_that_is_none(tmp_path, old, new, match):
    path = tmp_path / "walk.bvh"
    path.write_text(skeleton()[0].replace(old, new, 1))
    with pytest.raises(ValueError, match=match) as error:
        read_motion(path)
    assert str(error.value).startswith(f"{path}: ") and "\n" not in str(error.value)
