# SPDX-License-Identifier: LGPL-3.0-or-later
"""Labels as chance has them: some missing, prefixes, other cases, strays, a damaged static trial.

Whatever is read of a walker has his joint centres; what cannot be had is refused in one sentence.
Choices follow from the tests (derandomize); FUZZ_EXAMPLES asks for more of them.
"""

import os

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from shellform.motion.capture.read_motion import read_motion
from tests.motion.capture.made_up import (
    BMC,
    GAIT2392,
    HELEN_HAYES,
    IOR,
    OPENCAP,
    PLUG_IN,
    PLUG_IN_MARKERS,
    POSE2SIM,
    RAJAGOPAL,
    SKELETON,
    walker,
    write_csv,
)
from tests.motion.capture.test_fuzz_captures import DAMAGE, damaged
from tests.motion.capture.test_static_trial import trials

pytestmark = pytest.mark.serial  # labels are chosen the same way on every rank

EXAMPLES = int(os.environ.get("FUZZ_EXAMPLES", "60"))
SETS = (BMC, RAJAGOPAL, IOR, HELEN_HAYES, PLUG_IN, PLUG_IN_MARKERS, OPENCAP, POSE2SIM, SKELETON)
FORMS = ("{}", "Ann:{}", "Skeleton_{}", "{}_m", "{} ")
CASES = (str, str.lower, str.upper)
SETTINGS = {
    "derandomize": True,
    "database": None,
    "deadline": None,
    "suppress_health_check": [HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
}


def sentence(error, path):
    said = str(error)
    assert said.startswith(f"{path}: ") and "\n" not in said and len(said) < 4000, said


@settings(max_examples=EXAMPLES, **SETTINGS)
@given(
    labels=st.sampled_from(SETS),
    form=st.sampled_from(FORMS),
    case=st.sampled_from(CASES),
    gone=st.sets(st.integers(0, 40), max_size=4),
    stray=st.lists(st.text("RLkneA.:_ *1", min_size=1, max_size=8), max_size=3, unique=True),
)
def test_labels_by_chance(tmp_path, labels, form, case, gone, stray):
    names, tracks, truth = walker(labels, seconds=0.3)
    keep = [k for k in range(len(names)) if k not in gone]
    found = [case(form.format(names[k])) for k in keep]
    stray = [n for n in stray if n.strip() and n.strip() not in found]
    far = np.tile(tracks[:, :1] + [0.1, 0.2, 0.3], (1, len(stray), 1))
    path = write_csv(
        tmp_path / "walk.csv", found + stray, np.concatenate([tracks[:, keep], far], 1), unit="m"
    )
    try:
        rec = read_motion(path, cutoff=None, rigid=False)
    except ValueError as error:
        sentence(error, path)
        assert gone & set(range(len(names))) or stray, error
        return
    for side in ("right", "left"):
        for joint in ("hip", "knee", "ankle"):
            off = rec.joint_centre(f"{side}_{joint}") - truth[side][joint]
            assert np.abs(off).max() < 1e-6, (side, joint, found, stray, rec.notes)


@settings(max_examples=max(EXAMPLES // 3, 1), **SETTINGS)
@given(harm=st.lists(DAMAGE, min_size=1, max_size=2))
def test_damaged_static_trials(tmp_path, harm):
    """A recording or one sentence, which begins with the file that is wrong."""
    walk, static, _ = trials(tmp_path, GAIT2392, seconds=0.5)
    data = static.read_bytes()
    for damage in harm:
        data = damaged(data, damage)
    static.write_bytes(data)
    try:
        rec = read_motion(walk, static)
    except ValueError as error:
        sentence(error, walk if str(error).startswith(str(walk)) else static)
    else:
        assert all(np.isfinite(track).all() for track in rec.points.values())
