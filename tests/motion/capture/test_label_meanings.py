# SPDX-License-Identifier: LGPL-3.0-or-later
"""Markers and joint centres in one file, where `Knee` means both: right or refused."""

import numpy as np
import pytest

from shellform.motion.capture.label_meanings import labels_in_use, other_meaning
from shellform.motion.capture.read_motion import read_motion
from shellform.motion.capture.segment_map import segment_map
from tests.motion.capture.made_up import (
    BMC,
    HELEN_HAYES,
    KINECT,
    LATERAL,
    PLUG_IN_MARKERS,
    POSE2SIM,
    RAJAGOPAL,
    walker,
    write_csv,
)
from tests.motion.capture.test_label_families import FAMILIES

PLAIN = {"bmc": BMC, "lateral": LATERAL, "rajagopal": RAJAGOPAL, "helen-hayes": HELEN_HAYES}
OWN = {"plug-in": PLUG_IN_MARKERS} | {
    key: FAMILIES[key][1]
    for key in ("Human Body Model", "Human Body Model, medial", "IOR without medial", "Visual3D",
                "words with blanks", "Qualisys CAST")
}  # fmt: skip
CENTRES = {"pose2sim": POSE2SIM, "kinect": KINECT} | {
    key: FAMILIES[key][1] for key in ("MediaPipe", "SMPL", "Xsens", "Unreal")
}


@pytest.mark.parametrize("centres", CENTRES)
@pytest.mark.parametrize("markers", [*PLAIN, *OWN])
def test_a_file_of_markers_and_centres(tmp_path, markers, centres):
    """Both whole, at the places of one walker. Refused only where a marker is called Knee too."""
    names, tracks, truth = walker((PLAIN | OWN)[markers], seconds=0.3)
    more, joints, _ = walker(CENTRES[centres], seconds=0.3)
    add = [k for k, name in enumerate(more) if name not in names]
    both = np.concatenate([tracks, joints[:, add]], axis=1)
    path = write_csv(tmp_path / "walk.csv", names + [more[k] for k in add], both, unit="m")
    try:
        rec = read_motion(path, cutoff=None, rigid=False)
    except ValueError as error:
        assert markers in PLAIN and "each may be the" in str(error)
        return
    for side in ("right", "left"):
        for joint in ("hip", "knee", "ankle"):
            off = rec.joint_centre(f"{side}_{joint}") - truth[side][joint]
            assert np.abs(off).max() < 1e-6, (side, joint, rec.notes)


def test_the_label_with_one_meaning_counts():
    """`RKNE` is a marker everywhere, `RKnee` a centre too; `R.Knee` is spelled as in the map."""
    assert other_meaning("RKnee", "right_knee_lateral") == "joint centres"
    assert other_meaning("RKnee", "right_knee") == "markers"
    assert other_meaning("RKNE", "right_knee_lateral") == ""
    lateral = segment_map("lateral")
    assert labels_in_use(lateral, ["RKnee", "RKNE"])["right_knee_lateral"] == "RKNE"
    assert labels_in_use(lateral, ["RKnee", "R.Knee"])["right_knee_lateral"] == "R.Knee"
    centres = segment_map("joint-centres")
    assert labels_in_use(centres, ["R.Knee", "rknee"])["right_knee"] == "rknee"


def test_what_nothing_tells_apart_is_refused(tmp_path):
    """`R.Knee` on the skin and `RightKnee` at the centre, beside hips: which, and how far apart."""
    names, tracks, _ = walker(BMC, seconds=0.5)
    more, joints, _ = walker(FAMILIES["Xsens"][1], seconds=0.5)
    both = np.concatenate([tracks, joints], axis=1)
    path = write_csv(tmp_path / "walk.csv", names + more, both, unit="m")
    with pytest.raises(ValueError, match=r"walk\.csv: '.*Knee' and '.*Knee' are 55 mm apart"):
        read_motion(path)
