# SPDX-License-Identifier: LGPL-3.0-or-later
"""One of several ways to give a quantity: all that one way needs, and nothing of the others.

What is given but would not be used is refused: somebody measured it, and takes it to count.
"""

from collections.abc import Collection, Sequence

from .laminate import FabricError


def one_of(q: Collection[str], ways: Sequence[Sequence[str]], what: str, where: str) -> str:
    """First name of the way that is given.

    Parameters
    ----------
    q : names that are there
    ways : names that go together, the first of which tells the way; those in [] may be left out
    what : is given so; where : begins messages

    Raises
    ------
    FabricError : none or more than one way, a name that is missing, or one of another way
    """
    found = [names for names in ways if names[0] in q]
    if len(found) != 1:
        told = "; ".join(", ".join(names) for names in ways)
        have = " and ".join(names[0] for names in found) or "none"
        raise FabricError(
            f"{where}: {what} needs one of: {told} (each with its unit); there is {have}."
        )
    chosen = {name.strip("[]") for name in found[0]}
    for name in found[0][1:]:
        if name not in q and not name.startswith("["):
            raise FabricError(f"{where}: {name} is missing, {found[0][0]} needs it.")
    for name in (name.strip("[]") for names in ways for name in names):
        if name in q and name not in chosen:
            raise FabricError(
                f"{where}: {what} is given by {found[0][0]}, to which {name} does not belong: "
                "leave it out."
            )
    return found[0][0]
