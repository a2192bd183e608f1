# SPDX-License-Identifier: LGPL-3.0-or-later
"""The particle model: masses and springs in symplectic Euler steps, Secs. 2.1 and 3 of the paper.

The steps are those of explicit.py, of which symplectic Euler is another writing (velocities at half
steps, the first kick half as long); the forces come from springs.py. Provot's limit (Proc. Graphics
Interface, 1995) shortens structural and shear springs that would end a step beyond it, before the
parts see the velocities, so that contact has the last word. The impulses go along the spring by
inverse masses: momentum is kept, angular momentum to the turn of the spring in a step.

Directors are the surface's normals, brought up to date at output. Friction inside the cloth is in
the strains of cells (spring_friction.py), as in a shell, which can take it over.
"""

from typing import Any, NamedTuple

import numpy as np

from contact.kernel import kernel
from shellform.fem.cell_membrane import cell_warp
from shellform.fem.dolfinx_compat import cell_nodes
from shellform.fem.shell import Shell
from shellform.material.energy import StVenant

from .explicit import Newmark, check_settings
from .springs import Springs


class Limit(NamedTuple):
    """Provot's limit.

    bound : float, greatest length of a spring over that at rest
    slack : float, excess of strain at which the sweeps end; sweeps : int, at most
    fixed : (n,) bool, nodes that supports hold; shift : (n, 3), scratch
    """

    bound: float
    slack: float
    sweeps: int
    fixed: np.ndarray
    shift: np.ndarray


@kernel
def limit(
    x: np.ndarray,
    w: np.ndarray,
    v: np.ndarray,
    dt: float,
    table: np.ndarray,
    bound: float,
    slack: float,
    sweeps: int,
    fixed: np.ndarray,
    shift: np.ndarray,
    mass: np.ndarray,
    r: np.ndarray,
    impulse: np.ndarray,
    kicked: float,
) -> None:
    """Change velocities v so that springs end the step below their bound.

    What held ends pass on is added to the supports' impulse; what nodes get is taken off the
    internal forces that have kicked them over `kicked` seconds, so that it is booked with these.

    Parameters
    ----------
    x, w : (n, 3), (n, >= 3), reference positions and displacements [m]; v : (n, 3) [m/s], changed
    dt, kicked : float [s]; table : (s,) SPRING; bound, slack, sweeps, fixed, shift : see Limit
    mass : (n,) [kg]; r (n, 6) [N], impulse (n, 3) [N s] : of the kick, see Forces; changed
    """
    shift[:] = 0.0
    d = np.empty(3)
    moved = False
    for _ in range(sweeps):
        worst = 0.0
        for s in range(len(table)):
            i, j, rest = table[s].ends[0], table[s].ends[1], table[s].rest
            square = 0.0
            for c in range(3):
                d[c] = x[j, c] - x[i, c] + w[j, c] - w[i, c]
                d[c] += dt * (v[j, c] - v[i, c]) + shift[j, c] - shift[i, c]
                square += d[c] * d[c]
            over = np.sqrt(square) - bound * rest
            a = 0.0 if fixed[i] else 1.0 / mass[i]
            b = 0.0 if fixed[j] else 1.0 / mass[j]
            if over <= 0.0 or a + b == 0.0:
                continue
            worst, moved = max(worst, over / rest), True
            push = over / (np.sqrt(square) * (a + b))
            for c in range(3):
                shift[i, c] += a * push * d[c]
                shift[j, c] -= b * push * d[c]
                # a held end passes its share on to the support
                if fixed[i]:
                    impulse[i, c] -= push * d[c] / dt
                if fixed[j]:
                    impulse[j, c] += push * d[c] / dt
        if worst <= slack:
            break
    if moved:
        for i in range(len(mass)):
            for c in range(3):
                v[i, c] += shift[i, c] / dt
                r[i, c] -= mass[i] * shift[i, c] / (dt * kicked)


class Particles(Newmark):
    """Explicit steps of masses and springs; state, supports and loads are those of a shell.

    Parameters
    ----------
    shell : Shell of 4-node quads on one rank; none of its forms is compiled
    bending, curvature : see springs.Springs
    strain_limit : float or None, Provot's limit, 0.1 in his paper
    limit_slack : float, excess of strain at which its sweeps end; limit_sweeps : int, at most
    others : see Newmark; damping is that of each spring, along it

    Examples
    --------
    >>> import meshes, shellform as sf
    >>> fabric = sf.Fabric.isotropic(1e5, 0.3, 1e-3, 200.0)
    >>> shell = sf.Shell(meshes.rectangle(0.4, 0.4, (4, 4)), fabric)
    >>> shell.loads.gravity()
    >>> stepper = sf.Particles(shell)
    >>> stepper.advance(0.1)
    >>> f"{shell.displacements()[:, 2].mean():.3f} m"
    '-0.049 m'
    """

    def __init__(
        self, shell: Shell, time_step_factor: float = 0.9, damping: float = 0.0, drag: float = 0.0,
        *, bending: str = "flexion", curvature: float | None = None,
        strain_limit: float | None = None, limit_slack: float = 5e-3, limit_sweeps: int = 100,
        prefix: str = "particles_",
    ) -> None:  # fmt: skip
        if shell.comm.size > 1:
            raise ValueError(
                "the particle model runs on one rank: its springs reach two cells away, beyond the "
                f"nodes a rank shares, and the strain limit goes from spring to spring; there are "
                f"{shell.comm.size} ranks"
            )
        if shell.loads.pressures or shell.loads.moments:
            raise ValueError("particles carry forces only, no pressure and no moments")
        if type(shell.law) is not StVenant:
            raise ValueError(
                f"springs follow the default law of a sheet, not {shell.law!r}: use Newmark, or "
                "make the shell without `law`"
            )
        check_settings(time_step_factor, damping, drag)
        if strain_limit is not None and not strain_limit > 0:
            raise ValueError(f"a strain limit is above zero, as 0.1, not {strain_limit}")
        partition, cells = shell.partition, shell.surface.cells
        self._cells = partition.local(cells.ravel()).reshape(cells.shape)
        points = np.ascontiguousarray(partition.surface.points[partition.owned_nodes])
        springs = Springs(
            shell.surface, self._cells, points, shell.fabric, bending, curvature, damping,
            _friction(shell, points), shell.surface.flat,
        )  # fmt: skip
        super().__init__(shell, time_step_factor, damping, drag, 0.0, prefix, springs)
        self._limit: Limit | None = None
        self._limited = springs.table[: springs.limited]
        if strain_limit is not None:
            self._limit = Limit(
                1 + strain_limit, limit_slack, limit_sweeps, self.held[:, :3].any(axis=1),
                np.zeros((self.n_owned, 3)),
            )  # fmt: skip
        normals = self.normals()[0]
        # +1 or -1 a node: the side of the sheet on which the shell's directors are
        self._side = np.sign(np.sum(normals * self.owned[:, 3:], axis=1))[:, None]

    def describe(self) -> dict[str, Any]:
        """See Stepper."""
        plan = super().describe()
        return {"terms": plan.pop("terms"), "loads": self.shell.loads.kinds()} | plan

    def kick(self, kicked: float, dt: float) -> None:
        """Velocities by the forces, the supports, then the strain limit."""
        super().kick(kicked, dt)
        if self._limit is not None:
            limit(
                self.points, self.owned, self.v, dt, self._limited, *self._limit, self.mass,
                self.forces.internal, self.forces.support, kicked,
            )  # fmt: skip

    def advance(self, until: float) -> None:
        """Step until a time [s] is reached exactly; directors follow the surface."""
        super().advance(until)
        self.owned[:, 3:], _ = self.directors(None)

    def directors(self, v: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
        """Unit normals (n, 3) on the side of the shell's directors, their rates at velocities v."""
        d, rate = self.normals(v)
        return self._side * d, self._side * rate

    def normals(self, v: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Unit normals (n, 3), weighted by area, and with velocities v their rates [1/s]."""
        cells = self._cells
        x = (self.points + self.owned[:, :3])[cells]
        one, two = x[:, 2] - x[:, 0], x[:, 3] - x[:, 1]
        N, rate = np.zeros_like(self.points), np.zeros_like(self.points)
        for side in range(4):
            np.add.at(N, cells[:, side], np.cross(one, two))
        size = np.linalg.norm(N, axis=1, keepdims=True)
        N /= size
        if v is not None:
            u = v[cells]
            turn = np.cross(u[:, 2] - u[:, 0], two) + np.cross(one, u[:, 3] - u[:, 1])
            for side in range(4):
                np.add.at(rate, cells[:, side], turn)
            rate = (rate - np.sum(rate * N, axis=1, keepdims=True) * N) / size
        return N, rate


def _friction(shell, points):
    """Friction inside the cloth, its cells in the shell's order; None for a fabric without."""
    if shell.fabric.friction is None:
        return None
    # only here: kernels that other fabrics do not need
    from .spring_friction import SpringFriction

    warp = cell_warp(shell.surface, shell.fabric, shell.partition)
    directors = shell.reference.x.array.reshape(-1, 6)[:, 3:]
    cells, flat = cell_nodes(shell.space), shell.partition.flat
    return SpringFriction(points, directors, cells, warp, shell.fabric, flat)


def hand_over(particles: Particles, newmark: Newmark) -> None:
    """Give positions, velocities and time to a Newmark stepper of the same surface.

    Where both have a contact, what is touched is handed over too. Directors and their rates are
    those of the surface's normals; held directors go back to rest, as particles know none and let
    them follow the normals.

    Sliders inside the cloth bear in the shell what they bore before, and what they have lost stays
    booked. Their slips are not copied: strains of a shell, of arcs and directors, are not quite
    those of springs, and sliders, stiff as they are, would make stress of the difference. Nor do
    they start unloaded, as the folds that friction holds would open. Where the shell's fabric has
    other friction, what its sliders bear is not known, and they start unloaded.
    """
    newmark.shell.claim(newmark)
    v, _ = particles.velocities()
    d, q = particles.directors(v)
    free = ~newmark.held[:, 3]
    rest = newmark.shell.reference.x.array.reshape(-1, 6)[: newmark.n_owned, 3:]
    newmark.owned[~free, 3:] = rest[~free]
    newmark.owned[:, :3], newmark.v[:] = particles.owned[:, :3], v
    newmark.owned[free, 3:] = d[free]
    newmark.q[:] = np.where(free[:, None], q, 0.0)
    newmark.time, newmark.clock.last_dt = particles.time, 0.0
    newmark.scatter()
    _take_over_friction(particles, newmark)
    newmark.check_step()
    if particles.contact is not None and newmark.contact is not None:
        newmark.contact.set_touched(particles.contact.touched())


def _take_over_friction(particles, stepper):
    """Let the sliders of a stepper's shell bear what those of particles do."""
    shell, before = stepper.shell, particles.force_model.friction
    if shell.fabric.friction is None:
        return
    same = shell.fabric.friction == particles.shell.fabric.friction
    lost = before.lost if same else 0.0
    shell.cell_stress.bear(stepper.w, before.borne(particles.w) if same else None, lost)
