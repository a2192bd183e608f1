# SPDX-License-Identifier: LGPL-3.0-or-later
"""Every demo and study is a command that explains itself; what is timed by name exists."""

import importlib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
COMMANDS = sorted(
    path.relative_to(ROOT).with_suffix("").as_posix().replace("/", ".")
    for path in (ROOT / "demos").rglob("*.py")
    if '__name__ == "__main__"' in path.read_text()
)
pytestmark = pytest.mark.serial


def test_the_commands():
    """Six demos at the top, studies behind the tables."""
    top = {name.removeprefix("demos.") for name in COMMANDS if name.count(".") == 1}
    assert top == {"roll_up", "drape", "capstan", "strip_over_cylinder", "hinge_sleeve", "walk"}
    assert len(COMMANDS) > len(top)


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_explains_itself(name, capsys):
    with pytest.raises(SystemExit) as stop:
        importlib.import_module(name).main(["-h"])
    assert stop.value.code == 0 and "usage:" in capsys.readouterr().out


@pytest.mark.parametrize("study", ["refinement", "starts", "membrane", "methods"])
def test_studies_of_drapes_explain_themselves(study, capsys):
    run = importlib.import_module("demos.studies.drape.run")
    with pytest.raises(SystemExit) as stop:
        run.main([study, "-h"])
    assert stop.value.code == 0 and "--quick" in capsys.readouterr().out


def test_headers_say_what_is_asked_and_compared():
    """Each demo: objective, equations, what is compared, source."""
    for name in COMMANDS:
        if name.count(".") == 1:
            text = importlib.import_module(name).__doc__
            for part in ("Objective. ", "Equations. ", "What is compared. ", "Source. "):
                assert text.count(part) == 1, (name, part)


def test_what_the_profile_times_exists():
    """Parts are replaced by name in their owner's own dictionary."""
    parts = importlib.import_module("demos.studies.performance.profile_step").PARTS
    for places in parts.values():
        for owner, name in places:
            assert callable(vars(owner)[name])
