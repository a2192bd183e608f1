# SPDX-License-Identifier: LGPL-3.0-or-later
"""Points inside cells that meet the body: particles of their own for one step.

A sample is the point sum_a w_a x_a of a cell of four nodes. Several samples share a node. Corrected
one after the other, each moves what the one before has put right, and a sheet at rest rattles. Here
a node's mass is shared out among its samples by their weights, w_as / W_a with W_a = sum_s w_as:
the node is cut into pieces, every sample meets the body with its own pieces as a particle of mass

    M_s = 1 / sum_a w_as W_a / m_a,

and the pieces are put together again, which is adding the impulses: m_a dv_a = sum_s w_as J_s.
(Mass splitting: Tonge, Benevolenski and Voroshilov, ACM Trans. Graph. 31, 2012.) No order among
samples, so the same on any number of ranks; momentum is exact; each meeting loses energy and so
does putting together, E = sum_s J_s . (u_s - u) / 2 with u_s the particle's velocity and u that of
the point afterwards. A sheet pushed evenly gets in one step what it needs; elsewhere some of the
push is left for the next steps, and rest is reached at a depth of about g dt^2.

The samples lie on the chords of the cells: where cells bend around a body, its nodes are held
h^2/(8 R) outside.
"""

import numpy as np

from contact.kernel import kernel


def midpoints(k: int) -> np.ndarray:
    """Weights (k^2, 4) of the middles of k x k parts of a cell, nodes in tensor order."""
    if isinstance(k, bool) or not isinstance(k, (int, np.integer)) or k < 1:
        raise ValueError(f"samples inside cells are k x k points with k = 1, 2, ..., not {k!r}")
    a, b = np.meshgrid(*[(np.arange(k) + 0.5) / k] * 2, indexing="ij")
    a, b = a.ravel(), b.ravel()
    return np.column_stack([(1 - a) * (1 - b), a * (1 - b), (1 - a) * b, a * b])


def shares(cells: np.ndarray, weights: np.ndarray, nodes: int) -> np.ndarray:
    """W (n,), sum of the weights that all samples have at each node; cells (m, 4), n = nodes."""
    return np.bincount(cells.ravel(), np.tile(weights.sum(axis=0), len(cells)), nodes)


def particle_masses(
    cells: np.ndarray, weights: np.ndarray, share: np.ndarray, mass: np.ndarray, fixed: np.ndarray
) -> np.ndarray:
    """M (m s,) of the samples [kg], cell by cell; not finite where all nodes are fixed.

    Parameters
    ----------
    cells : (m, 4) int; weights : (s, 4); share, mass : (n,) W and m [kg] of the nodes
    fixed : (n,) bool, nodes of prescribed motion: no push moves them
    """
    inverse = np.where(fixed, 0.0, share / mass)[cells]
    with np.errstate(divide="ignore"):
        return 1.0 / (inverse @ weights.T).ravel()


@kernel
def collect(nodal: np.ndarray, cells: np.ndarray, weights: np.ndarray, out: np.ndarray) -> None:
    """Values (m s, k) of the samples from those of the nodes (n, k)."""
    row = 0
    for cell in cells:
        for w in weights:
            for c in range(out.shape[1]):
                out[row, c] = (
                    w[0] * nodal[cell[0], c]
                    + w[1] * nodal[cell[1], c]
                    + w[2] * nodal[cell[2], c]
                    + w[3] * nodal[cell[3], c]
                )
            row += 1


@kernel
def spread(impulse: np.ndarray, cells: np.ndarray, weights: np.ndarray, nodal: np.ndarray) -> None:
    """Add the impulses (m s, 3) of the samples to those of the nodes (n, 3 or more)."""
    row = 0
    for cell in cells:
        for w in weights:
            for a in range(4):
                for c in range(3):
                    nodal[cell[a], c] += w[a] * impulse[row, c]
            row += 1
