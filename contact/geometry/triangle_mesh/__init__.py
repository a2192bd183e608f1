# SPDX-License-Identifier: LGPL-3.0-or-later
"""Closed surfaces of triangles: checks, tree of boxes, closest points, smooth normals."""
