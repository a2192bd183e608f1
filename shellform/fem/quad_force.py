# SPDX-License-Identifier: LGPL-3.0-or-later
"""Internal force of 4-node quads, eight or four cells at a time: Eq. 14.

quad_force.c computes it; here are the arrays it reads. All strains of a cell come from six segments
and four lines, which UFL would work out at every quadrature point anew. The membrane is that of six
lengths, resolved, or relaxed by wrinkles that the cells are too large to make. Sums run cell by
cell in the order given, so they depend neither on the processor's vectors nor on where arrays lie.
"""

from pathlib import Path

import numpy as np

from shellform.material.sheet import Sheet

from .c_library import library
from .quad_rest import at_rest
from .taut_fibres import table

SOURCE = Path(__file__).with_name("quad_force.c")
DECLARATIONS = """
int lanes(void);
void relax(ptrdiff_t count, const double *fabric, const double *strain, const double *cost,
           double *stress);
double add_forces(ptrdiff_t count, const int *nodes, const double *points, const double *numbers,
                  const double *fabric, const double *w, const double *ahead,
                  const double *cost, const double *arcs, double *frozen, int freeze, double *r);
"""
ALIGNED = 64  # bytes, of the largest vector
GIVEN = "w", "ahead", "cost", "arcs", "frozen"  # arguments of add_forces, in its order
FIELDS = "w", "ahead"


class QuadForce:
    """The internal force of a sheet of 4-node quads.

    Damped, the stress is that of the strains plus their rates times a time tau, in the present
    configuration: it resists every change of strain, whatever stress there is, and no rigid motion.
    A relaxed membrane has the stress relaxed at those strains: with damping, too, it bears no more
    compression than wrinkles cost, and as its energy is convex, rates are never helped.

    Parameters
    ----------
    points, directors : (n, 3), reference state; cells : (m, 4) int, nodes in tensor order
    warp : (3,), (m, 3) or None; fabric : Sheet
    relaxed : bool; flat : (m, 4, 3) or None, stiffer : (m,) or None, see `quad_rest.at_rest`

    Attributes
    ----------
    nbytes : int, of what a call reads besides the fields

    Raises
    ------
    CompilerError if there is no C compiler
    """

    def __init__(
        self,
        points: np.ndarray,
        directors: np.ndarray,
        cells: np.ndarray,
        warp: np.ndarray | None,
        fabric: Sheet,
        relaxed: bool = False,
        flat: np.ndarray | None = None,
        stiffer: np.ndarray | None = None,
    ) -> None:
        self._ffi, self._library = library(SOURCE, DECLARATIONS)
        width = self._library.lanes()
        self.count, self.nodes, self.relaxed = len(cells), len(points), relaxed
        padded = np.concatenate([cells, np.repeat(cells[-1:], -len(cells) % width, axis=0)])
        blocks = padded.reshape(-1, width, 4).transpose(0, 2, 1)
        self._none = self._ffi.NULL
        # by name of an argument: the array last given, and the pointer to it
        self._known: dict[str, tuple] = dict.fromkeys((*GIVEN, "r"), (None, self._none))
        arrays = [
            np.ascontiguousarray(blocks, np.int32),
            np.ascontiguousarray(points, float),
            in_blocks(
                at_rest(points, directors, cells, warp, fabric, relaxed, flat, stiffer), width
            ),
        ]
        self.nbytes = sum(array.nbytes for array in arrays)
        kinds = ["int[]", *["double[]"] * 2]
        self._fixed = [self._ffi.from_buffer(k, a) for k, a in zip(kinds, arrays, strict=True)]
        fibres = np.ascontiguousarray(table(fabric.membrane), float) if relaxed else None
        self._fixed.append(self._ffi.from_buffer("double[]", fibres) if relaxed else self._none)

    def __call__(
        self,
        w: np.ndarray,
        r: np.ndarray,
        ahead: np.ndarray | None = None,
        cost: np.ndarray | None = None,
        arcs: np.ndarray | None = None,
        frozen: np.ndarray | None = None,
    ) -> float:
        """Add the forces of all cells to r.

        Parameters
        ----------
        w : (n, 6), (u, d); r : (n, 6), C-contiguous, added to [N, N m]
        ahead : (n, 6), w plus tau times its rates; None: undamped
        cost, arcs : (m,), of a relaxed membrane: what a wrinkle costs [N/m], weight of the arcs
        frozen : (m, 3), of `freeze`: the taut sheet under this stress, in place of relaxation

        Returns
        -------
        Twice what the rates would store as strains [J]: over tau, the power of damping; 0 undamped
        """
        return self._add(w, r, ahead, cost, arcs, frozen, False)

    def freeze(self, w: np.ndarray, cost: np.ndarray, arcs: np.ndarray) -> np.ndarray:
        """Stress (m, 3) [N/m] that relaxation adds at w to that of the taut sheet."""
        frozen = np.zeros((self.count, 3))
        self._add(w, np.zeros((self.nodes, 6)), None, cost, arcs, frozen, True)
        return frozen

    def _add(self, w, r, ahead, cost, arcs, frozen, freeze):
        if self.relaxed and not len(cost) == len(arcs) == self.count:
            raise ValueError(f"cost and arcs of {self.count} cells, not {len(cost)}, {len(arcs)}")
        given = map(self._pointer, GIVEN, (w, ahead, cost, arcs, frozen))
        return self._library.add_forces(
            self.count, *self._fixed, *given, freeze, self._pointer("r", r)
        )

    def _pointer(self, name, array):
        if array is None:
            return self._none
        # a step hands over the arrays of the last one; what cffi points to can be neither freed
        # nor resized
        known, pointer = self._known[name]
        if array is known:
            return pointer
        if name in FIELDS and array.shape != (self.nodes, 6):
            raise ValueError(
                f"fields of {self.nodes} nodes are ({self.nodes}, 6), not {array.shape}"
            )
        if name == "r":
            pointer = self._ffi.from_buffer("double[]", array, require_writable=True)
        else:
            given = np.ascontiguousarray(array, float)
            pointer = self._ffi.from_buffer("double[]", given)
            if given is not array:  # a copy, which does not follow the array
                return pointer
        self._known[name] = array, pointer
        return pointer


def relaxed_stress(membrane: np.ndarray, strain: np.ndarray, cost: np.ndarray) -> np.ndarray:
    """Stress (m, 3) [N/m] of a membrane relaxed by wrinkles.

    Parameters
    ----------
    membrane : (3, 3), stiffness C [N/m]
    strain : (m, 3), (E11, E22, 2 E12); cost : (m,), of wrinkles [N/m]
    """
    ffi, code = library(SOURCE, DECLARATIONS)
    stress = np.zeros((len(strain), 3))
    given = [np.ascontiguousarray(a, float) for a in (table(membrane), strain, cost)]
    code.relax(len(strain), *(ffi.from_buffer("double[]", a) for a in [*given, stress]))
    return stress


def in_blocks(numbers: np.ndarray, width: int) -> np.ndarray:
    """Numbers (m, k) of cells as (blocks, k, width), aligned, zero where there is no cell."""
    shape = -(-len(numbers) // width), numbers.shape[1], width
    buffer = np.zeros(8 * int(np.prod(shape)) + ALIGNED, np.uint8)
    start = -buffer.ctypes.data % ALIGNED
    array = buffer[start : start + 8 * int(np.prod(shape))].view(float).reshape(shape)
    for lane in range(width):
        cells = numbers[lane::width]
        array[: len(cells), :, lane] = cells
    return array
