# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact between cloth and body: ellipsoids (Eq. 15), friction (Eq. 16), body motion (Eq. 17).

The package works on arrays (positions, velocities, masses) and knows no finite elements, so that
one and the same correction serves the shell and the particle model. `body` gives the ellipsoids and
their motion, `correction` is called between steps; `travel` holds how the ellipsoids move over one.
For every point `planes` says what bounds its step, `wedge` finds the nearest step allowed,
`friction` what slip is left, and `point` puts them together and books what was done.

Kernels are compiled once and kept beside the sources, under a name that says what they compute:
what has changed is compiled anew by itself (`kernel`).
"""
