# SPDX-License-Identifier: LGPL-3.0-or-later
"""Internal force of the 4-node quad with arcs and turning angles, by segments: Eq. 14.

The same energy as element.py writes in UFL, which is its test. There every quadrature point works
out its own derivatives; but all strains at the corners come from six segments, four sides and two
diagonals, and all curvatures along an axis from two lines. Sharing them makes the force several
times cheaper, which is what explicit steps need. Cell by cell:

    gather         positions, directors                          nodes 0 to 3
    kinematics     segments, lines, crossings                    X, D, b = X . D, c = D . D
    strains        stretch, shear, curvature, twist              less those at rest
    damping        + tau times their rates                       C rates . rates is lost
    resultants     pulls, shear forces, moments                  C strains
    scatter        forces on positions, couples on directors     their work-conjugates

Nodes of a cell run in tensor order (0,0), (1,0), (0,1), (1,1). Segments: 0 = 01, 1 = 23 along axis
1; 2 = 02, 3 = 13 along axis 2; diagonals 4 = 21, 5 = 03.

Compiled code may reorder sums: the bits of a force hang on the order of the steps below.
"""

import numpy as np

from .quad_bending import (
    crossings,
    curvature_rates,
    curvatures,
    line_forces,
    line_rates,
    lines,
    loss_with_bending,
    on_lines,
    twist_rates,
    twists,
)
from .quad_membrane import (
    Four,
    FourVectors,
    Segments,
    Six,
    SixVectors,
    along_arc,
    differences,
    loss_with_membrane,
    middles,
    pulls,
    segments,
    shear_forces,
    shear_rates,
    shears,
    stretch_rates,
    stretches,
)
from .vector3 import add, add_to, compiled, mix, plus, row, stage, sub


@compiled
def add_force(
    w: np.ndarray,
    ahead: np.ndarray,
    damped: bool,
    points: np.ndarray,
    cells: np.ndarray,
    stiffness: np.ndarray,
    rest: np.ndarray,
    r: np.ndarray,
) -> float:
    """Add the internal forces of all cells.

    Damped, the stress is that of the strains plus their rates times a time tau, in the present
    configuration: it resists every change of strain, whatever stress there is, and no rigid motion.

    Parameters
    ----------
    w : (n, 6), (u, d); ahead : (n, 6), w + tau times its rates, used if `damped`
    points : (n, 3), reference positions
    cells : (m, 4) int in tensor order; stiffness, rest : see quad_reference.py
    r : (n, 6), added to [N, N m]

    Returns
    -------
    Twice what the rates would store as strains [J]: over tau, the power of damping; 0 undamped
    """
    loss = 0.0
    for m in range(cells.shape[0]):
        nodes, C, at_rest = cells[m], stiffness[m], rest[m]
        x, d = positions(points, w, nodes), directors(w, nodes)

        cell = segments(x, d)
        stretch = stretches(cell, at_rest)
        middle = middles(d)
        shear = shears(cell, middle, at_rest)
        line = lines(cell)
        curvature = curvatures(line, at_rest)
        point = crossings(line)
        twist = twists(point, at_rest)

        if damped:
            velocity, turns = changes(ahead, w, nodes, 0), changes(ahead, w, nodes, 3)
            vX, vD = differences(velocity), differences(turns)
            stretch_rate = stretch_rates(cell, vX, vD)
            shear_rate = shear_rates(cell, vX, middle, turns)
            loss = loss_with_membrane(loss, C, stretch_rate, shear_rate)
            line_rate = line_rates(line, on_lines(vX[:4]), on_lines(vD[:4]))
            curvature_rate = curvature_rates(line, line_rate)
            twist_rate = twist_rates(line, line_rate, point)
            loss = loss_with_bending(loss, C, curvature_rate, twist_rate)
            stretch, shear = sum6(stretch, stretch_rate), sum4(shear, shear_rate)
            curvature, twist = sum4(curvature, curvature_rate), sum4(twist, twist_rate)

        F, M = arc_forces(cell, pulls(C, stretch))
        across = shear_forces(C, shear)
        force, couple = line_forces(C, line, point, curvature, twist)
        F = with_shear_and_bending(F, across, middle, on_lines(force))
        M = with_bending_couples(M, on_lines(couple))

        scatter_forces(r, nodes, F)
        scatter_couples(r, nodes, M, shear_couples(cell, across))
    return loss


# ---------------------------------------------------------------- gather


@stage
def positions(points: np.ndarray, w: np.ndarray, nodes: np.ndarray) -> FourVectors:
    """Present positions of the nodes of a cell."""
    i0, i1, i2, i3 = nodes[0], nodes[1], nodes[2], nodes[3]
    return (
        add(row(points, i0, 0), row(w, i0, 0)),
        add(row(points, i1, 0), row(w, i1, 0)),
        add(row(points, i2, 0), row(w, i2, 0)),
        add(row(points, i3, 0), row(w, i3, 0)),
    )


@compiled
def directors(w: np.ndarray, nodes: np.ndarray) -> FourVectors:
    """Directors at the nodes of a cell."""
    return row(w, nodes[0], 3), row(w, nodes[1], 3), row(w, nodes[2], 3), row(w, nodes[3], 3)


@stage
def changes(ahead: np.ndarray, w: np.ndarray, nodes: np.ndarray, k: int) -> FourVectors:
    """Numbers k, k + 1, k + 2 of the nodes of a cell: their change from w to `ahead`."""
    i0, i1, i2, i3 = nodes[0], nodes[1], nodes[2], nodes[3]
    return (
        sub(row(ahead, i0, k), row(w, i0, k)),
        sub(row(ahead, i1, k), row(w, i1, k)),
        sub(row(ahead, i2, k), row(w, i2, k)),
        sub(row(ahead, i3, k), row(w, i3, k)),
    )


@compiled
def sum4(a: Four, b: Four) -> Four:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]


@compiled
def sum6(a: Six, b: Six) -> Six:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3], a[4] + b[4], a[5] + b[5]


# ---------------------------------------------------------------- scatter


@stage
def arc_forces(cell: Segments, pull: Six) -> tuple[SixVectors, SixVectors]:
    """Forces and couples, work-conjugate to X and D, of the pulls along the six arcs."""
    F0, M0 = along_arc(pull[0], cell[0])
    F1, M1 = along_arc(pull[1], cell[1])
    F2, M2 = along_arc(pull[2], cell[2])
    F3, M3 = along_arc(pull[3], cell[3])
    F4, M4 = along_arc(pull[4], cell[4])
    F5, M5 = along_arc(pull[5], cell[5])
    return (F0, F1, F2, F3, F4, F5), (M0, M1, M2, M3, M4, M5)


@stage
def with_shear_and_bending(
    F: SixVectors, across: Four, middle: FourVectors, force: FourVectors
) -> SixVectors:
    """Forces with those of shear across the sides and of bending along them."""
    F0, F1, F2, F3, F4, F5 = F
    return (
        add(plus(F0, across[0], middle[0]), force[0]),
        add(plus(F1, across[1], middle[1]), force[1]),
        add(plus(F2, across[2], middle[2]), force[2]),
        add(plus(F3, across[3], middle[3]), force[3]),
        F4,
        F5,
    )


@stage
def with_bending_couples(M: SixVectors, couple: FourVectors) -> SixVectors:
    """Couples with those of bending along the sides."""
    M0, M1, M2, M3, M4, M5 = M
    return (
        add(M0, couple[0]), add(M1, couple[1]), add(M2, couple[2]), add(M3, couple[3]), M4, M5,
    )  # fmt: skip


@stage
def scatter_forces(r: np.ndarray, nodes: np.ndarray, F: SixVectors) -> None:
    """Forces of the segments 01, 23, 02, 13, 21, 03 to the positions of their ends."""
    F0, F1, F2, F3, F4, F5 = F
    add_to(r, nodes[0], 0, mix(-1.0, add(F0, F2), -1.0, F5))
    add_to(r, nodes[1], 0, add(sub(F0, F3), F4))
    add_to(r, nodes[2], 0, sub(sub(F2, F1), F4))
    add_to(r, nodes[3], 0, add(add(F1, F3), F5))


@stage
def shear_couples(cell: Segments, across: Four) -> FourVectors:
    """Couples of the shear forces on the directors: half of each side's at both of its ends."""
    q0, q1, q2, q3 = across
    X0, X1, X2, X3 = cell[0].X, cell[1].X, cell[2].X, cell[3].X
    return (
        mix(0.5 * q0, X0, 0.5 * q2, X2),
        mix(0.5 * q0, X0, 0.5 * q3, X3),
        mix(0.5 * q1, X1, 0.5 * q2, X2),
        mix(0.5 * q1, X1, 0.5 * q3, X3),
    )


@stage
def scatter_couples(r: np.ndarray, nodes: np.ndarray, M: SixVectors, half: FourVectors) -> None:
    """Couples of the segments to the directors of their ends, with those of shear."""
    M0, M1, M2, M3, M4, M5 = M
    add_to(r, nodes[0], 3, sub(sub(half[0], M0), add(M2, M5)))
    add_to(r, nodes[1], 3, add(add(half[1], M0), sub(M4, M3)))
    add_to(r, nodes[2], 3, add(sub(half[2], M1), sub(M2, M4)))
    add_to(r, nodes[3], 3, add(add(half[3], M1), add(M3, M5)))
