# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rows (direction, value, verdict, figure) of extremes drawn together to one line a direction.

Each line says what was tried, what happens there, the first limit met, in the words a user reads,
and the figure at the last value that converges.
"""

import argparse
import json
import re
from pathlib import Path

from shellform.console import parse
from shellform.results.files import write_atomically

HEAD = ("direction", "tried", "what happens", "limit", "at the last that converges")
KINDS = ("converges", "degrades", "refused")


def kind(verdict):
    """One of KINDS; ValueError for a verdict that is none."""
    for word in KINDS:
        if verdict == word or verdict.startswith((f"{word}:", f"{word},")):
            return word
    raise ValueError(f"a verdict starts with one of {', '.join(KINDS)}, not '{verdict}'")


def reason(verdict):
    """First sentence of what a verdict says beyond its kind, without how often Newton tried."""
    said = verdict[len(kind(verdict)) :].lstrip(":, ")
    if "whose state is kept. " in said:
        said = "no equilibrium found: " + said.split("whose state is kept. ")[1]
    return re.split(r"\. (?=[A-Z])", said)[0].rstrip(".")


def span(values):
    """'a', 'a, b' or 'a to z' of a list of strings in the order tried."""
    return ", ".join(values) if len(values) < 3 else f"{values[0]} to {values[-1]}"


def condensed(rows):
    """Rows of HEAD, one a direction, from rows of four strings, in their order."""
    out = []
    for direction in dict.fromkeys(row[0] for row in rows):
        mine = [row for row in rows if row[0] == direction]
        runs = []  # of one kind, in the order tried
        for _, value, verdict, _ in mine:
            if runs and runs[-1][0] == kind(verdict):
                runs[-1][1].append(value)
            else:
                runs.append((kind(verdict), [value]))
        what = "; ".join(f"{word} {span(values)}" for word, values in runs)
        beyond = [reason(verdict) for _, _, verdict, _ in mine if kind(verdict) != "converges"]
        figures = [figure for *_, verdict, figure in mine if kind(verdict) == "converges"]
        out.append(
            (
                direction,
                span([value for _, value, *_ in mine]),
                what if len(runs) > 1 else runs[0][0],
                beyond[0] if beyond else "none met",
                figures[-1] if figures else "-",
            )
        )
    return out


def markdown(head, rows):
    """Lines of a table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return [f"| {' | '.join(cell.replace('|', '/') for cell in line)} |" for line in lines]


def arguments(name, given, **more):
    """Options of a demo of extremes; more : flag -> help."""
    parser = argparse.ArgumentParser(allow_abbrev=False, description="A table of extremes.")
    parser.add_argument("--every", action="store_true", help="a line for each value tried")
    for flag, said in more.items():
        parser.add_argument(f"--{flag}", action="store_true", help=said)
    parser.add_argument("--out", type=Path, default=Path("out") / name, help="folder")
    return parse(parser, given)


def tell(rows, options):
    """Print the table and leave all rows in summary.json."""
    keys = ("direction", "value", "verdict", "figure")
    whole = [dict(zip(keys, line, strict=True)) for line in rows]
    options.out.mkdir(parents=True, exist_ok=True)
    write_atomically(options.out / "summary.json", json.dumps({"rows": whole}, indent=1) + "\n")
    print("\n".join(markdown(keys, rows) if options.every else markdown(HEAD, condensed(rows))))
