# SPDX-License-Identifier: LGPL-3.0-or-later
"""Reading and writing surfaces, named groups."""
