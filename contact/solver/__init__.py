# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a body does to points in a step: planes, nearest step, friction. Eqs. 15 and 16."""
