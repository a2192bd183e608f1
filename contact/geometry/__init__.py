# SPDX-License-Identifier: LGPL-3.0-or-later
"""Shapes of bodies: closest points, normals, patches. Eq. 15."""
