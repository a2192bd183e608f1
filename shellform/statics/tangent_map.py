# SPDX-License-Identifier: LGPL-3.0-or-later
"""The map P of Eq. 10 (H in the paper) as a sparse matrix: from 5 unknowns a node to (u, d)."""

from petsc4py import PETSc

import numpy as np

from shellform.fem.shell import Shell


class TangentMap:
    """P with columns of held unknowns left out.

    Rows of a displacement hold one entry, or three where a node's axes are inclined; rows of a
    director hold two. The pattern is made once, `at` fills in the frames.

    Parameters
    ----------
    shell : Shell, with its supports
    length : float [m], by which rotations are scaled
    turning : bool, True: axes of nodes may change, see `turn`; rows of displacements hold three
    """

    def __init__(self, shell: Shell, length: float, turning: bool = False):
        n, supports = shell.partition.n_owned, shell.supports
        first = shell.space.dofmap.index_map.local_range[0]
        self._free = ~supports.held[:n]
        self._length = length
        inclined, Q = supports.inclined[:n] | turning, supports.Q[:n]
        width = np.where(inclined, 3, 1)
        counts = np.column_stack([width, width, width, *np.full((3, n), 2)]).ravel()
        self._indptr = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
        self._columns = np.empty(self._indptr[-1], np.int32)
        self._values = np.zeros(self._indptr[-1])
        self._start = self._indptr[:-1].reshape(n, 6)
        column = 5 * (first + np.arange(n))
        for i in range(3):
            upright, leaning = self._start[~inclined, i], self._start[inclined, i]
            self._columns[upright] = column[~inclined] + i
            self._values[upright] = self._free[~inclined, i]
            for j in range(3):
                self._columns[leaning + j] = column[inclined] + j
                self._values[leaning + j] = Q[inclined, j, i] * self._free[inclined, j]
            for j in range(2):
                self._columns[self._start[:, 3 + i] + j] = column + 3 + j
        self.matrix = PETSc.Mat().createAIJ(
            ((6 * n, None), (5 * n, None)),
            csr=(self._indptr, self._columns, self._values),
            comm=shell.comm,
        )

    def turn(self, Q: np.ndarray, free: np.ndarray) -> None:
        """Take axes Q (n_owned, 3, 3) and the unknowns that are free (n_owned, 5)."""
        self._free = free
        for i in range(3):
            for j in range(3):
                self._values[self._start[:, i] + j] = Q[:, j, i] * free[:, j]

    def at(self, T: np.ndarray) -> PETSc.Mat:
        """The matrix with director frames T (at least n_owned, 3, 2)."""
        T = T[: len(self._start)] * self._free[:, None, 3:] / self._length
        for i in range(3):
            for j in range(2):
                self._values[self._start[:, 3 + i] + j] = T[:, i, j]
        self.matrix.setValuesCSR(self._indptr, self._columns, self._values)
        self.matrix.assemble()
        return self.matrix
