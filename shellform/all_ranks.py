# SPDX-License-Identifier: LGPL-3.0-or-later
"""An error that one rank meets ends all of them: the others would wait for it for ever.

`import shellform` hooks into what Python does with an exception that nobody catches. On one rank,
and while MPI is not in use, nothing changes; on several, what was to be shown is shown, by the hook
that was there before, and then all ranks end. Threads and `sys.exit` are Python's own affair:
`python -m mpi4py` sees to the latter.
"""

import fcntl
import os
import stat
import struct
import sys
import termios
import time
from types import ModuleType
from typing import NoReturn

HEAD_START = 0.5  # s, in which rank 0 tells, for all, what all ranks have met, and ends them
PATIENCE = 2.0  # s, for the launcher to read what was written last; MPICH's drops what it has not
PASSING_ON = 0.1  # s, for it to pass that on


def watch_exceptions() -> None:
    """End all ranks after an exception that nobody catches; called once, by `import shellform`."""
    before = sys.excepthook

    def hook(kind, error, trace):
        world = _several_ranks()
        if world is not None and world.COMM_WORLD.rank:
            time.sleep(HEAD_START)
        before(kind, error, trace)
        if world is not None:
            end_all_ranks(130 if issubclass(kind, KeyboardInterrupt) else 1)

    sys.excepthook = hook


def end_all_ranks(code: int) -> NoReturn:
    """End the program on all ranks, with an exit code; on one rank by leaving Python."""
    world = _several_ranks()
    if world is not None:
        for stream in (sys.stdout, sys.stderr):
            try:
                stream.flush()
                wait_until_read(stream.fileno())
            except (OSError, ValueError, AttributeError):  # closed, or nobody reads any more
                pass
        time.sleep(PASSING_ON)
        world.COMM_WORLD.Abort(code)
    sys.exit(code)


def wait_until_read(pipe: int) -> None:
    """Wait until what was written into a pipe was read at its other end, `PATIENCE` at most."""
    if not stat.S_ISFIFO(os.fstat(pipe).st_mode):
        return
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        (unread,) = struct.unpack("i", fcntl.ioctl(pipe, termios.FIONREAD, b"\0" * 4))
        if not unread:
            return
        time.sleep(0.01)


def _several_ranks() -> ModuleType | None:
    """mpi4py's MPI where it is in use on several ranks; it is not loaded for this."""
    world = sys.modules.get("mpi4py.MPI")
    if world is None or not world.Is_initialized() or world.Is_finalized():
        return None
    return world if world.COMM_WORLD.size > 1 else None
