# SPDX-License-Identifier: LGPL-3.0-or-later
"""The ledger of a run: momentum, energy and contact forces at every output time, ledger.csv.

Momentum closes step by step: m v(n+1/2) - m v(0) is the sum of the impulses of loads, supports,
drag and contact. What is left over is the column `momentum_residual`, roundoff. Energy is given as
it is at the output time; `energy_residual` is what the sum of all its changes leaves over, which is
stiffness damping if there is any, and the error of the time steps.
"""

from pathlib import Path

import numpy as np

AXES = "xyz"


class Ledger:
    """Columns of a moving shell, one row an output time.

    Parameters
    ----------
    path : CSV file, written by rank 0; None: rows are only returned
    stepper : Newmark
    touch : Touch or None

    Attributes
    ----------
    rows : list of dict
    """

    def __init__(self, path, stepper, touch=None):
        self.stepper, self.touch, self.rows = stepper, touch, []
        self._path = None if path is None or stepper.shell.comm.rank else Path(path)
        self._contact, self._contact_work = np.zeros(3), 0.0
        self._start = (self._momentum(), *self._energies())
        if self._path:
            self._path.unlink(missing_ok=True)

    def record(self):
        """Append a row for the present time and begin a new window of contact; all ranks call."""
        stepper, comm = self.stepper, self.stepper.shell.comm
        kinds = ("external", "support", "drag")
        work = comm.allreduce(np.array([stepper.work[kind] for kind in kinds]))
        impulses = comm.allreduce(
            np.array([stepper.external_total, stepper.support_total, stepper.drag_total])
        )
        momentum = self._momentum()
        kinetic, strain = self._energies()
        row = {"time": stepper.time, "kinetic": kinetic, "strain": strain}
        row |= {"external_work": work[0], "support_work": work[1], "drag_loss": work[2]}
        friction = impact = moved = 0.0
        if self.touch is not None:
            correction = self.touch.correction
            window = correction.window
            table = comm.allreduce(window.table)
            seconds = max(window.seconds, 1e-300)
            self._contact += table[:, :3].sum(axis=0)
            moved, friction, impact = table[:, 6].sum(), table[:, 7].sum(), table[:, 8].sum()
            for name, force in zip(correction.body.names, table[:, :6] / seconds, strict=True):
                for k in range(3):
                    row[f"force_{name}_{AXES[k]}"] = force[k]
                    row[f"moment_{name}_{AXES[k]}"] = force[3 + k]
            row["active"] = comm.allreduce(correction.active)
            row["pinched"] = comm.allreduce(correction.pinched)
            correction.reset()
        row |= {"body_work": moved, "friction_loss": friction, "impact_loss": impact}
        self._contact_work += moved - friction - impact
        change = momentum - self._start[0] - impulses.sum(axis=0) - self._contact
        for k in range(3):
            row[f"momentum_{AXES[k]}"] = momentum[k]
            row[f"support_impulse_{AXES[k]}"] = impulses[1, k]
        row["momentum_residual"] = float(np.linalg.norm(change))
        gain = kinetic + strain - self._start[1] - self._start[2]
        row["energy_residual"] = gain - work[0] - work[1] + work[2] - self._contact_work
        self.rows.append(row)
        if self._path:
            first = len(self.rows) == 1
            with open(self._path, "a") as file:
                file.write((",".join(row) + "\n" if first else "") + _line(row))
        return row

    def _momentum(self):
        stepper = self.stepper
        return stepper.shell.comm.allreduce(stepper.mass @ stepper.v)

    def _energies(self):
        stepper = self.stepper
        return stepper.momenta()[2], sum(stepper.shell.energy().values())


def _line(row):
    return ",".join(f"{value:.10g}" for value in row.values()) + "\n"
