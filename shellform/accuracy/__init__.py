# SPDX-License-Identifier: LGPL-3.0-or-later
"""Error against cost: power laws measured, and choices of cells by them."""
