# SPDX-License-Identifier: LGPL-3.0-or-later
"""Buckling loads: where the tangent of Eq. 13 becomes singular, predicted from one equilibrium.

At a state on the path with tangent K, a further change mu of the level makes the tangent

    K + mu K_g,   K_g = d/dmu K(w, stress linearised about w for the change mu dw/dlevel),

of which dw/dlevel = -K^-1 dF/dlevel is the linear answer of the sheet. The least mu > 0 that makes
it singular is the classical buckling load where the state is the unloaded one, and the nearer to
the true one the nearer the state is to it. The eigenvalues of -K_g v = (1/mu) K v are found by
SLEPc's Krylov-Schur method (Hernandez, Roman, Vidal, ACM Trans. Math. Softw. 31, 2005).
"""

from typing import Any, NamedTuple

from petsc4py import PETSc

import numpy as np

from shellform.errors import NotConverged
from shellform.fem import director
from shellform.fem.shell import Shell

from .equilibrium import Equilibrium
from .newton import DEFAULTS, Newton, set_defaults
from .path import PathState
from .rigid_modes import refuse_free_motions

SOLVER = {f"st_{key}": value for key, value in DEFAULTS.items() if not key.startswith("snes")}
# of the length of the sheet, by which it is deformed for K_g: linear for quadratic laws, for others
# the strains must be small, and yet far above roundoff
SMALL = 1e-4
FAR = 1.0  # lengths of the sheet by which its linear answer may move it at a buckling load


class Buckling(NamedTuple):
    """Load levels (m,) at which the sheet buckles, the least first, and its modes (m, n, 3).

    A mode is the displacements in the surface's numbering, the largest of length 1.
    """

    levels: np.ndarray
    modes: np.ndarray


def buckling_loads(
    shell: Shell, count: int = 1, *, start: PathState | None = None, prefix: str = "shell_"
) -> Buckling:
    """Load levels at which a shell buckles, by its stiffness and stress in one state.

    All ranks call it, all get the answer. The shell is left in that state.

    Parameters
    ----------
    shell : Shell, with supports and loads complete
    count : int, how many loads, the least first; fewer are returned where there are fewer before
        the linear answer of the sheet moves it by its own length
    start : PathState, a stable equilibrium under loads; None: the unloaded reference state, which
        gives the classical (linear) buckling loads
    prefix : str, of the options of SLEPc: `eps_...`, `st_ksp_...`, `st_pc_...`

    Raises
    ------
    ImportError where slepc4py is missing; ValueError for a `count` below 1, where the supports
    leave a rigid motion free, and for a state that is not stable; NotConverged

    Examples
    --------
    >>> import meshes, shellform as sf
    >>> shell = sf.Shell(meshes.rectangle(0.4, 0.02, (16, 1)), sf.Fabric.isotropic(1e7, 0, 1e-3, 1))
    >>> shell.supports.clamp("left")
    >>> shell.loads.line("right", (-1.0, 0.0, 0.0))
    >>> try:  # Euler: pi^2 B / (4 L^2)
    ...     print(f"{sf.buckling_loads(shell).levels[0]:.4f} N/m")
    ... except ImportError:
    ...     print("0.0129 N/m")
    0.0129 N/m
    """
    slepc = _slepc()
    if count < 1:
        raise ValueError(f"the number of buckling loads is 1 or more, not {count}")
    refuse_free_motions(shell)
    equilibrium = Equilibrium(shell)
    newton = Newton(equilibrium, prefix)
    try:
        if start is not None:
            start.put(shell)
            equilibrium.adopt()
        level = 0.0 if start is None else start.level
        equilibrium.start(level)
        K, Kg, pace = _stiffnesses(equilibrium, newton)
        try:
            if unstable_directions(K):
                raise ValueError(
                    f"the state at level {level:.6g} is not stable: ask for buckling loads at a "
                    "state before the sheet has buckled"
                )
            # Sylvester's law counts the loads there are: the eigenvalues of none never converge
            far = K.copy()
            far.axpy(-FAR * equilibrium.length / pace, Kg)
            count = min(count, unstable_directions(far))
            far.destroy()
            changes, modes = _eigenpairs(slepc, equilibrium, K, Kg, count, prefix)
        finally:
            K.destroy()
            Kg.destroy()
        return Buckling(level + changes, modes)
    finally:
        newton.destroy()
        equilibrium.destroy()


def unstable_directions(K: PETSc.Mat) -> int:
    """Number of negative eigenvalues of a symmetric matrix: of its pivots (Sylvester), by MUMPS."""
    pc = PETSc.PC().create(K.comm)
    pc.setOperators(K)
    pc.setType("cholesky")
    pc.setFactorSolverType("mumps")
    pc.setUp()
    negative = pc.getFactorMatrix().getMumpsInfog(12)  # negative pivots
    pc.destroy()
    return negative


def _slepc() -> Any:
    """The module slepc4py.SLEPc: an option, which starts PETSc's eigenvalue solvers."""
    try:
        from slepc4py import SLEPc
    except ImportError as error:
        raise ImportError(
            "buckling loads need slepc4py, which is not here: install Debian's or Ubuntu's "
            "python3-slepc4py, or conda's slepc4py, of the release of this petsc4py (the wheel of "
            "PyPI brings it)"
        ) from error
    return SLEPc


def _stiffnesses(eq, newton):
    """Copies of K and of -K_g at the present state, and the displacements [m] of a level of 1."""
    K = eq.tangent(eq.x).copy()
    right, b = eq.x.duplicate(), eq.x.duplicate()
    eq.level_derivative(right)
    right.scale(-1.0)
    ksp = newton.snes.getKSP()
    ksp.setFromOptions()
    ksp.setOperators(K)
    ksp.solve(right, b)
    b.ghostUpdate(addv=PETSc.InsertMode.INSERT, mode=PETSc.ScatterMode.FORWARD)
    with b.localForm() as local:
        rate = local.array_r.reshape(-1, 5) / [1, 1, 1, eq.length, eq.length]
    step = director.push_forward(rate, eq.T, eq.Q)
    size = eq.shell.comm.allreduce(float(np.sum(step[: eq.n_owned, :3] ** 2)))
    size = np.sqrt(size / len(eq.shell.surface.points))
    if not size > 0.0:
        raise ValueError("the loads move nothing: buckling loads are those of loads that do")
    change = SMALL * eq.length / size
    eq.stress_from = (eq.w_base.ravel().copy(), change * step.ravel())
    eq.level += change
    Kg = eq.tangent(eq.x).copy()
    Kg.axpy(-1.0, K, structure=PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
    Kg.scale(-1.0 / change)
    eq.level -= change
    right.destroy()
    b.destroy()
    return K, Kg, size


def _eigenpairs(slepc, eq, K, Kg, count, prefix):
    """Changes mu of the level, the least first, and modes (m, n, 3)."""
    set_defaults(prefix, SOLVER)
    n = len(eq.shell.surface.points)
    if not count:
        return np.empty(0), np.empty((0, n, 3))
    eps = slepc.EPS().create(eq.shell.comm)
    eps.setOptionsPrefix(prefix)
    eps.setOperators(Kg, K)
    loads = eq.shell.loads
    symmetric = not (loads.moments or loads.pressures)
    kinds = slepc.EPS.ProblemType
    eps.setProblemType(kinds.GHEP if symmetric else kinds.GNHEP)
    eps.setWhichEigenpairs(slepc.EPS.Which.LARGEST_REAL)
    eps.setDimensions(count)
    eps.setFromOptions()
    vector = eq.x.duplicate()
    try:
        eps.solve()
        changes, modes = [], []
        if eps.getConverged() < count:
            raise NotConverged(
                f"{eps.getConverged()} of {count} buckling loads were found: raise "
                f"-{prefix}eps_max_it or -{prefix}eps_ncv"
            )
        for i in range(count):
            changes.append(1.0 / eps.getEigenpair(i, vector).real)
            own = eq.in_world(vector.array_r.reshape(-1, 5)[:, :3])
            mode = eq.shell.partition.gather(own)
            modes.append(mode / np.linalg.norm(mode, axis=1).max())
        return np.array(changes), np.array(modes)
    finally:
        vector.destroy()
        eps.destroy()
