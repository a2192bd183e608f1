# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact between cloth and body: ellipsoids (Eq. 15), friction (Eq. 16), body motion (Eq. 17).

The package works on arrays (positions, velocities, masses) and knows no finite elements, so that
one and the same correction serves the shell and the particle model. `body` gives the ellipsoids and
their motion, `correction` is called between steps; for every point `planes` says what bounds its
step, `wedge` finds the nearest step allowed, `friction` what slip is left, `point` books it.
"""
