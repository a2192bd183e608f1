# SPDX-License-Identifier: LGPL-3.0-or-later
"""Options of PETSc that nothing has asked for: misspelt, or of a solver that is not in use.

PETSc knows which options were looked up; petsc4py hands that out since 3.19 only, so the function
of C is called, PetscOptionsUsed.
"""

import ctypes
from collections.abc import Iterable

PREFIX = "-shell_"  # of our solvers


def unused(words: Iterable[str]) -> list[str]:
    """Those of the words of a command line that are options of our solvers and were not used."""
    names = dict.fromkeys(word for word in words if word.startswith(PREFIX))
    if not names:
        return []
    from petsc4py import PETSc  # only here: it starts PETSc

    was_used = ctypes.CDLL(PETSc.__file__).PetscOptionsUsed
    was_used.argtypes = ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p
    out = []
    for name in names:
        used = ctypes.c_int(0)  # a PetscBool is as large, or a byte
        was_used(None, name[1:].encode("utf-8", "replace"), ctypes.byref(used))
        if not used.value:
            out.append(name)
    return out
