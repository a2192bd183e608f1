# SPDX-License-Identifier: LGPL-3.0-or-later
"""Steps in time: explicit and implicit Newmark, mass and springs. Sec. 3.1.3, Fig. 1."""
