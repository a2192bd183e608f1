# SPDX-License-Identifier: LGPL-3.0-or-later
"""C code of this package, compiled when first used and kept on disk beside FFCx's.

The name of a library is a hash of its source, the flags, the compiler and the processor: what was
compiled otherwise is kept beside. It is written under another name and then moved, so that
processes that compile at once replace it by the same thing. The hash of its content stands at its
end: of a file that a power cut has shortened, the loader would map what is not there, and the
program die of it.
"""

import hashlib
import os
import platform
import shlex
import shutil
import subprocess
import tempfile
import time
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import cffi

from shellform.errors import CompilerError

from .c_compiler import check_room, compiler, compiler_flags
from .dolfinx_compat import cache_folder
from .killed_compile import OLD
from .quiet_compiler import LOG

HASH = 32  # bytes of a SHA-256


def library(source: Path, declarations: str, *options: str) -> tuple[Any, Any]:
    """Interface of cffi and the library of a C file, compiled unless it is kept.

    Parameters
    ----------
    declarations : of the functions wanted, as in C
    options : further flags of the compiler, as "-DNODES=3"

    Raises
    ------
    ValueError for SHELLFORM_CFLAGS that are no flags; CompilerError if there is no C compiler, if
    it refuses, or has nowhere to write to
    """
    return _opened(source, declarations, tuple(compiler()), (*compiler_flags(), *options))


@cache
def _opened(source, declarations, command, flags):
    ffi = cffi.FFI()
    ffi.cdef(declarations)
    path = cache_folder() / f"{source.stem}-{_key(source, command, flags)}.so"
    if _whole(path):
        with suppress(OSError):  # a folder whose files may not be run
            return ffi, ffi.dlopen(str(path))
    return ffi, _compiled(ffi, source, command, flags, path)


def _whole(path):
    """Whether a library is there and as it was written."""
    try:
        content = path.read_bytes()
    except OSError:
        return False
    return content[-HASH:] == hashlib.sha256(content[:-HASH]).digest()


def _key(source, command, flags):
    program = Path(shutil.which(command[0]) or command[0]).resolve()
    known = program.stat()
    headers = [file.read_bytes() for file in sorted(source.parent.glob("*.h"))]
    content = (
        source.read_bytes(),
        headers,
        command,
        flags,
        str(program),
        known.st_size,
        known.st_mtime_ns,
    )
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
    LOG.info("compiling %s; it is kept for the next run", source.name)
    with suppress(OSError):
        _remove_dead(path.parent)
    try:
        folder = tempfile.TemporaryDirectory(prefix="shellform-")
    except OSError as error:
        raise CompilerError(f"nowhere to compile {source.name}: {error.strerror}") from None
    with folder as place:
        made = Path(place, path.name)
        words = [*command, *flags, "-w", "-shared", "-fPIC", str(source), "-o", str(made)]
        run = subprocess.run(words, capture_output=True, text=True)
        if run.returncode or not made.is_file():
            check_room(Path(place).parent, "free some there, or name another folder in TMPDIR")
            errors = [line for line in run.stderr.splitlines() if "error" in line]
            raise CompilerError(
                f"the C compiler refuses {source.name}: {(errors or [run.stderr.strip()])[0]} "
                f"(command: {shlex.join(words)})"
            )
        written = path.with_suffix(f".{os.getpid()}-{Path(place).name}.tmp")
        content = made.read_bytes()
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            written.write_bytes(content + hashlib.sha256(content).digest())
            os.replace(written, path)
        except OSError:  # a full disk or a folder that cannot be written to: once a process
            with suppress(OSError):
                written.unlink()
        return ffi.dlopen(str(made))


def _remove_dead(folder):
    """Remove what processes have left that were killed while they wrote."""
    for written in folder.glob("*.tmp"):
        if written.stat().st_mtime < time.time() - OLD:
            written.unlink(missing_ok=True)
