# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact of a sheet with a body, said once for explicit and implicit steps: Eqs. 15 and 16.

Segments that can pass between nodes meet edges and insides of cells besides in explicit steps;
implicit steps refuse them (contact/solver/thin_segments.py).

`stepper.add(Contact(body))` gives the running contact of that stepper: `ExplicitContact` or
`ImplicitContact`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Any

import numpy as np

from contact.body.flesh_bed import Flesh
from contact.body.segments import Body
from contact.body.surface_motion import SurfaceMotion
from contact.solver.friction import as_friction
from shellform.dynamics.part import RunningContact

from .self_contact import SelfContact, refuse_implicit


@dataclass(frozen=True)
class Contact:
    """How a sheet meets a body.

    Parameters
    ----------
    body : Body, a Wearer among them; or a moving closed surface of triangles by itself, as
        `contact.body.rigid_surface.RigidSurface`
    friction : float, (mu_s, mu_k) or a law, see contact/solver/friction.py
    offset : float [m] or None: half the fabric's thickness
    samples : "nodes" or 0: the nodes alone; k: also k x k points inside every 4-node cell (explicit
        steps)
    flesh_stiffness : float [Pa/m] or None: of the body where two parts of it press cloth against
        each other (explicit steps, contact/solver/soft_contact.py); None: hard
    flesh : Flesh or None: of the body everywhere, or of the surface by the segments that its
        triangles belong to (explicit steps, contact/body/flesh_bed.py)
    recovery : float [m/s], greatest speed at which a node that starts a step inside is moved out
    surface : SurfaceMotion or None: closed surface of triangles bound to segments of the body,
        which is met instead of their own shapes
    shapes : names of segments of the body whose own shapes are met besides the surface
    smooth : bool, whether a surface is met as a smooth one, or as its flat triangles with their
        sharp edges
    self_contact : whether the sheet meets itself too, with the same friction, or a SelfContact
        (explicit steps)

    Examples
    --------
    >>> import meshes, shellform as sf
    >>> fabric = sf.Fabric.isotropic(1e5, 0.3, 1e-3, 200.0)
    >>> shell = sf.Shell(meshes.rectangle(0.4, 0.4, (4, 4)), fabric)
    >>> shell.loads.gravity()
    >>> stepper = sf.Newmark(shell)
    >>> ball = sf.Body([sf.Segment("ball", [0.2] * 3, sf.Fixed((0.2, 0.2, -0.202)))])
    >>> contact = stepper.add(sf.Contact(ball, friction=0.3))
    >>> stepper.advance(0.05)
    >>> bool(contact.window.impulse[:, 2].sum() > 0)
    True
    """

    body: Any
    friction: Any = 0.3
    offset: float | None = None
    samples: int | str = "nodes"
    flesh_stiffness: float | None = None
    flesh: Flesh | None = None
    recovery: float = 0.1
    surface: SurfaceMotion | None = None
    smooth: bool = True
    shapes: Sequence[str] = ()
    self_contact: bool | SelfContact = False

    def __post_init__(self):
        if isinstance(self.body, SurfaceMotion) and self.surface is None:
            object.__setattr__(self, "surface", self.body)
        elif not isinstance(self.body, Body):
            raise TypeError(
                "Contact takes a Body, as Body([Segment(...)]) or a Wearer, or a surface as "
                f"RigidSurface(...), not {self.body!r}"
            )
        if not (self.surface is None or isinstance(self.surface, SurfaceMotion)):
            raise TypeError(
                f"the surface of a contact is one as RigidSurface(...) or None, not "
                f"{self.surface!r}"
            )
        if self.shapes and self.surface is None:
            raise ValueError(
                "`shapes` of a contact are met besides a surface, which is not given: leave them "
                "out, all shapes are met"
            )
        as_friction(self.friction)
        for name, value in (("offset", self.offset), ("flesh_stiffness", self.flesh_stiffness)):
            if value is not None and not (isinstance(value, Real) and 0 <= value < np.inf):
                raise ValueError(f"{name} of a contact is a finite number >= 0, not {value!r}")
        if self.flesh is not None:
            if not isinstance(self.flesh, Flesh):
                raise TypeError(
                    f"flesh of a contact is a Flesh, as Flesh(6.7e5), not {self.flesh!r}"
                )
            for name, left_out in (("flesh_stiffness", None), ("samples", "nodes")):
                if getattr(self, name) not in (left_out, 0):
                    raise ValueError(f"a contact with flesh takes no {name}: leave it out")
            self.flesh.beds(self.body.names)
        if not (isinstance(self.recovery, Real) and self.recovery > 0):
            raise ValueError(f"the recovery speed is positive, in m/s, not {self.recovery!r}")
        if not isinstance(self.self_contact, bool | SelfContact):
            raise ValueError(
                f"self_contact is True, False or a SelfContact, not {self.self_contact!r}"
            )

    def attach(self, stepper: Any) -> RunningContact:
        """The running contact of a stepper.

        Raises
        ------
        ValueError for values out of range, for a stepper that has a contact already or a ledger
        that was added before, and under implicit steps for samples, soft flesh and segments that
        can pass between nodes
        """
        # each kind of contact is loaded with the steps that need it
        if self.self_contact:
            refuse_implicit(stepper)
        if stepper.implicit:
            if self.samples not in ("nodes", 0):
                raise ValueError(
                    f"implicit steps meet the body at nodes, not at {self.samples} samples a cell: "
                    "leave `samples` out, or take Newmark"
                )
            if self.flesh_stiffness is not None:
                raise ValueError(
                    f"implicit steps know no soft flesh, as of {self.flesh_stiffness} Pa/m: leave "
                    "`flesh_stiffness` out, or take Newmark"
                )
            if self.flesh is not None:
                raise ValueError("implicit steps know no flesh: leave `flesh` out, or take Newmark")
            from .implicit_contact import ImplicitContact

            running = ImplicitContact(
                stepper, self.body, self.friction, self.offset, self.recovery, self.surface,
                self.smooth, self.shapes,
            )  # fmt: skip
            return running.attach(stepper)
        from .explicit_contact import ExplicitContact

        itself = self.self_contact
        met = ExplicitContact(
            stepper, self.body, self.friction, self.offset, self.samples, self.flesh_stiffness,
            self.recovery, self.flesh, self.surface, self.smooth, self.shapes,
            SelfContact(self.friction) if itself is True else itself or None,
        )  # fmt: skip
        return met.attach(stepper)


def require_contact(stepper: Any, what: str) -> Any:
    """The explicit contact of a stepper; ValueError where `what` is asked for without one."""
    contact = stepper.contact
    if contact is None:
        raise ValueError(
            f"{what} needs a contact: first contact = stepper.add(Contact(body)), then the rest"
        )
    if stepper.implicit:
        raise ValueError(f"{what} is booked in explicit steps only: take Newmark")
    return contact
