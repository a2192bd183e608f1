# SPDX-License-Identifier: LGPL-3.0-or-later
"""Impulses of rows, one after another until all rows hold: Gauss and Seidel, Eqs. 15 and 16.

A row lacks bound - n . sum_a w_a v_a. Its impulse changes by that over

    K = sum_a w_a^2 n . Y_a n,

Y_a being the mobility of node a: 1/m, nothing in directions that a support or the body holds. The
sum of all changes is what must not pull, and what friction must keep in its cone; so a row may take
back what it gave before, and impulses of the step before serve as the first guess.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from contact.kernel import kernel
from contact.solver.friction import cone_kernel

from .row_impulses import spread

FREE = 0.01  # of the mobility of a row: what supports and body have to leave of it
LEFT = 1e-3  # of the speeds that impulses change: what sweeps may leave


@kernel(makes_arrays=False)
def set_masses(rows: np.ndarray, mobility: np.ndarray, mass: np.ndarray) -> None:
    """Fill the masses of rows (k,) ROW from the mobility (n, 3, 3) [1/kg] of the nodes.

    mass : (n,) [kg]. Rows whose nodes are held but for those that hardly count get none: all that
    the row lacks would have to come from these, which would be thrown away.
    """
    for k in range(len(rows)):
        row = rows[k]
        along = across = other = whole = sliding = 0.0
        for a in range(4):
            i = row.nodes[a]
            whole += row.weights[a] ** 2 / mass[i]
            for c in range(3):
                sliding += row.sliding[0, a, c] ** 2 / mass[i]
                for e in range(3):
                    y = mobility[i, c, e]
                    along += row.weights[a] ** 2 * row.normal[c] * y * row.normal[e]
                    across += row.sliding[0, a, c] * y * row.sliding[0, a, e]
                    other += row.sliding[1, a, c] * y * row.sliding[1, a, e]
        across = max(across, other)
        row.mass = 1.0 / along if along > FREE * whole else 0.0
        row.rub_mass = 1.0 / across if across > FREE * sliding else 0.0
        if row.mass == 0.0:
            row.push = 0.0
        if row.mass == 0.0 or row.rub_mass == 0.0:
            row.rub[0] = row.rub[1] = 0.0


@cache
def sweep_kernel(kinetic_coefficient: Callable) -> Any:
    """Kernel sweep(rows, v, mobility, parameters, most) of a law of friction.

    rows : (k,) ROW with their masses; v : (n, 3) [m/s], those by the impulses that rows have; both
        are changed
    mobility : (n, 3, 3) [1/kg]; parameters : numbers of the law; most : int, sweeps

    Returns the number of sweeps, what the first and the last found lacking, and the speed that
    impulses change [m/s].
    """
    transmitted = cone_kernel(kinetic_coefficient)

    @kernel(makes_arrays=False)
    def sweep(rows, v, mobility, parameters, most):
        rough = parameters[0] > 0.0
        scale = first = worst = 0.0
        for done in range(most):
            worst = 0.0
            for k in range(len(rows)):
                row = rows[k]
                if row.mass == 0.0:
                    continue
                apart = one = two = 0.0
                for a in range(4):
                    i = row.nodes[a]
                    for c in range(3):
                        apart += row.weights[a] * row.normal[c] * v[i, c]
                        one += row.sliding[0, a, c] * v[i, c]
                        two += row.sliding[1, a, c] * v[i, c]
                push = max(0.0, row.push + row.mass * (row.bound - apart))
                change = push - row.push
                worst = max(worst, abs(change) / row.mass)
                row.push = push
                scale = max(scale, push / row.mass)
                rub, rubbed = 0.0, 0.0
                if rough and row.rub_mass > 0.0:
                    rub = row.rub[0] - row.rub_mass * one
                    rubbed = row.rub[1] - row.rub_mass * two
                    size = np.sqrt(rub * rub + rubbed * rubbed)
                    part = 0.0
                    if push > 0.0:
                        part = transmitted(push, size, size / row.rub_mass, parameters)
                    one, two = part * rub - row.rub[0], part * rubbed - row.rub[1]
                    row.rub[0], row.rub[1] = part * rub, part * rubbed
                    worst = max(worst, (abs(one) + abs(two)) / row.rub_mass)
                else:
                    one = two = 0.0
                if change == 0.0 and one == 0.0 and two == 0.0:
                    continue
                for a in range(4):
                    i = row.nodes[a]
                    j0 = change * row.weights[a] * row.normal[0]
                    j1 = change * row.weights[a] * row.normal[1]
                    j2 = change * row.weights[a] * row.normal[2]
                    j0 += one * row.sliding[0, a, 0] + two * row.sliding[1, a, 0]
                    j1 += one * row.sliding[0, a, 1] + two * row.sliding[1, a, 1]
                    j2 += one * row.sliding[0, a, 2] + two * row.sliding[1, a, 2]
                    for c in range(3):
                        y = mobility[i, c]
                        v[i, c] += y[0] * j0 + y[1] * j1 + y[2] * j2
            if done == 0:
                first = worst
            if done >= 1 and worst <= LEFT * scale:
                return done + 1, first, worst, scale
        return most, first, worst, scale

    return sweep


@kernel(makes_arrays=False)
def swap_mobilities(mobility: np.ndarray, nodes: np.ndarray, others: np.ndarray) -> None:
    """Exchange the mobilities (n, 3, 3) of nodes (k,) with others (k, 3, 3)."""
    for k in range(len(nodes)):
        for c in range(3):
            for e in range(3):
                one = mobility[nodes[k], c, e]
                mobility[nodes[k], c, e] = others[k, c, e]
                others[k, c, e] = one


@kernel(makes_arrays=False)
def clear(impulse: np.ndarray, nodes: np.ndarray, factor: float) -> None:
    """Multiply what stands in impulse (n, 3) at nodes (k,) by a factor."""
    for k in range(len(nodes)):
        for c in range(3):
            impulse[nodes[k], c] = factor * impulse[nodes[k], c] if factor else 0.0


@cache
def turn_kernel(kinetic_coefficient: Callable) -> Any:
    """Kernel of one turn of body and sweeps, for a law of friction.

    Its arguments are those of the sweep, and besides:

    mass : (n,) [kg]; nodes, after, free : (k,), (k, 3), (k, 3, 3), those that the body holds, their
        velocities by it [m/s], and the mobilities that it leaves [1/kg]
    swept : (n, 3), velocities of the turn before [m/s]; turn : int; left, scale : as it returned
    close : part of the scale within which body and sweeps agree

    They agree where the answer to the last turn is near to what sweeps left (swept, which is then
    written over), and where the first sweep changed little, or all sweeps little at these nodes:
    the body would be asked the same.

    Returns the number of sweeps, whether body and sweeps agree, what the last sweep found lacking
    and the speed that impulses change [m/s].
    """
    sweep = sweep_kernel(kinetic_coefficient)

    @kernel(makes_arrays=False)
    def one_turn(
        rows, v, mobility, mass, nodes, after, free, swept, turn, left, scale, parameters, most,
        close,
    ):  # fmt: skip
        worst = 0.0
        for k in range(len(nodes)):
            for c in range(3):
                v[nodes[k], c] = after[k, c]
                worst = max(worst, abs(after[k, c] - swept[nodes[k], c]))
        if turn > 0 and len(nodes) and worst <= close * scale:
            return 0, True, left, scale
        clear(swept, nodes, 0.0)
        spread(rows, swept)
        clear(swept, nodes, -1.0)
        swap_mobilities(mobility, nodes, free)
        set_masses(rows, mobility, mass)
        done, first, left, scale = sweep(rows, v, mobility, parameters, most)
        swap_mobilities(mobility, nodes, free)
        spread(rows, swept)
        asked = 0.0
        for k in range(len(nodes)):
            for c in range(3):
                asked = max(asked, abs(mobility[nodes[k], c, c] * swept[nodes[k], c]))
        return done, min(first, 2.0 * asked) <= close * scale, left, scale

    return one_turn
