# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sets of segments as whole numbers.

Of a body of up to 62 segments bit b stands for segment b; of a larger one a bit stands for all
segments on one carrier, or for all from the 63rd on.
"""

from collections.abc import Hashable, Sequence

import numpy as np

SETS = 62  # bits of a set


def bits_of(carriers: Sequence[Hashable]) -> np.ndarray:
    """Bits (m,) int of the segments in sets, from what each rides on (`Body.carriers`).

    Each its own, if they are no more than SETS; else one for each of the carriers; else the last
    bit for all that are over.
    """
    m = len(carriers)
    kinds = list(dict.fromkeys(carriers))
    if m > SETS and len(kinds) <= SETS:
        return np.array([kinds.index(carrier) for carrier in carriers], np.int64)
    return np.minimum(np.arange(m), SETS)


def moving_together(carriers: Sequence[Hashable]) -> np.ndarray:
    """Sets (m,) int of the segments that ride on the same carrier as each."""
    sets: dict[Hashable, int] = {}
    for carrier, bit in zip(carriers, bits_of(carriers), strict=True):
        sets[carrier] = sets.get(carrier, 0) | 1 << int(bit)
    return np.array([sets[carrier] for carrier in carriers], np.int64)
