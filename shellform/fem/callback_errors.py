# SPDX-License-Identifier: LGPL-3.0-or-later
"""Errors of the functions that PETSc calls back, as they were raised.

petsc4py of PETSc 3.18 lets them through; 3.22 and 3.25 hand out a PETSc.Error, code -1 or 101, with
the original as its cause: `Unstable` would then never reach what cuts the step back, nor Ctrl-C end
a run.
"""

from collections.abc import Iterator
from contextlib import contextmanager

from petsc4py import PETSc


@contextmanager
def exceptions_as_raised() -> Iterator[None]:
    """Let exceptions of functions that PETSc calls back come out as they were raised."""
    original: BaseException | None = None
    try:
        yield
    except PETSc.Error as error:
        original = error
        while isinstance(original, PETSc.Error) and original.__cause__ is not None:
            original = original.__cause__
    if original is not None:
        raise original
