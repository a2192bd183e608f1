# SPDX-License-Identifier: LGPL-3.0-or-later
"""Body from motion: labels, repairs and Eq. 17 against motions known beforehand."""

import numpy as np
import pytest

from contact.body.segment_frame import pose_from_markers
from shellform.motion.capture.gaps_and_spikes import low_pass
from shellform.motion.capture.joint_centres import fixed_in
from shellform.motion.capture.read_motion import (
    read_markers,
    read_motion,
    recording,
)
from tests.motion.capture.made_up import (
    BMC,
    CAMARGO,
    DIRECT,
    KNEE,
    LATERAL,
    OPENCAP,
    PLUG_IN,
    RAJAGOPAL,
    SCALE,
    SHANK,
    THIGH,
    WRITERS,
    walker,
    write_csv,
    write_trc,
    y_up,
)


@pytest.mark.parametrize("kind", ["trc", "csv", "c3d"])
@pytest.mark.parametrize("unit", ["mm", "m"])
@pytest.mark.parametrize("up", ["y", "z"])
def test_pose_of_a_known_rigid_motion(tmp_path, kind, unit, up):
    """Centre and axes of Eq. 17 to 1e-12 (C3D: to its 4-byte numbers), det +1, rate and times."""
    n, rate = 40, 150.0
    t = np.arange(n) / rate
    angle = 2.0 * t + 0.3 * np.sin(9 * t)
    tilt = np.radians(8.0)
    e1 = np.stack([np.sin(tilt) * np.cos(angle), np.sin(tilt) * np.sin(angle), 0 * t], axis=1)
    e1[:, 2] = np.cos(tilt)
    e2 = np.stack([-np.sin(angle), np.cos(angle), 0 * t], axis=1)
    centre = np.stack([1.3 * t, 0.2 * np.sin(5 * t), 0.8 + 0.05 * t], axis=1)
    tracks = np.stack(
        [centre - 0.45 * e1, centre + 0.45 * e1, centre + 0.1 * e1 + 0.07 * e2], axis=1
    )
    moved = (tracks if up == "z" else y_up(tracks)) * SCALE[unit]
    path = tmp_path / f"limb.{kind}"
    extra = {"up": "+" + up.upper()} if kind == "c3d" else {}
    WRITERS[kind](path, ["R.Heel", "R.ASIS", "side"], moved, rate=rate, unit=unit, **extra)
    (tmp_path / "direct.toml").write_text(DIRECT)
    rec = read_motion(path, map=tmp_path / "direct.toml", cutoff=None)
    found, axes = pose_from_markers(*np.moveaxis(rec.points["limb"], 1, 0))
    exact = np.stack([e1, e2, np.cross(e1, e2)], axis=1)
    close = 1e-12 if kind != "c3d" else 2e-6
    assert np.abs(found - centre).max() < close
    assert np.abs(axes - exact).max() < close * (1 if kind != "c3d" else 10)
    assert np.abs(np.linalg.det(axes) - 1).max() < 1e-12
    assert rec.rate == pytest.approx(rate, rel=1e-9)
    assert np.abs(rec.times - rec.times[0] - t).max() < 1e-9


SETS = {
    "medial": (BMC, "medial"),
    "opencap": (OPENCAP, "opencap"),
    "plug-in": (PLUG_IN, "plug-in-gait"),
    "lateral": (LATERAL, "lateral"),
    "rajagopal": (RAJAGOPAL, "lateral"),
    "camargo": (CAMARGO, "lateral"),
}


@pytest.mark.parametrize("key", SETS)
def test_label_sets_give_the_joint_centres(tmp_path, key):
    """Hip, knee and ankle of a walker with the published pelvis, to 1e-9 m, in every label set."""
    labels, name = SETS[key]
    names, tracks, truth = walker(labels)
    path = write_trc(tmp_path / "walk.trc", names, 1000 * y_up(tracks), doubled=True, said=28)
    rec = read_motion(path, cutoff=None)
    assert f"map '{name}'" in rec.notes
    for side in ("right", "left"):
        for joint, centre in truth[side].items():
            assert np.abs(rec.joint_centre(f"{side}_{joint}") - centre).max() < 1e-9, joint
        assert rec.points[f"{side}_foot"].shape == (350, 3, 3)
    for segment, (_, spread) in rec.lengths().items():
        assert spread < 1e-9, segment


def test_a_cluster_carries_the_axis(tmp_path):
    """Thighs that turn by 10 degrees about themselves: a cluster finds the knee, a pelvis not."""
    off = {}
    for key, labels in (("cluster", CAMARGO), ("none", LATERAL)):
        names, tracks, truth = walker(labels, twist=np.radians(10))
        path = write_trc(tmp_path / f"{key}.trc", names, y_up(tracks), unit="m")
        rec = read_motion(path, cutoff=None, rigid=False)
        off[key] = np.linalg.norm(rec.joint_centre("right_knee") - truth["right"]["knee"], axis=1)
    assert off["cluster"].max() < 5e-4
    assert off["none"].max() == pytest.approx(2 * KNEE * np.sin(np.radians(5)), rel=0.05)


def test_direction_fixed_in_a_turning_cluster():
    """The best rotation of a cluster is the one that turned it."""
    rng = np.random.default_rng(2)
    shape, axis = rng.normal(size=(4, 3)), np.array([0.6, 0.0, 0.8])
    angle = np.linspace(0, 2, 30)
    turn = np.zeros((30, 3, 3))
    turn[:, 2, 2] = 1
    turn[:, 0, 0] = turn[:, 1, 1] = np.cos(angle)
    turn[:, 1, 0], turn[:, 0, 1] = np.sin(angle), -np.sin(angle)
    cluster = np.einsum("nab,kb->nka", turn, shape) + rng.normal(size=(30, 1, 3))
    turned = turn @ axis
    assert np.abs(fixed_in(cluster, turned) - turned).max() < 1e-12


@pytest.mark.parametrize("bend", [0.0, 0.4, -0.4])
def test_stride_and_cadence_along_the_path(tmp_path, bend):
    """A stride of 1.2 m in 1 s, straight and on a circle of 3 m: both to 1 %; the turn to 3 %."""
    names, tracks, _ = walker(BMC, bend=bend, seconds=5.3)
    rec = read_motion(write_csv(tmp_path / "walk.csv", names, tracks))
    assert rec.facts["stride_length"] == pytest.approx(1.2, rel=0.01)
    assert rec.facts["cadence"] == pytest.approx(120.0, rel=0.01)
    assert rec.facts["turn"] == pytest.approx(bend * 4.3, rel=0.03, abs=0.01)
    legs = (THIGH + SHANK) / 0.4954  # thigh and shank over stature, de Leva 1996
    assert rec.facts["stature"] == pytest.approx(legs, rel=1e-3)


def test_a_short_walk_repeats(tmp_path):
    """Less than two strikes of one foot: the stride from the repetition of the posture."""
    names, tracks, _ = walker(BMC, seconds=1.4)
    rec = recording(read_markers(write_csv(tmp_path / "walk.csv", names, tracks[10:])))
    assert rec.facts["strides"] == 0
    assert rec.facts["stride_length"] == pytest.approx(1.2, rel=0.02)
    assert rec.facts["cadence"] == pytest.approx(120.0, rel=0.02)


def test_mirrored_labels_are_swapped(tmp_path):
    """Right and left exchanged in all labels: the same recording as without. A left-handed file:
    its mirror image."""
    names, tracks, truth = walker(BMC)
    other = [{"R": "L", "L": "R"}[n[0]] + n[1:] for n in names]
    right = read_motion(write_trc(tmp_path / "a.trc", names, 1000 * tracks), cutoff=None)
    wrong = read_motion(write_trc(tmp_path / "b.trc", other, 1000 * tracks), cutoff=None)
    assert any("mirrored" in note for note in wrong.notes)
    assert not any("mirrored" in note for note in right.notes)
    for segment, track in right.points.items():
        assert np.abs(track - wrong.points[segment]).max() < 1e-12, segment
    assert np.abs(wrong.joint_centre("left_knee") - truth["left"]["knee"]).max() < 1e-9
    mirror = np.array([1.0, -1.0, 1.0])
    image = read_motion(write_trc(tmp_path / "c.trc", names, 1000 * tracks * mirror), cutoff=None)
    assert any("mirrored" in note for note in image.notes)
    assert np.abs(image.joint_centre("left_knee") - mirror * truth["right"]["knee"]).max() < 1e-9


def test_gaps_and_spikes_are_mended_and_told(tmp_path):
    """Gaps of 80 ms come back to 1 mm; a spike of 60 mm goes; ends without a marker are cut."""
    names, tracks, truth = walker(BMC)
    marred = tracks.copy()
    knee, medial, toe = (names.index(n) for n in ("R.Knee", "R.Knee.Medial", "L.MT5"))
    marred[100:108, knee] = np.nan
    marred[200:203, toe] += [0.06, 0.0, 0.04]
    marred[:5, medial] = marred[-7:, medial] = np.nan
    path = write_trc(tmp_path / "walk.trc", names, 1000 * marred)
    rec = read_motion(path, cutoff=None)
    assert len(rec.times) == 350 - 12 and rec.times[0] == pytest.approx(0.05)
    assert np.abs(rec.joint_centre("right_knee") - truth["right"]["knee"][5:-7]).max() < 1e-3
    assert np.abs(rec.points["left_foot"][:, 2] - tracks[5:-7, toe]).max() < 1e-3
    said = "\n".join(rec.notes)
    assert "filled at t = 1.000 s for 80 ms: R.Knee" in said
    assert "'L.MT5' jumps at t = " in said and "R.Knee.Medial" in said
    assert sum("jumps" in note for note in rec.notes) == 1
    with pytest.raises(ValueError, match=r"walk\.trc.*'R\.Knee'.*t = 1\.000 s.*0\.080 s.*max_gap"):
        read_motion(path, max_gap=0.05)
    part = read_motion(path, max_gap=0.05, window=(1.2, 3.0))
    assert part.times[0] == pytest.approx(1.2)


def test_low_pass_halves_the_power_at_its_cutoff():
    """No shift, 1/sqrt(2) at 6 Hz, untouched at 0.5 Hz, gone at 40 Hz."""
    t = np.arange(2000) / 200.0
    for frequency, gain in ((0.5, 1.0), (6.0, np.sqrt(0.5)), (40.0, 0.0)):
        wave = np.sin(2 * np.pi * frequency * t)
        out = low_pass(wave[:, None], 200.0, 6.0)[400:-400, 0]
        assert np.abs(out - gain * wave[400:-400]).max() < 0.01, frequency
