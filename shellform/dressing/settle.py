# SPDX-License-Identifier: LGPL-3.0-or-later
"""Waiting until the dressed cloth is quiet: the end of every way to put a garment on.

The wearer stands still before the first frame of the motion. Cloth settles there until its root
mean square speed is that of `Dressing.quiet`; what time is left over is skipped.
"""

from collections.abc import Callable

import numpy as np

from shellform.contact_coupling.contact import require_contact
from shellform.dynamics.explicit import Newmark

from .belt import Belt
from .fit import fit
from .procedure import Dressing, Watch, unwatched
from .settings import borrowed

AT_LEAST = 0.1  # s, that cloth is given to find the body it now lies on


def settle(
    stepper: Newmark,
    belt: Belt | None,
    dressing: Dressing,
    watch: Watch = unwatched,
    every: float = 0.05,
) -> dict:
    """Wait until the cloth is quiet; the clock ends at the wearer's first frame.

    Returns
    -------
    dict: `seconds` it took, root mean square `speed` [m/s], whether `settled`, figures of `fit`
    """
    end, begin = _start_of_motion(stepper), stepper.time
    stepper.drag = dressing.drag
    while stepper.time < end - 1e-9 and speed(stepper) > dressing.quiet:
        advance_watched(
            stepper, min(stepper.time + 0.1, end), every, lambda: watch("settle", stepper)
        )
    report = {"seconds": stepper.time - begin, "speed": speed(stepper)}
    report |= {"settled": report["speed"] <= dressing.quiet} | fit(stepper, belt)
    stepper.time = end
    watch("settled", stepper)
    return report


def settle_again(
    stepper: Newmark, tension: float | None, dressing: Dressing
) -> tuple[Belt | None, dict]:
    """Hold cloth that lies on the wearer by a belt of `tension` [N], and let it settle there.

    What hangs on the shoulders is held by none, `tension` None.

    It is given AT_LEAST seconds, which the report's `seconds` leave out, as neither the body nor
    the model of the cloth need be those it was draped with.

    Returns
    -------
    belt : Belt, which stays, or None; report : of `settle`
    """
    with borrowed(stepper):
        belt = None if tension is None else stepper.add(Belt("waist", tension))
        return belt, settle_on(stepper, belt, dressing)


def settle_on(
    stepper: Newmark, belt: Belt | None, dressing: Dressing, watch: Watch = unwatched
) -> dict:
    """As `settle_again`, held by a belt that is there, or by none; the report of `settle`."""
    with borrowed(stepper):
        stepper.time = _start_of_motion(stepper) - dressing.settle
        stepper.advance(stepper.time + AT_LEAST)
        return settle(stepper, belt, dressing, watch)


def _start_of_motion(stepper: Newmark) -> float:
    """Time [s] of the wearer's first frame."""
    return require_contact(stepper, "a dressed wearer").body.start


def speed(stepper: Newmark) -> float:
    """Root mean square speed of the cloth [m/s], on every rank."""
    sums = np.array([stepper.mass @ np.sum(stepper.v**2, axis=1), stepper.mass.sum()])
    squares, mass = stepper.shell.comm.allreduce(sums)
    return float(np.sqrt(squares / mass))


def advance_watched(
    stepper: Newmark, until: float, every: float, watch: Callable[[], None]
) -> None:
    """Advance in parts of about `every` [s], calling watch after each."""
    parts = max(1, int(np.ceil((until - stepper.time) / every - 1e-9)))
    for time in np.linspace(stepper.time, until, parts + 1)[1:]:
        stepper.advance(time)
        watch()
