# SPDX-License-Identifier: LGPL-3.0-or-later
"""Flesh of a scene, `contact.flesh_bed`: everywhere or by segments, contact/body/flesh_bed.py."""

from collections.abc import Iterable

from contact.body.flesh_bed import Flesh

from .scene import Scene

EVERYWHERE = "body"  # the name for all segments that have none of their own


def flesh_of(scene: Scene, all_names: Iterable[str], names: Iterable[str]) -> Flesh | None:
    """Flesh of the segments `names` of the wearer; None where the scene has none.

    Raises
    ------
    ValueError for flesh of a segment that is not in `all_names`, and for stiffnesses that are none
    """
    beds = scene.contact.flesh_bed
    if not beds:
        return None
    known = [EVERYWHERE, *all_names]
    for name in beds:
        if name not in known:
            raise ValueError(f"contact.flesh_bed: no '{name}'; there are {', '.join(known)}")
    try:
        Flesh(beds)
    except ValueError as error:
        raise ValueError(f"contact.flesh_bed: {error}") from None
    every = beds.get(EVERYWHERE)
    by_name = {name: beds.get(name, every) for name in names}
    return Flesh({name: value for name, value in by_name.items() if value is not None})
