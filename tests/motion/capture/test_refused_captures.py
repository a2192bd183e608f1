# SPDX-License-Identifier: LGPL-3.0-or-later
"""Files, labels and maps that cannot be read are refused in a sentence."""

import sys

import numpy as np
import pytest

from shellform.motion.capture.read_motion import (
    read_markers,
    read_motion,
    recording,
    segment_map,
)
from tests.motion.capture.made_up import (
    BMC,
    DIRECT,
    PLUG_IN,
    walker,
    write_c3d,
    write_csv,
    write_trc,
    y_up,
)


def test_c3d_leaves_out_what_is_no_place(tmp_path):
    """Angles, prefixes, residuals below 0, and a vertical told by the file alone."""
    names, tracks, truth = walker(PLUG_IN)
    tracks[50:54, names.index("RKNE")] = np.nan
    more = np.concatenate([tracks, 0.09 + 0 * tracks[:, :2]], axis=1)
    labels = [f"Ann:{n}" for n in [*names, "RKneeAngles", "odd"]]
    path = write_c3d(
        tmp_path / "a.c3d", labels, 1000 * more, groups=[("ANGLES", ["Ann:RKneeAngles", "Ann:odd"])]
    )
    markers = read_markers(path)
    assert markers.names == tuple(names)
    assert np.isnan(markers.track("RKNE")).all(axis=1).sum() == 4
    rec = recording(markers, cutoff=None)
    assert np.abs(rec.joint_centre("left_hip") - truth["left"]["hip"]).max() < 1e-6
    unknown = write_c3d(tmp_path / "b.c3d", ["p", "q"], 1000 * y_up(tracks[:, [0, 4]]), up="+Y")
    assert any("up is y, from the file" in note for note in read_markers(unknown).notes)


def test_c3d_without_ezc3d(tmp_path, monkeypatch):
    """A sentence, and only when a C3D file is read."""
    (tmp_path / "a.c3d").write_bytes(b"\x02\x50" + bytes(1022))
    monkeypatch.setitem(sys.modules, "ezc3d", None)
    names, tracks, _ = walker(BMC, seconds=0.5)
    assert len(read_markers(write_csv(tmp_path / "a.csv", names, tracks)).names) == 18
    with pytest.raises(ImportError, match=r"a\.c3d.*ezc3d.*pip install"):
        read_markers(tmp_path / "a.c3d")


def test_c3d_cut_off(tmp_path):
    """A file shorter than its header tells, one without a header, one that is none."""
    names, tracks, _ = walker(PLUG_IN, seconds=0.5)
    path = write_c3d(tmp_path / "a.c3d", names, 1000 * tracks)
    assert len(read_markers(path).times) == 50
    whole = path.read_bytes()
    for part in (whole[: len(whole) // 2], whole[:-600], whole[:300], b"no" * 1000):
        path.write_bytes(part)
        with pytest.raises(ValueError, match=r"a\.c3d: .*cut off"):
            read_markers(path)


def test_bad_files_are_refused_in_a_sentence(tmp_path):
    names, tracks, _ = walker(BMC, seconds=0.5)
    path = tmp_path / "walk.trc"

    def refused(match, **changes):
        with pytest.raises(ValueError, match=match) as error:
            read_motion(path, **changes)
        assert str(path) in str(error.value) and "\n" not in str(error.value)

    write_trc(path, names, 1000 * tracks, unit="m")
    refused(r"unit 'm' in the header.*span 9\d\d.*unit='mm'")
    assert np.ptp(read_markers(path, unit="mm").positions[0], axis=0).max() < 2.5
    write_trc(path, names, 1000 * tracks)
    refused("unknown unit 'furlong'", unit="furlong")
    refused("window", window=(7, 8))
    refused("cutoff must lie between", cutoff=90.0)
    text = path.read_text()
    path.write_text(text[: int(0.7 * len(text))])
    refused("cut off in frame 3. of 50")
    lines = text.splitlines()
    path.write_text("\n".join([*lines[:20], lines[20].rsplit("\t", 1)[0], *lines[21:]]) + "\n")
    refused("cut off in frame 15 of 50")
    path.write_text(text.replace("Frame#", "Bild"))
    refused("'Frame#'")
    path.write_text(text.replace("\t0.010\t", "\t0.010\tx"))
    refused(r"line 8, column 3 holds 'x")
    path.write_text(text.replace("100\t100", "300\t300"))
    refused("rate is 300 Hz.*100 Hz")
    path.write_text(text.replace("R.ASIS", "L.ASIS"))
    refused("two markers are called 'L.ASIS'")
    blank = 1000 * tracks
    blank[:, names.index("R.Ankle")] = np.nan
    write_trc(path, names, blank)
    refused(r"'R\.Ankle' holds no numbers", map="medial")
    write_trc(path, [n.replace("R.Knee", "R.Kneee") for n in names], 1000 * tracks)
    refused(r"right_knee_lateral.*closest label: 'R\.Kneee'", map="medial")
    refused("no shipped map fits.*medial.*lateral")
    swapped = [{"R.Knee": "R.Knee.Medial", "R.Knee.Medial": "R.Knee"}.get(n, n) for n in names]
    write_trc(path, swapped, 1000 * tracks)
    refused("right_thigh lies inward.*lateral and medial")
    flipped = [n.translate(str.maketrans("RL", "LR")) if "Knee" in n else n for n in names]
    write_trc(path, flipped, 1000 * tracks)
    refused("pelvis and legs disagree about right and left")
    lying = 1000 * tracks[..., [2, 1, 0]]
    write_trc(path, names, lying)
    refused("x points up")
    slanted = 1000 * np.stack(
        [tracks[..., 0], tracks[..., 1] - tracks[..., 2], tracks[..., 1] + tracks[..., 2]], axis=-1
    )
    write_trc(path, names, slanted)
    refused("vertical is not clear.*up='y'")


def test_a_marker_on_the_axis_is_refused(tmp_path):
    """M 5 mm off J1-J2 does not tell how the segment turns."""
    t = np.arange(30) / 100
    line = np.stack([t, 0 * t, 0 * t], axis=1)
    tracks = np.stack([line, line + [0, 0, 0.9], line + [0, 0.005, 0.4]], axis=1)
    (tmp_path / "map.toml").write_text(DIRECT)
    path = write_csv(tmp_path / "a.csv", ["R.Heel", "R.ASIS", "side"], tracks)
    with pytest.raises(ValueError, match=r"a\.csv: M of 'limb' is 5\.0 mm off"):
        read_motion(path, map=tmp_path / "map.toml", up="z")


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ("[segments]", "[segment]", "unknown key 'segment'"),
        ('J2 = "b"', 'J2 = "bb"', "J2 of segment 'limb' is 'bb'.*closest point: 'b'"),
        ('M = "c"', 'N = "c"', "unknown key 'N'"),
        (', M = "c"', "", "M of segment 'limb' is missing"),
        ("[segments]", '[points]\nd = { midpoint = ["a", "q"] }\n[segments]', "uses 'q'"),
        ("[segments]", '[points]\nd = { middle = ["a", "b"] }\n[segments]', "no known rule"),
        ("[segments]", '[points]\nd = { offset = "a", by = 1 }\n[segments]', "lacks 'along'"),
        ("[segments]", '[points]\nd = { same = "d" }\n[segments]', "made of itself"),
        ("a = [", "a = 3 #", "list of labels"),
        ("a = [", "a = [[", "no TOML|list of labels"),
    ],
)
def test_maps_are_checked(tmp_path, old, new, match):
    path = tmp_path / "map.toml"
    path.write_text(DIRECT.replace(old, new))
    with pytest.raises(ValueError, match=match) as error:
        segment_map(path)
    assert str(path) in str(error.value)
    with pytest.raises(ValueError, match=r"no map 'media'; there are .*medial"):
        segment_map("media")


def test_feet_that_cross_on_a_line_are_no_swapped_labels(tmp_path):
    """Ankles 20 mm past each other, as on a beam: read. As far as swapped ones are: refused."""
    names, tracks, truth = walker(BMC)
    lower = [n.split(".")[1] in ("Ankle", "Heel", "MT2", "MT5") for n in names]
    apart = (truth["right"]["ankle"] - truth["left"]["ankle"])[0, 1]
    for cross, fits in ((0.02, True), (0.08, False)):
        shifted = tracks.copy()
        for k, name in enumerate(names):
            if lower[k]:
                shifted[:, k, 1] -= 0.5 * (apart - cross) * (1 if name[0] == "R" else -1)
        path = write_trc(tmp_path / "walk.trc", names, 1000 * shifted)
        if fits:
            assert len(read_motion(path).times) == len(tracks)
        else:
            with pytest.raises(ValueError, match="disagree about right and left"):
                read_motion(path)
