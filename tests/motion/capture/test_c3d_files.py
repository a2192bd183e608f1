# SPDX-License-Identifier: LGPL-3.0-or-later
"""C3D files as processors and programs write them, made byte by byte."""

import numpy as np
import pytest

from shellform.motion.capture.c3d_header import header_of
from shellform.motion.capture.formats import read_table
from shellform.motion.capture.read_motion import read_motion
from tests.motion.capture.c3d_bytes import write_c3d_bytes
from tests.motion.capture.made_up import BMC, walker


@pytest.fixture
def marked():
    pytest.importorskip("ezc3d", reason="C3D files are read by ezc3d, not installed here")
    names, tracks, _ = walker(BMC, seconds=1.0)
    return names, 1000 * tracks


@pytest.mark.parametrize("order", ["intel", "dec", "mips"])
@pytest.mark.parametrize("whole", [False, True])
def test_three_byte_orders(tmp_path, marked, order, whole):
    """Places to 4-byte numbers or half a step, gaps, rate, unit, vertical: the same in all."""
    if order == "mips":
        pytest.importorskip("c3d", reason="C3D files of MIPS are read by c3d, not installed here")
    names, tracks = marked
    tracks[3:5, 2] = np.nan
    path = write_c3d_bytes(tmp_path / "a.c3d", names, tracks, 120.0, order, whole)
    header = header_of(path)
    assert (header.points, header.first, header.last) == (len(names), 1, len(tracks))
    assert header.rate == pytest.approx(120.0)
    raw = read_table(path)
    step = np.nanmax(np.abs(tracks)) / 32000 if whole else 2e-4
    assert raw.names == tuple(names) and raw.rate == 120.0
    assert (raw.unit, raw.up) == ("mm", "z")
    assert np.array_equal(np.isnan(raw.positions), np.isnan(tracks))
    assert np.nanmax(np.abs(raw.positions - tracks)) < 0.6 * step
    assert raw.times == pytest.approx(np.arange(len(tracks)) / 120.0)


@pytest.mark.parametrize("order", ["intel", "dec", "mips"])
@pytest.mark.parametrize("share", [0.2, 0.5, 0.9])
def test_cut_off_in_any_order(tmp_path, marked, order, share):
    path = write_c3d_bytes(tmp_path / "a.c3d", *marked, order=order)
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    with pytest.raises(ValueError, match=r"a\.c3d: cut off"):
        read_table(path)


def test_more_than_255_labels(tmp_path, marked):
    """LABELS2 goes on where LABELS ends."""
    names = [f"p{k}" for k in range(300)]
    tracks = np.random.default_rng(1).uniform(0, 1500, (4, 300, 3))
    raw = read_table(write_c3d_bytes(tmp_path / "a.c3d", names, tracks))
    assert raw.names == tuple(names)


def test_points_without_label_are_told(tmp_path, marked):
    names, tracks = marked
    path = write_c3d_bytes(tmp_path / "a.c3d", names, tracks, labels=names[:-2])
    assert f"2 of {len(names)} points have no label (POINT:LABELS) and are left out" in (
        read_table(path).notes
    )


def test_two_rates_and_rounded_ones(tmp_path, marked):
    """Refused where they differ; 119.88 and 120 Hz are one rate."""
    path = write_c3d_bytes(tmp_path / "a.c3d", *marked, rate=100.0, header_rate=150.0)
    with pytest.raises(ValueError, match="POINT:RATE is 100 Hz and the header's rate is 150 Hz"):
        read_motion(path)
    path = write_c3d_bytes(tmp_path / "a.c3d", *marked, rate=120.0, header_rate=119.88)
    assert read_table(path).rate == 120.0


def test_every_residual_below_zero(tmp_path, marked):
    path = write_c3d_bytes(tmp_path / "a.c3d", *marked, residual=-1.0)
    with pytest.raises(ValueError, match="every residual is -1"):
        read_motion(path)


def test_rotations_cut_off(tmp_path, marked):
    pose = np.tile(np.eye(4), (40, 1, 1))
    poses = {f"{s}_{p}_4X4": pose for s in "rl" for p in ("thigh", "shank", "foot", "toes")}
    path = write_c3d_bytes(tmp_path / "a.c3d", [], np.zeros((40, 0, 3)), poses=poses)
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    with pytest.raises(ValueError, match=r"a\.c3d: .*(cut off|ezc3d)"):
        read_motion(path)
