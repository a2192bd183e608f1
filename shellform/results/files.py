# SPDX-License-Identifier: LGPL-3.0-or-later
"""Files written whole or not at all."""

import os
from pathlib import Path


def write_atomically(path: str | Path, text: str) -> None:
    """Write a text file so that readers see either the old or the whole new one."""
    path = Path(path)
    part = path.with_name(path.name + ".part")
    part.write_text(text)
    os.replace(part, path)
