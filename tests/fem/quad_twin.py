# SPDX-License-Identifier: LGPL-3.0-or-later
"""The energy of 4-node quads point by point, slowly: what quad_force.c is held against.

No line is shared with it: strains at corners and Gauss points come from derivatives there, as in
strains.py. Fields may be complex, so forces are derivatives of the energy to roundoff.
"""

import numpy as np

from shellform.fem.six_lengths import FIRST, SECOND, six_lengths

CORNERS = [(0, 0), (1, 0), (0, 1), (1, 1)]
GAUSS = [(0.5 + a / np.sqrt(12), 0.5 + b / np.sqrt(12)) for b in (-1, 1) for a in (-1, 1)]


def dot(a, b):
    return np.sum(a * b, axis=-1)  # not conjugated


def derivatives(X, p, q):
    """Of a bilinear field X (..., 4, 3) at (p, q), and its value."""
    one = (1 - q) * (X[:, 1] - X[:, 0]) + q * (X[:, 3] - X[:, 2])
    two = (1 - p) * (X[:, 2] - X[:, 0]) + p * (X[:, 3] - X[:, 1])
    value = (1 - q) * ((1 - p) * X[:, 0] + p * X[:, 1]) + q * ((1 - p) * X[:, 2] + p * X[:, 3])
    return one, two, value


def axes(X, p, q, warp):
    """Components l_i . G^a (m, 2, 2) and the area at (p, q)."""
    G1, G2, _ = derivatives(X, p, q)
    normal = np.cross(G1, G2)
    area = np.linalg.norm(normal, axis=1)
    normal /= area[:, None]
    first = np.broadcast_to(G1 if warp is None else warp, G1.shape)
    first = first - dot(first, normal)[:, None] * normal
    first /= np.linalg.norm(first, axis=1)[:, None]
    frame = np.stack([first, np.cross(normal, first)], 1)
    duals = np.linalg.pinv(np.stack([G1, G2], 1))  # (m, 3, 2)
    return frame @ duals, area


def turn(g, h):
    c = dot(h, h)
    return dot(g, h) * (1 + c / 12 + c**2 / 90)


def curvatures(x, d, p, q):
    """(11, 22, 12) (m, 3) covariant."""
    g1, g2, _ = derivatives(x, p, q)
    h1, h2, _ = derivatives(d, p, q)
    twist = (turn(g1 + g2, h1 + h2) - turn(g1 - g2, h1 - h2)) / 4
    return np.stack([turn(g1, h1), turn(g2, h2), twist], 1)


def shears(x, d, p, q):
    """Of the two sides that meet in a corner, each in its middle (m, 2)."""
    g1, g2, _ = derivatives(x, p, q)
    one, two = derivatives(d, 0.5, q)[2], derivatives(d, p, 0.5)[2]
    return np.stack([dot(g1, one), dot(g2, two)], 1)


def lengths(x, d, arcs=1.0):
    dx, dd = x[:, SECOND] - x[:, FIRST], d[:, SECOND] - d[:, FIRST]
    arc = dot(dx, dd) ** 2 * (1 + 2 * dot(dd, dd) / 15) / 24
    return 0.5 * dot(dx, dx) + np.reshape(arcs, (-1, 1)) * arc


def voigt(tensor):
    """(E11, E22, 2 E12) of symmetric tensors (m, 2, 2)."""
    return np.stack([tensor[:, 0, 0], tensor[:, 1, 1], 2 * tensor[:, 0, 1]], 1)


def quadratic(matrix, strain):
    return 0.5 * np.einsum("mi,ij,mj->m", strain, matrix, strain)


class Twin:
    """Energy of a sheet; the membrane's density is a function of strains (m, 3)."""

    def __init__(self, points, directors, cells, warp, fabric, density=None, arcs=1.0):
        self.cells, self.warp, self.fabric, self.arcs = cells, warp, fabric, arcs
        self.points = points
        self.X, self.D = points[cells], directors[cells]
        self.density = density or (lambda E: quadratic(fabric.membrane, E))
        self.B, self.modes, self.area = six_lengths(self.X, warp, fabric.membrane)

    def strains(self, w):
        s = lengths(*self.fields(w), self.arcs) - lengths(self.X, self.D, self.arcs)
        return np.einsum("mij,mj->mi", self.B, s), np.einsum("mij,mj->mi", self.modes, s)

    def fields(self, w):
        return (self.points + w[:, :3])[self.cells], w[:, 3:][self.cells]

    def energies(self, w, membrane=True):
        """Energy (m,) of cells."""
        x, d = self.fields(w)
        energy = 0.0 * x[:, 0, 0]
        if membrane:
            E, bent = self.strains(w)
            energy = self.area * self.density(E) + 0.5 * np.sum(bent**2, axis=1)
        for p, q in CORNERS:
            M, area = axes(self.X, p, q, self.warp)
            strain = shears(x, d, p, q) - shears(self.X, self.D, p, q)
            strain = np.einsum("mia,ma->mi", M, strain)
            energy = energy + area / 4 * quadratic(self.fabric.shear, strain)
        for p, q in GAUSS:
            M, area = axes(self.X, p, q, self.warp)
            k = curvatures(x, d, p, q) - curvatures(self.X, self.D, p, q)
            tensor = np.stack([k[:, [0, 2]], k[:, [2, 1]]], 1)
            strain = voigt(np.einsum("mia,mab,mjb->mij", M, tensor, M))
            energy = energy + area / 4 * quadratic(self.fabric.bending, strain)
        return energy

    def forces(self, w, **options):
        """Derivative (n, 6) of the energy, by complex steps."""
        out, step = np.zeros(w.shape), 1e-30
        for i, k in np.ndindex(w.shape):
            ahead = w.astype(complex)
            ahead[i, k] += 1j * step
            out[i, k] = self.energies(ahead, **options).sum().imag / step
        return out

    def stored_by_rates(self, w, rates):
        """Energy (m,) that the rates (n, 6) of the strains at w would store, were they strains."""
        step = 1e-30
        ahead = w + step * 1j * rates
        x, d = self.fields(ahead)

        def rate(strain):
            return strain.imag / step

        E, bent = map(rate, self.strains(ahead))
        energy = self.area * quadratic(self.fabric.membrane, E) + 0.5 * np.sum(bent**2, axis=1)
        for p, q in CORNERS:
            M, area = axes(self.X, p, q, self.warp)
            strain = np.einsum("mia,ma->mi", M, rate(shears(x, d, p, q)))
            energy += area / 4 * quadratic(self.fabric.shear, strain)
        for p, q in GAUSS:
            M, area = axes(self.X, p, q, self.warp)
            k = rate(curvatures(x, d, p, q))
            tensor = np.stack([k[:, [0, 2]], k[:, [2, 1]]], 1)
            strain = voigt(np.einsum("mia,mab,mjb->mij", M, tensor, M))
            energy += area / 4 * quadratic(self.fabric.bending, strain)
        return energy
