# SPDX-License-Identifier: LGPL-3.0-or-later
"""Parts of a run: what `stepper.add` takes, and what a stepper does with it.

    contact = stepper.add(Contact(body))
    ledger = stepper.add(Ledger("ledger.csv"))

`add` returns what `attach` returns. A description (`Contact`) returns the running part that it
describes; a `Part` returns itself. Every part has its turn once a step, in the order of adding:
in explicit steps between the kick and the drift, with the free velocities in `stepper.v`; in
implicit steps at the end of a step that has been solved. `add` takes a plain function
(stepper, dt) as well.

Steps that diverge are taken back, and runs are stopped and gone on with. So a part tells its state:
`state` and `restore` are of one rank and of the memory, `saved` is of all ranks and of a file.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol, Self, runtime_checkable

import numpy as np


@runtime_checkable
class Attachable(Protocol):
    """What can be added to a stepper: a Part, or the description of one."""

    def attach(self, stepper: Any) -> Any:
        """Start to run with a stepper; returns the running part."""


class Part:
    """What runs with a stepper; derive from it and write `__call__`.

    A part that changes in `__call__` gives what has changed in `state` and takes it back in
    `restore`. `books_contact` is True for parts that read what contact did in a step: contact must
    have had its turn before them.
    """

    books_contact = False
    _stepper: Any = None

    @property
    def stepper(self) -> Any:
        """The stepper that the part runs with; ValueError before it is added to one."""
        if self._stepper is None:
            name = type(self).__name__
            raise ValueError(f"{_article(self)} runs with a stepper: stepper.add({name}(...))")
        return self._stepper

    def attach(self, stepper: Any) -> Self:
        """Start to run with a stepper, once; returns self."""
        self._take(stepper)
        stepper.parts.append(self)
        return self

    def _take(self, stepper: Any) -> None:
        if self._stepper is not None:
            raise ValueError(
                f"{_article(self)} runs with one stepper only: make another for the second one"
            )
        self._stepper = stepper

    def __call__(self, stepper: Any, dt: float) -> None:
        """Its turn in a step of length dt [s]."""

    def state(self) -> Any:
        """What steps change in the part, on this rank, for `restore` (copies)."""
        return None

    def restore(self, state: Any) -> None:
        """Continue from `state()`."""

    def saved(self) -> dict[str, Any]:
        """What a later run needs to go on, over all ranks, by name; all ranks call."""
        return {}


class PlainFunction(Part):
    """A plain function (stepper, dt) as a part."""

    def __init__(self, function: Callable[[Any, float], object]) -> None:
        self.function = function

    def __call__(self, stepper: Any, dt: float) -> None:
        self.function(stepper, dt)


class AppliedForce(Part):
    """Forces on nodes that depend on positions, velocities and time; explicit steps only.

    Booked as external, with the loads. `add_force` is called at every kick, and whenever velocities
    or energies are asked for; it changes nothing but `force`.
    """

    def attach(self, stepper: Any) -> Self:
        """Start to push the nodes of a stepper; returns self."""
        self._take(stepper)
        stepper.add_applied_force(self)
        return self

    def add_force(self, stepper: Any, force: np.ndarray) -> None:
        """Add to force (n_owned, 3) [N] at the positions and the time of a kick."""
        raise NotImplementedError


class RunningContact(Part):
    """Contact of a sheet with a body while it runs; what its books are read from.

    Attributes
    ----------
    body : contact.body.segments.Body
    last, window : contact.solver.contact_ledger.Ledger, of the last step and of all since `reset`
    segment : (n_owned,) int, segment that each node touches, -1 without contact
    active, sticking, pinched : int, nodes in contact in the last step, of these in stick, and
        pressed by two parts of the body
    max_depth, pinch_depth : float [m], deepest start of the last step, of nodes not pinched and
        pinched
    friction : contact.solver.friction.Friction, the law
    seconds : float, time the contact has cost
    """

    body: Any
    last: Any
    window: Any
    segment: Any
    seconds: float

    @property
    def active(self) -> int:
        raise NotImplementedError

    @property
    def sticking(self) -> int:
        raise NotImplementedError

    @property
    def pinched(self) -> int:
        raise NotImplementedError

    @property
    def max_depth(self) -> float:
        raise NotImplementedError

    @property
    def pinch_depth(self) -> float:
        raise NotImplementedError

    @property
    def friction(self) -> Any:
        raise NotImplementedError

    def attach(self, stepper: Any) -> Self:
        """Start to meet the sheet of a stepper; returns self."""
        stepper.set_contact(self)
        return super().attach(stepper)

    def reset(self) -> None:
        """Begin a new window."""
        self.window.clear()

    def touched(self) -> Any:
        """What is touched, for `set_touched` of the same contact under another stepper (copies)."""
        raise NotImplementedError

    def set_touched(self, touched: Any) -> None:
        """Take over what another contact of the same sheet and body has touched."""
        raise NotImplementedError

    def resume(self, path: str | Path, state: dict[str, np.ndarray]) -> None:
        """Go on from what `saved` has put into a file; all ranks call."""
        raise NotImplementedError


def _article(part: Part) -> str:
    name = type(part).__name__
    return ("an " if name[0] in "AEIO" else "a ") + name
