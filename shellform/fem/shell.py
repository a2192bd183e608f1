# SPDX-License-Identifier: LGPL-3.0-or-later
"""The director shell: field, strain energy and the forms derived from it, Eqs. 2, 3, 13, 14.

UFL sees one nodal field w = (u, d). The strain energy per area is
(eps A eps + 2 eps B kap + kap D kap + gam S gam)/2, the thickness being integrated exactly; with
`thick` also the products of chi. The internal force is its derivative. The two rotations of a node
enter later, algebraically (director.py, equilibrium.py).

Tangent. The exact one fails for thin sheets: the stress of an iterate off the solution is mostly
error. In the geometric part the stress linearised about the iterate before is used instead,
C (e(w_) + De(w_)[dw_]) (mixed integration point, Magisano, Leonetti and Garcea, Int. J. Numer.
Methods Engrg. 109, 2017). With w_ = w and dw_ = 0 the same form is the exact tangent.
"""

import warnings
import weakref
from functools import cached_property

from mpi4py import MPI

import numpy as np

import ufl
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from ufl.algorithms import expand_derivatives

from meshes import Surface
from meshes.geometry import widest_corners
from shellform.material.sheet import Sheet

from .dolfinx_compat import compiled
from .element import check_warp, energy_terms, measure, terms_of
from .loads import Loads
from .partition import Partition
from .shape_functions import locate
from .strains import configuration
from .supports import Supports


class Shell:
    """A sheet of fabric on a surface.

    Parameters
    ----------
    surface : meshes.Surface
        Triangles, quads or 9-node quads; its `warp` is needed by fabrics with a direction.
        Quads and triangles with arcs are made for sheets that fold: bending *in their own plane*
        they are stiff on coarse meshes (a cantilever of 10 quads has 0.23 of its deflection, 0.67
        with membrane='chords'); 9-node quads are right there too.
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
        for name, value, choices in (
            ("membrane", membrane, ("arcs", "chords")),
            ("curvature", curvature, ("turning", "plain")),
        ):
            if value not in choices:
                raise ValueError(f"{name} is one of {', '.join(choices)}, not '{value}'")
        for given, kind, name in (
            (surface, Surface, "a meshes.Surface"),
            (fabric, Sheet, "a Fabric"),
        ):
            if not isinstance(given, kind):
                raise TypeError(f"Shell takes {name} here, not {type(given).__name__}: {given!r}")
        if fabric.directional:
            check_warp(surface, fabric)
        if surface.cells.shape[1] == 4 and not comm.rank:
            warn_of_corners(surface)
        self.surface, self.fabric = surface, fabric
        self.options = {"membrane": membrane, "curvature": curvature, "thick": thick}
        self.partition = partition = Partition(surface, comm)
        self.comm, self.mesh, self.space = comm, partition.mesh, partition.space
        self.w, self.reference = fem.Function(self.space, name="w"), fem.Function(self.space)
        self.supports = Supports(partition)
        self.loads = Loads(partition, fabric.areal_mass)
        self.rest()
        self._compiled = {}
        self._owner: weakref.ref | None = None

    def rest(self):
        """Put the sheet back into its reference state."""
        self.reference.x.array.reshape(-1, 6)[:, 3:] = self.partition.directors
        self.w.x.array[:] = self.reference.x.array

    @cached_property
    def before(self):
        """Field w of the iterate before; made when a tangent or a form first needs it."""
        return fem.Function(self.space)

    @cached_property
    def step(self):
        """Change of w since `before`, or rates of w; made when first needed."""
        return fem.Function(self.space)

    def claim(self, owner: object) -> None:
        """Let the last solver that calls it have the configuration; others ask `is_claimed_by`."""
        self._owner = weakref.ref(owner)

    def is_claimed_by(self, owner: object) -> bool:
        """True for the last one that has called `claim`."""
        return self._owner is not None and self._owner() is owner

    def take_directors(self):
        """Take over the reference directors that supports have put into their planes."""
        rest, w = (f.x.array.reshape(-1, 6)[:, 3:] for f in (self.reference, self.w))
        moved = np.any(rest != self.partition.directors, axis=1) & np.all(w == rest, axis=1)
        w[moved] = self.partition.directors[moved]
        rest[:] = self.partition.directors

    def forms(self):
        """Compiled (internal force, tangent) pairs, one per rule; compiled when first needed."""
        if "strain" not in self._compiled:
            v, dw = ufl.TestFunction(self.space), ufl.TrialFunction(self.space)
            pairs = []
            for dx, terms in self.by_rule():
                force = tangent = 0
                for term in terms:
                    strain = term.strain(self.configuration(self.w))
                    virtual = expand_derivatives(ufl.derivative(strain, self.w, v))
                    change = expand_derivatives(ufl.derivative(strain, self.w, dw))
                    work = term.product(self._linearised(term.strain), virtual) * dx
                    force += work
                    tangent += term.product(change, virtual) * dx
                    tangent += ufl.derivative(work, self.w, dw)
                pairs.append((force, tangent))
            self._compiled["strain"] = compiled(pairs)
        if self.loads.pressures and "pressure" not in self._compiled:
            self._pressure = fem.Constant(self.mesh, 0.0)
            force = self.pressure_force(self._pressure)
            tangent = ufl.derivative(force, self.w, ufl.TrialFunction(self.space))
            self._compiled["pressure"] = compiled([(force, tangent)])
        pressure = self._compiled["pressure"] if self.loads.pressures else []
        return self._compiled["strain"] + pressure

    def plan(self):
        """What is modelled: element, terms, where in the cell they are evaluated, and the loads."""
        energy = energy_terms(self.mesh, self.surface, self.fabric, **self.options)
        return {
            "element": f"{self.surface.kind} of degree {self.surface.degree}",
            "terms": terms_of(self.fabric, thick=self.options["thick"]),
            "evaluated": [f"{term.name} at {term.rule}" for term in energy],
            "loads": self.loads.kinds(),
        }

    def displacements(self):
        """Displacements (n, 3) [m] in the surface's numbering; all ranks call it, all get them."""
        return self._gathered()[:, :3]

    def positions(self):
        """Present positions (n, 3) [m] in the surface's numbering, on every rank."""
        return self.partition.surface.points + self.displacements()

    def directors(self):
        """Present unit directors (n, 3) in the surface's numbering, on every rank."""
        return self._gathered()[:, 3:]

    def displacement_at(self, point):
        """Displacement (3,) [m] of the point of the surface that was at `point` (3,) at rest.

        All ranks call it, all get the value.
        """
        nodes, weights = locate(self.partition.surface, point)
        return weights @ self.displacements()[nodes]

    def _gathered(self):
        owned = self.w.x.array.reshape(-1, 6)[: self.partition.n_owned]
        return self.partition.gather(owned)

    def energy(self):
        """Strain energy [J] by kind of term; the same on every rank."""
        if "energy" not in self._compiled:
            kinds = {}
            for dx, terms in self.by_rule():
                for term in terms:
                    strain = self.strain(term.strain, self.w)
                    kinds.setdefault(term.name, []).append(0.5 * term.product(strain, strain) * dx)
            self._compiled["energy"] = dict(zip(kinds, compiled(list(kinds.values())), strict=True))
        return {
            kind: self.comm.allreduce(sum(fem.assemble_scalar(form) for form in forms))
            for kind, forms in self._compiled["energy"].items()
        }

    def internal_force(self, out, pressure=0.0, stress_from=None):
        """Add the internal force less the pressure's into a Vec of the space, ghosts included.

        `stress_from` is (w_, dw_), arrays with ghosts: stress linearised about w_; None: exact.
        """
        self._set_stress(stress_from)
        self._set_pressure(pressure)
        for force, _ in self.forms():
            fem_petsc.assemble_vector(out, force)

    def tangent(self, out, pressure=0.0, stress_from=None):
        """Assemble the derivative of `internal_force` into a matrix of `create_tangent`."""
        self._set_stress(stress_from)
        self._set_pressure(pressure)
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

    def _set_pressure(self, pressure):
        if self.loads.pressures:
            self.forms()
            self._pressure.value = pressure

    def pressure_force(self, pressure):
        """UFL form of minus the force of a pressure that stays normal to the moving surface."""
        v = ufl.TestFunction(self.space)
        now = self.configuration(self.w)
        rest = self.configuration(self.reference)
        area = ufl.cross(*rest.g)
        # per reference area: the surface element of the moving surface over that at rest
        normal = ufl.cross(*now.g) / ufl.sqrt(ufl.dot(area, area))
        rule = {3: "vertices", 4: "gauss2", 9: "gauss3"}[self.surface.cells.shape[1]]
        virtual = ufl.as_vector([v[i] for i in range(3)])
        return -pressure * ufl.dot(normal, virtual) * measure(self.mesh, rule)

    def by_rule(self):
        """Energy terms grouped by rule: list of (UFL measure, Terms)."""
        groups = {}
        for term in energy_terms(self.mesh, self.surface, self.fabric, **self.options):
            groups.setdefault(term.rule, []).append(term)
        return [(measure(self.mesh, rule), terms) for rule, terms in groups.items()]

    def configuration(self, w):
        """Tangents and directors of a nodal field, see strains.Configuration."""
        return configuration(self.mesh, w)

    def strain(self, strain, w):
        """A strain measure of a nodal field, less that of the reference state."""
        return strain(self.configuration(w)) - strain(self.configuration(self.reference))

    def _linearised(self, strain):
        at = strain(self.configuration(self.before))
        change = expand_derivatives(ufl.derivative(at, self.before, self.step))
        return self.strain(strain, self.before) + change


def warn_of_corners(surface):
    """Warn of four-node quads that lean too much to bend as they should.

    Rolled up into a circle, strips of quads with corners of 120, 150 and 170 degrees have their tip
    wrong by 0.03, 2 and 50 % of the length (`demos/studies/extremes/sheets.py`).
    """
    widest = widest_corners(surface.points, surface.cells)
    worst, count = int(widest.argmax()), int((widest > 150.0).sum())
    if count:
        warnings.warn(
            f"cell {worst} of {surface.source} has a corner of {widest[worst]:.0f} degrees (more "
            f"than 150 in {count} cells): quads that lean so much are too stiff in bending, cut "
            "them into triangles or mesh this place again",
            stacklevel=3,
        )
