# SPDX-License-Identifier: LGPL-3.0-or-later
"""Labels as laboratories and programs spell them: the set, and joint centres of a known walker.

Each row is a way of naming that public captures or manuals of programs have. All joint centres are
those of the walker to 1e-9 m, whichever set it is taken for: nothing is taken for something else.
"""

import numpy as np
import pytest

from shellform.motion.capture.read_motion import read_motion
from tests.motion.capture.made_up import (
    BMC,
    GAIT2392,
    LATERAL,
    OPENCAP,
    PLUG_IN,
    PLUG_IN_MARKERS,
    walker,
    write_trc,
    y_up,
)

EXACT = 1e-9
THIGH = {"t1": "{S}TH1", "t2": "{S}TH2", "t3": "{S}TH3"}
CENTRES = {"hip_c": "{S}Hip", "knee_c": "{S}Knee", "ankle_c": "{S}Ankle"}

# place on the walker -> label, and the set that is right
FAMILIES = {
    "Qualisys CAST": ("medial", THIGH | {
        "asis": "{S}_IAS", "psis": "{S}_IPS", "knee": "{S}_FLE", "knee_in": "{S}_FME",
        "s1": "{S}_SK1", "s2": "{S}_SK2", "s3": "{S}_SK3", "ankle": "{S}_FAL",
        "ankle_in": "{S}_TAM", "heel": "{S}_FCC", "toe": "{S}_FM2", "toe_in": "{S}_FM1",
        "toe_out": "{S}_FM5",
    }),
    "Qualisys, in words": ("medial", {
        "asis": "{S}_ASIS", "psis": "{S}_PSIS", "t1": "{s}_thigh_1", "knee": "{s}_knee_lat",
        "knee_in": "{s}_knee_med", "s1": "{s}_shank_1", "ankle": "{s}_ankle_lat",
        "ankle_in": "{s}_ankle_med", "heel": "{s}_heel", "toe": "{s}_toe2", "toe_out": "{s}_toe5",
    }),
    "QTM sports": ("lateral", {
        "asis": "Waist{S}Front", "sacrum": "WaistBack", "t1": "{S}ThighFrontLow",
        "knee": "{S}KneeOut", "knee_in": "{S}KneeIn", "s1": "{S}ShinFrontHigh",
        "ankle": "{S}AnkleOut", "heel": "{S}HeelBack", "toe": "{S}Forefoot2",
        "toe_out": "{S}Forefoot5",
    }),
    "Visual3D": ("medial", THIGH | {
        "asis": "{S}ASIS", "psis": "{S}PSIS", "knee": "{S}LK", "knee_in": "{S}MK",
        "ankle": "{S}LA", "ankle_in": "{S}MA", "heel": "{S}HEEL", "toe": "{S}MT2",
    }),
    "Human Body Model": ("lateral", {
        "asis": "{S}ASIS", "psis": "{S}PSIS", "knee": "{S}LEK", "ankle": "{S}LM", "t1": "{S}GTRO",
        "s1": "{S}ATI", "heel": "{S}HEE", "toe": "{S}TOE", "toe_out": "{S}MT5",
    }),
    "Human Body Model, medial": ("medial", {
        "asis": "{S}ASIS", "psis": "{S}PSIS", "knee": "{S}LEK", "knee_in": "{S}MEK",
        "ankle": "{S}LM", "ankle_in": "{S}MM", "heel": "{S}HEE", "toe": "{S}TOE",
    }),
    "Rajagopal 2016": ("medial", THIGH | {
        "asis": "{S}ASI", "psis": "{S}PSI", "knee": "{S}LFC", "knee_in": "{S}MFC",
        "ankle": "{S}LMAL", "ankle_in": "{S}MMAL", "s1": "{S}TB1", "heel": "{S}CAL",
        "toe": "{S}TOE", "toe_out": "{S}MT5", "hip_c": "{S}HJC",
    }),
    "Rajagopal 2016 walking": ("lateral", THIGH | {
        "asis": "{S}ASI", "psis": "{S}PSI", "knee": "{S}LFC", "ankle": "{S}LMAL", "s1": "{S}TB1",
        "s2": "{S}TB2", "s3": "{S}TB3", "heel": "{S}CAL", "toe": "{S}TOE", "toe_out": "{S}MT5",
    }),
    "gait2392 standing": ("medial", GAIT2392),
    "L and M behind": ("medial", {
        "asis": "{S}.ASIS", "psis": "{S}.PSIS", "knee": "{S}.Knee.L", "knee_in": "{S}.Knee.M",
        "ankle": "{S}.Ankle.L", "ankle_in": "{S}.Ankle.M", "heel": "{S}.Heel", "toe": "{S}.Toe",
    }),
    "words with blanks": ("medial", {
        "asis": "{side} ASIS", "psis": "{side} PSIS", "knee": "{side} Lateral Knee",
        "knee_in": "{side} Medial Knee", "ankle": "{side} Lateral Malleolus",
        "ankle_in": "{side} Medial Malleolus", "heel": "{side} Heel", "toe": "{side} Toe",
    }),
    "Plug-in Gait with medial knees": ("plug-in-gait-markers", PLUG_IN_MARKERS | {
        "knee_in": "{S}KNM",
    }),
    "Plug-in Gait, all medial": ("medial", PLUG_IN_MARKERS | {
        "knee_in": "{S}KNM", "ankle_in": "{S}MED",
    }),
    "Plug-in Gait and OpenPose": ("plug-in-gait-markers", PLUG_IN_MARKERS | CENTRES),
    "Plug-in Gait, centres of Nexus": ("plug-in-gait", PLUG_IN | {
        "hip_c": "{S}HJC", "knee_c": "{S}KJC", "ankle_c": "{S}AJC",
    }),
    "both sides and centres": ("medial", BMC | {
        "hip_c": "{S}HJC", "knee_c": "{S}KJC", "ankle_c": "{S}AJC",
    }),
    "lateral and centres by words": ("lateral", LATERAL | {
        "hip_c": "{S}Hip_centre", "knee_c": "{S}Knee_centre", "ankle_c": "{S}Ankle_centre",
    }),
    "Helen Hayes with bars": ("helen-hayes", {
        "asis": "{S}.ASIS", "sacrum": "Sacrum", "t1": "{S}.Thigh.Bar", "knee": "{S}.Knee",
        "s1": "{S}.Shank.Bar", "ankle": "{S}.Ankle", "heel": "{S}.Heel", "toe": "{S}.Toe",
    }),
    "Cleveland": ("medial", {
        "asis": "{S}ASI", "sacrum": "SACR", "knee": "{S}LKN", "knee_in": "{S}MKN",
        "ankle": "{S}LAN", "ankle_in": "{S}MAN", "heel": "{S}HEE", "toe": "{S}TOE",
    }),
    "IOR without medial": ("lateral", {
        "asis": "{S}ASIS", "psis": "{S}PSIS", "t1": "{S}GT", "knee": "{S}LE", "s1": "{S}HF",
        "ankle": "{S}LM", "heel": "{S}CA", "toe": "{S}SM", "toe_out": "{S}VM",
    }),
    "OpenCap with hip centres": ("opencap", OPENCAP | {"hip_c": "{S}HJC_study"}),
    "MediaPipe": ("joint-centres", {
        "hip_c": "{S}_HIP", "knee_c": "{S}_KNEE", "ankle_c": "{S}_ANKLE", "heel": "{S}_HEEL",
        "toe": "{S}_FOOT_INDEX", "shoulder": "{S}_SHOULDER",
    }),
    "SMPL": ("joint-centres", {
        "hip_c": "{S}_Hip", "knee_c": "{S}_Knee", "ankle_c": "{S}_Ankle", "toe": "{S}_Foot",
    }),
    "Unreal": ("skeleton", {
        "hip_c": "thigh_{s}", "knee_c": "calf_{s}", "ankle_c": "foot_{s}", "toe": "ball_{s}",
        "neck": "neck_01",
    }),
    "Blender": ("skeleton", {
        "hip_c": "thigh.{S}", "knee_c": "shin.{S}", "ankle_c": "foot.{S}", "toe": "toe.{S}",
    }),
    "Xsens": ("joint-centres", {
        "hip_c": "{side}Hip", "knee_c": "{side}Knee", "ankle_c": "{side}Ankle",
        "toe": "{side}Toe", "neck": "Neck",
    }),
}  # fmt: skip


@pytest.mark.parametrize("family", FAMILIES)
def test_joint_centres_of_a_family(tmp_path, family):
    name, labels = FAMILIES[family]
    names, tracks, truth = walker(labels, seconds=1.2)
    path = write_trc(tmp_path / "walk.trc", names, 1000 * y_up(tracks))
    rec = read_motion(path, cutoff=None, rigid=False)
    assert f"map '{name}'" in rec.notes, rec.notes
    for side in ("right", "left"):
        for joint in ("hip", "knee", "ankle"):
            off = rec.joint_centre(f"{side}_{joint}") - truth[side][joint]
            assert np.abs(off).max() < EXACT, (side, joint)
        assert f"{side}_foot" in rec.points


def test_a_knee_that_has_both_sides_needs_no_breadth(tmp_path):
    """Medial markers at the knees alone: their middle, though knees are 40 mm broader than adults'
    are, and ankles by the rule."""
    names, tracks, truth = walker(LATERAL | {"knee_in": "{S}.Knee.Medial"}, seconds=1.2)
    for side, sign in (("R", -1), ("L", 1)):
        for label, out in ((".Knee", 0.02), (".Knee.Medial", -0.02)):
            tracks[:, names.index(side + label), 1] += sign * out
    rec = read_motion(write_trc(tmp_path / "walk.trc", names, 1000 * y_up(tracks)), cutoff=None)
    assert "map 'lateral'" in rec.notes
    assert np.abs(rec.joint_centre("right_knee") - truth["right"]["knee"]).max() < EXACT


@pytest.mark.parametrize(("aside", "taken"), [(0.0, "by regression"), (0.04, "RHJC_study")])
def test_opencap_hips_by_regression_as_long_as_the_file_agrees(tmp_path, aside, taken):
    """ASIS and PSIS of a network may be no bones: the centres beside them then count, and which
    are taken is told."""
    names, tracks, truth = walker(OPENCAP | {"hip_c": "{S}HJC_study"}, seconds=1.2)
    tracks[:, [n.endswith(("ASIS_study", "PSIS_study")) for n in names], 2] += aside
    path = write_trc(tmp_path / "walk.trc", names, 1000 * y_up(tracks))
    rec = read_motion(path, cutoff=None, rigid=False)
    assert np.abs(rec.joint_centre("left_hip") - truth["left"]["hip"]).max() < EXACT
    assert any("RHJC_study" in n and n.endswith(f"{taken} taken") for n in rec.notes), rec.notes


def test_centres_of_the_file_are_told(tmp_path):
    """Plug-in Gait: model points are used, not the markers beside them."""
    names, tracks, _ = walker(PLUG_IN, seconds=1.2)
    notes = read_motion(write_trc(tmp_path / "walk.trc", names, 1000 * y_up(tracks))).notes
    said = next(n for n in notes if n.startswith("joint centres of the file"))
    assert set(said.split(": ")[1].split(", ")) == {
        f"{side}{point}" for side in "RL" for point in ("FEP", "FEO", "TIO")
    }
