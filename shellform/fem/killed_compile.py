# SPDX-License-Identifier: LGPL-3.0-or-later
"""A compile that was killed is noticed and begun anew.

FFCx (0.5 to 0.11 alike) creates NAME.c, empty, as its lock, compiles, and writes NAME.c.cached when
all is done. A process that is killed in between leaves NAME.c without NAME.c.cached, and everyone
who wants that form waits for the time-out, then fails. The lock says nothing of its owner.

So who compiles holds a lock of the system on a file in the same folder, which ends with its
process, however that ends, and notes there when it began. Who then gets the lock and still finds a
note knows that its writer died: what was begun since then and is unfinished is removed. What is
older than any compiler takes is removed as well, of programs other than ours.
"""

import fcntl
import os
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

OLD = 600.0  # s, after which nobody compiles any more: the time-out of those who wait
CLOCKS = 2.0  # s, by which the clocks of processor and files may differ
LOCK = "shellform.lock"


@contextmanager
def alone(folder: Path) -> Iterator[None]:
    """Be the one process that compiles into a folder; what dead ones left unfinished is removed.

    One rank calls, the one that compiles, once none of those that it meets meanwhile has anything
    to compile before that. Where files cannot be locked or written, nothing is done.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        file = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError:  # a full cache that can only be read serves as well
        yield
        return
    try:
        with suppress(OSError):  # a file system without locks
            fcntl.flock(file, fcntl.LOCK_EX)
        remove_unfinished(folder, _began(file))
        os.pwrite(file, f"{time.time():20.3f}".encode(), 0)
        yield
        os.ftruncate(file, 0)
    except Exception:
        os.ftruncate(file, 0)  # FFCx has put away what failed
        raise
    finally:
        os.close(file)


def comm_of(groups: Sequence[tuple]) -> Any:
    """Ranks of the mesh of tuples of UFL forms, whose first one compiles; None without forms."""
    forms = [form for group in groups for form in group]
    return forms[0].ufl_domain().ufl_cargo().comm if forms else None


def remove_unfinished(folder: Path, since: float | None, old: float = OLD) -> list[str]:
    """Remove what stands unfinished in a folder of FFCx, so that it is compiled anew.

    Parameters
    ----------
    since : time [s] from which on what was begun is dead, or None
    old : age [s] beyond which all is

    Returns
    -------
    names of what was removed
    """
    removed = []
    for half in folder.glob("libffcx_*.c.~*"):  # of a process that died while it wrote NAME.c
        with suppress(OSError):
            if half.stat().st_mtime < time.time() - old:
                half.unlink()
    for source in folder.glob("libffcx_*.c"):
        if source.with_suffix(".c.cached").exists():
            continue
        with suppress(OSError):
            begun = source.stat().st_mtime
            if begun < time.time() - old or (since is not None and begun > since - CLOCKS):
                for part in folder.glob(f"{source.stem}.*"):
                    part.unlink()
                removed.append(source.stem)
    return removed


def _began(file: int) -> float | None:
    """When the last owner of the lock began, if it never ended."""
    try:
        return float(os.pread(file, 64, 0))
    except (OSError, ValueError):
        return None
