# SPDX-License-Identifier: LGPL-3.0-or-later
"""Docstrings are plain text with sections; here they become paragraphs, lists and literal blocks.

The project's docstrings are written to be read in an editor: sections underlined as numpydoc's,
one item a line with what continues it indented, formulas and examples indented by four. They are
no reStructuredText, so stars, bars and underscores in them mean themselves.
"""

import re

from docutils import nodes

SPAN = re.compile(r"(``[^`]+``|`[^`]+`)")
NEXT = re.compile(r"; (?=[A-Za-z_][\w, ]* : )")  # between two names described on one line
ITEM = re.compile(r"[\w*, ]+ : \S")  # a name described
# numpy's ArrayLike, which signatures give written out
ARRAY_LIKE = re.compile(r"_SupportsArray\[.*?_NestedSequence\[bool \|[^\]]*\]")
OBJECT = re.compile(r"<[\w. ]+>")
PLAIN_BASES = ("object", "NamedTuple", "Protocol")
RAISED = re.compile(r"^(\w+Error|Unstable|NotConverged|Stopped) (?=[A-Z])")
INDENT = 4
LISTS = ("Parameters", "Attributes")


def escaped(text: str) -> str:
    """Text in which only `code` between backquotes is marked up."""
    parts = SPAN.split(text)
    for k, part in enumerate(parts):
        if SPAN.fullmatch(part):
            # what is written on to it, as an s, is set off by a mark that is not shown
            follows = parts[k + 1][:1].isalnum()
            parts[k] = f"``{part.strip(chr(96))}``" + (r"\ " if follows else "")
        else:
            parts[k] = re.sub(r"([\\*_|`])", r"\\\1", part)
    return "".join(parts)


def indent_of(line: str) -> int:
    return len(line) - len(line.lstrip())


def sections(lines: list[str]):
    """Pairs of title (None for what comes first) and lines."""
    found, k = [(None, [])], 0
    while k < len(lines):
        under = lines[k + 1].strip() if k + 1 < len(lines) else ""
        if lines[k].strip() and len(under) > 2 and set(under) == {"-"} and not indent_of(lines[k]):
            found.append((lines[k].strip(), []))
            k += 2
            continue
        found[-1][1].append(lines[k])
        k += 1
    return found


def paragraphs(lines: list[str]):
    """Runs of lines without a blank one between them."""
    run = []
    for line in [*lines, ""]:
        if line.strip():
            run.append(line)
        elif run:
            yield run
            run = []


def prose(lines: list[str]) -> list[str]:
    """Paragraphs; what is indented stays as it is."""
    out = []
    for run in paragraphs(lines):
        if all(indent_of(line) or ITEM.match(line) for line in run) and not indent_of(run[0]):
            out += items(run)
            continue
        literal, text = [], []
        for line in run:
            # what is indented below a sentence is a formula, an example or a table
            (literal if indent_of(line) >= INDENT or literal else text).append(line)
        if text:
            out += [escaped(" ".join(line.strip() for line in text)), ""]
        if literal:
            out += ["::", "", *("    " + line for line in literal), ""]
    return out


def items(lines: list[str]) -> list[str]:
    """One point of a list for every line that is not indented; the name before ` : ` is code."""
    entries = []
    for line in (line for run in paragraphs(lines) for line in run):
        if indent_of(line) and entries:
            entries[-1].append(line.strip())
        else:
            entries.append([line.strip()])
    out = []
    for text in (text for entry in entries for text in NEXT.split(" ".join(entry))):
        if " : " not in text:
            text = RAISED.sub(r"\1 : ", text)
        name, colon, rest = text.partition(" : ")
        if colon and "`" not in name:
            out.append(f"- ``{name}``: {escaped(rest)}")
        else:
            out.append(f"- {escaped(text)}")
    return [*out, ""]


def examples(lines: list[str]) -> list[str]:
    """Code as a reader would type it, with its output; sentences between stay sentences."""
    out = []
    for run in paragraphs(lines):
        if run[0].lstrip().startswith(">>>"):
            out += [".. code-block:: pycon", "", *("    " + line for line in run), ""]
        else:
            out += prose(run)
    return out


def is_list(title: str, lines: list[str]) -> bool:
    """Parameters are; what is returned or raised may be a sentence that runs over lines."""
    return title in LISTS or any(indent_of(line) for line in lines)


def marked_up(lines: list[str]) -> list[str]:
    """reStructuredText of a docstring."""
    out = []
    for title, text in sections(lines):
        if title is None:
            out += prose(text)
        elif title in ("Examples", "Example"):
            out += [f".. rubric:: {title}", "", *examples(text)]
        else:
            shown = items(text) if is_list(title, text) else prose(text)
            out += [f".. rubric:: {title}", "", *shown]
    return out


def shorter(signature: str) -> str:
    """A signature that can be read as Python: defaults without a text of their own are dots."""
    return OBJECT.sub("...", ARRAY_LIKE.sub("ArrayLike", signature))


def setup(app):
    def process(app, what, name, obj, options, lines):
        # what Python writes of a field without a word of its own
        if lines and lines[0].startswith("Alias for field number"):
            lines.clear()
        lines[:] = marked_up(lines)

    def short(app, what, name, obj, options, signature, returned):
        return tuple(text and shorter(text) for text in (signature, returned))

    def without_plain_bases(app, doctree):
        for line in list(doctree.findall(nodes.paragraph)):
            title, _, bases = line.astext().partition("Bases: ")
            if not title and bases in PLAIN_BASES:
                line.parent.remove(line)

    app.connect("autodoc-process-docstring", process)
    app.connect("autodoc-process-signature", short)
    app.connect("doctree-read", without_plain_bases)
