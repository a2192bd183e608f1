# SPDX-License-Identifier: LGPL-3.0-or-later
"""The particle model: masses and springs in symplectic Euler steps, Secs. 2.1 and 3 of the paper.

The steps are those of newmark.py, of which symplectic Euler is another writing (velocities at half
steps, the first kick half as long); the forces come from springs.py. Provot's limit (Proc. Graphics
Interface, 1995) shortens structural and shear springs that would end a step beyond it, before the
parts see the velocities, so that contact has the last word. The impulses go along the spring by
inverse masses: momentum is kept, angular momentum to the turn of the spring in a step.

Directors are the surface's normals, brought up to date at output.
"""

import numpy as np

from contact.kernel import kernel

from .explicit import Newmark, check_settings
from .explicit_kernels import work_over
from .springs import Springs
from .time_stepper import Stepper


@kernel
def limit(
    x, w, v, dt, pairs, rest, count, bound, slack, sweeps, mass, fixed, shift, impulse, r, kicked
):  # fmt: skip
    """Change velocities v so that springs end the step below bound.

    What held ends pass on is added to the supports' impulse; what nodes get is taken off the
    internal forces r that have kicked them over `kicked` seconds, so that it is booked with these.
    """
    shift[:] = 0.0
    d = np.empty(3)
    moved = False
    for _ in range(sweeps):
        worst = 0.0
        for s in range(count):
            i, j = pairs[s, 0], pairs[s, 1]
            square = 0.0
            for c in range(3):
                d[c] = x[j, c] - x[i, c] + w[j, c] - w[i, c]
                d[c] += dt * (v[j, c] - v[i, c]) + shift[j, c] - shift[i, c]
                square += d[c] * d[c]
            over = np.sqrt(square) - bound * rest[s]
            a = 0.0 if fixed[i] else 1.0 / mass[i]
            b = 0.0 if fixed[j] else 1.0 / mass[j]
            if over <= 0.0 or a + b == 0.0:
                continue
            worst, moved = max(worst, over / rest[s]), True
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
    """

    def __init__(
        self, shell, time_step_factor=0.9, damping=0.0, drag=0.0, *, bending="flexion",
        curvature=None, strain_limit=None, limit_slack=5e-3, limit_sweeps=100, prefix="particles_",
    ):  # fmt: skip
        if shell.comm.size > 1:
            raise ValueError(
                "the particle model runs on one rank: its springs reach two cells away, beyond the "
                f"nodes a rank shares, and the strain limit goes from spring to spring; there are "
                f"{shell.comm.size} ranks"
            )
        if shell.loads.pressures or shell.loads.moments:
            raise ValueError("particles carry forces only, no pressure and no moments")
        check_settings(time_step_factor, damping, drag)
        if strain_limit is not None and not strain_limit > 0:
            raise ValueError(f"a strain limit is above zero, as 0.1, not {strain_limit}")
        partition = shell.partition
        self._cells = partition._local[shell.surface.cells]
        points = np.ascontiguousarray(partition.surface.points[partition.owned_nodes])
        springs = Springs(shell.surface, self._cells, points, shell.fabric, bending, curvature)
        # not Newmark's own start, which compiles the shell's force
        Stepper.__init__(self, shell, 0.0, prefix)
        self._shift = np.zeros((self.n_owned, 3))
        self._set_supports()
        self.held[:, 3], self.plane[:] = True, 0.0
        self._fixed = self.held[:, :3].any(axis=1)
        self.strain_limit, self._sweeping = strain_limit, (limit_slack, limit_sweeps)
        self._side = np.sign(np.sum(self._normals()[0] * self.owned[:, 3:], axis=1))[:, None]
        self._start(springs, time_step_factor, damping, drag)

    def strain_energy(self):
        """Strain energy [J] by kind of spring."""
        return self.internal.energy(self.w)

    def internal_force(self):
        """Forces of the springs (n, 6) [N], damped, at present."""
        return self.internal(self.owned, self.v, self.damping)

    def _damping_loss(self, dt):
        return 0.0  # booked spring by spring, see `_book`

    def _book(self, dt):
        super()._book(dt)
        if self.damping:
            self.works[4] += work_over(self.internal.viscous, self.v_old, self.v, dt)

    def _present(self):
        v, q, works = super()._present()
        if self.damping:
            works[4] += work_over(self.internal.viscous, self.v, v, 0.5 * self.last_dt)
        return v, q, works

    def find_stable_step(self, iterations=30):
        """See Newmark; buckling springs count with the slope they start with, on both sides."""
        self.internal.linear = True
        try:
            return super().find_stable_step(iterations)
        finally:
            self.internal.linear = False

    def kick(self, dt):
        """Velocities over dt by the forces, the supports, then the strain limit."""
        super().kick(dt)
        if self.strain_limit is None:
            return
        springs = self.internal
        limit(
            self.points, self.owned, self.v, self._next, springs.pairs, springs.rest,
            springs.limited, 1 + self.strain_limit, *self._sweeping, self.mass, self._fixed,
            self._shift, self.support_impulse, self.r, dt,
        )  # fmt: skip

    def _follow(self, dt, kicked):
        super()._follow(dt, kicked)
        self.q[:] = 0.0  # directors are not moved

    def advance(self, until):
        """Step until a time [s] is reached exactly; directors follow the surface."""
        super().advance(until)
        self.owned[:, 3:] = self._side * self._normals()[0]

    def _normals(self, v=None):
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


def hand_over(particles, newmark):
    """Give positions, velocities and time to a Newmark stepper of the same surface.

    Where both have a contact, what is touched is handed over too. Directors and their rates are
    those of the surface's normals; held directors go back to rest, as particles know none and let
    them follow the normals.
    """
    v, _ = particles.velocities()
    d, q = particles._normals(v)
    free = ~newmark.held[:, 3]
    rest = newmark.shell.reference.x.array.reshape(-1, 6)[: newmark.n_owned, 3:]
    newmark.owned[~free, 3:] = rest[~free]
    newmark.owned[:, :3], newmark.v[:] = particles.owned[:, :3], v
    newmark.owned[free, 3:] = (particles._side * d)[free]
    newmark.q[:] = np.where(free[:, None], particles._side * q, 0.0)
    newmark.time, newmark.last_dt = particles.time, 0.0
    newmark.scatter()
    newmark.check_step()
    if particles.contact is not None and newmark.contact is not None:
        newmark.contact.set_touched(particles.contact.touched())
