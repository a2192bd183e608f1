# SPDX-License-Identifier: LGPL-3.0-or-later
r"""
Roll-up of a strip by an end moment
===================================

The validation problem of the paper's Fig. 5. A flat strip of length :math:`L` is clamped at
:math:`x = 0`; a moment :math:`M` along its other end bends it to the curvature
:math:`\kappa = M/D`. In the limit of a thin sheet the exact shape is a circle,

.. math::

    x(s) = \frac{\sin \kappa s}{\kappa}, \qquad z(s) = \frac{1 - \cos \kappa s}{\kappa},

closed once :math:`M = 2 \pi D/L`.
"""

import matplotlib.pyplot as plt
import numpy as np
import roll_up

import meshes
import shellform as sf

# %%
# The strip
# ---------
# One row of 4-node quads. With :math:`\nu = 0` the strip is a beam, and only :math:`M/D` matters.

length, cells, steps = 12.0, 16, 20
strip = meshes.rectangle(length, length / 12, cells=(cells, 1))
fabric = sf.Fabric.isotropic(1.2e6, 0.0, thickness=0.01, density=1000.0)
shell = sf.Shell(strip, fabric)

# %%
# Supports and load
# -----------------
# The long edges slide in their planes: a free strip would leave the plane sideways beyond three
# quarters of a turn, a true instability. The moment grows with the load level from 0 to 1.

kappa = 2 * np.pi / length
shell.supports.clamp("left")
shell.supports.symmetry("bottom", (0, 1, 0))
shell.supports.symmetry("top", (0, 1, 0))
shell.loads.edge_moment("right", (0, -kappa * fabric.bending[0, 0], 0))

# %%
# Load steps
# ----------
# Every step is solved by Newton's method to equilibrium, Eq. 13 of the paper without inertia,
#
# .. math:: r(u, \theta) = f_\mathrm{ext} - f_\mathrm{int}(u, \theta) = 0 .

figure, axes = plt.subplots(figsize=(6.5, 4.2), layout="constrained")
s = np.linspace(0, length, 400)
with sf.Statics(shell) as statics:
    for k, step in enumerate(statics.march(steps), start=1):
        if k % 4:
            continue
        x, z = shell.positions()[shell.surface.points[:, 1] == 0][:, [0, 2]].T
        exact = roll_up.circle(kappa * step.level, s)
        axes.plot(exact[:, 0], exact[:, 2], "k", lw=0.8)
        axes.plot(x, z, "o", ms=4, label=f"{step.level:g} turn")
axes.set_aspect("equal")
axes.set_xlabel("x [m]")
axes.set_ylabel("z [m]")
axes.legend(frameon=False, fontsize=8)
figure.suptitle("Nodes of 16 cells over the exact circles", fontsize=10)

# %%
# How far the tip is off
# ----------------------
# The tip comes back to the clamp. A sheet of finite thickness stretches a little as it bends, by
# about :math:`t^2 \kappa^2 / 12`, so the distance stops falling there.

tip = shell.displacement_at((length, 0, 0)) + (length, 0, 0)
print(f"tip {np.linalg.norm(tip) / length:.1e} of the length from the clamp")
iterations = sum(step.iterations for step in statics.steps)
print(f"{len(statics.steps)} steps, {iterations} Newton iterations")
