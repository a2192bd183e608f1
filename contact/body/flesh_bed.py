# SPDX-License-Identifier: LGPL-3.0-or-later
"""Flesh over a rigid core, as an elastic bed: what skin gives way to where cloth presses it.

A Winkler bed: every place gives way by itself. At a depth d below the skin at rest it presses with

    p = k d + clip(k_s (d - s), -Y, Y) + q,    q' = k_v d' - q/tau,    p >= 0,

an elastic part; one that slips, s, at a pressure Y, so that loading and unloading differ by 2 Y at
any speed (Prandtl's element); and one that relaxes in a time tau (Maxwell's). The area pressed is
that of the cloth at rest: under cloth stretched by 20 % give 20 % more. A layer of modulus E and
thickness t has k = E/t: 20 kPa over 30 mm make 0.67 MPa/m. Cloth that presses with less than a
tenth of a kPa sinks in by less than 0.15 mm there: leave flesh out. Segments that can pass between
nodes of the cloth stay hard, as edges and insides of cells meet them too.

Indented lower limbs: moduli of 0.22 to 58 kPa at first, times of 0.05 to 8.9 s (4 sites, 8
subjects, J. Biomech. Eng. 121, 330, 1999).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np

HARD = 1e9  # Pa/m: 1 kPa sinks in by a micrometre
BED = np.dtype(
    [
        ("stiffness", float),  # k [Pa/m]
        ("slip_stiffness", float),  # k_s [Pa/m]
        ("yield_pressure", float),  # Y [Pa]
        ("relaxing_stiffness", float),  # k_v [Pa/m]
        ("relaxation_time", float),  # tau [s]
    ]
)


@dataclass(frozen=True)
class Flesh:
    """An elastic bed under the skin.

    Parameters
    ----------
    stiffness : float, or one by names of segments, k [Pa/m]; those not named are hard: 1e9
    slip_stiffness, yield_pressure : k_s [Pa/m] and Y [Pa]; 0: loading and unloading are alike
    relaxing_stiffness, relaxation_time : k_v [Pa/m] and tau [s]; 0: no part relaxes

    Raises
    ------
    ValueError for numbers that are none, negative or do not go together

    Examples
    --------
    >>> import shellform as sf
    >>> ball = sf.Body([sf.Segment("calf", (0.06, 0.06, 0.2), sf.Fixed())])
    >>> sf.Contact(ball, flesh=sf.Flesh(6.7e5)).flesh.stiffness
    670000.0
    """

    stiffness: float | Mapping[str, float]
    slip_stiffness: float = 0.0
    yield_pressure: float = 0.0
    relaxing_stiffness: float = 0.0
    relaxation_time: float = 0.0

    def __post_init__(self) -> None:
        by_name = self.stiffness if isinstance(self.stiffness, Mapping) else {"": self.stiffness}
        for name, value in by_name.items():
            if not (isinstance(value, int | float) and 0 < value <= HARD):
                of = f" of {name}" if name else ""
                raise ValueError(
                    f"the stiffness of flesh{of} is above 0 and at most {HARD:g} Pa/m, as 6.7e5 "
                    f"for 20 kPa over 30 mm, not {value!r}"
                )
        for item in fields(self)[1:]:
            value = getattr(self, item.name)
            if not (isinstance(value, int | float) and 0 <= value < np.inf):
                raise ValueError(f"{item.name} of flesh is a finite number >= 0, not {value!r}")
        for one, other in (
            ("slip_stiffness", "yield_pressure"),
            ("relaxing_stiffness", "relaxation_time"),
        ):
            if (getattr(self, one) > 0) != (getattr(self, other) > 0):
                raise ValueError(f"flesh needs both {one} and {other}, or neither")

    def beds(self, names: Sequence[str]) -> np.ndarray:
        """Records (m,) BED of the segments of these names.

        Raises
        ------
        ValueError for a name that no segment has
        """
        out = np.zeros(len(names), BED)
        for item in fields(self)[1:]:
            out[item.name] = getattr(self, item.name)
        if not isinstance(self.stiffness, Mapping):
            out["stiffness"] = self.stiffness
            return out
        unknown = sorted(set(self.stiffness) - set(names))
        if unknown:
            raise ValueError(
                f"flesh of {unknown[0]!r}: no segment has this name; there are {', '.join(names)}"
            )
        out["stiffness"] = [self.stiffness.get(name, HARD) for name in names]
        return out
