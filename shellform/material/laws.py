# SPDX-License-Identifier: LGPL-3.0-or-later
"""Laws by name, as cards and scenes have them: `law = "neo-hookean"`, or a table with numbers.

    [law]
    kind = "fung"
    stiffening_load_N_per_m = 40

Keys are the parameters of the law's class with their units. A law is imported when it is named: it
is written in UFL, which a card without one does not need.
"""

from __future__ import annotations

import inspect
from importlib import import_module
from reprlib import repr as brief
from typing import TYPE_CHECKING, Any

from .laminate import FabricError
from .spelling import nearest, with_unit

if TYPE_CHECKING:
    from .energy import StVenant

# kind: file and class
LAWS = {
    "st-venant": ("energy", "StVenant"),
    "fung": ("fung", "Fung"),
    "neo-hookean": ("neo_hookean", "NeoHookean"),
    "compressible-neo-hookean": ("solid", "CompressibleNeoHookean"),
    "metric-and-curvature": ("surface_energy", "MetricAndCurvature"),
}
UNITS = {"stiffening_load": "N/m"}


def law_from(given: str | dict[str, Any], where: str = "law") -> StVenant:
    """Law of a name or of a table with its `kind` and numbers; `where` begins messages.

    Raises
    ------
    FabricError : no such law, a key that is missing or not known, or a value that the law refuses

    Examples
    --------
    >>> law_from({"kind": "fung", "stiffening_load_N_per_m": 40})
    Fung(stiffening_load=40)
    """
    table = {"kind": given} if isinstance(given, str) else given
    if not isinstance(table, dict) or not isinstance(table.get("kind"), str):
        raise FabricError(
            f'{where}: a law is a name, or a table with kind = "...", one of {", ".join(LAWS)}; '
            f"not {brief(given)}"
        )
    table = dict(table)
    kind = table.pop("kind")
    if kind not in LAWS:
        raise FabricError(f'{where}: unknown law "{kind}"; {nearest(kind, LAWS)}')
    file, name = LAWS[kind]
    # only here: laws are written in UFL, and some bring more
    law = getattr(import_module(f"{__package__}.{file}"), name)
    keys = {with_unit(p, UNITS): p for p in inspect.signature(law).parameters}
    for key in table:
        if key not in keys:
            mend = nearest(key, keys) if keys else "it has no keys."
            raise FabricError(f'{where}: unknown key "{key}" of the law "{kind}"; {mend}')
    for key in keys:
        if key not in table:
            raise FabricError(f'{where}: key "{key}" of the law "{kind}" is missing.')
    try:
        return law(**{keys[key]: value for key, value in table.items()})
    except (ValueError, TypeError) as error:
        raise FabricError(f"{where}: {error}") from error


def law_table(law: StVenant) -> dict[str, Any]:
    """Table of a law, from which `law_from` makes it again.

    FabricError for a law of a class that is not in LAWS.
    """
    for kind, (_, name) in LAWS.items():
        if type(law).__name__ == name and type(law).__module__.startswith(f"{__package__}."):
            parameters = inspect.signature(type(law)).parameters
            return {"kind": kind} | {with_unit(p, UNITS): getattr(law, p) for p in parameters}
    raise FabricError(f"{law!r} is none of the laws that have a name: {', '.join(LAWS)}")
