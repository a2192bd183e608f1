# SPDX-License-Identifier: LGPL-3.0-or-later
"""Error against cost: the laws measured, and choices by them."""
