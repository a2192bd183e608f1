# SPDX-License-Identifier: LGPL-3.0-or-later
"""The director shell: kinematics, strains, weak form, loads and supports. Eqs. 2 to 10, 13, 14."""
