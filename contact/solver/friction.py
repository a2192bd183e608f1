# SPDX-License-Identifier: LGPL-3.0-or-later
"""Dry friction of a point on a surface, Eq. 16, as impulses over one step.

Eq. 16 takes the residual force F on a node and the slip velocity v_T. Over a step dt the node would
reach the velocity v_free = v + dt F / m; the normal impulse j_n takes its approach away, and the
tangential impulse that would end the slip is j* = -m v_free,T. Then

    |j*| <= mu_s j_n :  stick, j_T = j*                   (slip exactly zero)
    |j*| >  mu_s j_n :  slip,  j_T = mu_k j_n j* / |j*|   (against the slip)

With j = f dt this is Eq. 16 case by case: open, j_n = 0; at rest (v_T = 0), j* = -dt F_T and
j_n = dt |F_N| give f = -F as long as |F_T| <= mu_s |F_N|; sliding, j*/|j*| -> -v_T/|v_T| for
dt -> 0. Two things differ by one step, hence vanish with dt: a node that breaks loose meets mu_k at
once, where Eq. 16 still has mu_s at v_T = 0; and a sliding node is caught when m |v_T| falls below
mu_s j_n, not at exactly zero. As mu_k <= mu_s, kinetic friction never turns the slip around.

Another law is a class like `Friction` in a file of its own, with a kernel for its mu_k at a slip
speed; the cone is the same for all (`cone_kernel`). Numba compiles one set of kernels for each law.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from contact.kernel import NumbaError, kernel

PARAMETERS = 6  # numbers that a law may have


@kernel(makes_arrays=False)
def _constant(speed, parameters):
    return parameters[1]


@dataclass(frozen=True)
class Friction:
    """Coulomb's law with a static and a kinetic coefficient.

    Another law is a frozen class derived from this one with a kernel of its own as

        kinetic_coefficient(speed, parameters) -> mu_k >= 0, and <= static; it makes no arrays

    of the slip speed [m/s] that is left by the normal impulse, and its numbers as `parameters`, the
    static coefficient first.

    Parameters
    ----------
    static : float
    kinetic : float or None: the static one

    Raises
    ------
    ValueError
        For a negative or non-finite coefficient, or a kinetic one above the static one.

    Examples
    --------
    >>> import shellform as sf
    >>> skin = sf.Friction(0.4, 0.3)
    >>> skin.static, sf.Friction(0.4).kinetic
    (0.4, 0.4)
    >>> ball = sf.Body([sf.Segment("ball", (0.1, 0.1, 0.1), sf.Fixed())])
    >>> sf.Contact(ball, friction=skin).friction.kinetic
    0.3
    """

    static: float
    kinetic: float | None = None

    kinetic_coefficient = staticmethod(_constant)

    def __post_init__(self):
        if self.kinetic is None:
            object.__setattr__(self, "kinetic", self.static)
        pair = self.static, self.kinetic
        if not (np.isfinite(pair).all() and self.kinetic >= 0):
            raise ValueError(
                "friction coefficients are finite and not negative, not "
                f"{self.static}, {self.kinetic}"
            )
        if self.kinetic > self.static:
            raise ValueError(
                f"kinetic friction {self.kinetic} exceeds static friction {self.static}: give "
                "(mu_s, mu_k), the larger one first"
            )

    @property
    def parameters(self) -> tuple[float, ...]:
        """What kernels get: at most PARAMETERS numbers, the static coefficient first."""
        return self.static, float(self.kinetic)  # type: ignore[arg-type]


def as_friction(friction: Friction | ArrayLike) -> Friction:
    """A law from one coefficient, from the pair (mu_s, mu_k), or a law as it is.

    Raises
    ------
    ValueError
        As `Friction`, for what is neither, and for a law whose kernel does not compile.
    """
    if isinstance(friction, Friction):
        if len(friction.parameters) > PARAMETERS:
            raise ValueError(
                f"{friction!r} has {len(friction.parameters)} parameters, {PARAMETERS} fit"
            )
        if friction.kinetic_coefficient is not Friction.kinetic_coefficient:
            _check_kernel(friction)
        return friction
    try:
        pair = np.atleast_1d(np.asarray(friction, float))
    except (TypeError, ValueError):
        pair = np.empty(0)
    if isinstance(friction, str | None) or pair.shape not in ((1,), (2,)):
        raise ValueError(
            "friction is one coefficient, the pair (mu_s, mu_k) of a static and a kinetic one, or "
            f"a law as Friction(0.3), not {friction!r}"
        )
    return Friction(*pair.tolist())


def _check_kernel(law):
    """ValueError where the kernel of a law cannot be compiled into the cone's."""
    try:
        cone_kernel(law.kinetic_coefficient)(0.0, 1.0, 0.0, np.zeros(PARAMETERS))
    except NumbaError as error:
        where = f"{type(law).__name__}.kinetic_coefficient(speed, parameters)"
        reason = str(error).strip().splitlines()[-1]
        raise ValueError(
            f"{where} does not compile: it gives a number, makes no arrays and is a "
            f"staticmethod(kernel(function)); numba says: {reason}"
        ) from error


@cache
def cone_kernel(kinetic_coefficient: Callable) -> Any:
    """Kernel of the friction cone of a law.

    transmitted(normal, trial, speed, parameters) gives the fraction of the trial impulse that
    friction can transmit, 1 in stick and below 1 in slip, from the normal impulse j_n >= 0 [N s],
    the length |j*| of the impulse that would end the slip [N s], the speed of that slip [m/s] and
    the numbers of the law.
    """

    @kernel(makes_arrays=False)
    def transmitted(normal, trial, speed, parameters):
        if trial <= parameters[0] * normal:
            return 1.0
        return kinetic_coefficient(speed, parameters) * normal / trial

    return transmitted
