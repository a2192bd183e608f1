# SPDX-License-Identifier: LGPL-3.0-or-later
"""What every command line shares: PETSc's options, errors in one sentence, progress."""

import argparse
import sys
import time
import traceback

from mpi4py import MPI

from .errors import Stopped


def parse(parser, arguments=None):
    """Parse a command line; options with one dash that the parser does not know go to PETSc.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    arguments : list of str or None, sys.argv without the program's name
    """
    from petsc4py import PETSc

    known, rest = parser.parse_known_args(arguments)
    if rest and (rest[0].startswith("--") or not rest[0].startswith("-")):
        parser.error(f"unknown argument {rest[0]}")
    for word in rest:
        if word.startswith("--"):
            parser.error(f"unknown argument {word}")
    PETSc.Options().insertString(" ".join(rest))
    return known


def positive(kind):
    """Type of an argparse argument: a finite number above zero."""

    def convert(text):
        value = kind(text)
        if not 0 < value < float("inf"):
            raise argparse.ArgumentTypeError(f"must be above zero, not {text}")
        return value

    convert.__name__ = kind.__name__
    return convert


def accuracy(text):
    """Type of `--accuracy`: a relative error, from the words draft, standard, fine or from N%."""
    from shellform.accuracy.choice import relative_error

    try:
        return relative_error(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def say(lines):
    """Print lines on rank 0."""
    if MPI.COMM_WORLD.rank == 0:
        print("\n".join(lines), flush=True)


def run(main, arguments=None):
    """Call main(arguments); end all ranks on an error, told in one sentence where it is known."""
    from .errors import NotConverged, Unstable

    known = (ValueError, NotConverged, Unstable, FloatingPointError, OSError, ImportError)
    world = MPI.COMM_WORLD
    try:
        main(arguments)
        return
    except known as error:
        message, code = f"{sys.argv[0]}: {error}", 2
    except Stopped as stop:
        message, code = f"{sys.argv[0]}: {stop}", 130
    except KeyboardInterrupt:
        message, code = f"{sys.argv[0]}: interrupted", 130
    except Exception:
        message, code = traceback.format_exc(), 1
    # one voice: an error that all ranks meet is told by rank 0, which then ends the others
    time.sleep(0.3 * world.rank)
    print(message, file=sys.stderr, flush=True)
    if world.size > 1:
        world.Abort(code)
    sys.exit(code)


def progress(iterable, total, label):
    """Pass items through, with a bar on rank 0's terminal and none elsewhere."""
    if MPI.COMM_WORLD.rank or not sys.stderr.isatty():
        return iterable
    from tqdm import tqdm

    return tqdm(iterable, total=total, desc=label, leave=False)
