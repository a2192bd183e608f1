# SPDX-License-Identifier: LGPL-3.0-or-later
"""The ledger of a run: momentum, energy and contact forces at every output time, ledger.csv.

Momentum closes step by step: m v(n+1/2) - m v(0) is the sum of the impulses of loads, supports,
drag and contact. What is left over is the column `momentum_residual`, roundoff. Energies and works
are given at the output time. The work of all forces is the change of kinetic energy to roundoff;
the internal ones take the change of strain energy, `damping_loss` by stiffness damping,
`hysteresis_loss` by friction inside cloth that has it, and the error of the time steps, which is
`energy_residual`:

    kinetic + strain - start = external + support + body - friction - impact - drag - damping
                               - hysteresis - self_impact - self_friction + energy_residual.

Works and losses add up from the start, those of contact with the body from the row before.
Supports that move are booked with their velocity of the last half step, an error of first order.

The work of a follower pressure is booked with the internal forces: with one, energy_residual holds
it too.
"""

import csv
from pathlib import Path
from typing import Any, Self

import numpy as np

from shellform.dynamics.part import Part
from shellform.dynamics.time_stepper import Stepper

from .files import check_place, write_atomically

AXES = "xyz"


class Ledger(Part):
    """Columns of a moving shell, one row an output time, with those of its contact if it has one.

    Parameters
    ----------
    path : CSV file, written by rank 0; None: rows are only returned
    resumed : state of a run that is gone on with, see `saved`; its rows stay in the file

    Attributes
    ----------
    rows : list of dict

    Examples
    --------
    >>> import meshes, shellform as sf
    >>> fabric = sf.Fabric.isotropic(1e5, 0.3, 1e-3, 200.0)
    >>> shell = sf.Shell(meshes.rectangle(0.4, 0.4, (4, 4)), fabric)
    >>> shell.loads.gravity()
    >>> stepper = sf.Newmark(shell)
    >>> ledger = stepper.add(sf.Ledger("ledger.csv"))
    >>> stepper.advance(0.1)
    >>> row = ledger.record()
    >>> f"{row['momentum_z']:.2f} N s", row["momentum_residual"] < 1e-12
    ('-0.03 N s', True)
    """

    books_contact = True

    def __init__(
        self, path: str | Path | None = None, resumed: dict[str, Any] | None = None
    ) -> None:
        self.path, self._resumed = path, resumed
        self._file: Path | None = None  # rank 0 writes
        self.rows: list[dict[str, float]] = []
        self._contact, self._contact_work = np.zeros(3), 0.0
        self._lost = np.zeros(2)  # by contact of the sheet with itself before the books began

    def attach(self, stepper: Stepper) -> Self:
        """Begin the books with the present state of a stepper; all ranks call."""
        comm = stepper.shell.comm
        if self.path is not None:
            check_place(self.path, comm)
        super().attach(stepper)
        if self.path is not None and comm.rank == 0:
            self._file = Path(self.path)
        if self._resumed is not None:
            self._resume(self._resumed)
            return self
        self._start = self._momentum(), self._impulses(), stepper.balance()
        if stepper.self_contact is not None:
            self._lost = stepper.self_contact.losses.copy()
        if self._file:
            self._file.unlink(missing_ok=True)
        return self

    def _resume(self, resumed):
        kinds, numbers, sums = (resumed[f"ledger_{name}"] for name in ("kinds", "start", "sums"))
        start = dict(zip(kinds.tolist(), numbers[12:].tolist(), strict=True))
        self._start = numbers[:3], numbers[3:12].reshape(3, 3), start
        self._contact, self._contact_work = sums[:3].copy(), float(sums[3])
        self._lost = sums[4:6].copy()
        if self.path is None:
            return
        with open(self.path) as file:
            rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
        self.rows = [row for row in rows if row["time"] <= self.stepper.time + 1e-9]
        if self._file and self.rows:
            head = ",".join(self.rows[0]) + "\n"
            write_atomically(self._file, head + "".join(map(_line, self.rows)))

    def record(self) -> dict[str, float]:
        """Append a row for the present time and begin a new window of contact; all ranks call."""
        stepper, comm = self.stepper, self.stepper.shell.comm
        start, now = self._start[2], stepper.balance()
        impulses = self._impulses() - self._start[1]
        momentum = self._momentum()
        row = {"time": stepper.time, "kinetic": now["kinetic"], "strain": now["strain"]}
        change = {kind: now[kind] - start[kind] for kind in now}
        row |= {"external_work": change["external"], "support_work": change["support"]}
        row |= {"drag_loss": change["drag"], "damping_loss": change["damping"]}
        if "hysteresis" in change:
            row["hysteresis_loss"] = change["hysteresis"]
        friction = impact = moved = 0.0
        contact = stepper.contact
        if contact is not None:
            window = contact.window
            table = comm.allreduce(window.table)
            seconds = max(window.seconds, 1e-300)
            self._contact += table[:, :3].sum(axis=0)
            moved, friction, impact = table[:, 6].sum(), table[:, 7].sum(), table[:, 8].sum()
            for name, force in zip(contact.body.names, table[:, :6] / seconds, strict=True):
                for k in range(3):
                    row[f"force_{name}_{AXES[k]}"] = force[k]
                    row[f"moment_{name}_{AXES[k]}"] = force[3 + k]
            row["active"] = comm.allreduce(contact.active)
            row["pinched"] = comm.allreduce(contact.pinched)
            contact.reset()
        row |= {"body_work": moved, "friction_loss": friction, "impact_loss": impact}
        if stepper.self_contact is not None:
            lost = stepper.self_contact.losses - self._lost
            row["self_impact_loss"], row["self_friction_loss"] = lost.tolist()
        self._contact_work += moved - friction - impact
        residual = momentum - self._start[0] - impulses.sum(axis=0) - self._contact
        for k in range(3):
            row[f"momentum_{AXES[k]}"] = momentum[k]
            row[f"support_impulse_{AXES[k]}"] = impulses[1, k]
        row["momentum_residual"] = float(np.linalg.norm(residual))
        gain = change["kinetic"] + change["strain"] - self._contact_work
        given = change["external"] + change["support"] - change["drag"] - change["damping"]
        given -= change.get("hysteresis", 0.0)
        given -= row.get("self_impact_loss", 0.0) + row.get("self_friction_loss", 0.0)
        row["energy_residual"] = gain - given
        self.rows.append(row)
        if self._file:
            first = len(self.rows) == 1
            with open(self._file, "a") as file:
                file.write((",".join(row) + "\n" if first else "") + _line(row))
        return row

    def saved(self) -> dict[str, np.ndarray]:
        """What a later part of the run needs, for `resumed`."""
        momentum, impulses, start = self._start
        return {
            "ledger_start": np.concatenate([momentum, impulses.ravel(), list(start.values())]),
            "ledger_kinds": np.array(list(start)),
            "ledger_sums": np.concatenate([self._contact, [self._contact_work], self._lost]),
        }

    def _impulses(self):
        """Impulses of loads, supports and drag so far (3, 3) [N s], over all ranks."""
        stepper = self.stepper
        own = [stepper.external_total, stepper.support_total, stepper.drag_total]
        return stepper.shell.comm.allreduce(np.array(own))

    def _momentum(self):
        stepper = self.stepper
        return stepper.shell.comm.allreduce(stepper.mass @ stepper.v)


def _line(row):
    return ",".join(f"{value:.12g}" for value in row.values()) + "\n"
