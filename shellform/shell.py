# SPDX-License-Identifier: LGPL-3.0-or-later
"""The director shell: its field, its strain energy and the forms derived from it, Eqs. 2, 3, 13, 14.

UFL sees one nodal field w = (u, d). The strain energy per area is
(eps A eps + 2 eps B kap + kap D kap + gam S gam)/2, the thickness being integrated exactly; with
`thick` also the products of chi. The internal force is its derivative. The two rotations of a node
enter later, algebraically (director.py, equilibrium.py).

Tangent. The exact one fails for thin sheets: the stress of an iterate off the solution is mostly
error. In the geometric part the stress linearised about the iterate before is used instead,
C (e(w_) + De(w_)[dw_]) (mixed integration point, Magisano, Leonetti and Garcea, Int. J. Numer.
Methods Engrg. 109, 2017). With w_ = w and dw_ = 0 the same form is the exact tangent.
"""

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from mpi4py import MPI
from petsc4py import PETSc
from ufl.algorithms import expand_derivatives

from . import strains
from .loads import Loads
from .partition import Partition
from .strains import Term
from .supports import Supports

# a rank that waits for another rank's compiler must not give up
JIT = {"timeout": 600}


class Shell:
    """A sheet of fabric on a surface.

    Parameters
    ----------
    surface : meshes.Surface
        Triangles, quads or 9-node quads; its `warp` is needed by fabrics with a direction.
    fabric : Fabric
    comm : MPI communicator
    membrane : 'arcs' (default) or 'chords'
        Membrane strain of triangles and 4-node quads from arc lengths at the corners, or from the
        tangents at 2x2 Gauss points. Ignored by 9-node quads.
    curvature : 'turning' (default) or 'plain'
        Curvature by turning angles or by x,a . d,b. Ignored by 9-node quads.
    thick : bool
        Keep the strain quadratic in the thickness coordinate (matters for t kappa > 0.1).

    Attributes
    ----------
    w : fem.Function (u, d) [m, -]; reference : the same before loading
    supports : Supports, loads : Loads

    Raises
    ------
    ValueError for an unknown option or a missing warp direction
    """

    def __init__(
        self,
        surface,
        fabric,
        comm=MPI.COMM_WORLD,
        *,
        membrane="arcs",
        curvature="turning",
        thick=False,
    ):
        for value, choices in ((membrane, ("arcs", "chords")), (curvature, ("turning", "plain"))):
            if value not in choices:
                raise ValueError(f"choose one of {', '.join(choices)}, not '{value}'")
        if fabric.directional and surface.warp is None:
            raise ValueError(
                f"{surface.source} has no warp direction, which the fabric '{fabric.name}' needs: "
                "give surface.replace(warp=(x, y, z))"
            )
        self.fabric, self.thick = fabric, thick
        self.coupled = bool(np.any(fabric.coupling))
        # products of membrane strain with others are positive only where all share their points
        self.membrane = "chords" if self.coupled or thick else membrane
        self.curvature = curvature
        self.partition = partition = Partition(surface, comm)
        self.comm, self.mesh, self.space = comm, partition.mesh, partition.space
        self.w, self.reference = fem.Function(self.space, name="w"), fem.Function(self.space)
        self.before, self.step = fem.Function(self.space), fem.Function(self.space)
        self.supports = Supports(partition)
        self.loads = Loads(partition, fabric.areal_mass)
        self.rest()
        self._compiled = {}

    def rest(self):
        """Put the sheet back into its reference state."""
        self.reference.x.array.reshape(-1, 6)[:, 3:] = self.partition.directors
        for field in (self.w, self.before):
            field.x.array[:] = self.reference.x.array
        self.step.x.array[:] = 0.0

    def terms(self):
        """The terms of the strain energy that this fabric and element need, as `Term`s."""
        mesh, fabric = self.mesh, self.fabric
        warp = self._warp() if fabric.directional else None
        M = strains.lamina(mesh, warp)
        V = strains.voigt(M)
        A, B, D, E, F, S = (
            fem.Constant(mesh, np.array(q, float))
            for q in (
                fabric.membrane,
                fabric.coupling,
                fabric.bending,
                fabric.third_moment,
                fabric.fourth_moment,
                fabric.shear,
            )
        )

        def through(stiffness):
            return lambda p, q: ufl.dot(V * p, stiffness * (V * q))

        def across(p, q):
            return ufl.dot(M * p, S * (M * q))

        def stacked(matrices):
            """Product of strain vectors stacked by powers of z; None for an absent block."""

            def product(p, q):
                part = lambda s, i: V * ufl.as_vector([s[3 * i + k] for k in range(3)])  # noqa: E731
                return sum(
                    ufl.dot(part(p, i), C * part(q, j))
                    for i, row in enumerate(matrices)
                    for j, C in enumerate(row)
                    if C is not None
                )

            return product

        if self.partition.surface.degree == 2:
            return self._terms_9_nodes(V, M, (A, B, D, E, F, S), stacked)
        triangle = self.partition.surface.kind == "triangle"
        corners, inside = ("vertices", "vertices") if triangle else ("corners", "gauss2")
        s = self._corner_offsets(strains.TRIANGLE_CORNERS if triangle else strains.QUAD_CORNERS)
        gamma = strains.shear_triangle_corner(s) if triangle else strains.shear_quad_corner(s)
        softer = strains.shear_cap(mesh, self._shear_over_bending()) if triangle else 1
        across_cell = lambda p, q: softer * across(p, q)  # noqa: E731
        terms = [Term("shear", gamma, across_cell, corners)]
        if self.curvature == "plain":
            kappa = strains.curvature
        else:
            kappa = strains.curvature_turning_sides if triangle else strains.curvature_turning
        eps = strains.membrane_chords
        if self.membrane == "arcs":
            eps = strains.membrane_arcs(1 if triangle else 4 * s[0] * s[1])
            terms.append(Term("membrane", eps, through(A), corners))
            terms.append(Term("bending", kappa, through(D), inside))
        elif self.thick:
            both = _stack(eps, kappa, strains.director_strain)
            C = [[A, B if self.coupled else None, D], [B if self.coupled else None, D, E], [D, E, F]]
            terms.append(Term("membrane and bending", both, stacked(C), inside))
        elif self.coupled:
            both = _stack(eps, kappa)
            terms.append(Term("membrane and bending", both, stacked([[A, B], [B, D]]), inside))
        else:
            terms.append(Term("membrane", eps, through(A), inside))
            terms.append(Term("bending", kappa, through(D), inside))
        return terms

    def _terms_9_nodes(self, V, M, stiffness, stacked):
        A, B, D, E, F, S = stiffness
        C = ufl.dot(ufl.transpose(V), ufl.dot(A, V))
        T = ufl.dot(ufl.transpose(M), ufl.dot(S, M))
        eps, kap, gam = strains.membrane_chords, strains.curvature, strains.shear

        def mixed(p, q):
            return (
                C[0, 1] * (p[0] * q[1] + p[1] * q[0])
                + C[0, 2] * (p[0] * q[2] + p[2] * q[0])
                + C[1, 2] * (p[1] * q[2] + p[2] * q[1])
                + C[2, 2] * p[2] * q[2]
            )

        terms = [
            Term("membrane", eps, lambda p, q: C[0, 0] * p[0] * q[0], "gauss23"),
            Term("shear", gam, lambda p, q: T[0, 0] * p[0] * q[0], "lines1"),
            Term("membrane", eps, lambda p, q: C[1, 1] * p[1] * q[1], "gauss32"),
            Term("shear", gam, lambda p, q: T[1, 1] * p[1] * q[1], "lines2"),
            Term("membrane", eps, mixed, "gauss2"),
            Term("shear", gam, lambda p, q: T[0, 1] * (p[0] * q[1] + p[1] * q[0]), "gauss2"),
            Term("bending", kap, lambda p, q: ufl.dot(V * p, D * (V * q)), "gauss3"),
        ]
        b = B if self.coupled else None
        if self.thick:
            blocks = [[None, b, D], [b, None, E], [D, E, F]]
            both = _stack(eps, kap, strains.director_strain)
            terms.append(Term("coupling", both, stacked(blocks), "gauss2"))
        elif self.coupled:
            terms.append(Term("coupling", _stack(eps, kap), stacked([[None, b], [b, None]]), "gauss2"))
        return terms

    def _shear_over_bending(self):
        S, D = self.fabric.shear, self.fabric.bending
        return fem.Constant(self.mesh, float(np.trace(S) / (D[0, 0] + D[1, 1])))

    def _warp(self):
        warp = np.asarray(self.partition.surface.warp, float)
        if warp.ndim == 1:
            return fem.Constant(self.mesh, warp)
        # dolfinx renumbers cells: take each cell's warp by its original number
        field = fem.Function(fem.VectorFunctionSpace(self.mesh, ("DG", 0), dim=3))
        count = field.function_space.dofmap.index_map.size_local
        original = np.asarray(self.mesh.topology.original_cell_index)[:count]
        field.x.array.reshape(-1, 3)[:count] = warp[original]
        field.x.scatter_forward()
        return field

    def _corner_offsets(self, table):
        # a cell-wise field with the same corner values in every cell: UFL has no reference point
        family = "DQ" if len(table) == 4 else "DG"
        space = fem.FunctionSpace(self.mesh, ufl.VectorElement(family, self.mesh.ufl_cell(), 1, dim=2))
        field = fem.Function(space)
        dofs = space.dofmap.list.array.reshape(-1, len(table))
        field.x.array.reshape(-1, 2)[dofs] = table
        return field

    def forms(self):
        """Compiled (internal force, tangent) pairs, one per rule; compiled at the first call."""
        if "forms" not in self._compiled:
            v, dw = ufl.TestFunction(self.space), ufl.TrialFunction(self.space)
            pairs = []
            for measure, terms in self._by_rule():
                force, tangent = 0, 0
                for term in terms:
                    strain = term.strain(self._configuration(self.w))
                    virtual = expand_derivatives(ufl.derivative(strain, self.w, v))
                    change = expand_derivatives(ufl.derivative(strain, self.w, dw))
                    stress_strain = self._linearised(term.strain)
                    work = term.product(stress_strain, virtual)
                    force += work * measure
                    tangent += (term.product(change, virtual) * measure) + ufl.derivative(
                        work * measure, self.w, dw
                    )
                pairs.append((force, tangent))
            if self.loads.pressures:
                self._pressure = fem.Constant(self.mesh, 0.0)
                pairs.append(self._pressure_forms(v, dw))
            flat = compiled([form for pair in pairs for form in pair])
            self._compiled["forms"] = list(zip(flat[::2], flat[1::2], strict=True))
        return self._compiled["forms"]

    def energy(self):
        """Strain energy [J] by kind of term; the same on every rank."""
        if "energy" not in self._compiled:
            kinds = {}
            for measure, terms in self._by_rule():
                for term in terms:
                    strain = self._strain(term.strain, self.w)
                    kinds.setdefault(term.name, []).append(
                        0.5 * term.product(strain, strain) * measure
                    )
            self._compiled["energy"] = {k: compiled(forms) for k, forms in kinds.items()}
        return {
            kind: self.comm.allreduce(sum(fem.assemble_scalar(form) for form in forms))
            for kind, forms in self._compiled["energy"].items()
        }

    def internal_force(self, out, level=0.0, stress_from=None):
        """Add the internal force less the pressure's into a Vec of the space, ghosts included.

        `stress_from` is (w_, dw_), arrays with ghosts: stress linearised about w_; None: exact.
        """
        self._set_stress(stress_from)
        self._set_pressure(level)
        for force, _ in self.forms():
            fem_petsc.assemble_vector(out, force)

    def tangent(self, out, level=0.0, stress_from=None):
        """Assemble the derivative of `internal_force` into a matrix of `create_tangent`."""
        self._set_stress(stress_from)
        self._set_pressure(level)
        out.zeroEntries()
        for _, tangent in self.forms():
            fem_petsc.assemble_matrix(out, tangent)

    def create_tangent(self):
        """Matrix (6 n, 6 n) with the pattern of `tangent`."""
        return fem_petsc.create_matrix(self.forms()[0][1])

    def _set_stress(self, stress_from):
        before, step = (self.w.x.array, 0.0) if stress_from is None else stress_from
        self.before.x.array[:] = before
        self.step.x.array[:] = step

    def _set_pressure(self, level):
        if self.loads.pressures:
            self.forms()
            self._pressure.value = sum(a(level) * p for a, p in self.loads.pressures)

    def _pressure_forms(self, v, dw):
        c = self._configuration(self.w)
        G = ufl.Jacobian(self.mesh)
        G1, G2 = (ufl.as_vector([G[i, a] for i in range(3)]) for a in range(2))
        normal = ufl.cross(*c.g) / ufl.sqrt(ufl.dot(ufl.cross(G1, G2), ufl.cross(G1, G2)))
        rule = {"triangle": "vertices", "quadrilateral": "gauss2"}[self.partition.surface.kind]
        rule = "gauss3" if self.partition.surface.degree == 2 else rule
        vu = ufl.as_vector([v[i] for i in range(3)])
        measure = ufl.Measure("dx", domain=self.mesh, metadata=strains.RULES[rule])
        force = -self._pressure * ufl.dot(normal, vu) * measure
        return force, ufl.derivative(force, self.w, dw)

    def _by_rule(self):
        groups = {}
        for term in self.terms():
            groups.setdefault(term.rule, []).append(term)
        for rule, terms in groups.items():
            yield ufl.Measure("dx", domain=self.mesh, metadata=strains.RULES[rule]), terms

    def _configuration(self, w):
        return strains.configuration(self.mesh, w)

    def _strain(self, measure, w):
        return measure(self._configuration(w)) - measure(self._configuration(self.reference))

    def _linearised(self, measure):
        at = measure(self._configuration(self.before))
        change = expand_derivatives(ufl.derivative(at, self.before, self.step))
        return self._strain(measure, self.before) + change


def compiled(forms):
    """Compile UFL forms; all signatures first, since compiling one changes those of others."""
    for form in forms:
        form.signature()
    return [fem.form(form, jit_params=JIT) for form in forms]


def _stack(*measures):
    def strain(c):
        parts = [m(c) for m in measures]
        return ufl.as_vector([p[k] for p in parts for k in range(3)])

    return strain
