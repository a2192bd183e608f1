# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a run can end with, apart from bad input (ValueError)."""


class NotConverged(RuntimeError):
    """No solution at some load level after every cut-back; the last good state is kept."""


class Unstable(RuntimeError):
    """A step produced numbers that are not finite, or energy from nothing."""


class Stopped(RuntimeError):
    """The run was interrupted; what it had reached is kept, the message says how to go on."""
