# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact of a sheet with a body under explicit and implicit steps. Eqs. 15 and 16."""
