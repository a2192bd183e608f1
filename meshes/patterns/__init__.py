"""Flat sewing patterns: read, meshed panel by panel, placed about a body, sewn.

A sewn garment is a `meshes.Surface` whose cells know their shape in the flat panels, `flat`.
"""
# SPDX-License-Identifier: LGPL-3.0-or-later

from meshes.surface import Surface

from .pattern import Edge, Panel, SewingPattern, Stitch
from .placing import Axis
from .read import read_pattern
from .relax import StandingBody
from .sewing import sew

__all__ = [
    "Axis",
    "Edge",
    "Panel",
    "SewingPattern",
    "StandingBody",
    "Stitch",
    "Surface",
    "read_pattern",
    "sew",
]
