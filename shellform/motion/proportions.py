# SPDX-License-Identifier: LGPL-3.0-or-later
"""Proportions of the body that gait, standing pose and ellipsoids share.

Lengths are those at a stature of 1.755 m, the median of ANSUR II men (Gordon et al., NATICK/
TR-15/007, 2014), and scale with stature. Thigh 0.242 and shank 0.239 of it: between what the
heights of trochanterion, epicondyle and malleolus there give (0.233, 0.238) and de Leva, J.
Biomech. 29, 1996 (0.2425, 0.2493). Foot 0.152: Drillis and Contini, 1966. Feet wear shoes.
"""

STATURE = 1.755  # [m]
LENGTHS = {"pelvis": 0.100, "thigh": 0.425, "shank": 0.420, "foot": 0.267}  # |J2 - J1| [m]
LEG = LENGTHS["thigh"] + LENGTHS["shank"]
HIP_SPACING = 0.170  # of the hip centres [m]
MARKERS = {"pelvis": 0.090, "thigh": 0.060, "shank": 0.048, "foot": 0.050}  # M from J1 or J2 [m]
SIGN = {"right": -1.0, "left": 1.0}  # of the outward axis along the walker's left

# foot on the floor [m]
ANKLE = 0.075  # height of the ankle centre above the sole
HEEL, TOE = 0.055, 0.212  # heel end and toe end behind and before the ankle
RIM = 0.035  # height of both ends above the sole
# the same as parts of the leg, for one who is known by the legs alone
ANKLE_UP, ENDS_UP, HEEL_BACK = ANKLE / LEG, RIM / LEG, HEEL / LEG

# thigh and shank over stature, by which a captured leg tells the stature: men (de Leva, 1996)
LEG_OF_STATURE = (0.4222 + 0.4403) / 1.741
