# SPDX-License-Identifier: LGPL-3.0-or-later
"""C code of this package, compiled when first used and kept on disk beside FFCx's.

C code is compiled for the processor it runs on. The environment variable SHELLFORM_CFLAGS names
other flags in place of -march=native, as SHELLFORM_CFLAGS=-march=x86-64-v2 for machines of many
kinds that share a cache; code compiled with other flags is kept beside.

The name of a library is a hash of its source, the flags, the compiler and the processor. It is
written under another name and then moved, so that processes that compile at once replace it by the
same thing.
"""

import hashlib
import os
import platform
import shlex
import shutil
import subprocess
import sysconfig
import tempfile
from collections.abc import Mapping
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import cffi

from .dolfinx_compat import cache_folder
from .quiet_compiler import LOG

# without NaN or infinity assumed away: a step that explodes must be seen to
FAST = ["-fno-math-errno", "-fno-trapping-math", "-fassociative-math"]
FAST += ["-fno-signed-zeros", "-freciprocal-math", "-ffp-contract=fast"]


def compiler_flags(environment: Mapping[str, str] = os.environ) -> list[str]:
    """Flags of the C compiler, those of the processor among them; ValueError for what is none."""
    given = environment.get("SHELLFORM_CFLAGS", "-march=native")
    processor = shlex.split(given)
    if not all(flag.startswith("-") for flag in processor):
        raise ValueError(
            f"SHELLFORM_CFLAGS is {given!r}: give flags of the C compiler, as -march=x86-64-v2"
        )
    return ["-O3", *processor, *FAST]


def compiler(environment: Mapping[str, str] = os.environ) -> list[str]:
    """Command of the C compiler: that of CC, else the one that Python was built with, else cc.

    Raises
    ------
    RuntimeError if there is none
    """
    named = environment.get("CC")
    commands = [named] if named else [sysconfig.get_config_var("CC") or "cc", "cc"]
    for command in map(shlex.split, commands):
        if command and shutil.which(command[0], path=environment.get("PATH")):
            return command
    raise RuntimeError(
        f"no C compiler: {commands[0]!r} is not found; install one (Debian: apt install gcc) or "
        "name it in the environment variable CC"
    )


def library(source: Path, declarations: str) -> tuple[Any, Any]:
    """Interface of cffi and the library of a C file, compiled unless it is kept.

    Parameters
    ----------
    declarations : of the functions wanted, as in C

    Raises
    ------
    ValueError for SHELLFORM_CFLAGS that are no flags; RuntimeError if there is no C compiler, or if
    it refuses
    """
    return _opened(source, declarations, tuple(compiler()), tuple(compiler_flags()))


@cache
def _opened(source, declarations, command, flags):
    ffi = cffi.FFI()
    ffi.cdef(declarations)
    path = cache_folder() / f"{source.stem}-{_key(source, command, flags)}.so"
    try:
        return ffi, ffi.dlopen(str(path))
    except OSError:  # none, or cut short by a power cut
        return ffi, _compiled(ffi, source, command, flags, path)


def _key(source, command, flags):
    program = Path(shutil.which(command[0]) or command[0]).resolve()
    known = program.stat()
    content = source.read_bytes(), command, flags, str(program), known.st_size, known.st_mtime_ns
    return hashlib.sha256(repr((content, _processor())).encode()).hexdigest()[:24]


def _processor():
    """What -march=native goes by: kind and abilities of the processor, as far as they are known."""
    with suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text().split("\n\n")[0].splitlines()
        kinds = "vendor_id", "cpu family", "model", "flags", "Features", "CPU"
        return [line for line in lines if line.startswith(kinds) and "MHz" not in line]
    return platform.machine(), platform.processor()


def _compiled(ffi, source, command, flags, path):
    """Compile into a folder of its own, move what comes out to `path` if that can be written."""
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder, path.name)
        words = [*command, *flags, "-w", "-shared", "-fPIC", str(source), "-o", str(made)]
        LOG.info("compiling %s; it is kept for the next run", source.name)
        run = subprocess.run(words, capture_output=True, text=True)
        if run.returncode or not made.is_file():
            errors = [line for line in run.stderr.splitlines() if "error" in line]
            raise RuntimeError(
                f"the C compiler refuses {source.name}: {(errors or [run.stderr.strip()])[0]} "
                f"(command: {shlex.join(words)})"
            )
        written = path.with_suffix(f".{os.getpid()}-{Path(folder).name}.tmp")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(made, written)
            os.replace(written, path)
        except OSError:  # a full disk or a folder that cannot be written to: once a process
            with suppress(OSError):
                written.unlink()
        return ffi.dlopen(str(made))
