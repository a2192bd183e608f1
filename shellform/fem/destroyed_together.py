# SPDX-License-Identifier: LGPL-3.0-or-later
"""PETSc's solvers are destroyed by all their ranks at once; Python frees what owns them at will.

A solver holds what MUMPS keeps on every rank, and giving that back is collective: a rank whose
collector comes first would wait in it for others, which are elsewhere. So where there are several
ranks, a freed owner only notes that its solver is no longer wanted. Solvers that no rank wants are
destroyed when the same ranks make the next one, the rest at exit, before PETSc is finalised, in the
order in which they were made; that order is the same on all of them.
"""

import atexit
import weakref
from typing import Any

from mpi4py import MPI
from petsc4py import PETSc

Ranks = tuple[int, ...]  # of MPI's world, that share solvers

_solvers: dict[Ranks, dict[int, PETSc.Object]] = {}  # those that exist, by number
_unwanted: dict[Ranks, set[int]] = {}  # numbers of those whose owner was freed on this rank
_made: dict[Ranks, int] = {}


def destroy_with(owner: Any, solver: PETSc.Object, comm: MPI.Comm) -> None:
    """Destroy a solver once its owner is freed, on one rank at once. Collective on `comm`."""
    if comm.size == 1:
        weakref.finalize(owner, solver.destroy)  # at exit too
        return
    ranks = _world_ranks(comm)
    unwanted = _unwanted.setdefault(ranks, set())
    destroy_unwanted(comm)
    number = _made[ranks] = _made.get(ranks, 0) + 1
    _solvers.setdefault(ranks, {})[number] = solver
    freed = weakref.finalize(owner, unwanted.add, number)
    freed.atexit = False  # type: ignore[misc]  # a property, which mypy does not see


def destroy_unwanted(comm: MPI.Comm) -> int:
    """Destroy the solvers of these ranks that none of them wants; how many. Collective."""
    ranks = _world_ranks(comm)
    unwanted = _unwanted.get(ranks, set())
    by_all = set.intersection(*comm.allgather(set(unwanted)))
    for number in sorted(by_all):
        _solvers[ranks].pop(number).destroy()
        unwanted.discard(number)
    return len(by_all)


@atexit.register
def _destroy_all() -> None:
    for _, solvers in sorted(_solvers.items()):
        while solvers:
            solvers.pop(min(solvers)).destroy()


def _world_ranks(comm: MPI.Comm) -> Ranks:
    return tuple(comm.allgather(MPI.COMM_WORLD.rank))
