# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact between cloth and body: ellipsoids (Eq. 15), friction (Eq. 16), body motion (Eq. 17).

The package works on arrays (positions, velocities, masses, forces) and knows no finite elements, so
that one and the same correction serves the shell and the particle model.  Nothing is here yet.
"""
