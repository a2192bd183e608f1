# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Flesh that meets flesh behind a bent joint is pressed flat against the plane that halves it.

    g(s) = s                                  for s >= m
    g(s) = r + (m - r)^2 / (2 m - r - s)      for s < m

s is the distance of a point from the plane, on its own side, m > 0 the distance within which it is
pressed, 0 <= r < m the room that is left of it, however deep it would be, for cloth between both.
g is above r, rising and has a continuous derivative, so points of both sides never pass one
another, triangles keep their orientation, and velocities are those of the surface.
"""

from contact.kernel import kernel


@kernel(makes_arrays=False)
def kept_on_side(s: float, m: float, r: float) -> tuple[float, float]:
    """g(s) [m] and its derivative; a margin m of 0 presses nothing."""
    if s >= m or m <= 0.0:
        return s, 1.0
    above = (m - r) ** 2 / (2.0 * m - r - s)
    return r + above, (above / (m - r)) ** 2
