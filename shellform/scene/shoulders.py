# SPDX-License-Identifier: LGPL-3.0-or-later
"""Whether the garment of a scene hangs on the shoulders, and the wearer it is put on then.

Such a wearer has trunk and arms; others do not, nor is anything of these imported for them.
"""

from __future__ import annotations

import json
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from .parts import Garment

if TYPE_CHECKING:
    from meshes.patterns import SewingPattern

PATTERNS = (".json", ".dxf", ".svg")  # endings of files with flat panels


def is_pattern(garment: Garment) -> bool:
    """Whether a garment is sewn from a file of flat panels."""
    return garment.file is not None and Path(garment.file).suffix.lower() in PATTERNS


def pattern_read(garment: Garment) -> SewingPattern:
    """The pattern of a garment's file; MeshError for one that is wrong."""
    assert garment.file is not None
    path = Path(garment.file)
    changed = path.stat().st_mtime_ns if path.is_file() else 0
    unit = None if garment.unit == "m" else garment.unit
    return _read(path, changed, garment.size, unit, json.dumps([garment.stitches, garment.about]))


@lru_cache(maxsize=4)  # wearer, garment and plan ask for the same one
def _read(path: Path, changed: int, size: str | None, unit: str | None, more: str) -> SewingPattern:
    # only here: other garments are not sewn
    from meshes.patterns import read_pattern

    stitches, about = json.loads(more)
    return read_pattern(path, size, unit, stitches or (), about)


def hangs_on_shoulders(garment: Garment) -> bool:
    """Whether the wearer needs shoulders for it; ValueError for what cannot hang there."""
    if garment.hangs == "shoulders" and not is_pattern(garment):
        raise ValueError(
            "garment.hangs = 'shoulders' is for sewing patterns, and "
            f"{f'{garment.file} is a mesh' if garment.file else 'there is no file'}: name a file "
            "that ends in .json, .dxf or .svg, or leave it out"
        )
    if garment.hangs != "auto" or not is_pattern(garment):
        return garment.hangs == "shoulders"
    # only here, as above
    from meshes.patterns.placing import goes_about_arms

    return goes_about_arms(pattern_read(garment))


def belt_of(belt: float, garment: Garment) -> float:
    """Tension [N] of the belt: what hangs on the shoulders has none."""
    return 0.0 if hangs_on_shoulders(garment) else belt
