# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Particles at the crossings of threads: strains of yarns and their derivatives.

Between neighbours of a thread at the spacing h an elongation e = |d|/h - 1; at a crossing, in each
of its four corners, the angle gamma by which warp and weft have left the right angle; along three
neighbours a curvature, from the unit tangents t1, t2 before and after,

    K = |t2 - t1|/h = (2/h) sin(turn/2),    signed:  (t2 - t1) . n/h,  n the normal of the crossing.

where h is the length that the bend stands for: half a spacing where threads leave a table that
clamps them (`clamped`). Each strain stands for an area. A `Strains` holds them with their
derivatives by the places of their nodes: stress times area times derivative, summed, is the force
on the nodes. With n its own change is left out: it is nothing where cloth bends along threads.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np


class Strains(NamedTuple):
    """Values (k,), nodes (k, m), derivatives (k, m, 3) by the places of the nodes, areas (k,)."""

    values: np.ndarray
    nodes: np.ndarray
    slopes: np.ndarray
    areas: np.ndarray

    def forces(self, stress: np.ndarray, count: int) -> np.ndarray:
        """Forces (count, 3) [N] with which stresses (k,) pull the nodes."""
        pull = -(stress * self.areas)[:, None, None] * self.slopes
        where = self.nodes.ravel()
        return np.column_stack([np.bincount(where, pull[..., c].ravel(), count) for c in range(3)])

    def rates(self, v: np.ndarray) -> np.ndarray:
        """Rates (k,) at velocities (n, 3) of all nodes."""
        return np.einsum("kmc,kmc->k", self.slopes, v[self.nodes])


@dataclass(frozen=True)
class Grid:
    """Crossings of threads, `shape` of them along warp and weft, `spacing` [m] apart.

    Attributes
    ----------
    points : (n, 3) [m], flat; areas : (n,) [m^2], of cloth that a crossing stands for
    links (k, 2), corners (k, 3), bends (k, 3) : nodes; corners with the crossing first
    of_links, of_corners, of_bends : (k,) [m^2], areas; lengths : (k,) [m], of bends
    """

    shape: tuple[int, int]
    spacing: float
    points: np.ndarray
    areas: np.ndarray
    links: np.ndarray
    corners: np.ndarray
    bends: np.ndarray
    of_links: np.ndarray
    of_corners: np.ndarray
    of_bends: np.ndarray
    lengths: np.ndarray

    def clamped(self, held: np.ndarray) -> "Grid":
        """The same threads, some nodes held: half of a bend at their edge is held as well."""
        still = np.zeros(len(self.points), bool)
        still[held] = True
        half = np.where(still[self.bends].sum(axis=1) == 2, 0.5, 1.0)
        return replace(self, of_bends=half * self.of_bends, lengths=half * self.lengths)

    def elongations(self, x: np.ndarray) -> Strains:
        """Of links, at places x (n, 3)."""
        tangent, length = _unit(x[self.links[:, 1]] - x[self.links[:, 0]])
        slopes = np.stack([-tangent, tangent], axis=1) / self.spacing
        return Strains(length / self.spacing - 1, self.links, slopes, self.of_links)

    def angles(self, x: np.ndarray) -> Strains:
        """Of corners [rad], positive where the corner closes."""
        at = x[self.corners]
        (p, long_p), (q, long_q) = _unit(at[:, 1] - at[:, 0]), _unit(at[:, 2] - at[:, 0])
        sine = np.einsum("kc,kc->k", p, q)
        cosine = np.sqrt(np.maximum(1 - sine**2, 1e-12))
        by_p = (q - sine[:, None] * p) / (long_p * cosine)[:, None]
        by_q = (p - sine[:, None] * q) / (long_q * cosine)[:, None]
        slopes = np.stack([-by_p - by_q, by_p, by_q], axis=1)
        return Strains(np.arcsin(np.clip(sine, -1, 1)), self.corners, slopes, self.of_corners)

    def curvatures(self, x: np.ndarray, signed: bool = False) -> Strains:
        """Of bends [1/m]; `signed` by the normal of the cloth, or as a length."""
        at = x[self.bends]
        (t1, long_1), (t2, long_2) = _unit(at[:, 1] - at[:, 0]), _unit(at[:, 2] - at[:, 1])
        turn = t2 - t1
        if signed:
            along = self.normals(x)[self.bends[:, 1]]
        else:
            along, _ = _unit(turn)
        before = _across(along, t1) / (long_1 * self.lengths)[:, None]
        after = _across(along, t2) / (long_2 * self.lengths)[:, None]
        slopes = np.stack([before, -before - after, after], axis=1)
        values = np.einsum("kc,kc->k", turn, along) / self.lengths
        return Strains(values, self.bends, slopes, self.of_bends)

    def normals(self, x: np.ndarray) -> np.ndarray:
        """Unit normals (n, 3) of the crossings."""
        a, b = np.gradient(x.reshape(*self.shape, 3), axis=(0, 1))
        return _unit(np.cross(a, b).reshape(-1, 3))[0]


def _unit(vectors):
    length = np.linalg.norm(vectors, axis=1)
    return vectors / np.maximum(length, 1e-300)[:, None], length


def _across(vectors, tangents):
    return vectors - np.einsum("kc,kc->k", vectors, tangents)[:, None] * tangents


def grid(shape: tuple[int, int], spacing: float) -> Grid:
    """Crossings in the plane z = 0 about the origin, warp along x."""
    number = np.arange(shape[0] * shape[1]).reshape(shape)
    at = np.stack(np.meshgrid(*(np.arange(n) - (n - 1) / 2 for n in shape), indexing="ij"), axis=-1)
    points = np.column_stack([spacing * at.reshape(-1, 2), np.zeros(number.size)])
    # threads at the edge are half as wide, and end half a spacing earlier
    parts = [np.r_[0.5, np.ones(n - 2), 0.5] for n in shape]
    areas = spacing**2 * np.outer(*parts)
    warp, weft = np.ones_like(areas) * parts[1], np.ones_like(areas) * parts[0][:, None]
    links = [(number[:-1], number[1:], warp[1:]), (number[:, :-1], number[:, 1:], weft[:, 1:])]
    bends = [
        (number[:-2], number[1:-1], number[2:], warp[1:-1]),
        (number[:, :-2], number[:, 1:-1], number[:, 2:], weft[:, 1:-1]),
    ]
    quads = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    quarter = np.full((shape[0] - 1, shape[1] - 1), 0.25)
    corners = [(quads[k], quads[(k + 1) % 4], quads[k - 1], quarter) for k in range(4)]

    def joined(parts):
        columns = [np.concatenate([p.ravel() for p in column]) for column in zip(*parts)]
        return np.column_stack(columns[:-1]).astype(int), spacing**2 * columns[-1]

    found = [joined(parts) for parts in (links, corners, bends)]
    nodes, of = zip(*found)
    lengths = np.full(len(of[2]), spacing)
    return Grid(shape, spacing, points, areas.ravel(), *nodes, *of, lengths)


def on_table(points: np.ndarray, half: float) -> np.ndarray:
    """Nodes (k,) on a square table of 2 `half` [m] a side about the origin."""
    return np.flatnonzero(np.abs(points[:, :2]).max(axis=1) <= half * (1 + 1e-9))
