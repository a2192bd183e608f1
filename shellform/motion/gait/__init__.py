# SPDX-License-Identifier: LGPL-3.0-or-later
"""A walk over an obstacle without a capture."""
