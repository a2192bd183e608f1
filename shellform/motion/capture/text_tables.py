# SPDX-License-Identifier: LGPL-3.0-or-later
"""Text files of tables, whatever their encoding, separator and decimal sign.

A byte-order mark tells UTF-8, UTF-16 and UTF-32; zero bytes tell UTF-16 without one; what is no
UTF-8 is read as Windows writes it (cp1252). Cells stand between tabs, semicolons, commas or blanks.
"""

import codecs
import csv
import re
from pathlib import Path

MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF32_LE, "utf-32"),  # begins as that of UTF-16 does
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
COMMA_NUMBER = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?$")
POINT_NUMBER = re.compile(r"[+-]?\d*\.\d+([eE][+-]?\d+)?$")


def text_of(path: str | Path) -> tuple[str, list[str]]:
    """Text of a file, and notes of an encoding that is not usual.

    Raises
    ------
    ValueError
        When it is no text.
    """
    data = Path(path).read_bytes()
    encoding = next((name for mark, name in MARKS if data.startswith(mark)), None)
    if encoding is None and data[:4096].count(0) > len(data[:4096]) // 4:
        encoding = "utf-16-be" if data[:1] == b"\0" else "utf-16-le"
    try:
        text = data.decode(encoding or "utf-8")
    except UnicodeDecodeError as error:
        if encoding is not None:
            raise ValueError(
                f"{path}: byte {error.start} is no text in {encoding.upper()}; the file is cut off "
                "or damaged, copy it again"
            ) from None
        encoding, text = "cp1252", data.decode("cp1252", errors="replace")
    if "\0" in text:
        raise ValueError(f"{path}: byte {text.index(chr(0))} is no text; export the file again")
    if encoding in (None, "utf-8-sig"):
        return text, []
    return text, [f"read as {str(encoding).upper()} text"]


def separator_of(line: str) -> str:
    """What separates the cells of a line, "" for blanks; commas last, as numbers may have them."""
    return next((sign for sign in "\t;," if line.count(sign) > 1), "")


def cells_of(line: str, separator: str = "\t") -> list[str]:
    """Cells of a line, without blanks and quotation marks about them."""
    if not separator:
        return line.split()
    if '"' in line:
        return [c.strip() for c in next(csv.reader([line], delimiter=separator), [])]
    return [c.strip() for c in line.split(separator)]


def with_points(rows: list[list[str]], separator: str) -> tuple[list[list[str]], list[str]]:
    """Rows of cells whose decimal commas have become points, and a note of it."""
    if separator == "," or not any(COMMA_NUMBER.match(c) for row in rows for c in row):
        return rows, []
    if any(POINT_NUMBER.match(c) for row in rows for c in row):
        return rows, []  # both: a cell that is no number is refused with its place
    points = [[c.replace(",", ".") if COMMA_NUMBER.match(c) else c for c in r] for r in rows]
    return points, ["decimal commas read as points"]


def unended(text: str) -> bool:
    """Whether the last line of a text may have lost its end: no end of line, and another number of
    decimals than the line before."""
    if text.endswith(("\n", "\r")):
        return False
    before, last = ([""] * 2 + text.splitlines())[-2:]
    ends = [re.search(r"(\d*)\s*\"?$", line.rstrip(",;\t ")) for line in (before, last)]
    return len({len(m.group(1)) if m else 0 for m in ends}) > 1
