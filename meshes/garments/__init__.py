# SPDX-License-Identifier: LGPL-3.0-or-later
"""Garments made by measures, and a garment of the user's own prepared for dressing.

A new kind of garment is one file with a function that returns a Surface, and one entry in
`GARMENTS` below; scenes then know it by its name, as `[garment] kind = "skirt"`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from meshes.surface import Surface

from .sleeve_and_skirt import skirt
from .trousers import SIZES, trousers


@dataclass(frozen=True)
class Pattern:
    """A kind of garment that hangs on the waist.

    Parameters
    ----------
    build : function of measures [m] by name, among them `waist_height`, and of `cell_size` [m]. It
        returns a Surface with the edge 'waist', standing as on a body with its feet on z = 0, x
        forward and y left. Where there are sizes, one is its first argument.
    lengths : measures along the body [m], those that grow with the wearer, for hip joints 0.918 m
        over the floor
    girths : measures [m] that `build` is given where nobody asks for others
    sizes : names of sizes to their measures
    """

    build: Callable[..., Surface]
    lengths: Mapping[str, float]
    girths: Mapping[str, float] = field(default_factory=dict)
    sizes: Mapping[str, Mapping[str, float]] = field(default_factory=dict)


GARMENTS = {
    "trousers": Pattern(
        trousers,
        lengths={k: v for k, v in SIZES["large-regular"].items() if k.endswith("_height")},
        sizes=SIZES,
    ),
    "skirt": Pattern(
        skirt,
        lengths={"length": 0.60, "hip_depth": 0.14},
        girths={"waist": 1.00, "hip": 1.17, "hem": 1.50},
    ),
}
