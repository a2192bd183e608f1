# SPDX-License-Identifier: LGPL-3.0-or-later
"""Proportions of the walker that all synthetic motion shares."""

# At a stature of 1.755 m, the median of ANSUR II men. Thigh 0.242 and shank 0.239 of it: between
# what the heights of trochanterion, epicondyle and malleolus there give (0.233, 0.238) and
# de Leva, J. Biomech. 29, 1996 (0.2425, 0.2493). Foot 0.152: Drillis and Contini, 1966.
STATURE = 1.755
LENGTHS = {"pelvis": 0.100, "thigh": 0.425, "shank": 0.420, "foot": 0.267}  # [m]
HIP_SPACING = 0.170  # [m]
MARKERS = {"pelvis": 0.090, "thigh": 0.060, "shank": 0.048, "foot": 0.050}  # M from J1 or J2 [m]
LEG = LENGTHS["thigh"] + LENGTHS["shank"]
SIGN = {"right": -1.0, "left": 1.0}  # of the outward axis along the walker's left
