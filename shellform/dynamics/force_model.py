# SPDX-License-Identifier: LGPL-3.0-or-later
"""What pushes the nodes of explicit steps from inside: Eq. 14 for a shell, Sec. 2.1 for springs.

`Newmark` steps M a = f_ext - r for any r. A force model gives r, its energy, what damping takes,
and a linear stand-in from which the stable step follows. `ShellForce` is the director shell,
`Springs` are those of `Particles`; a third one needs the methods below and goes in as
`Newmark(shell, force_model=...)`.
"""

from typing import Any, Protocol

import numpy as np


class InnerFriction(Protocol):
    """Friction inside the cloth: sliders in the cells of this rank, in its own order.

    Attributes
    ----------
    slips : (m, s), of the sliders of each cell, copied; see `ClothFriction.table`
    lost : float [J], what they have lost on this rank since the start
    state : arrays that steps change, for a copy and its return
    """

    lost: float

    @property
    def slips(self) -> np.ndarray: ...

    @property
    def state(self) -> list[np.ndarray]: ...

    def set_slips(self, slips: np.ndarray) -> None:
        """Take over slips (m, s)."""

    def borne(self, w: np.ndarray) -> np.ndarray:
        """Stresses (m, s) that the sliders bear at w (n_local, 6)."""


class ForceModel(Protocol):
    """Internal forces of the owned nodes of a sheet.

    Fields: w (n_local, 6), displacements [m] and directors, ghosts valid; v, q (n_owned, 3), their
    rates [m/s, 1/s]. Forces: (n_owned, 6), work-conjugate to displacement and director [N, N m].

    Attributes
    ----------
    turns_directors : bool; False: directors are held, as the forces know none
    friction : what slips inside the cloth as forces are asked for, None: nothing does
    """

    turns_directors: bool

    @property
    def friction(self) -> InnerFriction | None: ...

    def force(self, w: np.ndarray, v: np.ndarray, q: np.ndarray, time: float) -> np.ndarray:
        """Forces with damping, at a time [s]; may be written over by the next call."""

    def freeze(self, w: np.ndarray) -> Any:
        """What `elastic` needs to know of the state that it is asked for about."""

    def elastic(self, w: np.ndarray, frozen: Any) -> np.ndarray:
        """Forces without damping, smooth in w, of a sheet that is taut under the stress of a
        frozen state: their differences give the stable step. A slack cell is soft only until it is
        taut again.
        """

    def energy(self, w: np.ndarray) -> dict[str, float]:
        """Strain energy [J] by kind of term, over all ranks; all ranks call."""

    def damping_loss(self, v_old: np.ndarray, v: np.ndarray, dt: float, last: float) -> float:
        """What damping takes on this rank [J] while the forces of the last call of `force` act.

        v_old, v : (n_owned, 3) [m/s], at the start and at the end of these dt [s]
        last : float [s], duration of the kick before
        """

    def describe(self) -> dict[str, Any]:
        """Terms of the model for the plan of a run: `terms`, `loads` and more."""
