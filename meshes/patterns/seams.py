# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where the nodes of sewn edges lie: as many on both sides of a seam, each with its mate.

A seam is parted at the corners of either side and at notches that have a mate on the other side, in
their order; in each part both sides have the same number of nodes at the same fractions of their
lengths, so that what is longer is eased in evenly between two notches.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from .pattern import SewingPattern, Side, Stitch

NEAR = 2e-3  # fractions of a seam that are taken for one; distance of a notch from its edge [m]


class ChainPart(NamedTuple):
    """One edge in a chain: from `start` to `end`, fractions of the chain; `back`: run backwards."""

    side: Side
    start: float
    end: float
    back: bool


def spacings(
    pattern: SewingPattern, stitches: list[Stitch], size: float
) -> tuple[dict[Side, np.ndarray], list[tuple[list[ChainPart], list[ChainPart]]]]:
    """Fractions (k,) of the nodes of every edge, and the chains of every seam.

    Parameters
    ----------
    stitches : with `along` decided; size : wanted distance of nodes [m]

    Both chains of a seam run the same way along it.
    """
    out: dict[Side, np.ndarray] = {}
    seams = []
    for stitch in stitches:
        chains = chain_of(pattern, stitch.first), chain_of(pattern, stitch.second)
        if not stitch.along:
            chains = chains[0], reversed_chain(chains[1])
        seams.append(chains)
        breaks = _breaks(pattern, chains)
        lengths = [pattern.chain_length([part.side for part in chain]) for chain in chains]
        spans = np.diff(breaks, axis=0)
        wide = 0.5 * (spans[:, 0] * lengths[0] + spans[:, 1] * lengths[1])
        number = np.maximum(1, np.round(wide / size)).astype(int)
        for k, chain in enumerate(chains):
            inner = [
                np.linspace(a, b, n + 1)[:-1]
                for a, b, n in zip(breaks[:-1, k], breaks[1:, k], number)
            ]
            nodes = np.append(np.concatenate(inner), 1.0)
            for part in chain:
                own = nodes[(nodes > part.start - 1e-9) & (nodes < part.end + 1e-9)]
                own = np.clip((own - part.start) / (part.end - part.start), 0.0, 1.0)
                out[part.side] = np.sort(1.0 - own if part.back else own)
    for panel in pattern.panels:
        for edge in panel.edges:
            if (panel.name, edge.name) not in out:
                count = max(1, round(edge.length / size))
                out[panel.name, edge.name] = np.linspace(0.0, 1.0, count + 1)
    return out, seams


def chain_of(pattern: SewingPattern, sides: tuple[Side, ...]) -> list[ChainPart]:
    """Parts of a chain, all run forwards or, where its edges follow each other so, backwards."""
    back = False
    for (panel, one), (other, two) in pairwise(sides):
        names = [edge.name for edge in pattern.panel(panel).edges]
        if panel == other and names[names.index(one) - 1] == two and len(names) > 2:
            back = True
    lengths = [pattern.panel(panel).edge(edge).length for panel, edge in sides]
    ends = np.concatenate([[0.0], np.cumsum(lengths)]) / sum(lengths)
    ends[-1] = 1.0
    return [ChainPart(s, float(a), float(b), back) for s, a, b in zip(sides, ends, ends[1:])]


def reversed_chain(chain: list[ChainPart]) -> list[ChainPart]:
    """The same chain from its other end."""
    return [ChainPart(p.side, 1.0 - p.end, 1.0 - p.start, not p.back) for p in chain[::-1]]


def _breaks(pattern, chains):
    """Fractions (k, 2) of both chains that belong together, rising from (0, 0) to (1, 1)."""
    notches = [_notches(pattern, chain) for chain in chains]
    pairs = [(0.0, 0.0)]
    if len(notches[0]) == len(notches[1]):
        pairs += list(zip(*notches))
    pairs = np.array([*pairs, (1.0, 1.0)])
    found = [tuple(pair) for pair in pairs]
    for k, chain in enumerate(chains):
        for part in chain[1:]:
            at = [0.0, 0.0]
            at[k] = part.start
            at[1 - k] = float(np.interp(part.start, pairs[:, k], pairs[:, 1 - k]))
            found.append(tuple(at))
    found = sorted(found)
    kept = [found[0]]
    corners = [[part.start for part in chain[1:]] for chain in chains]
    for pair in found[1:]:
        if min(pair[0] - kept[-1][0], pair[1] - kept[-1][1]) > NEAR:
            kept.append(pair)
        else:  # a corner beside a corner of the other side: both are nodes, mates
            last = kept.pop()
            kept.append(tuple(_exact(pair[k], last[k], [0.0, 1.0, *corners[k]]) for k in range(2)))
    return np.array(kept)


def _exact(one, other, corners):
    """Of two fractions the one that is a corner."""
    return one if any(abs(one - c) < 1e-12 for c in corners) else other


def _notches(pattern, chain):
    """Fractions of the notches along a chain, rising, none of them at a corner."""
    found = []
    for part in chain:
        panel = pattern.panel(part.side[0])
        edge = panel.edge(part.side[1])
        for notch in panel.notches:
            at = edge.fraction_of(notch)
            if np.linalg.norm(edge.at([at])[0] - notch) > NEAR or not 0.01 < at < 0.99:
                continue
            at = 1.0 - at if part.back else at
            found.append(part.start + at * (part.end - part.start))
    return sorted(found)


def along_or_against(
    pattern: SewingPattern, stitch: Stitch, places: dict[str, tuple[np.ndarray, np.ndarray]]
) -> bool:
    """Whether both sides of a stitch run the same way, by where their ends lie in space.

    places : rotation (3, 3) and translation (3,) of the panels that have them
    """
    if stitch.along is not None:
        return stitch.along
    chains = chain_of(pattern, stitch.first), chain_of(pattern, stitch.second)
    if not all(part.side[0] in places for chain in chains for part in chain):
        return False
    ends = []
    for chain in chains:
        two = []
        for part, last in ((chain[0], False), (chain[-1], True)):
            panel, edge = part.side
            turn, shift = places[panel]
            at = pattern.panel(panel).edge(edge).points[-1 if last != part.back else 0]
            two.append(turn[:, :2] @ at + shift)
        ends.append(np.array(two))
    same = np.linalg.norm(ends[0] - ends[1], axis=1).sum()
    against = np.linalg.norm(ends[0] - ends[1][::-1], axis=1).sum()
    return bool(same < 0.8 * against)


def ease_notes(pattern: SewingPattern) -> list[str]:
    """A sentence for each seam of which one side is longer by more than a per cent."""
    notes = []
    for stitch in pattern.stitches:
        one, other = (pattern.chain_length(chain) for chain in (stitch.first, stitch.second))
        if max(one, other) > 1.01 * min(one, other):
            sides = [stitch.first, stitch.second]
            long, short = sides if one > other else sides[::-1]
            notes.append(
                f"{pattern.source}: {_named(long)} ({max(one, other):.3f} m) is eased into "
                f"{_named(short)} ({min(one, other):.3f} m), "
                f"{max(one, other) / min(one, other):.2f} to 1."
            )
    return notes


def _named(chain):
    return " and ".join(f"{panel}.{edge}" for panel, edge in chain)
