# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a command line shows: sentences, no paths of ours, nothing that other packages log."""

import logging
import subprocess
import sys
import warnings

from mpi4py import MPI

import pytest

from shellform import console
from shellform.errors import NotConverged, Stopped
from tests.ranks import launch, needs_mpirun


@pytest.fixture(autouse=True)
def untouched(monkeypatch):
    """Warnings and the root logger as a fresh program has them."""
    monkeypatch.setattr(warnings, "showwarning", warnings.showwarning)
    monkeypatch.setattr(logging.getLogger(), "handlers", [])


def test_a_warning_is_a_sentence_of_rank_0(capsys):
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        console.run(lambda _: warnings.warn("cells are large", stacklevel=1))
    said = capsys.readouterr()
    first = MPI.COMM_WORLD.rank == 0
    assert said.err == ("warning: cells are large\n" if first else "") and said.out == ""


def test_nothing_that_other_packages_log(capsys):
    """`logging.info` would set the root logger up, and its lines on the terminal."""

    def main(_):
        logging.getLogger().setLevel(logging.INFO)
        logging.info("running build_ext")
        logging.getLogger("other").warning("deprecated")

    level = logging.getLogger().level
    try:
        console.run(main)
    finally:
        logging.getLogger().setLevel(level)
    said = capsys.readouterr()
    assert said.out == said.err == ""


@pytest.mark.serial
@pytest.mark.parametrize(
    ("error", "code"),
    [(ValueError("no such hem"), 2), (NotConverged("at level 0.5"), 2), (Stopped("at 1 s"), 130)],
)
def test_an_error_is_a_sentence(error, code, capsys, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["demos/walk.py"])

    def main(_):
        raise error

    with pytest.raises(SystemExit) as stop:
        console.run(main)
    said = capsys.readouterr()
    assert stop.value.code == code and said.out == ""
    assert said.err == f"walk.py: {error}\n"


@pytest.mark.serial
def test_an_error_of_ours_is_shown_whole(capsys):
    with pytest.raises(SystemExit) as stop:
        console.run(lambda _: 1 / 0)
    assert stop.value.code == 1 and "ZeroDivisionError" in capsys.readouterr().err


def test_no_bar_without_a_terminal(capsys):
    """The same items, and not a character."""
    assert list(console.progress(range(3), 3, "walk")) == [0, 1, 2]
    said = capsys.readouterr()
    assert said.out == said.err == ""


@pytest.mark.serial
def test_output_into_a_pipe_that_closes(tmp_path):
    """As `| head -1`: the reader goes after a line, the program ends without a word."""
    program = (
        "import argparse\n"
        "from shellform import console\n"
        "def main(given=None):\n"
        "    console.parse(argparse.ArgumentParser(), given)\n"
        "    for i in range(100000):\n"
        "        console.say([f'line {i}'])\n"
        "console.run(main)\n"
    )
    command = [sys.executable, "-c", program]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout.readline() == b"line 0\n"
        process.stdout.close()
        said = process.stderr.read()
    assert said == b"" and process.returncode == 141


@needs_mpirun
@pytest.mark.serial
def test_a_stop_that_all_have_agreed_upon_is_told_once():
    """Also while nobody reads what rank 0 has said, as mpirun does not after Ctrl-C."""
    program = (
        "import os\n"
        "from mpi4py import MPI\n"
        "from shellform import Stopped, console\n"
        "def main(given):\n"
        "    if MPI.COMM_WORLD.rank == 0:\n"
        "        os.dup2(os.pipe()[1], 2)\n"
        "    raise Stopped('stopped here')\n"
        "console.run(main)\n"
    )
    done = launch(2, "-c", program)
    assert done.returncode == 130 and "stopped here" not in done.stderr
