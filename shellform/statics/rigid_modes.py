# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rigid motions that supports leave free: a static problem must have none.

A rigid motion of a connected piece, u = a + b x X, dd = b x D, costs no energy. It is held if it
moves some held unknown (Eq. 10 gives the motion of the 5 unknowns of a node).
"""

import numpy as np

from meshes import Surface
from shellform.fem.director import along_axes, tangent_frames
from shellform.fem.shell import Shell, require_shell


def free_motions(shell: Shell) -> list[tuple[int, np.ndarray]]:
    """Rigid motions free at rest, the same list on every rank.

    Returns
    -------
    list of (node of the piece, motion (6,)): three translations, three rotations about the middle
    of the surface, scaled by its length
    """
    partition, supports, n = shell.partition, shell.supports, shell.partition.n_owned
    points, label = partition.surface.points, pieces(partition.surface)
    X = (points[partition.owned_nodes] - partition.origin) / partition.length
    D = partition.directors[:n]
    T = tangent_frames(D, supports.plane[:n])
    rows = np.zeros((n, 5, 6))
    for k, axis in enumerate(np.eye(3)):
        rows[:, :3, k] = along_axes(supports.Q[:n], np.broadcast_to(axis, (n, 3)))
        rows[:, :3, 3 + k] = along_axes(supports.Q[:n], np.cross(axis, X))
        rows[:, 3:, 3 + k] = np.einsum("nij,ni->nj", T, np.cross(axis, D))
    rows *= supports.held[:n, :, None]
    gram = np.zeros((label.max() + 1, 6, 6))
    np.add.at(gram, label[partition.owned_nodes], np.einsum("nik,nil->nkl", rows, rows))
    free = []
    for piece, matrix in enumerate(shell.comm.allreduce(gram)):
        values, vectors = np.linalg.eigh(matrix)
        node = int(np.argmax(label == piece))
        free += [(node, v) for x, v in zip(values, vectors.T, strict=True) if x < 1e-10]
    return free


def refuse_free_motions(shell: Shell) -> None:
    """ValueError if the supports leave a rigid motion free, TypeError for what is no shell."""
    require_shell(shell, "this solver")
    for node, motion in free_motions(shell):
        raise ValueError(
            f"the supports leave a rigid motion free: the piece of {shell.surface.source} with "
            f"node {node} {describe(motion)}; hold it, or use dynamics"
        )


def pieces(surface: Surface) -> np.ndarray:
    """Number (n,) of the connected piece that each point belongs to."""
    label = np.arange(len(surface.points))
    while True:
        lowest = label.copy()
        np.minimum.at(lowest, surface.cells, label[surface.cells].min(axis=1, keepdims=True))
        lowest = lowest[lowest]
        if np.array_equal(lowest, label):
            return np.unique(label, return_inverse=True)[1]
        label = lowest


def describe(motion: np.ndarray) -> str:
    """A free motion (6,) in words."""
    names = ("x", "y", "z")
    part = "moves along" if np.linalg.norm(motion[:3]) > 0.7 else "turns about"
    vector = motion[:3] if part == "moves along" else motion[3:]
    axis = int(np.abs(vector).argmax())
    if abs(vector[axis]) > 0.95 * np.linalg.norm(vector):
        return f"{part} {names[axis]}"
    return f"{part} ({', '.join(f'{c:.2g}' for c in vector / np.linalg.norm(vector))})"
