"""Surfaces of garments as plain arrays: panels, imported files, repair and named edges.

Nothing here knows finite elements. Lengths are in m; a Surface has passed `check` when it exists.
"""
# SPDX-License-Identifier: LGPL-3.0-or-later

from meshes.files.load import load, save
from meshes.garments import GARMENTS, Pattern
from meshes.garments.placing import upright, waist_by_shape
from meshes.garments.prepare import prepare_garment, regions
from meshes.garments.sleeve_and_skirt import skirt, sleeve
from meshes.garments.trousers import SIZES, trousers
from meshes.shapes.panel import (
    annulus,
    cylinder,
    disc,
    distorted,
    from_outline,
    patch,
    rectangle,
    skewed,
    spherical_cap,
)

from .geometry import nodal_normals
from .repair import (
    boundary_loops,
    clean,
    elevate,
    merge_duplicates,
    orient,
    scaled_jacobian,
    split_triangles,
    to_triangles,
)
from .surface import MeshError, Surface, check

__all__ = [
    "GARMENTS",
    "SIZES",
    "MeshError",
    "Pattern",
    "Surface",
    "annulus",
    "boundary_loops",
    "check",
    "clean",
    "cylinder",
    "disc",
    "distorted",
    "elevate",
    "from_outline",
    "load",
    "merge_duplicates",
    "nodal_normals",
    "orient",
    "patch",
    "prepare_garment",
    "rectangle",
    "regions",
    "save",
    "scaled_jacobian",
    "skewed",
    "skirt",
    "sleeve",
    "spherical_cap",
    "split_triangles",
    "to_triangles",
    "trousers",
    "upright",
    "waist_by_shape",
]
