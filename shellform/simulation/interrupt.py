# SPDX-License-Identifier: LGPL-3.0-or-later
"""Ctrl-C as a question between steps, the same answer on all ranks.

Open MPI's mpirun answers Ctrl-C by SIGTERM to its ranks, and by SIGKILL a second later; batch
systems announce the end of a job by SIGTERM too. So that is the same question.
"""

import signal

from mpi4py import MPI

SIGNALS = signal.SIGINT, signal.SIGTERM


class Interrupt:
    """Ctrl-C as a question to be asked between windows, the same answer on all ranks."""

    def __init__(self, comm: MPI.Comm):
        self.comm, self.pressed = comm, False

    def __enter__(self):
        self.before = [signal.signal(number, self._press) for number in SIGNALS]
        return self

    def __exit__(self, *_):
        for number, handler in zip(SIGNALS, self.before, strict=True):
            signal.signal(number, handler)

    def _press(self, *_):
        self.pressed = True

    def asked(self) -> bool:
        """True on all ranks once a rank has been interrupted."""
        return bool(self.comm.allreduce(int(self.pressed)))
