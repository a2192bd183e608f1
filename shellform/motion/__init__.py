# SPDX-License-Identifier: LGPL-3.0-or-later
"""The moving wearer: captures, synthetic gait, sizes of the body. Sec. 3.3, Eq. 17."""
