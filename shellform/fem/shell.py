# SPDX-License-Identifier: LGPL-3.0-or-later
"""The director shell: its state, and what its weak form gives at it, Eqs. 2, 3, 13, 14.

UFL sees one nodal field w = (u, d). The internal force is the derivative of the strain energy
(weak_form.py), the thickness being integrated exactly; with `thick` also the products of chi. The
two rotations of a node enter later, algebraically (director.py, equilibrium.py).
"""

from __future__ import annotations

import weakref
from functools import cached_property
from typing import TYPE_CHECKING

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
from numpy.typing import ArrayLike

from meshes import Surface
from shellform.material.energy import StVenant, check_law
from shellform.material.sheet import Sheet

from .cell_membrane import NOT_RELAXED, CellMembrane, cell_warp
from .dolfinx_compat import (
    Constant,
    Function,
    assemble_matrix,
    assemble_scalar,
    assemble_vector,
    cell_nodes,
    compiled,
    create_matrix,
    vector_space,
)
from .element import energy_terms, has_six_lengths, terms_of
from .loads import Loads
from .partition import Partition
from .shape_functions import locate
from .shell_arguments import (
    check_arguments,
    check_coupling,
    check_friction,
    check_relaxed,
    check_stiffer,
    warn_of_corners,
)
from .sliders import Sliders, friction_terms
from .supports import Supports
from .weak_form import WeakForm
from .wrinkle_field import Wrinkling
from .wrinkles import Wrinkles

if TYPE_CHECKING:
    from .cell_stress import CellStress

# field w_ of an iterate and the change since, arrays with ghosts: the stress is linearised about it
Linearised = tuple[np.ndarray, np.ndarray]


class Shell:
    """A sheet of fabric on a surface.

    Parameters
    ----------
    surface : meshes.Surface
        Triangles, quads or 9-node quads; its `warp` is needed by fabrics with a direction.
        Triangles are made for sheets that fold: bending *in their own plane* they are stiff on
        coarse meshes (a cantilever of 10 x 1 squares, each cut in two, has 0.29 of its deflection),
        quads are not.
    fabric : Fabric
    comm : MPI communicator
    law : StVenant or one derived from it, as NeoHookean; default: the fabric's, else StVenant
        What the sheet stores in its strains, see material/energy.py. Any but the default makes the
        explicit force of 4-node quads several times dearer. Laws that couple stretching and
        bending take quads by chords.
    membrane : 'arcs' (default) or 'chords'
        Membrane strain of triangles and 4-node quads from the lengths of arcs (three sides; four
        sides and two diagonals), or from tangents, of quads at 2x2 Gauss points. Ignored by 9-node
        quads.
    wrinkles : 'resolved' (default) or 'relaxed'
        Whether cells answer compression as they are, or give way as cloth does that wrinkles below
        their size (material/wrinkling.py); the latter for 4-node quads with arcs.
    curvature : 'turning' (default) or 'plain'
        Curvature by turning angles or by x,a . d,b. Ignored by 9-node quads.
    stiffer : (m,) or None
        Bending stiffness of each cell over that of the fabric, as at seams; None: 1. For quadratic
        laws without friction, triangles and 4-node quads in the default form.
    thick : bool
        Keep the strain quadratic in the thickness coordinate (matters for t kappa > 0.1).

    Attributes
    ----------
    w : fem.Function (u, d) [m, -]; reference : the same before loading
    supports : Supports, loads : Loads
    cell_membrane : CellMembrane of 4-node quads with arcs, None for others

    Raises
    ------
    ValueError for an unknown option or a missing warp direction; FabricError for a law that does
    not start with the fabric's stiffness

    Examples
    --------
    >>> import meshes, shellform as sf
    >>> surface = meshes.rectangle(0.4, 0.1, (4, 1))
    >>> shell = sf.Shell(surface, sf.Fabric.isotropic(1e6, 0.3, 1e-3, 400.0))
    >>> shell.positions().shape
    (10, 3)
    """

    def __init__(
        self,
        surface: Surface,
        fabric: Sheet,
        comm: MPI.Comm = MPI.COMM_WORLD,
        *,
        law: StVenant | None = None,
        membrane: str = "arcs",
        curvature: str = "turning",
        thick: bool = False,
        wrinkles: str = "resolved",
        stiffer: np.ndarray | None = None,
    ):
        check_arguments(surface, fabric, membrane, curvature, wrinkles)
        if surface.cells.shape[1] == 4 and not comm.rank:
            warn_of_corners(surface, stacklevel=3)
        self.surface, self.fabric = surface, fabric
        law = fabric.law if law is None else law
        self.law = StVenant() if law is None else law
        check_law(self.law, fabric)
        check_coupling(self.law, fabric, thick)
        if wrinkles == "relaxed":
            check_relaxed(surface, fabric, self.law, membrane, thick)
        self.relaxed = wrinkles == "relaxed"
        self.options: dict = {"membrane": membrane, "curvature": curvature, "thick": thick}
        check_friction(surface, fabric, self.in_default_form)
        self.stiffer = None if stiffer is None else np.asarray(stiffer, float)
        if self.stiffer is not None:
            check_stiffer(self.stiffer, surface, fabric, self.law, self.in_default_form)
        self.partition = partition = Partition(surface, comm)
        self.comm, self.mesh, self.space = comm, partition.mesh, partition.space
        self.w, self.reference = Function(self.space, name="w"), Function(self.space)
        self.supports = Supports(partition)
        self.loads = Loads(partition, fabric.areal_mass)
        self.rest()
        self._compiled: dict = {}
        self._owner: weakref.ref | None = None

    def rest(self) -> None:
        """Put the sheet back into its reference state, in which nothing has slipped."""
        self.reference.x.array.reshape(-1, 6)[:, 3:] = self.partition.directors
        self.w.x.array[:] = self.reference.x.array
        if "cell_stress" in vars(self) and self.cell_stress is not None:  # else not made yet
            self.cell_stress.forget()

    @property
    def in_default_form(self) -> bool:
        """True with arcs, turning angles, no `thick` and nothing that couples strains."""
        plain = self.options == {"membrane": "arcs", "curvature": "turning", "thick": False}
        return plain and not (self.law.couples or np.any(self.fabric.coupling))

    @cached_property
    def weak_form(self) -> WeakForm:
        """Energy, virtual work and tangent in UFL; made when first needed."""
        terms = energy_terms(
            self.partition, self.fabric, self.law, **self.options, stiffer=self.stiffer
        )
        return self._form(terms)

    def _form(self, terms):
        return WeakForm(self.mesh, terms, self.w, self.reference, self.partition.flat_field)

    @cached_property
    def cell_membrane(self) -> CellMembrane | None:
        """Membrane of 4-node quads with arcs, else None; made when first needed."""
        options = self.options["membrane"], self.options["thick"], self.law
        if not has_six_lengths(self.surface, self.fabric, *options):
            return None
        reference = self.reference.x.array.reshape(-1, 6)
        membrane = CellMembrane(self.partition, self.fabric, self.law, reference, self.relaxed)
        if self.fabric.friction is not None:
            assert self.cell_stress is not None
            membrane.sliders = Sliders(self.fabric.friction, self.cell_stress)
        return membrane

    @cached_property
    def cell_stress(self) -> CellStress | None:
        """Stress in the middle of cells: friction inside the cloth, curves of quads; else None.

        Made when first needed, and only if the fabric names friction or curves.
        """
        friction, curves = self.fabric.friction, None
        quads = self.surface.cells.shape[1] == 4
        if quads and self.law.in_the_middle and self.in_default_form:
            curves = self.law.curves
        if friction is None and curves is None:
            return None
        # only here: compiled code that other sheets do not need
        from .cell_stress import CellStress

        partition = self.partition
        return CellStress(
            partition.surface.points[partition.nodes] - partition.origin,
            self.reference.x.array.reshape(-1, 6)[:, 3:],
            np.ascontiguousarray(cell_nodes(self.space)),
            cell_warp(self.surface, self.fabric, partition),
            self.fabric, curves, friction, partition.flat,
        )  # fmt: skip

    @cached_property
    def _slips(self) -> Function:
        """Slips of the sliders as a field of cells."""
        assert self.fabric.friction is not None
        width = sum(self.fabric.friction.counts())
        return Function(vector_space(self.mesh, "DG", 0, width))

    def friction_loss(self) -> float:
        """Energy [J] lost so far by friction inside the cloth, on every rank."""
        return 0.0 if self.cell_stress is None else self.comm.allreduce(self.cell_stress.lost)

    def keep_slips(self) -> None:
        """Let sliders of friction inside the cloth slip to where the present state takes them."""
        if self.fabric.friction is not None:
            assert self.cell_stress is not None
            self.cell_stress.keep(self.w.x.array.reshape(-1, 6))

    @property
    def wrinkles(self) -> Wrinkles | None:
        """When the cells of a relaxed sheet wrinkle; None for a resolved one."""
        return self.cell_membrane.wrinkles if self.relaxed and self.cell_membrane else None

    @cached_property
    def before(self) -> Function:
        """Field w of the iterate before; made when a tangent or a form first needs it."""
        return Function(self.space)

    def claim(self, owner: object) -> None:
        """Let the last solver that calls it have the configuration; others ask `is_claimed_by`."""
        self._owner = weakref.ref(owner)

    def is_claimed_by(self, owner: object) -> bool:
        """True for the last one that has called `claim`."""
        return self._owner is not None and self._owner() is owner

    @cached_property
    def step(self) -> Function:
        """Change of w since `before`, or rates of w; made when first needed."""
        return Function(self.space)

    def take_directors(self) -> None:
        """Take over the reference directors that supports have put into their planes."""
        rest, w = (f.x.array.reshape(-1, 6)[:, 3:] for f in (self.reference, self.w))
        moved = np.any(rest != self.partition.directors, axis=1) & np.all(w == rest, axis=1)
        w[moved] = self.partition.directors[moved]
        rest[:] = self.partition.directors

    def forms(self) -> list[tuple]:
        """Compiled (internal force, tangent) pairs, one per rule; compiled when first needed."""
        if "strain" not in self._compiled:
            form = self.weak_form
            pairs = form.newton(self.before, self.step)
            if self.fabric.friction is not None:
                terms = friction_terms(self.partition, self.fabric, self._slips)
                pairs += self._form(terms).newton(self.before, self.step)
            self._compiled["strain"] = compiled(pairs)
        if self.loads.pressures and "pressure" not in self._compiled:
            self._pressure = Constant(self.mesh, 0.0)
            self._compiled["pressure"] = compiled([self.weak_form.pressure(self._pressure)])
        pressure = self._compiled["pressure"] if self.loads.pressures else []
        return self._compiled["strain"] + pressure

    def plan(self) -> dict:
        """What is modelled: element, terms, where in the cell they are evaluated, and the loads."""
        more = {} if type(self.law) is StVenant else {"law": repr(self.law)}
        if self.fabric.provenance is not None:
            more["fabric"] = f"{self.fabric.name}: {self.fabric.provenance.line()}"
        return {
            "element": f"{self.surface.kind} of degree {self.surface.degree}",
            "terms": terms_of(self.fabric, thick=self.options["thick"]),
            "evaluated": [f"{term.name} at {term.rule}" for term in self.weak_form.terms]
            + (["membrane by six lengths"] if self.cell_membrane else []),
            "wrinkles": "relaxed" if self.relaxed else "resolved",
            "loads": self.loads.kinds(),
        } | more

    def displacements(self) -> np.ndarray:
        """Displacements (n, 3) [m] in the surface's numbering; all ranks call it, all get them."""
        return self._gathered()[:, :3]

    def positions(self) -> np.ndarray:
        """Present positions (n, 3) [m] in the surface's numbering, on every rank."""
        return self.partition.surface.points + self.displacements()

    def directors(self) -> np.ndarray:
        """Present unit directors (n, 3) in the surface's numbering, on every rank."""
        return self._gathered()[:, 3:]

    def displacement_at(self, point: ArrayLike) -> np.ndarray:
        """Displacement (3,) [m] of the point of the surface that was at `point` (3,) at rest.

        All ranks call it, all get the value.
        """
        nodes, weights = locate(self.partition.surface, point)
        return weights @ self.displacements()[nodes]

    def wrinkling(self) -> Wrinkling:
        """Taut, wrinkled and slack cells of a relaxed sheet as it lies now.

        In the surface's numbering of cells; all ranks call it, all get it.

        Raises
        ------
        ValueError for a sheet that is not relaxed
        """
        if not (self.relaxed and self.cell_membrane):
            raise ValueError(NOT_RELAXED)
        state, crest, strain = self.cell_membrane.wrinkling(self.w.x.array)
        whole = self.partition.gather_cells(np.column_stack([state, strain, crest]))
        return Wrinkling(whole[:, 0].astype(np.int64), whole[:, 2:], whole[:, 1])

    def _gathered(self):
        owned = self.w.x.array.reshape(-1, 6)[: self.partition.n_owned]
        return self.partition.gather(owned)

    def energy(self) -> dict[str, float]:
        """Strain energy [J] by kind of term; the same on every rank."""
        if "energy" not in self._compiled:
            kinds = self.weak_form.energy()
            self._compiled["energy"] = dict(zip(kinds, compiled(list(kinds.values())), strict=True))
        energy = {
            kind: self.comm.allreduce(sum(assemble_scalar(form) for form in forms))
            for kind, forms in self._compiled["energy"].items()
        }
        if self.cell_membrane:
            membrane = self.cell_membrane.energy(self.w.x.array)
            energy["membrane"] = self.comm.allreduce(membrane)
        if self.fabric.friction is not None:
            assert self.cell_stress is not None
            stored = self.cell_stress.stored(self.w.x.array.reshape(-1, 6))
            energy["friction"] = self.comm.allreduce(stored)
        return energy

    def internal_force(
        self, out: PETSc.Vec, pressure: float = 0.0, stress_from: Linearised | None = None
    ) -> None:
        """Add the internal force less the pressure's into a Vec of the space, ghosts included.

        `stress_from` is (w_, dw_), arrays with ghosts: stress linearised about w_; None: exact.
        """
        self._set_stress(stress_from)
        self._set_pressure(pressure)
        for force, _ in self.forms():
            assemble_vector(out, force)
        if self.cell_membrane:
            with out.localForm() as local:
                self.cell_membrane.add_force(local.array_w, self.w.x.array, stress_from)

    def tangent(
        self, out: PETSc.Mat, pressure: float = 0.0, stress_from: Linearised | None = None
    ) -> None:
        """Assemble the derivative of `internal_force` into a matrix of `create_tangent`."""
        self._set_stress(stress_from)
        self._set_pressure(pressure)
        out.zeroEntries()
        for _, tangent in self.forms():
            assemble_matrix(out, tangent)
        if self.cell_membrane:
            self.cell_membrane.add_tangent(out, self.w.x.array, stress_from)

    def create_tangent(self) -> PETSc.Mat:
        """Matrix (6 n, 6 n) with the pattern of `tangent`."""
        return create_matrix(self.forms()[0][1])

    def _set_stress(self, stress_from):
        if self.fabric.friction is not None:
            assert self.cell_stress is not None
            space = self._slips.function_space
            values = self._slips.x.array.reshape(-1, space.dofmap.index_map_bs)
            values[cell_nodes(space)[:, 0]] = self.cell_stress.slips
        before, step = (self.w.x.array, 0.0) if stress_from is None else stress_from
        self.before.x.array[:] = before
        self.step.x.array[:] = step

    def _set_pressure(self, pressure):
        if self.loads.pressures:
            self.forms()
            self._pressure.value = pressure


def require_shell(given: object, taker: str) -> Shell:
    """The shell given to what steps or solves it; TypeError for anything else."""
    if not isinstance(given, Shell):
        raise TypeError(
            f"{taker} takes a Shell, as Shell(meshes.rectangle(1.0, 1.0, (8, 8)), fabric), not "
            f"{type(given).__name__}: {given!r}"
        )
    return given
