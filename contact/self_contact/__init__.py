# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a sheet of triangles does to itself in explicit steps; arrays only."""
