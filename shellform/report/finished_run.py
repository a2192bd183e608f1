# SPDX-License-Identifier: LGPL-3.0-or-later
"""The runs that a report is made of: read from their folders, or refused in one sentence."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from shellform.errors import Mendable
from shellform.motion.wearer import Wearer
from shellform.results.mean_torque import Course, read_courses
from shellform.scene.scene import Scene
from shellform.scene.scene_file import read_scene
from shellform.scene.skin import skin_of_scene
from shellform.scene.wearer import wearer_of
from shellform.simulation.ensemble import complete_of

if TYPE_CHECKING:
    from contact.body.surface_motion import SurfaceMotion


class FinishedRun(NamedTuple):
    """A scene that was run, from one or more starts.

    label : name in the report; out : its folder; scene; fabric : as its file has it
    wearer : before ellipsoids are left out; skin : of a body of triangles, None for ellipsoids and
        where the files of that body are no longer there
    summary : contents of summary.json; courses : joint -> windows of all its runs
    """

    label: str
    out: Path
    scene: Scene
    fabric: Any
    wearer: Wearer
    skin: SurfaceMotion | None
    summary: dict[str, Any]
    courses: dict[str, Course]

    @property
    def results(self) -> dict[str, Any]:
        """Results of summary.json."""
        return self.summary["results"]


def finished_runs(folders: Sequence[str | Path]) -> list[FinishedRun]:
    """Runs in the given folders, and those that a folder of demos/walk.py holds.

    Raises
    ------
    ValueError in one sentence: no such folder, none of a run, a run that is not finished, a folder
    named twice
    """
    outs = [out for folder in folders for out in _expanded(Path(folder))]
    seen: set[Path] = set()
    for out in outs:
        if out.resolve() in seen:
            raise ValueError(f"{out} is named twice: give each run once")
        seen.add(out.resolve())
    return [_read(out, label) for out, label in zip(outs, labels(outs), strict=True)]


def labels(outs: Sequence[Path]) -> list[str]:
    """Names of the runs: of their folders; whole paths where two folders have one name."""
    names = [out.resolve().name for out in outs]
    return names if len(set(names)) == len(names) else [str(out) for out in outs]


def _expanded(folder):
    """The folder itself, or those of the fabrics that a walk compared."""
    if not folder.is_dir():
        raise ValueError(f"there is no folder {folder}: name the folder that a run has written")
    if (folder / "scene.toml").is_file():
        return [folder]
    summary = _summary_in(folder)
    fabrics = summary.get("results", {}).get("fabrics")
    if not isinstance(fabrics, dict) or not fabrics:
        raise ValueError(
            f"{folder} is no run of a scene, of which there are joints to report: name the --out "
            "of `shellform run` or of demos/walk.py"
        )
    return [folder / name for name in fabrics]


def _summary_in(folder):
    path = folder / "summary.json"
    if not path.is_file():
        begun = any((folder / name).is_file() for name in ("checkpoint.npz", "scene.toml"))
        what, mend = "is not finished", f"go on with `shellform resume {folder}`"
        if not begun:
            what, mend = "is no folder of a run", "name the --out of `shellform run`"
        raise ValueError(f"{folder} holds no summary.json, it {what}: {mend}")
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise ValueError(f"{path} is damaged ({error}): run the scene again") from error
    return found if isinstance(found, dict) else {}


def _read(out, label):
    if not out.is_dir():
        raise ValueError(f"there is no folder {out}: name the folder that a run has written")
    summary = _summary_in(out)
    if not summary.get("results", {}).get("joints"):
        raise ValueError(f"{out}/summary.json has no joints: there is no torque to report")
    scene = read_scene(out / "scene.toml")
    complete = complete_of(out)
    if len(complete) < scene.runs:
        raise ValueError(
            f"{out} is not finished, {len(complete)} of {scene.runs} runs are complete: go on with "
            f"`shellform resume {out}`"
        )
    wearer = wearer_of(scene)
    files = [member.out / "torque.csv" for member in complete]
    courses = read_courses(files, wearer.start)
    skin = _skin_in(scene, wearer)
    return FinishedRun(label, out, scene, _fabric_in(out), wearer, skin, summary, courses)


def _skin_in(scene, wearer):
    """Skin of the wearer; None where its files are gone: a report needs its numbers, not it."""
    try:
        return skin_of_scene(scene, wearer)
    except (ValueError, OSError, Mendable):
        return None


def _fabric_in(out):
    """What the scene's file says of the fabric: name, path or table; None if nothing."""
    # other values of the file may be names that are no UTF-8
    text = (out / "scene.toml").read_text(encoding="utf-8", errors="replace")
    return tomllib.loads(text).get("fabric")
