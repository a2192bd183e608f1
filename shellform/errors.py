# SPDX-License-Identifier: LGPL-3.0-or-later
"""What can go wrong in a run, by name: in a file of its own, as naming an error loads no solver."""


class NotConverged(RuntimeError):
    """No solution at some load level after every cut-back; the last good state is kept.

    Examples
    --------
    >>> import shellform as sf
    >>> try:
    ...     raise sf.NotConverged("no equilibrium found just beyond level 0.5")
    ... except RuntimeError as error:
    ...     print(error)
    no equilibrium found just beyond level 0.5
    """


class Unstable(RuntimeError):
    """A step produced numbers that are not finite, or energy from nothing.

    Explicit steps are cut back and tried again first; the last good state is kept.

    Examples
    --------
    >>> import shellform as sf
    >>> try:
    ...     raise sf.Unstable("node 7 of rectangle has left the finite numbers")
    ... except sf.Unstable as error:
    ...     print(error)
    node 7 of rectangle has left the finite numbers
    """


class Stopped(RuntimeError):
    """The run was interrupted; what it had reached is kept, the message says how to go on.

    Examples
    --------
    >>> import shellform as sf
    >>> try:
    ...     sf.run(sf.Scene(), "out/walk")  # doctest: +SKIP
    ... except sf.Stopped:  # Ctrl-C was pressed
    ...     sf.resume("out/walk")
    """
