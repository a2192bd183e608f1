# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sets of segments as whole numbers.

Of a body of up to 62 segments bit b stands for segment b; of a larger one a bit stands for all
segments on one carrier, or for all from the 63rd on.
"""

import numpy as np

SETS = 62  # bits of a set


def bits_of(body):
    """Bits (m,) int of the segments in sets.

    Each its own, if they are no more than SETS; else one for each of the `carriers` that a Wearer
    has; else the last bit for all that are over.
    """
    m = len(body.radii)
    carriers = list(getattr(body, "carriers", range(m)))
    kinds = list(dict.fromkeys(carriers))
    if m > SETS and len(kinds) <= SETS:
        return np.array([kinds.index(carrier) for carrier in carriers], np.int64)
    return np.minimum(np.arange(m), SETS)


def mates_of(body):
    """Sets (m,) of the ellipsoids that move as one with each: that have the same entry in the
    `carriers` of a body that has them, as a Wearer; else each alone."""
    bits = bits_of(body)
    names = getattr(body, "carriers", range(len(bits)))
    sets = {}
    for name, bit in zip(names, bits, strict=True):
        sets[name] = sets.get(name, 0) | 1 << int(bit)
    return np.array([sets[name] for name in names], np.int64)
