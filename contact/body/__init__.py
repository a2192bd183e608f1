# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bodies of segments and how they move. Eqs. 15 and 17."""
