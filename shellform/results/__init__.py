# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a run leaves: ledger, joint torque, skin pressure, files. Figs. 9 and 10."""
