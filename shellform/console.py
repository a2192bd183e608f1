# SPDX-License-Identifier: LGPL-3.0-or-later
"""What every command line shares: PETSc's options, errors and warnings in one sentence, progress.

Under mpirun rank 0 alone speaks: warnings, the bar, the lines of `say`.
"""

import argparse
import codecs
import io
import logging
import os
import signal
import sys
import time
import traceback
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NoReturn

from mpi4py import MPI

from . import writable_folders
from .all_ranks import HEAD_START, PATIENCE, end_all_ranks
from .errors import CompilerError, Mendable, NotConverged, Stopped, Unstable
from .petsc_options import unused

COMM = MPI.COMM_WORLD  # all ranks of the program
# errors whose message tells a user what to do
KNOWN = (
    *(ValueError, FloatingPointError, OSError, ImportError),
    *(NotConverged, Unstable, CompilerError),
)


def parse(
    parser: argparse.ArgumentParser, arguments: Sequence[str] | None = None
) -> argparse.Namespace:
    """Parse a command line; options with one dash that the parser does not know go to PETSc.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    arguments : list of str or None, sys.argv without the program's name
    """
    from petsc4py import PETSc

    # PETSc takes a closed pipe for a crash; without its handler it is a BrokenPipeError, see `run`
    signal.signal(signal.SIGPIPE, signal.SIG_IGN)
    known, rest = parser.parse_known_args(arguments)
    if rest and (rest[0].startswith("--") or not rest[0].startswith("-")):
        parser.error(f"unknown argument {rest[0]}")
    for word in rest:
        if word.startswith("--"):
            parser.error(f"unknown argument {word}")
    PETSc.Options().insertString(" ".join(rest))
    return known


def positive(kind: type) -> Callable[[str], Any]:
    """Type of an argparse argument: a finite number above zero."""

    def convert(text: str) -> Any:
        value = kind(text)
        if not 0 < value < float("inf"):
            raise argparse.ArgumentTypeError(f"must be above zero, not {text}")
        return value

    convert.__name__ = kind.__name__
    return convert


def accuracy(text: str) -> float:
    """Type of `--accuracy`: a relative error, from the words draft, standard, fine or from N%."""
    from shellform.accuracy.asked import relative_error

    try:
        return relative_error(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def say(lines: Iterable[str]) -> None:
    """Print lines on rank 0."""
    if MPI.COMM_WORLD.rank == 0:
        print("\n".join(lines), flush=True)


def run(
    main: Callable,
    arguments: Sequence[str] | None = None,
    words: Mapping[str, str] | None = None,
) -> None:
    """Call main(arguments); end all ranks on an error, in one sentence where it is known.

    words : how the program spells options that mend an input, see `shellform.errors.Mendable`
    """
    be_quiet()
    print_all_names()
    for note in writable_folders.NOTES:
        logging.getLogger("shellform").info(note)
    # what mpirun makes of Ctrl-C, and how it ends the others after a failing rank, which has spoken
    ended = signal.SIG_DFL if MPI.COMM_WORLD.rank else _interrupt
    before = signal.signal(signal.SIGTERM, ended)
    try:
        _call(main, arguments)
        sys.stdout.flush()
        return
    except BrokenPipeError:  # as in `shellform check ... | head -1`: no more is wanted
        _leave_quietly()
    except KNOWN as error:
        said = error.in_words(words) if words and isinstance(error, Mendable) else error
        message, code = f"{_program()}: {said}", 2
    except Stopped as stop:
        # all ranks have agreed upon it; mpirun may take as long as it gives them to read a line
        message, code = "" if COMM.rank else f"{_program()}: {stop}", 130
    except KeyboardInterrupt:
        message, code = f"{_program()}: interrupted", 130
    except Exception:
        message, code = traceback.format_exc(), 1
    finally:
        signal.signal(signal.SIGTERM, before)
    # one voice: an error that all ranks meet is printed by rank 0, which then ends the others
    time.sleep(HEAD_START if MPI.COMM_WORLD.rank else 0.0)
    if message:
        print(message, file=sys.stderr, flush=True)
    else:
        time.sleep(PATIENCE)
    end_all_ranks(code)


def _call(main: Callable, arguments: Sequence[str] | None) -> None:
    """Call main(arguments); then, if solvers ran, warn of options that none has asked for."""
    given = sys.argv[1:] if arguments is None else arguments
    words = [*os.environ.get("PETSC_OPTIONS", "").split(), *given]
    try:
        main(arguments)
    except (NotConverged, Unstable):
        _warn_of_unused_options(words)
        raise
    _warn_of_unused_options(words)


def _warn_of_unused_options(words: Sequence[str]) -> None:
    """Misspelt options of PETSc change nothing, which nobody would notice."""
    names = unused(words)
    if names:
        what = f"no solver here has asked for {', '.join(names)}"
        warnings.warn(f"{what}: misspelt, or of another solver", stacklevel=1)


def _interrupt(*_: object) -> NoReturn:
    """Handler of a signal that ends the program as Ctrl-C does."""
    raise KeyboardInterrupt


def _leave_quietly() -> NoReturn:
    """End as Unix tools do whose reader has gone: without a word, also when Python flushes."""
    sys.stdout = open(os.devnull, "w")
    end_all_ranks(128 + signal.SIGPIPE)


def _program():
    """What the user called, without its folder."""
    name = Path(sys.argv[0]).name
    return "shellform" if name == "__main__.py" else name


def print_all_names() -> None:
    """Let stdout take names of files that are not UTF-8, as their bytes; stderr escapes them.

    What else the terminal's encoding lacks is escaped.
    """

    def as_bytes(error: UnicodeError) -> tuple[str | bytes, int]:
        try:
            return codecs.lookup_error("surrogateescape")(error)
        except UnicodeError:
            return codecs.lookup_error("backslashreplace")(error)

    codecs.register_error("shellform.names", as_bytes)
    if isinstance(sys.stdout, io.TextIOWrapper):  # others, as those of notebooks, take all
        sys.stdout.reconfigure(errors="shellform.names")


def be_quiet() -> None:
    """Warnings and notes of ours as sentences of rank 0; nothing of what other packages log."""
    warnings.showwarning = _show_warning
    # packages below log to the root logger, some by logging.info, which would set it up: it stays
    # as quiet as it is before
    root = logging.getLogger()
    if not root.handlers:
        root.addHandler(logging.NullHandler())
    # notes, as of how long forms were compiled
    log = logging.getLogger("shellform")
    log.setLevel(logging.WARNING if MPI.COMM_WORLD.rank else logging.INFO)
    log.propagate = False
    if not log.handlers:
        log.addHandler(logging.StreamHandler())


def _show_warning(message, category, filename, lineno, file=None, line=None):
    """In place of warnings.showwarning: what is wrong, not the file of ours that noticed."""
    if MPI.COMM_WORLD.rank == 0:
        print(f"warning: {message}", file=file or sys.stderr, flush=True)


def progress(iterable: Iterable, total: int, label: str) -> Iterable:
    """Pass items through, with a bar on rank 0's terminal and none elsewhere."""
    if MPI.COMM_WORLD.rank or not sys.stderr.isatty():
        return iterable
    from tqdm import tqdm

    return tqdm(iterable, total=total, desc=label, leave=False)
