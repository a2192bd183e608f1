# SPDX-License-Identifier: LGPL-3.0-or-later
"""A report of one or more runs: one HTML file that needs no network.

    write_report(["out/stiff", "out/compliant"], "report.html")

Text and tables are HTML, pictures for paper PNG, curves and the walk arrays in JSON, drawn by
report.js with plotly.js; all of it stands inside the file. A policy in its head forbids the browser
to load anything from anywhere.
"""

import base64
from collections.abc import Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

from shellform.results.files import write_atomically

from . import plotly_library, trust
from .curves import torque_curves
from .finished_run import FinishedRun, finished_runs
from .joint_tables import comparison_sections, joint_table, joint_words
from .markup import Markup, bullets, number, paragraph, safe, table, with_error
from .packed import as_json
from .skin import read_skin, skin_data, skin_scale
from .still_pictures import skin_picture, torque_picture, walk_picture
from .subject import subject_table
from .walk_frames import MOST, read_walk, scales, walk_data


def write_report(folders: Sequence[str | Path], path: str | Path | None = None) -> Path:
    """Write a report of runs; returns its path.

    Parameters
    ----------
    folders : of runs, or of demos/walk.py, which holds several; the first is what others are
        compared with
    path : HTML file; None: report.html in the first folder

    Raises
    ------
    ValueError for folders without a finished run, or where there is no folder for the file
    ImportError without plotly

    Examples
    --------
    >>> write_report(["out/nothing"])
    Traceback (most recent call last):
    ValueError: there is no folder out/nothing: name the folder that a run has written
    """
    runs = finished_runs(folders)
    path = Path(folders[0]) / "report.html" if path is None else Path(path)
    if path.is_dir():
        raise ValueError(f"{path} is a folder: give the name of a file in it")
    if not path.parent.is_dir():
        raise ValueError(f"{path}: there is no folder {path.parent}, make it first")
    write_atomically(path, page(runs))
    return path


def page(runs: list[FinishedRun]) -> str:
    """The HTML text of a report."""
    library = plotly_library.script()
    curves = [torque_curves(run) for run in runs]
    data, pictures = _data_and_pictures(runs, curves)
    title = runs[0].scene.title
    if len(runs) > 1:
        title = f"{', '.join(run.label for run in runs[:-1])} and {runs[-1].label}, side by side"
    sentences, comparison = comparison_sections(runs)
    has_walk, has_skin = (any(run[name] for run in data["runs"]) for name in ("walk", "skin"))
    room = files(__package__)
    parts = {
        "title": escape(title),
        "lead": _lead(runs) + "".join(paragraph(text, "verdict") for text in sentences),
        "subject": subject_table(runs),
        "joints": joint_table(runs),
        "comparison": comparison
        or paragraph("One run: name two or more folders to see whether they differ."),
        "torque_pictures": pictures["torque"],
        "walk_pictures": pictures["walk"],
        "skin_pictures": pictures["skin"],
        "walk_state": "" if has_walk else "absent",
        "skin_state": "" if has_skin else "absent",
        "skin_table": _skin_table(runs),
        "errors": trust.error_table(runs),
        "warnings": trust.by_run(runs, {r.label: trust.warnings_of(r) for r in runs}, "None."),
        "notes": trust.by_run(
            runs, {r.label: trust.notes_of(r) for r in runs}, "Nothing had to be chosen or mended."
        ),
        "caveats": trust.caveats(runs),
        "versions": trust.cost_table(runs),
        "style": (room / "report.css").read_text(encoding="utf-8"),
        "script": (room / "report.js").read_text(encoding="utf-8"),
        "library": library,
        "data": as_json(data),
    }
    return Template((room / "report.html").read_text(encoding="utf-8")).substitute(parts)


def _data_and_pictures(
    runs: list[FinishedRun], curves: list[dict[str, dict[str, Any]]]
) -> tuple[dict[str, Any], dict[str, str]]:
    """What report.js draws, and the pictures that stand still, as HTML."""
    walks = [read_walk(run, MOST / len(runs)) for run in runs]
    maps = [read_skin(run) for run in runs]
    ends = scales([walk for walk in walks if walk is not None] or [])
    skin_ends = skin_scale([map for map in maps if map is not None] or [])
    entries: list[dict[str, Any]] = []
    walk_pictures, skin_pictures = "", ""
    for run, own, walk, map in zip(runs, curves, walks, maps, strict=True):
        entry: dict[str, Any] = {"label": run.label, "joints": own, "walk": None, "skin": None}
        if walk is not None:
            entry["walk"] = walk_data(run, walk, ends)
            walk_pictures += _image(walk_picture(run), f"{run.label}: key frames of the walk")
        if map is not None:
            entry["skin"] = skin_data(run, map, skin_ends)
            words = f"{run.label}: mean pressure on the skin from the front, left, back and right"
            skin_pictures += _image(skin_picture(run, map, 10.0 ** skin_ends[1]), words)
        entries.append(entry)
    torque = _image(torque_picture(runs, curves, False), "Torque about the joints against time")
    if any(len(entry["strides"]) for own in curves for entry in own.values()):
        words = (
            "Torque against the phase of gait: the mean stride, single ones where none are alike"
        )
        torque += _image(torque_picture(runs, curves, True), words)
    joints = list(dict.fromkeys(joint for own in curves for joint in own))
    data = {
        "runs": entries,
        "joints": [[joint, joint_words(joint)] for joint in joints],
        "counted": [run.results["counted_s"] for run in runs],
        "scales": ends,
        "skin_scale": skin_ends,
    }
    return data, {"torque": torque, "walk": walk_pictures, "skin": skin_pictures}


def _image(png: bytes, words: str) -> str:
    """A picture inside the page, with its caption."""
    text = base64.b64encode(png).decode("ascii")
    return (
        f'<figure class="still"><img alt="{escape(words)}" src="data:image/png;base64,{text}">'
        f"<figcaption>{escape(words)}</figcaption></figure>"
    )


def _lead(runs: list[FinishedRun]) -> Markup:
    """What was worn and the largest torque, a sentence a run."""
    lines = []
    for run in runs:
        joints = run.results["joints"]
        joint = max(joints, key=lambda name: abs(joints[name]["peak_torque"]))
        entry = joints[joint]
        peak = with_error(entry["peak_torque"], entry.get("peak_torque_error"))
        lines.append(
            safe(f"{run.label}: {run.scene.title}; {number(run.results['weight'])} N of clothing. ")
            + safe(f"Its largest torque is about the {joint_words(joint)}: ")
            + Markup(f"{peak} N m.")
        )
    return bullets([Markup(line) for line in lines])


def _skin_table(runs: list[FinishedRun]) -> Markup:
    """Force, peak pressure and area by part of the body."""
    rows = []
    names = list(dict.fromkeys(n for run in runs for n in run.results.get("pressure") or {}))
    for name in names:
        own = [run for run in runs if name in (run.results.get("pressure") or {})]
        for k, run in enumerate(own):
            entry = run.results["pressure"][name]
            cells = (
                number(entry["normal_force"]),
                number(entry["peak_pressure"]),
                number(entry["peak_time"]),
                number(1e4 * entry["contact_area"]),
            )
            rows.append([joint_words(name) if k == 0 else "", run.label, *cells])
    if not rows:
        return paragraph("No map of pressure was asked for: pressure_m under [output] is 0.")
    head = ("part of the body", "run", "mean force [N]", "peak pressure [Pa]", "at [s]",
            "mean area touched [cm\N{SUPERSCRIPT TWO}]")  # fmt: skip
    return table(head, rows, "Pressure on the skin, of the first start", "skin")
