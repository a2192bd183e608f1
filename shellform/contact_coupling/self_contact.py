# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact of a sheet with itself, said by a user: `SelfContact` alone or within a `Contact`.

    stepper.add(SelfContact(friction=0.3))                    # cloth and nothing else
    stepper.add(Contact(body, 0.3, self_contact=True))        # cloth on a body, and on itself
    stepper.add(Contact(body, 0.3, self_contact=SelfContact(0.2, thickness=2e-3)))

Explicit steps only. What it does: explicit_self_contact.py.
"""

from dataclasses import dataclass
from numbers import Real
from typing import Any

import numpy as np

from contact.solver.friction import as_friction
from shellform.dynamics.part import Part


@dataclass(frozen=True)
class SelfContact:
    """How a sheet meets itself.

    Parameters
    ----------
    friction : float, (mu_s, mu_k) or a law, see contact/solver/friction.py
    thickness : float [m] or None: the fabric's; distance that mid-surfaces keep
    recovery : float [m/s], greatest speed at which layers that start closer are moved apart

    Raises
    ------
    ValueError for numbers out of range

    Examples
    --------
    >>> import meshes, shellform as sf
    >>> fabric = sf.Fabric.isotropic(1e5, 0.3, 1e-3, 200.0)
    >>> shell = sf.Shell(meshes.rectangle(0.4, 0.4, (4, 4)), fabric)
    >>> stepper = sf.Newmark(shell)
    >>> cloth = stepper.add(sf.SelfContact(friction=0.3))
    >>> stepper.advance(0.01)
    >>> cloth.pairs, cloth.limited
    (0, 0)
    """

    friction: Any = 0.3
    thickness: float | None = None
    recovery: float = 0.1

    def __post_init__(self):
        as_friction(self.friction)
        t = self.thickness
        if t is not None and not (isinstance(t, Real) and 0 < t < np.inf):
            raise ValueError(
                f"the thickness of cloth on cloth is a length above 0 in m, not {t!r}: leave it "
                "out for that of the fabric"
            )
        if not (isinstance(self.recovery, Real) and self.recovery > 0):
            raise ValueError(f"the recovery speed is positive, in m/s, not {self.recovery!r}")

    def attach(self, stepper: Any) -> Part:
        """The running contact of a stepper.

        Raises
        ------
        ValueError for implicit steps, and for a stepper whose cloth meets a body or itself already
        """
        refuse_implicit(stepper)
        if stepper.contact is not None:
            raise ValueError(
                "this stepper's cloth meets a body already: both go together, say "
                "Contact(body, self_contact=True)"
            )
        # only here: its kernels are loaded for those who ask for it
        from .explicit_self_contact import ExplicitSelfContact

        return ExplicitSelfContact(stepper, self).attach(stepper)


def refuse_implicit(stepper: Any) -> None:
    """ValueError for a stepper of implicit steps."""
    if stepper.implicit:
        raise ValueError(
            "implicit steps know no contact of cloth with cloth: leave `self_contact` out, or take "
            "Newmark"
        )
