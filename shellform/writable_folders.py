# SPDX-License-Identifier: LGPL-3.0-or-later
"""Folders for what is compiled, also where the user's own cannot be written to.

FFCx, numba, our C code and matplotlib keep files in the user's cache and look into the user's
settings. In containers and on clusters the home folder is often read-only, absent or another
user's. Then a temporary folder of this user takes its place, by the variables that all of them know
(XDG_CACHE_HOME, XDG_CONFIG_HOME, MPLCONFIGDIR, HOME), so that programs begun from here have it too.
It stays, so that the next run finds what this one compiled. Called before any of them is loaded.

A TMPDIR that cannot be written to is passed over by Python and compilers, and ends Open MPI as it
starts; so it is taken out.
"""

import os
import stat
import tempfile
from collections.abc import MutableMapping
from functools import cache
from pathlib import Path

KEPT = ("fenics", "fenics/shellform", "numba")  # folders in the user's cache
SETTINGS = ("dolfinx/dolfinx_jit_parameters.json", "dolfinx/dolfinx_jit_options.json")
NOTES: list[str] = []  # what there is to say of it, for the command lines


def provide(environment: MutableMapping[str, str] = os.environ) -> list[str]:
    """Name a temporary folder in the environment in place of those that do not serve.

    Returns
    -------
    lines that say so, none where all is well
    """
    notes = []
    given = environment.get("TMPDIR")
    if given and not writable(Path(given), made=True):
        del environment["TMPDIR"]
        tempfile.tempdir = None  # what Python has found before counts no more
        notes += [f"TMPDIR={given} cannot be written to: {tempfile.gettempdir()} is used"]
    try:
        home = Path(environment.get("HOME") or Path.home())
    except RuntimeError:  # a user without a name or a home
        home = Path("/nonexistent")
        environment["HOME"] = str(temporary())
    cache = Path(environment.get("XDG_CACHE_HOME") or home / ".cache")
    if not all(writable(cache / name) for name in KEPT):
        environment["XDG_CACHE_HOME"] = str(temporary())
        notes += [f"{cache} cannot be written to: compiled code is kept in {temporary()}"]
    config = Path(environment.get("XDG_CONFIG_HOME") or home / ".config")
    if not all(readable(config / name) for name in SETTINGS):
        environment["XDG_CONFIG_HOME"] = str(temporary())
    if "MPLCONFIGDIR" not in environment and not writable(config / "matplotlib"):
        environment["MPLCONFIGDIR"] = str(temporary() / "matplotlib")
    return notes


def writable(folder: Path, made: bool = False) -> bool:
    """Whether files can be put into a folder, or the folder be made unless it must be there."""
    for place in (folder, *([] if made else folder.absolute().parents)):
        try:
            found = place.stat()
        except FileNotFoundError:
            continue
        except OSError:
            return False
        return stat.S_ISDIR(found.st_mode) and os.access(place, os.W_OK | os.X_OK)
    return False


def readable(path: Path) -> bool:
    """Whether a file can be read, or plainly is not there."""
    try:
        with open(path):
            return True
    except FileNotFoundError:
        return True
    except OSError:
        return False


@cache
def temporary() -> Path:
    """Temporary folder of this user, made if missing; one of its own where another user has it."""
    folder = Path(tempfile.gettempdir(), f"shellform-{os.getuid()}")
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        found = folder.lstat()
        if stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid():
            return folder
    except OSError:
        pass
    return Path(tempfile.mkdtemp(prefix="shellform-"))
