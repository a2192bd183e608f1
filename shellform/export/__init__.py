# SPDX-License-Identifier: LGPL-3.0-or-later
"""What other programs read of a run."""
