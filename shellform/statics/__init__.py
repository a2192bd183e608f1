# SPDX-License-Identifier: LGPL-3.0-or-later
"""Equilibrium: residual and tangent, Newton, load stepping, paths by arc length, buckling."""
