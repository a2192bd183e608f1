# SPDX-License-Identifier: LGPL-3.0-or-later
"""A scene from plan to summary: check, run, resume."""
