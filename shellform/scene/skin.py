# SPDX-License-Identifier: LGPL-3.0-or-later
"""The skin of a scene's wearer, where the body is one of triangles.

Joints, segments and what stands on them stay those of the wearer; contact is with the skin. Nothing
of it is imported for a body of ellipsoids.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from shellform.motion.proportions import STATURE
from shellform.motion.wearer import Wearer

from .scene import Scene

if TYPE_CHECKING:
    from contact.body.skinned_surface import SkinnedSurface


def skin_of_scene(scene: Scene, wearer: Wearer) -> SkinnedSurface | None:
    """Closed surface of triangles around the wearer, or None for a body of ellipsoids.

    A scan keeps the girths that the scene does not give; a body of the installed files takes those
    of the person's size.

    Raises
    ------
    Mendable where the installed files are missing; ValueError, FileNotFoundError for a scan or
    girths that are wrong
    """
    person = scene.person
    if person.body == "ellipsoids":
        return None
    # only here: reading, fitting and skinning bodies loads and compiles what ellipsoids do not need
    from pathlib import Path

    from shellform.motion.body_mesh.fitting import asked_girths
    from shellform.motion.body_mesh.scan import scan
    from shellform.motion.body_mesh.skin import skin_of
    from shellform.motion.body_mesh.template import template

    stature = person.stature or wearer.recording.facts.get("stature")
    if person.body == "mesh" or Path(person.body).is_dir():
        body = template(person.sex, None if person.body == "mesh" else person.body)
        stature = stature or STATURE
        return skin_of(wearer, body, stature, asked_girths(stature, person.mass, person.girths))
    body = scan(person.body)
    return skin_of(wearer, body, stature or body.stature, person.girths)
