# SPDX-License-Identifier: LGPL-3.0-or-later
"""The seam between implicit steps and what nodes meet: segments of a body, or a surface.

Each kind of body gives the same kernels; `world` is what they know of it in the step, different for
each. A plane of a node stands on something of the body: `nodes.owner` is the segment that what it
does is booked to, `nodes.over` the triangle below it, or -1 - k on the k-th shape. No kernel here
knows a law of friction: active_set.py and held_nodes.py know no body.
"""

from typing import Any, NamedTuple

from contact.kernel import kernel

from .held_nodes import FIXED, OPEN, PASSES, PLANES, SLIP, STICK


class Obstacle(NamedTuple):
    """Kernels of a kind of body.

    locate(begins, x0, x1, changed, work, world, nodes) : see `locate_kernel`
    velocities(x, world, nodes, out) : fill the velocities out (n, 3, 3) [m/s] of the body below the
        planes of nodes at x (n, 3) at the end of the step
    book(x, impulses, energies, world, nodes) : book what planes did, impulses (n, 3, 3) [N s] and
        energies (n, 3, 3) [J]: work, friction and impact loss
    """

    locate: Any
    velocities: Any
    book: Any


def locate_kernel(depth: Any, carry: Any, tangent: Any, met: Any) -> Any:
    """Kernel locate(begins, x0, x1, changed, work, world, nodes) of a kind of body.

    Where it begins, it carries last step's set to the start of a step at x0 (n, 3): 0 and the
    deepest start inside [m]. Else it sets the planes of nodes that slip anew after a solve that
    ended at x1 (n, 3), and gives nodes planes of what they have met: the number of nodes that
    changed, those in changed (n,) among them, and the greatest distance from planes [m].

    depth(x, i, offset, world) : how deep node i starts inside [m], at least 0
    carry(x, i, world, nodes) : fill the anchor of node i, and the normals of its planes, with where
        the body takes them over the step
    tangent(x, i, k, offset, world, nodes) : put plane k of node i at the foot of x at the end of
        the step; height of x over it [m]
    met(x0, x1, i, offset, world, nodes, place) : owner and `over` of what node i passes into on its
        way from x0 to x1, beyond what holds it already, or -1 and 0; place (7,) : filled with where
        that is at the end of the step and the normal there; last how deep x1 lies [m]
    """

    @kernel(makes_arrays=False)
    def put_on(x, i, offset, world, nodes):
        for _ in range(PASSES):
            worst, count = 0.0, 0
            for k in range(PLANES):
                if nodes.owner[i, k] < 0:
                    continue
                gap = tangent(x, i, k, offset, world, nodes)
                for c in range(3):
                    x[c] -= gap * nodes.normal[i, k, c]
                worst, count = max(worst, abs(gap)), count + 1
            if count <= 1 or worst < 1e-13:
                break

    @kernel(makes_arrays=False)
    def locate(begins, x0, x1, changed, work, world, nodes):
        offset, changes, worst, place = work.offset, 0, 0.0, world.place
        for i in range(len(x0)):
            if begins:
                nodes.flips[i], nodes.way_out[i] = 0, 0.0
            if nodes.state[i] == FIXED:
                continue
            moved = False
            if begins:
                own = depth(x0[i], i, offset, world)
                worst = max(worst, own)
                nodes.way_out[i] = max(0.0, own - work.recovery)
                if nodes.state[i] > OPEN:
                    carry(x0[i], i, world, nodes)
                    moved = True
            else:
                count = 0
                for k in range(PLANES):
                    if nodes.owner[i, k] >= 0:
                        count += 1
                        if nodes.state[i] == SLIP:
                            worst = max(worst, abs(tangent(x1[i], i, k, offset, world, nodes)))
                new = changed[i]
                if count < PLANES:
                    owner, over = met(x0[i], x1[i], i, offset, world, nodes, place)
                    if owner >= 0:
                        nodes.owner[i, count], nodes.over[i, count] = owner, over
                        for c in range(3):
                            nodes.normal[i, count, c] = place[3 + c]
                        if count == 0:
                            nodes.state[i] = STICK if work.friction[0] > 0.0 else SLIP
                            nodes.cone[i] = 0.0
                            for c in range(3):
                                nodes.anchor[i, c] = place[c]
                        moved = new = True
                if new:
                    changes += 1
                    nodes.flips[i] += 1
            if moved:
                put_on(nodes.anchor[i], i, offset, world, nodes)
        return changes, worst

    return locate


def velocities_kernel(velocity: Any) -> Any:
    """Kernel `velocities` of an Obstacle from velocity(x, i, k, world, nodes, out)."""

    @kernel(makes_arrays=False)
    def velocities(x, world, nodes, out):
        for i in range(len(x)):
            if nodes.state[i] > OPEN:
                for k in range(PLANES):
                    if nodes.owner[i, k] >= 0:
                        velocity(x[i], i, k, world, nodes, out[i, k])

    return velocities


def book_kernel(book: Any) -> Any:
    """Kernel `book` of an Obstacle from book(x, i, k, impulse, energies, world, nodes)."""

    @kernel(makes_arrays=False)
    def book_all(x, impulses, energies, world, nodes):
        for i in range(len(x)):
            if nodes.state[i] > OPEN:
                for k in range(PLANES):
                    if nodes.owner[i, k] >= 0:
                        book(x[i], i, k, impulses[i, k], energies[i, k], world, nodes)

    return book_all
