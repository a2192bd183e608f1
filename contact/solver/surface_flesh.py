# SPDX-License-Identifier: LGPL-3.0-or-later
"""A moving closed surface of triangles whose flesh gives way, Eqs. 15 and 16 with a bed in series.

As on segments with flesh (flesh_step.py): below each triangle is the bed of the segment that it is
reported to belong to, and a node presses it along the smooth normal under it, with the area that
its mass has of the cloth. Between two parts of the body, and in a crease, a node is met as by a
hard surface (surface_node.py) that is smaller by the depth that it has come to, which follows the
pressure in a time of LAG.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from contact.body.flesh_bed import Flesh
from contact.body.segments import Body
from contact.body.surface_motion import SurfaceMotion
from contact.kernel import kernel

from .bed_push import bed_kernel, touch_side
from .flesh_correction import OnFlesh
from .flesh_step import LAG
from .friction import Friction
from .surface_correction import SurfaceCorrection
from .surface_node import book_surface, surface_node_kernel
from .surface_planes import add_carried
from .surface_step import surface_kernel


@cache
def soft_node_kernel(kinetic_coefficient: Callable) -> Any:
    """Kernel meet_soft(i, x, v, mass, found, ...) of a law of friction, see `surface_node_kernel`.

    beds : records (m,) BED of the owners, (n,) SIDE of the nodes, areal mass of the cloth [kg/m^2],
        (n,) bool, set where a node still lies in flesh; one that nothing pushes in a crease does
    """
    meet_hard = surface_node_kernel(kinetic_coefficient)
    press_planes = bed_kernel(kinetic_coefficient)

    @kernel(makes_arrays=False)
    def in_crease(
        i, x, v, mass, found, second, other, local, last, smooth, asked, highest, work, mesh, start,
        end, planes, over, stack, bounds, owners, acting, beds,
    ):  # fmt: skip
        side, compliance, offset = beds[1][i], work.dt * work.dt / beds[2], work.offset
        beds[3][i] = True
        depth = side.depth if side.owner >= 0 else 0.0
        work.offset = offset - depth
        pushing, near, deep = meet_hard(
            i, x, v, mass, found, second, other, local, last, smooth, asked, highest, work, mesh,
            start, end, planes, over, stack, bounds, owners, acting, (),
        )  # fmt: skip
        work.offset = offset
        if pushing >= 0:
            pressure = 0.0
            for k in range(work.count):
                pressure += planes[k].push / compliance
            side.owner = owners[pushing]
            wanted = pressure / beds[0][side.owner].stiffness
            side.slip = side.relaxing = side.recess = 0.0
            side.depth = depth + (wanted - depth) * min(1.0, work.dt / LAG)
        return pushing, near, deep

    @kernel(makes_arrays=False)
    def meet_soft(
        i, x, v, mass, found, second, other, local, last, smooth, asked, highest, work, mesh, start,
        end, planes, over, stack, bounds, owners, acting, beds,
    ):  # fmt: skip
        if other:
            return in_crease(
                i, x, v, mass, found, second, other, local, last, smooth, asked, highest, work,
                mesh, start, end, planes, over, stack, bounds, owners, acting, beds,
            )  # fmt: skip
        work.count = work.soft = work.pushing = 0
        t = found[0]
        depth = add_carried(x, found, mesh, start, end, owners, work, planes, over)
        plane = planes[0]
        plane.bound = depth
        for c in range(3):
            work.free[c] = work.dt * v[c]
            plane.bound += plane.normal[c] * (plane.drift[c] - work.free[c])
        if not plane.bound > 0.0:
            return -1, t, 0.0
        side = beds[1][i]
        compliance = work.dt * work.dt / beds[2]
        touch_side(side, plane.owner, plane.depth, False, work.recovery)
        stick = press_planes(1, mass, work, side, planes, beds[0][plane.owner], compliance)
        if not plane.push > 0.0:
            return -1, t, 0.0
        book_surface(x, v, mass, work, planes, over, mesh, start, acting)
        beds[3][i] = True
        work.pushing = 1
        work.active += 1
        work.sticking += stick
        return t, t, 0.0

    return meet_soft


class SurfaceFleshCorrection(OnFlesh, SurfaceCorrection):
    """Contact and friction with a closed surface of triangles on flesh, applied between steps.

    Parameters
    ----------
    surface, nodes, body, friction, offset, fixed, recovery, allowed, smooth : see SurfaceCorrection
    flesh : Flesh; areal_mass : float, of the cloth [kg/m^2]

    Attributes
    ----------
    sides : (n,) SIDE, what presses each node and how deep it lies [m]

    Raises
    ------
    ValueError as SurfaceCorrection, and for flesh of unknown segments
    """

    def __init__(
        self,
        surface: SurfaceMotion,
        nodes: int,
        body: Body | None = None,
        friction: Friction | ArrayLike = 0.0,
        offset: float = 0.0,
        fixed: ArrayLike | None = None,
        recovery: float = 0.1,
        allowed: ArrayLike | None = None,
        smooth: bool = True,
        *,
        flesh: Flesh,
        areal_mass: float,
    ):
        names = surface.names if body is None else body.names
        self.lay_beds(flesh, names, areal_mass, nodes)
        self._in_flesh = np.zeros(nodes, bool)
        super().__init__(surface, nodes, body, friction, offset, fixed, recovery, allowed, smooth)

    def _kernel_of(self, friction: Friction) -> Any:
        return surface_kernel(friction.kinetic_coefficient, soft_node_kernel)

    def _beds_of(self, nodes):
        return self._beds_of_segments, self.sides[nodes], self._areal, self._in_flesh[nodes]

    def _correct_all(self, x, v, old, mass, dt):
        self._in_flesh[:] = False
        bad = super()._correct_all(x, v, old, mass, dt)
        self.sides["owner"][~self._in_flesh] = -1
        return bad

    def state(self) -> dict[str, np.ndarray]:
        """See SurfaceCorrection; with the sides."""
        return super().state() | {"sides": self.sides.copy()}

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Continue from `state()`."""
        super().restore(state)
        self.sides[:] = state["sides"]
