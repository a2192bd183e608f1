# SPDX-License-Identifier: LGPL-3.0-or-later
"""A body of the user's own: read in any axes and unit; each fault gets a sentence."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import meshes
from shellform.motion.body_mesh.scan import scan, turns_around
from shellform.motion.body_mesh.surface import JOINTS

from .manikin import manikin

TURN = Rotation.from_rotvec([0.9, -0.4, 2.1])  # of the scanner's axes


def write(folder, ending="ply", unit="mm", scale=1000.0, triangles=None, joints=None, more=""):
    body = manikin()
    triangles = body.triangles if triangles is None else triangles
    points = scale * TURN.apply(body.points)
    directors = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    surface = meshes.Surface(points, triangles, {}, directors, source="scan", verify=False)
    meshes.save(surface, folder / f"scan.{ending}")
    rows = {name: (scale * TURN.apply(at)).tolist() for name, at in body.landmarks.items()}
    rows |= joints or {}
    lines = [f'file = "scan.{ending}"', f'unit = "{unit}"', more, "[joints]"]
    lines += [f"{name} = {at}" for name, at in rows.items()]
    path = folder / "scan.toml"
    path.write_text("\n".join(lines))
    return path


@pytest.mark.parametrize("ending", ["ply", "stl", "obj"])
def test_any_axes_unit_and_format(tmp_path, ending):
    body, wanted = scan(write(tmp_path, ending)), manikin()
    assert len(body.points) == len(wanted.points)
    assert len(body.triangles) == len(wanted.triangles)
    low = wanted.landmarks["right_ankle"] - body.landmarks["right_ankle"]
    for name in JOINTS:
        assert np.abs(body.landmarks[name] + low - wanted.landmarks[name]).max() < 1e-6
    assert body.points[:, 2].max() + low[2] == pytest.approx(wanted.points[:, 2].max(), abs=1e-5)
    assert body.stature == pytest.approx(wanted.stature - 0.1, rel=0.05)


def test_given_stature(tmp_path):
    assert scan(write(tmp_path, more="stature_m = 1.9")).stature == 1.9


def refused(path, words):
    with pytest.raises(ValueError, match=words) as caught:
        scan(path)
    assert "\n" not in str(caught.value)


def test_faults(tmp_path):
    body = manikin()
    refused(write(tmp_path, unit="m"), "which no leg is: set unit")
    refused(write(tmp_path, unit="ell"), "unit is one of m, cm, mm, in, not 'ell'")
    refused(write(tmp_path, triangles=body.triangles[5:]), "the surface is open; close its holes")
    far = {"left_knee": [0.0, 5000.0, 0.0]}
    refused(write(tmp_path, joints=far), "left_knee at .* mm is outside of scan.ply")
    refused(write(tmp_path, joints={"left_hip": [1.0, 2.0]}), r"\[joints\] left_hip is a point")
    refused(write(tmp_path, more="sise = 3"), "unknown key 'sise'; there are file, unit")
    (tmp_path / "x.toml").write_text("solid scan")
    refused(tmp_path / "x.toml", "not a TOML file")
    with pytest.raises(FileNotFoundError, match="no such file, which would describe a body"):
        scan(tmp_path / "none.toml")


def test_inside_out_is_turned_and_told(tmp_path):
    with pytest.warns(UserWarning, match="was inside-out: all its triangles are turned"):
        body = scan(write(tmp_path, triangles=manikin().triangles[:, ::-1]))
    assert turns_around(body.points, body.triangles, body.middle) == pytest.approx(1.0, abs=1e-9)


def test_winding_number_of_a_tetrahedron():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    triangles = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    assert turns_around(points, triangles, np.full(3, 0.2)) == pytest.approx(1.0, abs=1e-12)
    assert turns_around(points, triangles, np.full(3, 0.4)) == pytest.approx(0.0, abs=1e-12)
