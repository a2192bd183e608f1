# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Flesh that meets flesh behind a bent joint is pressed flat against the plane that halves it.

    g(s) = s                    for s >= m
    g(s) = m^2 / (2 m - s)      for s < m

s is the distance of a point from the plane, on its own side, m > 0 the distance within which it is
pressed. g is positive, rising and has a continuous derivative, so points of both sides never pass
one another, triangles keep their orientation, and velocities are those of the surface.
"""

from contact.kernel import kernel


@kernel(makes_arrays=False)
def kept_on_side(s: float, m: float) -> tuple[float, float]:
    """g(s) [m] and its derivative; a margin m of 0 presses nothing."""
    if s >= m or m <= 0.0:
        return s, 1.0
    g = m * m / (2.0 * m - s)
    return g, (g / m) ** 2
