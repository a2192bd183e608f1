# SPDX-License-Identifier: LGPL-3.0-or-later
"""The C compiler: which one, its flags, and in one sentence why it has made nothing.

C code is compiled for the processor it runs on. The environment variable SHELLFORM_CFLAGS names
other flags in place of -march=native, as SHELLFORM_CFLAGS=-march=x86-64-v2 for machines of many
kinds that share a cache. Forms are compiled by FFCx with flags of its own, -O2, in place of which
stand those of SHELLFORM_FORM_CFLAGS: with -O0, as in tests, a form that is needed once is there in
half the time.

FFCx, cffi, setuptools and dolfinx pass a failed compile on in errors of five kinds, whose texts
change with their versions. So it is not they that are read: what a compiler needs is tried again.
"""

import os
import shlex
import shutil
import sysconfig
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import cffi

from shellform.errors import CompilerError

# without NaN or infinity assumed away: a step that explodes must be seen to
FAST = ["-fno-math-errno", "-fno-trapping-math", "-fassociative-math"]
FAST += ["-fno-signed-zeros", "-freciprocal-math", "-ffp-contract=fast"]
ROOM = 4 << 20  # bytes, more than any file that a compile writes


def compiler_flags(environment: Mapping[str, str] = os.environ) -> list[str]:
    """Flags of the C compiler, those of the processor among them; ValueError for what is none."""
    processor = _flags("SHELLFORM_CFLAGS", environment, "-march=native", "-march=x86-64-v2")
    return ["-O3", *processor, *FAST]


def form_flags(environment: Mapping[str, str] = os.environ) -> list[str] | None:
    """Flags for forms, None: FFCx's own; ValueError for what is none."""
    return _flags("SHELLFORM_FORM_CFLAGS", environment, "", "-O0") or None


def _flags(name, environment, otherwise, example):
    given = environment.get(name, otherwise)
    flags = shlex.split(given)
    if not all(flag.startswith("-") for flag in flags):
        raise ValueError(f"{name} is {given!r}: give flags of the C compiler, as {example}")
    return flags


def compiler(environment: Mapping[str, str] = os.environ) -> list[str]:
    """Command of the C compiler: that of CC, else the one that Python was built with, else cc.

    Raises
    ------
    CompilerError if there is none
    """
    named = environment.get("CC")
    commands = [named] if named else [sysconfig.get_config_var("CC") or "cc", "cc"]
    for command in map(shlex.split, commands):
        if command and shutil.which(command[0], path=environment.get("PATH")):
            return command
    raise CompilerError(
        f"no C compiler: {commands[0]!r} is not found; install one (Debian: apt install gcc) or "
        "name it in the environment variable CC"
    )


def check_headers() -> None:
    """Raise CompilerError if Python's headers are missing, which forms are compiled with."""
    if not Path(sysconfig.get_path("include"), "Python.h").is_file():
        raise CompilerError("no Python.h, which forms are compiled with: apt install python3-dev")


def check_room(folder: Path, mend: str) -> None:
    """Raise CompilerError if a folder has no room for what a compiler writes.

    mend : what to do then, in words
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder) as file:
            for _ in range(ROOM >> 16):
                file.write(bytes(1 << 16))
            file.flush()
    except OSError as error:
        raise CompilerError(
            f"compiled code cannot be written to {folder}: {error.strerror}; {mend}"
        ) from None


@contextmanager
def failures_as_sentences(folder: Path) -> Iterator[None]:
    """Raise a failed compile of forms as one CompilerError that says what to do.

    folder : where compiled forms are kept
    """
    try:
        yield
    except (cffi.VerificationError, OSError, RuntimeError) as error:
        ours = isinstance(error, (cffi.VerificationError, OSError))
        if not ours and not any(word in str(error) for word in ("JIT", "just-in-time")):
            raise  # of a mesh, say
        compiler()
        check_headers()
        check_room(folder, "free some there, or name another folder in XDG_CACHE_HOME")
        check_room(Path(tempfile.gettempdir()), "free some there, or name another folder in TMPDIR")
        raise CompilerError(
            f"the forms of the finite elements were not compiled into {folder}: "
            f"{(str(error).strip() or type(error).__name__).splitlines()[-1]}"
        ) from error
