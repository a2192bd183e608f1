# SPDX-License-Identifier: LGPL-3.0-or-later
"""Names of files that are not UTF-8 on the command line, kept from libraries that refuse them.

dolfinx hands `sys.argv` to C++ as it loads, which takes only what UTF-8 can encode. Python keeps
the bytes of other names as lone surrogates (PEP 383).
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def plain_arguments() -> Iterator[None]:
    """Have `sys.argv` in UTF-8 for a while, other bytes in it written as `\\udce9`."""
    before = sys.argv
    sys.argv = [word.encode("utf-8", "backslashreplace").decode() for word in before]
    try:
        yield
    finally:
        sys.argv = before
