# SPDX-License-Identifier: LGPL-3.0-or-later
"""Plain shapes: panels, grids, outlines."""
