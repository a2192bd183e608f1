# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where the numbers of a fabric come from: what is measured and what is estimated, and how well.

    [provenance]
    source = "Kawabata test of 3 May, 3 specimens"
    estimated = ["bending"]              # of QUANTITIES, or "all"; the others are measured
    spread = { bending = [0.3, 3.0] }    # factors between which 8 of 10 such fabrics lie

Bending and shear that are estimated and have no numbers in the card get those of prior.py.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .laminate import FabricError
from .spelling import nearest

QUANTITIES = ("tension", "shear", "bending", "friction", "mass", "thickness")
KEYS = ("source", "estimated", "spread")
WIDEST = 1e3


@dataclass(frozen=True)
class Provenance:
    """Source in words, estimated ones of QUANTITIES, and (low, high) factors of some of these."""

    source: str
    estimated: tuple[str, ...] = ()
    spread: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def measured(self) -> tuple[str, ...]:
        """Those of QUANTITIES that are not estimated."""
        return tuple(name for name in QUANTITIES if name not in self.estimated)

    def line(self) -> str:
        """For a person: "estimated: ...; measured: ...; source".

        Examples
        --------
        >>> Provenance("tested in May", ("friction", "thickness")).line()
        'estimated: friction, thickness; measured: tension, shear, bending, mass; tested in May'
        """
        if not self.measured:
            return f"estimated, not measured; {self.source}"
        parts = {"estimated": self.estimated, "measured": self.measured}
        said = [f"{word}: {', '.join(names)}" for word, names in parts.items() if names]
        return "; ".join([*said, self.source])

    def table(self) -> dict[str, Any]:
        """Table from which `provenance_from` makes it again."""
        spread = {name: list(factors) for name, factors in self.spread.items()}
        return {"source": self.source, "estimated": list(self.estimated)} | (
            {"spread": spread} if spread else {}
        )


def provenance_from(table: Any, where: str = "provenance") -> Provenance:
    """Provenance of a card's table; `where` begins messages.

    Raises
    ------
    FabricError : an unknown key or quantity, no source, factors that do not enclose 1
    """
    if not isinstance(table, dict):
        raise FabricError(f"{where}: this must be a table of keys, not {table!r}.")
    for key in table:
        if key not in KEYS:
            raise FabricError(f'{where}: unknown key "{key}"; {nearest(key, KEYS)}')
    source = table.get("source")
    if not isinstance(source, str) or not source.strip():
        raise FabricError(f"{where}: source = {source!r}: say in words where the numbers are from.")
    given = table.get("estimated", [])
    estimated = list(QUANTITIES) if given == "all" else given
    if not isinstance(estimated, list):
        raise FabricError(f'{where}: estimated = {given!r}: a list of quantities, or "all".')
    for name in estimated:
        if name not in QUANTITIES:
            raise FabricError(f"{where}: estimated {name!r}; {nearest(str(name), QUANTITIES)}")
    spread = table.get("spread", {})
    if not isinstance(spread, dict):
        raise FabricError(f"{where}: spread = {spread!r}: a table as {{ bending = [0.3, 3.0] }}.")
    return Provenance(
        source.strip(),
        tuple(name for name in QUANTITIES if name in estimated),
        {name: _factors(name, two, estimated, where) for name, two in spread.items()},
    )


def _factors(name, given, estimated, where):
    if name not in estimated:
        raise FabricError(f'{where}: spread of "{name}", which is not among those estimated.')
    try:
        low, high = (float(factor) for factor in given)
    except (TypeError, ValueError):
        low = high = np.nan
    if not (1 / WIDEST <= low <= 1 <= high <= WIDEST):
        raise FabricError(
            f"{where}: spread of {name} = {given!r}: two factors, the first at most 1, the second "
            "at least 1, as [0.3, 3.0]."
        )
    return low, high
