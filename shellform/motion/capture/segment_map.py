# SPDX-License-Identifier: LGPL-3.0-or-later
"""From marker labels to J1, J2, M of every segment (Eq. 17): named maps, written in TOML.

    [markers]   name = [labels it may have]         case, dots, dashes, underscores do not count
    [points]    name = rule, or [rule, rule, ...]   the first one whose markers are there
    [segments]  name = { J1 = point, J2 = point, M = point, optional = true }
    also        = [labels]    that belong to the set, though no segment needs them
    knows       = [maps]      whose labels may be in the same file
    base        = map         whose points and segments these are, for other labels

The rules are those of joint_centres.py. `{side}` in a name or a text stands for right and left,
`{S}` for R and L, `{s}` for r and l, `{other}` for the other side. Maps in `maps/` are known by
their names.
"""

import difflib
import tomllib
from dataclasses import dataclass, replace
from functools import cache
from itertools import chain
from pathlib import Path

from .joint_centres import RULES, references

FOLDER = Path(__file__).parent / "maps"
# of those that explain equally many labels the first one is taken
SHIPPED = (
    "opencap",
    "plug-in-gait",
    "ior",
    "medial",
    "plug-in-gait-markers",
    "helen-hayes",
    "cmu",
    "lateral",
    "theia",
    "skeleton",
    "joint-centres",
)
SIDES = (
    {"side": "right", "other": "left", "S": "R", "s": "r"},
    {"side": "left", "other": "right", "S": "L", "s": "l"},
)
KEYS = ("summary", "base", "also", "knows", "markers", "points", "segments")


@dataclass(frozen=True, eq=False)
class SegmentMap:
    """How points of segments follow from markers.

    Parameters
    ----------
    name : str, for messages
    markers : dict, marker -> tuple of labels
    points : dict, point -> tuple of rules
    segments : dict, segment -> dict of J1, J2, M (names of points) and optional (bool)
    also : tuple of labels that belong to the set as well
    knows : tuple of names of shipped maps whose labels may be in the same file
    """

    name: str
    markers: dict
    points: dict
    segments: dict
    also: tuple = ()
    knows: tuple = ()


@cache
def segment_map(name_or_path: str | Path) -> SegmentMap:
    """A map by name, one of `SHIPPED`, or from a TOML file.

    Raises
    ------
    ValueError
        When there is no such map, or it says something that is not understood.
    """
    path = FOLDER / f"{name_or_path}.toml" if str(name_or_path) in SHIPPED else Path(name_or_path)
    if not path.is_file():
        raise ValueError(
            f"no map '{name_or_path}'; there are {', '.join(SHIPPED)}, or give a TOML file"
        )
    try:
        # editors on Windows put a byte-order mark first
        table = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{path}: no TOML ({error})") from None
    if str(name_or_path) in SHIPPED:
        table = _sides_anywhere(table)
    name = str(name_or_path) if str(name_or_path) in SHIPPED else path.name
    return _checked(_both_sides(table), name, str(path))


@cache
def with_upper_body(map: SegmentMap) -> SegmentMap:
    """A map with trunk and arms besides, by `maps/upper-body.toml`, where markers for them are."""
    path = FOLDER / "upper-body.toml"
    table = _sides_anywhere(tomllib.loads(path.read_text(encoding="utf-8")))
    more = _checked(_both_sides(table), "upper-body", str(path))
    return replace(
        map,
        markers={**map.markers, **more.markers, **map.markers},
        points={**map.points, **more.points, **map.points},
        segments={**map.segments, **more.segments, **map.segments},
    )


def _sides_anywhere(table):
    """A shipped map whose labels may have the side in full, and behind as well: R.ASIS, ASIS_R,
    right ASIS. Two letters alone are not turned around."""

    def more(labels):
        stems = [s[3:].lstrip("._ ") for s in labels if s.startswith("{S}")]
        forms = ("{{side}}{}", "{}_{{S}}", "{}_{{side}}")
        return [*labels, *(form.format(s) for form in forms for s in stems if len(s) > 2)]

    markers = {key: more(labels) for key, labels in table["markers"].items()}
    return table | {"markers": markers, "also": more(table.get("also", []))}


@cache
def vocabulary(map: SegmentMap) -> dict[str, str]:
    """Labels of a set and of those it knows, without case and punctuation -> marker, "" for none.

    A label that the set itself uses has its own meaning there.
    """
    words = {plain(s): key for key, labels in map.markers.items() for s in labels}
    for label in map.also:
        words.setdefault(plain(label), "")
    for name in map.knows:
        for label in vocabulary(segment_map(name)):
            words.setdefault(label, "")
    return words


def plain(label: str) -> str:
    """A label without prefix, case and punctuation: "Ann:R.Knee" is "rknee"."""
    return "".join(c for c in label.split(":")[-1].lower() if c.isalnum())


def _both_sides(value):
    """Entries and texts with {side}, {S}, {other} written out for right and left."""
    if isinstance(value, dict):
        out = {}
        for key, item in value.items():
            for side in SIDES if "{" in key else ({},):
                out[_fill(key, side)] = _filled(item, side)
        return {key: _both_sides(item) for key, item in out.items()}
    if isinstance(value, list):
        texts = [item for item in value if isinstance(item, str) and "{" in item]
        if texts:  # a list of labels that belong to no side: of both
            rest = [item for item in value if item not in texts]
            return rest + [_fill(item, side) for item in texts for side in SIDES]
    return value


def _fill(text, side):
    for word, meaning in side.items():
        text = text.replace("{" + word + "}", meaning)
    return text


def _filled(value, side):
    if isinstance(value, str):
        return _fill(value, side)
    if isinstance(value, list):
        return [_filled(item, side) for item in value]
    if isinstance(value, dict):
        return {key: _filled(item, side) for key, item in value.items()}
    return value


def _closest(word, words):
    found = difflib.get_close_matches(word, sorted(words), 1, 0.0)
    return found[0] if found else "nothing"


def _checked(table, name, where):
    for key in table:
        if key not in KEYS:
            raise ValueError(f"{where}: unknown key '{key}'; a map has {', '.join(KEYS)}")
    for key in ("markers", "points", "segments"):
        if not isinstance(table.get(key, {}), dict):
            raise ValueError(f"{where}: {key} is a table, not {table[key]!r}")
    markers, points, segments = (dict(table.get(k, {})) for k in ("markers", "points", "segments"))
    also, knows = (table.get(key, []) for key in ("also", "knows"))
    for key, value in (("also", also), ("knows", knows)):
        if not isinstance(value, list) or not all(isinstance(s, str) for s in value):
            raise ValueError(f"{where}: '{key}' needs a list of names, not {value!r}")
    base = table.get("base")
    for other in [*knows, *([] if base is None else [base])]:
        if other not in SHIPPED:
            raise ValueError(f"{where}: no map {other!r}; there are {', '.join(SHIPPED)}")
    if base is not None:
        under = segment_map(base)
        markers = {key: [] for key in under.markers} | markers
        points, segments = under.points | points, under.segments | segments
    for key, labels in markers.items():
        labels = [labels] if isinstance(labels, str) else labels
        if not isinstance(labels, list) or not all(isinstance(s, str) for s in labels):
            raise ValueError(f"{where}: marker '{key}' needs a list of labels, not {labels!r}")
        markers[key] = tuple(labels)
    known = {*markers, *points}
    for key, rules in points.items():
        if key in markers:
            raise ValueError(f"{where}: '{key}' is a marker and a point; rename one of them")
        points[key] = tuple(rules) if isinstance(rules, list | tuple) else (rules,)
        for rule in points[key]:
            _check_rule(rule, key, known, where)
    for key, entry in segments.items():
        entry = entry if isinstance(entry, dict) else {}
        for word in entry:
            if word not in ("J1", "J2", "M", "optional"):
                raise ValueError(
                    f"{where}: segment '{key}' has unknown key '{word}'; it takes J1, J2, M, "
                    "optional"
                )
        for end in ("J1", "J2", "M"):
            if entry.get(end) not in known:
                said = f"'{entry[end]}', which is no point" if end in entry else "missing"
                raise ValueError(
                    f"{where}: {end} of segment '{key}' is {said}; closest point: "
                    f"'{_closest(str(entry.get(end, key)), known)}'"
                )
    if not segments:
        raise ValueError(f"{where}: no [segments]; give J1, J2 and M of at least one")
    out = SegmentMap(name, markers, points, segments, tuple(also), tuple(knows))
    for key in points:
        _check_circle(out, key, (), where)
    return out


def _check_rule(rule, key, known, where):
    kinds = [word for word in RULES if isinstance(rule, dict) and word in rule]
    if len(kinds) != 1:
        raise ValueError(
            f"{where}: point '{key}' has no known rule in {rule!r}; the rules are "
            f"{', '.join(RULES)}"
        )
    needed, allowed = RULES[kinds[0]]
    for word in rule:
        if word not in (kinds[0], *needed, *allowed):
            raise ValueError(
                f"{where}: point '{key}' has unknown key '{word}'; '{kinds[0]}' takes "
                f"{', '.join((*needed, *allowed)) or 'nothing else'}"
            )
    for word in needed:
        if word not in rule:
            raise ValueError(f"{where}: point '{key}' lacks '{word}' beside '{kinds[0]}'")
    try:
        needed, optional = references(rule)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{where}: point '{key}': {error}") from None
    for name in [*needed, *optional]:
        if name not in known:
            raise ValueError(
                f"{where}: point '{key}' uses '{name}', which is no marker and no point; closest: "
                f"'{_closest(name, known)}'"
            )


def _check_circle(map, key, above, where):
    if key in above:
        raise ValueError(f"{where}: point '{key}' is made of itself ({' < '.join(above)})")
    for rule in map.points.get(key, ()):
        for name in chain(*references(rule)):
            _check_circle(map, name, (*above, key), where)
