# SPDX-License-Identifier: LGPL-3.0-or-later
"""Equilibrium paths F(x, level) = 0 past limit points and snap-backs, Eq. 13 without inertia.

What grows along the path is the load level: of loads, or of displacements that supports prescribe.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from shellform.errors import NotConverged
from shellform.fem.partition import Place
from shellform.fem.shell import Shell
from shellform.fem.supports import AXES, unit

from .arc_length import ArcLength
from .equilibrium import Equilibrium
from .newton import Newton
from .path import Path, PathState
from .path_recorder import PathRecorder
from .rigid_modes import refuse_free_motions
from .step_control import End, StepControl

AHEAD = 0.01  # of the displacements so far: the first step in which a limit point is looked for


def follow(
    shell: Shell,
    to_level: float = 1.0,
    *,
    to_displacement: tuple[Place, str | ArrayLike, float] | None = None,
    watch: Mapping[str, Place] | None = None,
    first: float | None = None,
    iterations: int = 5,
    longest: float = np.inf,
    max_steps: int = 500,
    keep_states: bool = False,
    start: PathState | None = None,
    prefix: str = "shell_",
    mip: bool = True,
) -> Path:
    """Follow the equilibrium path of a shell, through limit points and snap-backs.

    All ranks call it, all get the path. The shell is left where the path ends.

    Parameters
    ----------
    shell : Shell, with supports and loads complete
    to_level : float, load level that ends the path, which is met exactly
    to_displacement : (place, direction, value), ends the path too: the mean displacement [m] of the
        nodes of a place along "x", "y", "z" or a vector (3,), which is met exactly
    watch : name -> place (see `Partition.find`), whose displacements and reactions the path records
    first : float, change of the level in the first step, which gives the direction;
        None: a twentieth of the way to `to_level`
    iterations : int, desired for each step: more make steps longer
    longest : float [m], bound of a step, root mean square of the displacements over the sheet
    max_steps : int, ends the path too
    keep_states : bool, keep the whole sheet at every point, not at the last one only
    start : PathState to go on from, of this shell or of one like it; None: the reference state
    prefix : str, of the PETSc options: `snes_rtol`, `snes_max_it`, `snes_monitor`, `ksp_...`,
        `pc_...` as in `Statics`
    mip : bool, see `Equilibrium`

    Raises
    ------
    ValueError for a goal that is no finite number or is met at the start, where supports leave
    a rigid motion free, and for a `start` of cloth with friction inside; NotConverged where no step
    is short enough, with `path` up to there

    Notes
    -----
    Riks, Int. J. Solids Struct. 15 (1979); Crisfield, Comput. Struct. 13 (1981).

    Examples
    --------
    >>> import meshes, shellform as sf
    >>> surface = meshes.rectangle(0.1, 0.02, (4, 1))
    >>> shell = sf.Shell(surface, sf.Fabric.isotropic(1e6, 0.3, 1e-3, 400.0))
    >>> shell.supports.clamp("left")
    >>> shell.loads.line("right", (0.0, 0.0, 1e-2))
    >>> path = sf.follow(shell, watch={"corner": (0.1, 0.0, 0.0)})
    >>> print(path.stopped, path.levels[-1])
    level 1.0
    """
    refuse_free_motions(shell)
    if iterations < 2 or max_steps < 1 or not longest > 0.0:
        raise ValueError(
            "iterations must be 2 or more, max_steps 1 or more, and longest positive, not "
            f"{iterations}, {max_steps} and {longest}"
        )
    if start is not None and shell.fabric.friction is not None:
        raise ValueError(
            "a path of cloth with friction inside hangs on its past: follow it from the reference "
            "state, without `start`"
        )
    equilibrium = Equilibrium(shell, mip)
    newton = Newton(equilibrium, prefix)
    arc = ArcLength(equilibrium, newton)
    try:
        if start is not None:
            start.put(shell)
            equilibrium.adopt()
            arc.moved = start.moved[shell.partition.owned_nodes]
        equilibrium.start(0.0 if start is None else start.level)
        ends = _ends(equilibrium, to_level, to_displacement)
        if first is None:
            first = 0.05 * (to_level - equilibrium.level)
        if not np.isfinite(first) or first == 0.0:
            raise ValueError(f"the first step changes the level by a finite number, not {first}")
        record = PathRecorder(equilibrium, watch or {}, keep_states)
        control = StepControl(arc, float(first), iterations, longest)
        while len(record.levels) <= max_steps:
            try:
                end = control.next(ends)
            except NotConverged as error:
                error.path = record.path("not converged")
                raise
            shell.keep_slips()
            record.add(arc)
            if end:
                break
        record.end(arc)
        return record.path(end or "steps")
    finally:
        arc.destroy()
        newton.destroy()
        equilibrium.destroy()


def _ends(equilibrium, to_level, to_displacement):
    """The conditions that end a path, none of them met at the present point."""
    nowhere = np.zeros((equilibrium.n_owned, 3))
    ends = [End("level", nowhere, 1.0, float(to_level))]
    if to_displacement is not None:
        place, direction, value = to_displacement
        if isinstance(direction, str):
            if direction not in AXES:
                raise ValueError(f"a direction is x, y, z or a vector, not '{direction}'")
            direction = np.eye(3)[AXES[direction]]
        partition = equilibrium.shell.partition
        nodes = partition.find(place)
        own = np.isin(partition.owned_nodes, nodes)
        world = np.where(own[:, None], unit(direction) / len(nodes), 0.0)
        ends.append(End("displacement", equilibrium.along_axes(world), 0.0, float(value)))
    for end in ends:
        ahead = end.ahead(equilibrium)
        if not np.isfinite(ahead) or ahead == 0.0:
            raise ValueError(
                f"a path must end at a finite {end.name} where it does not begin, not {end.value}"
            )
    return ends


def limit_ahead(equilibrium: Equilibrium, newton: Newton, sense: float) -> float | None:
    """Level at which the path turns just ahead of the present state; None where it does not.

    The state is kept. `sense` : sign of the level's change
    """
    eq = equilibrium
    level, state = eq.level, eq.state()
    arc = ArcLength(eq, newton)
    try:
        u = eq.x.array_r.reshape(-1, 5)[:, :3]
        (size,) = arc.inner((u, u))
        if size == 0.0 or not arc.find_tangent(sense):
            return None
        arc.moved = AHEAD * np.sqrt(size) * arc.tangent[0]
        record, control = PathRecorder(eq, {}, False), StepControl(arc, sense, 5, np.inf)
        for _ in range(10):
            control.next([])
            record.add(arc)
            if sense * arc.tangent[1] < 0.0:
                return next(iter(record.path("limit").limit_levels().tolist()), None)
        return None
    except NotConverged:
        return None
    finally:
        eq.level = level
        eq.restore(state)
        arc.destroy()
