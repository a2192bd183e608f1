# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fabrics: laws, plies, measured stiffness, cards. Eqs. 11 and 12, Fig. 3 of the paper."""
