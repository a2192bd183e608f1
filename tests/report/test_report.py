# SPDX-License-Identifier: LGPL-3.0-or-later
"""A report holds what the files of its runs say, and nothing that asks for a network."""

import csv
import json
import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from shellform.__main__ import main
from shellform.report import plotly_library
from shellform.report.finished_run import finished_runs, labels
from shellform.report.joint_tables import comparison_sections
from shellform.report.packed import unpacked
from shellform.report.page import write_report
from tests.ranks import ROOT

pytestmark = pytest.mark.serial
needs_plotly = pytest.mark.skipif(
    not plotly_library.is_there(), reason="plotly, an option, is not installed"
)
PANELS = ["subject", "joints", "comparison", "torque", "walk", "skin", "trust"]
LOADING = {"src", "href", "action", "data", "poster", "srcset"}


class Page(HTMLParser):
    """What a test looks at: sections, addresses, tables by class, the data, other text."""

    def __init__(self, text):
        super().__init__()
        self.sections, self.addresses, self.values = [], [], {}
        self.data, self.words, self.styles = None, [], []
        self._within, self._caption = [], None
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        self._within.append((tag, given))
        if tag == "section":
            self.sections.append(given["id"])
        self.addresses += [value for name, value in given.items() if name in LOADING]
        if tag == "table":
            self._caption = given["class"]
        if "data-value" in given:
            self.values.setdefault(self._caption, []).append(float(given["data-value"]))

    def handle_endtag(self, tag):
        while self._within and self._within.pop()[0] != tag:
            pass

    def handle_data(self, text):
        tag, given = self._within[-1] if self._within else ("", {})
        if tag == "script":
            if given.get("id") == "data":
                self.data = json.loads(text)
        elif tag == "style":
            self.styles.append(text)
        else:
            self.words.append(text)

    @property
    def text(self):
        return re.sub(r"\s+", " ", " ".join(self.words))


def summary_of(out):
    return json.loads((out / "summary.json").read_text())


@pytest.fixture(scope="module")
def page(written):
    return Page(written.read_text(encoding="utf-8"))


def test_every_panel_is_there(page):
    assert page.sections == PANELS
    said = page.text
    for words in (
        "Garment, wearer and motion", "synthetic walk", "Errors, predicted and reached", "Warnings",
        "Notes on the capture and the garment", "What would make these figures wrong", "dolfinx",
        "estimated: the shipped card 'compliant'", "Pressure on the skin",
    ):  # fmt: skip
        assert words in said, words


def test_nothing_asks_for_a_network(page, written):
    """All addresses stand in the page; so do its style and script; the browser is told so."""
    inner = [a for a in page.addresses if not a.startswith(("#", "data:"))]
    assert inner == [] and len(page.addresses) > 6
    assert not any(re.search(r"url\(|@import", style) for style in page.styles)
    text = written.read_text(encoding="utf-8")
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', text).group(1)
    assert "default-src 'none'" in policy and "http" not in policy
    assert written.stat().st_size < 15e6


def test_a_sentence_says_whether_runs_differ(page, ensembles, two_runs):
    """Half more torque differs; the same scene from other starts does not."""
    assert "heavy and light differ, in " in page.text and "95 % interval" in page.text
    runs = finished_runs([two_runs[0], ensembles("again", 1.0, 0.02, 3)])
    sentences, tables = comparison_sections(runs)
    assert [s.startswith("again and light do not differ: ") for s in sentences] == [True]
    assert "\N{BLACK DIAMOND}" not in tables and "3 pairs of runs, 95 % interval" in tables


def test_numbers_are_those_of_the_summary(page, two_runs):
    """Peak, rms, work, resistance of every joint; mean over time from torque.csv."""
    summaries = [summary_of(out)["results"] for out in two_runs]
    expected = []
    for joint in summaries[0]["joints"]:
        for out, results in zip(two_runs, summaries, strict=True):
            files = [out / "torque.csv", *sorted(out.glob("run_*/torque.csv"))]
            means = [mean_torque(path, joint, results["counted_s"]) for path in files]
            entry = results["joints"][joint]
            names = ("peak_torque", "rms_torque", "work", "resistance")
            expected += [np.mean(means), *(entry[name] for name in names)]
    assert page.values["joints"] == pytest.approx(expected, rel=1e-9, abs=1e-15)


def mean_torque(path, joint, counted):
    with open(path) as file:
        rows = [row for row in csv.DictReader(file) if row["joint"] == joint]
    times = np.array([float(row["time"]) for row in rows])
    torque = np.array([float(row["torque_flexion"]) for row in rows])
    within = (times > counted[0] + 1e-6) & (times <= counted[1] + 1e-6)
    widths = np.diff(times, prepend=2 * times[0] - times[1])[within]
    return torque[within] @ widths / widths.sum()


def test_curves_are_the_mean_of_torque_csv(page, two_runs):
    for out, run in zip(two_runs, page.data["runs"], strict=True):
        files = [out / "torque.csv", *sorted(out.glob("run_*/torque.csv"))]
        for joint, own in run["joints"].items():
            curves = []
            for path in files:
                with open(path) as file:
                    rows = [row for row in csv.DictReader(file) if row["joint"] == joint]
                curves.append([float(row["torque_flexion"]) for row in rows])
            assert own["time"] == [float(row["time"]) for row in rows]
            assert own["torque"] == pytest.approx(np.mean(curves, axis=0), rel=1e-9, abs=1e-15)
            error = np.std(curves, axis=0, ddof=1) / np.sqrt(len(files))
            assert own["error"] == pytest.approx(error, rel=1e-9, abs=1e-12)


def test_frames_are_those_of_the_series(page, two_runs):
    """Places to a tenth of a millimetre, pressure by its colour."""
    meshio = pytest.importorskip("meshio")
    walk = page.data["runs"][0]["walk"]
    places, origins = (unpacked(walk[name]) for name in ("places", "origins"))
    files = sorted((two_runs[0] / "series").glob("*.vtu"))
    assert len(places) == len(walk["times"]) <= walk["frames_of_series"] <= len(files)
    mesh = meshio.read(files[-1])
    found = places[-1] * walk["step"] + origins[-1]
    assert np.abs(found - mesh.points).max() < 0.51 * walk["step"] + 1e-6
    steps = unpacked(walk["colours"]["pressure"])[-1]
    pressure = mesh.point_data["contact_pressure"].ravel()
    assert ((steps == 255) == (pressure == 0)).all()
    low, high = page.data["scales"]["pressure"]
    shown = low + (high - low) * steps[pressure > 0] / 254
    wanted = np.clip(np.log10(pressure[pressure > 0]), low, high)
    assert shown == pytest.approx(wanted, abs=0.51 * (high - low) / 254)
    cells = unpacked(walk["triangles"]).reshape(-1, 2, 3)
    assert cells[:, 0].tolist() == mesh.cells[0].data[:, :3].tolist()


def test_names_of_files_are_text(two_runs, tmp_path):
    """Titles and notes come from files of others: no tag of theirs is a tag of the page."""
    out = tmp_path / "run"
    shutil.copytree(two_runs[0], out)
    summary = summary_of(out)
    summary["results"]["notes"] = ["</script><script>alert(1)</script>", "a & b"]
    (out / "summary.json").write_text(json.dumps(summary))
    text = write_report([out]).read_text(encoding="utf-8")
    assert "<script>alert" not in text and "&lt;script&gt;alert" in text and "a &amp; b" in text
    assert Page(text).text.count("One run: name two or more folders") == 1


BAD = {
    "nothing": "there is no folder {out}: name the folder",
    "empty": "{out} holds no summary.json, it is no folder of a run: ",
    "begun": "{out} holds no summary.json, it is not finished: go on with `shellform resume {out}`",
    "other": "{out} is no run of a scene, of which there are joints to report: ",
    "damaged": "{out}/summary.json is damaged",
    "partial": "{out} is not finished, 2 of 3 runs are complete: go on with `shellform resume",
}


@pytest.mark.parametrize("kind", BAD)
def test_bad_folders_get_a_sentence(kind, two_runs, tmp_path):
    out = tmp_path / kind
    if kind == "partial":
        shutil.copytree(two_runs[0], out)
        (out / "run_2/summary.json").unlink()
    elif kind != "nothing":
        out.mkdir()
    if kind == "begun":
        shutil.copy(two_runs[0] / "scene.toml", out)
    if kind == "other":
        (out / "summary.json").write_text('{"results": {"height": 1.0}}')
    if kind == "damaged":
        shutil.copy(two_runs[0] / "scene.toml", out)
        (out / "summary.json").write_text('{"results": ')
    with pytest.raises(ValueError) as caught:
        finished_runs([out])
    said = str(caught.value)
    assert said.startswith(BAD[kind].format(out=out)) and "\n" not in said


def test_a_run_twice_and_no_place_for_the_file(two_runs, tmp_path):
    with pytest.raises(ValueError, match="is named twice"):
        finished_runs([two_runs[0], two_runs[0]])
    with pytest.raises(ValueError, match=r"there is no folder .*, make it first"):
        write_report(two_runs, tmp_path / "not" / "report.html")
    with pytest.raises(ValueError, match="is a folder: give the name of a file"):
        write_report(two_runs, tmp_path)


def test_labels_are_folders_or_paths():
    assert labels([Path("out/a"), Path("out/b")]) == ["a", "b"]
    assert labels([Path("one/a"), Path("two/a")]) == ["one/a", "two/a"]


@needs_plotly
def test_the_command_writes_it(two_runs, tmp_path, capsys):
    """Of the folder that compares fabrics, too: of those that it names."""
    home = tmp_path / "walk"
    home.mkdir()
    for out in two_runs:
        shutil.copytree(out, home / out.name)
    fabrics = {out.name: {} for out in two_runs}
    (home / "summary.json").write_text(json.dumps({"results": {"fabrics": fabrics}}))
    main(["report", str(home)])
    assert capsys.readouterr().out.splitlines() == [f"wrote {home}/report.html"]
    found = Page((home / "report.html").read_text(encoding="utf-8"))
    assert [run["label"] for run in found.data["runs"]] == list(fabrics)


def test_without_plotly_a_sentence_says_how_to_get_it(two_runs, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "plotly", None)
    monkeypatch.setitem(sys.modules, "plotly.offline", None)
    with pytest.raises(ImportError, match=r"^a report needs the package plotly: pip install"):
        write_report(two_runs, tmp_path / "report.html")
    assert not (tmp_path / "report.html").exists()


def test_the_command_line_loads_nothing_of_it():
    """Nor plotly: a run that does not ask for a report does not pay for one."""
    code = (
        "import sys; import shellform.__main__; import shellform.simulation.ensemble; "
        "print([m for m in sys.modules if m.startswith(('shellform.report', 'plotly'))])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"
