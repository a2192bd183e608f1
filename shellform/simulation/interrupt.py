# SPDX-License-Identifier: LGPL-3.0-or-later
"""Ctrl-C as a question between steps, the same answer on all ranks."""

import signal

from mpi4py import MPI


class Interrupt:
    """Ctrl-C as a question to be asked between windows, the same answer on all ranks."""

    def __init__(self, comm: MPI.Comm):
        self.comm, self.pressed = comm, False

    def __enter__(self):
        self.before = signal.signal(signal.SIGINT, self._press)
        return self

    def __exit__(self, *_):
        signal.signal(signal.SIGINT, self.before)

    def _press(self, *_):
        self.pressed = True

    def asked(self) -> bool:
        """True on all ranks once a rank has been interrupted."""
        return bool(self.comm.allreduce(int(self.pressed)))
