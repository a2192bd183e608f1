# SPDX-License-Identifier: LGPL-3.0-or-later
"""A file under another name, for libraries that take names in UTF-8 only."""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def plain_path(path: str | Path) -> Iterator[str]:
    """The path itself where UTF-8 has it, else that of a link, which lasts as long as the context.

    Python keeps the bytes of such names as lone surrogates (PEP 383).
    """
    try:
        str(path).encode()
    except UnicodeEncodeError:
        with tempfile.TemporaryDirectory() as folder:
            link = Path(folder) / "file"
            link.symlink_to(Path(path).absolute())
            yield str(link)
    else:
        yield str(path)
