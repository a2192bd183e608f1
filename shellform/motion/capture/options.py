# SPDX-License-Identifier: LGPL-3.0-or-later
"""The options that a capture is read with: one list for scenes, command lines and messages.

Each has the name of its argument of `read_motion`. A scene has it under [motion], with its unit
behind (`max_gap_s`), a command line as `--max-gap`. The window is given by its two ends.
"""

import argparse
from collections.abc import Callable
from typing import Any, NamedTuple


class Option(NamedTuple):
    """An option: its name, what it is for, its unit, its default, and the values it may have."""

    name: str
    help: str
    unit: str = ""
    default: Any = None
    choices: tuple[str, ...] | None = None

    @property
    def flag(self) -> str:
        """On a command line, `--max-gap`."""
        return f"--{self.name.replace('_', '-')}"

    @property
    def key(self) -> str:
        """In a scene file, `max_gap_s`."""
        return f"{self.name}_{self.unit}" if self.unit else self.name


OPTIONS = (
    Option("static", "file of a static trial with markers that the walk lacks"),
    Option("map", "segment map of the markers (default: the one that fits)"),
    Option("unit", "of the capture, where it does not tell"),
    Option("up", "vertical, where it is not clear", choices=("y", "z")),
    Option("cutoff", "of the low pass", "Hz", 6.0),
    Option("max_gap", "longest gap filled", "s", 0.1),
)
DEFAULTS = {option.name: option.default for option in OPTIONS}
# how messages name them, see `shellform.errors.Mendable`; what is lowered is named without a value
IN_SCENE = {o.name: f"{o.key} = ..." if o.unit else f'{o.name} = "..."' for o in OPTIONS} | {
    "cutoff": "cutoff_Hz",
    "window": "start_s and end_s",
}


def add_options(parser: argparse.ArgumentParser, positive: Callable[[type], Any]) -> None:
    """Give a command line all options of a capture; `positive` makes the type of its numbers."""
    for option in OPTIONS:
        more: dict[str, Any] = {"type": positive(float)} if option.unit else {}
        unit = f", {option.unit}" if option.unit else ""
        parser.add_argument(
            option.flag,
            default=option.default,
            choices=option.choices,
            help=option.help + unit,
            **more,
        )


def on_command_line(window: str) -> dict[str, str]:
    """How messages name the options of a command line, whose window is given by `window`."""
    words = {o.name: f"{o.flag} ..." for o in OPTIONS}
    return words | {"cutoff": "--cutoff", "window": window}


def options_of(source: object) -> dict[str, Any]:
    """Values of the options by name, from a scene's [motion] or from parsed arguments."""
    return {option.name: getattr(source, option.name) for option in OPTIONS}
