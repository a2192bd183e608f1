# SPDX-License-Identifier: LGPL-3.0-or-later
"""Text, numbers and tables as HTML; all that comes from files is escaped."""

import math
from collections.abc import Sequence
from html import escape


class Markup(str):
    """Text that is HTML already."""


def safe(text: object) -> Markup:
    """HTML of a text; of Markup as it is."""
    return text if isinstance(text, Markup) else Markup(escape(str(text)))


def number(value: float | None, digits: int = 3) -> str:
    """A number in so many significant digits, with a real minus; a dash for none."""
    if value is None or not math.isfinite(value):
        return "\N{EN DASH}"
    if value == 0:
        return "0"
    places = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    text = f"{value:.{places}f}" if places < 7 else f"{value:.{digits - 1}e}"
    return text.replace("-", "\N{MINUS SIGN}")


def with_error(value: float, error: float | None) -> Markup:
    """A number and its standard error, both to the error's second digit; the value is `data-value`.

    Four places after the point at most; four digits of the value where there is no error.
    """
    if error is None or not math.isfinite(error) or error <= 0:
        shown = number(value, 4)
    else:
        places = min(max(1 - math.floor(math.log10(error)), 0), 4)
        shown = f"{value:.{places}f}".replace("-", "\N{MINUS SIGN}")
        shown += f" <small>\N{PLUS-MINUS SIGN} {max(error, 10.0**-places):.{places}f}</small>"
    return Markup(f'<span data-value="{value!r}">{shown}</span>')


def paragraph(text: object, kind: str = "") -> Markup:
    """A paragraph, with a class where one is given."""
    return Markup(f'<p class="{kind}">{safe(text)}</p>' if kind else f"<p>{safe(text)}</p>")


def bullets(items: Sequence[object], otherwise: str = "") -> Markup:
    """A list; a paragraph `otherwise` where there is nothing in it."""
    if not items:
        return paragraph(otherwise)
    return Markup("<ul>" + "".join(f"<li>{safe(item)}</li>" for item in items) + "</ul>")


def table(
    head: Sequence[object], rows: Sequence[Sequence[object]], caption: str, kind: str = ""
) -> Markup:
    """A table; the first cell of every row is its heading, `kind` a class."""
    top = "".join(f'<th scope="col">{safe(cell)}</th>' for cell in head)
    lines = [
        f'<tr><th scope="row">{safe(first)}</th>'
        + "".join(f"<td>{safe(cell)}</td>" for cell in rest)
        + "</tr>"
        for first, *rest in rows
    ]
    return Markup(
        f'<div class="scroll" tabindex="0" role="region" aria-label="{escape(caption)}">'
        f'<table class="{kind}"><caption><span>{safe(caption)}</span></caption>'
        f"<thead><tr>{top}</tr></thead><tbody>{''.join(lines)}</tbody></table></div>"
    )
