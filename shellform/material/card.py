# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fabric cards: a TOML file whose one table says how the material is given.

    name = "suiting"
    [kes]                                   # or [isotropic] [orthotropic] [stiffness] [[ply]]
    tensile_warp_N_per_m = 8100
    shear_N_per_m_per_radian = 54.4
    ...

The keys of a table are the arguments of the constructor of `Fabric` it stands for, each with its
unit; a list of `[[ply]]` tables, bottom first, makes a laminate. `law`, a name or a table of its
own, says what the sheet stores where that is not quadratic (laws.py). `[measured]` takes tests of
the cloth in their own units, with loading and unloading (measurements.py). `[provenance]` says what
is measured and what estimated (provenance.py).
"""

from __future__ import annotations

import inspect
import tomllib
from collections.abc import Callable
from pathlib import Path
from reprlib import repr as brief

from .fabric import Fabric, FabricError, Ply
from .laws import law_from
from .prior import filled
from .provenance import Provenance, provenance_from
from .sheet import MATRICES
from .spelling import nearest, with_unit

_UNITS = {name: unit for name, (_, unit) in MATRICES.items()} | {
    **dict.fromkeys(("youngs_modulus", "E1", "E2", "G12", "G13", "G23"), "Pa"),
    "bending_stiffness": "N m",
    "thickness": "m",
    "density": "kg/m^3",
    "areal_mass": "kg/m^2",
    "angle": "degrees",
}


def _ply(E1, E2, nu12, G12, G13, G23, density, thickness, angle):
    return Ply(E1, E2, nu12, G12, G13, G23, density), thickness, angle


_MAKERS = {
    "isotropic": Fabric.isotropic,
    "orthotropic": Fabric.orthotropic,
    "stiffness": Fabric.from_stiffness,
    "kes": Fabric.from_kes,
    "ply": _ply,
}


def card_keys(maker: Callable) -> dict[str, inspect.Parameter]:
    """The keys of a maker's table: its arguments with their units, `thickness` as `thickness_m`."""
    keys = {}
    for name, parameter in inspect.signature(maker).parameters.items():
        keys[with_unit(name, _UNITS)] = parameter
    keys.pop("name", None)  # stands above the table
    return keys


def _make(where: str, table, maker, **more):
    keys = card_keys(maker)
    if not isinstance(table, dict):
        raise FabricError(f"{where}: this must be a table of keys, not {brief(table)}.")
    for key in table:
        if key not in keys:
            gf = "gf" in key.split("_")
            mend = "numbers in gf go into a table [measured]." if gf else nearest(key, keys)
            raise FabricError(f'{where}: unknown key "{key}"; {mend}')
    for key, parameter in keys.items():
        if key not in table and parameter.default is inspect.Parameter.empty:
            raise FabricError(f'{where}: key "{key}" is missing.')
    try:
        return maker(**{keys[key].name: value for key, value in table.items()}, **more)
    except (ValueError, TypeError, OverflowError) as error:
        raise FabricError(f"{where}: {error}") from error


def fabric_from_card(card: dict, where: str = "fabric card", folder: Path = Path()) -> Fabric:
    """Fabric from the contents of a card; `where` begins every message.

    `folder` is where the card lies, which may name a file of a measured table.

    Raises
    ------
    FabricError : unknown or missing key, more or less than one table, or a value Fabric refuses.
    """
    name = card.get("name", Path(where).stem)
    if "law" in card:
        rest = {key: value for key, value in card.items() if key != "law"}
        return storing(fabric_from_card(rest, where, folder), card["law"], f"{where} [law]")
    if "provenance" in card:
        return _with_provenance(dict(card), where, folder)
    kinds, known = [key for key in card if key != "name"], [*_MAKERS, "measured"]
    for kind in kinds:
        if kind not in known:
            mend = nearest(kind, [*known, "law", "provenance"])
            raise FabricError(f'{where}: unknown key "{kind}"; {mend}')
    if len(kinds) != 1:
        raise FabricError(f"{where}: needs exactly one table of {', '.join(known)}; has {kinds}.")
    kind, table = kinds[0], card[kinds[0]]
    if kind == "measured":
        fabric = _measured(table, name, where, folder)
        return fabric.with_provenance(Provenance("numbers of the card"))
    if kind != "ply":
        return _make(f"{where} [{kind}]", table, _MAKERS[kind], name=name)
    if not isinstance(table, list):
        raise FabricError(f"{where}: plies are a list, write [[ply]] above each.")
    plies = [_make(f"{where} ply {i}", ply, _ply) for i, ply in enumerate(table, start=1)]
    try:
        return Fabric.laminate(plies, name=name)
    except (ValueError, TypeError, OverflowError) as error:
        raise FabricError(f"{where}: {error}") from error


def _with_provenance(card, where, folder):
    """Fabric of a card with a table `provenance`; missing estimates are those of prior.py."""
    table = card.pop("provenance")
    provenance = provenance_from(table, f"{where} [provenance]")
    for kind in card.keys() & {"kes", "measured"}:
        if isinstance(card[kind], dict):
            card[kind] = filled(kind, card[kind], provenance.estimated)
    fabric = fabric_from_card(card, where, folder).with_provenance(provenance)
    return fabric if fabric.card is None else fabric.with_card(fabric.card | {"provenance": table})


def _measured(table, name, where, folder):
    if not isinstance(table, dict):
        shown = brief(table)
        raise FabricError(f"{where} [measured]: this must be a table of keys, not {shown}.")
    # only here: it brings scipy, which other cards do not need
    from .measurements import measured_fabric

    return measured_fabric(table, name, f"{where} [measured]", folder)


def storing(fabric: Fabric, given: str | dict, where: str = "law") -> Fabric:
    """The fabric with the law of a name or table, see `law_from`; FabricError where they disagree.

    Examples
    --------
    >>> stiffening = {"kind": "fung", "stiffening_load_N_per_m": 40}
    >>> storing(fabric_of("compliant"), stiffening).law
    Fung(stiffening_load=40)
    """
    law = law_from(given, where)
    # only here: written in UFL, as the law is
    from .energy import check_law

    try:
        check_law(law, fabric)
    except FabricError as error:
        raise FabricError(f"{where}: {error}") from None
    stored = fabric.with_law(law)
    return stored if fabric.card is None else stored.with_card(fabric.card | {"law": given})


def read_fabric(path: str | Path) -> Fabric:
    """Fabric from a card file.  Raises FabricError naming the file, FileNotFoundError without.

    Examples
    --------
    >>> import shellform as sf
    >>> from shellform.material.card import CARDS
    >>> fabric = sf.read_fabric(CARDS / "stiff.toml")
    >>> fabric.thickness > 0
    True
    """
    if not Path(path).is_file():
        raise FileNotFoundError(f"{path}: there is no such file; a card is a TOML file of a fabric")
    data = Path(path).read_bytes()
    try:
        # some editors put a mark of the byte order in front
        card = tomllib.loads(data.decode("utf-8-sig"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise FabricError(f"{path}: not a TOML file: {error}.") from None
    return fabric_from_card(card, str(path), Path(path).parent)


CARDS = Path(__file__).parents[1] / "material/fabrics"


def fabric_of(
    given: Fabric | dict | str | Path, folder: Path = Path(), where: str = "scene"
) -> Fabric:
    """Fabric from a Fabric, the name of a shipped card, a path, or the table of a card."""
    if isinstance(given, Fabric):
        return given
    if isinstance(given, dict):
        return fabric_from_card(given, f"{where} [fabric]", folder)
    if not isinstance(given, str | Path):
        raise ValueError(f"fabric is the name of a card, a file or a table, not {given!r}")
    shipped = CARDS / f"{given}.toml"
    if shipped.is_file():
        return read_fabric(shipped)
    path = Path(folder) / given
    if not path.is_file():
        names = ", ".join(sorted(card.stem for card in CARDS.glob("*.toml")))
        raise ValueError(f"no fabric '{given}': it is a file, or one of the cards {names}")
    return read_fabric(path)
