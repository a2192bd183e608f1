# SPDX-License-Identifier: LGPL-3.0-or-later
"""Keys of cards: names with their units, and what a mistyped one was meant to be."""

import difflib
from collections.abc import Iterable, Mapping


def with_unit(name: str, units: Mapping[str, str]) -> str:
    """Key of a quantity: `thickness` as `thickness_m` by {"thickness": "m"}.

    Examples
    --------
    >>> with_unit("density", {"density": "kg/m^3"})
    'density_kg_per_m3'
    """
    unit = units.get(name, "").replace("/", "_per_").replace("^", "").replace(" ", "_")
    return f"{name}_{unit}".strip("_")


def nearest(key: str, valid: Iterable[str]) -> str:
    """End of a message: the key that was meant, or all there are."""
    valid = list(valid)
    close = difflib.get_close_matches(key, valid, n=1, cutoff=0.5)
    return f'did you mean "{close[0]}"?' if close else f"valid are {', '.join(valid)}."
