# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bodies of triangles: read, brought to the wearer's joints and girths, and rigged to segments."""
