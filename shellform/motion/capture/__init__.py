# SPDX-License-Identifier: LGPL-3.0-or-later
"""From marker files to the motion of segments."""
