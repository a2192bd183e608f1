# SPDX-License-Identifier: LGPL-3.0-or-later
r"""
Wrinkles of a sheared strip
===========================

A thin sheet does not bear compression: sheared between two clamps it wrinkles, and carries the load
along the crests alone. Cells larger than these wrinkles are given the relaxed energy (Pipkin 1986),

.. math::

    \psi_r(E) = \min_{W \ge 0} \; \psi(E + W) + N_c \, \mathrm{tr}\, W ,

in which :math:`W` is what wrinkles take up. Far from the ends of a long strip, drawn apart by
:math:`\varepsilon` and sheared by :math:`\gamma`, crests run at the angle that makes the tension
largest (Mansfield 1989),

.. math::

    \tan 2 \alpha = -\gamma / \varepsilon, \qquad
    N = E t \left( \varepsilon \sin^2 \alpha + \gamma \sin \alpha \cos \alpha \right) .
"""

import matplotlib.pyplot as plt
import numpy as np

import meshes
import shellform as sf
from shellform.pictures.surfaces import CLOTH, EDGE

# %%
# Strip
# -----
# Four times as long as high, of a stiffness Et = 1000 N/m; its nodes stay in the plane, as wrinkles
# are smaller than its cells.

stiffness, eps, gamma = 1000.0, 2e-3, 2e-2
strip = meshes.rectangle(0.8, 0.2, (32, 8))
shell = sf.Shell(strip, sf.Fabric.isotropic(1e6, 0.3, 1e-3, 200.0), wrinkles="relaxed")
shell.wrinkles.load[:] = 0.0  # N_c: as if it bent without resistance
everywhere = np.arange(len(strip.points))
shell.supports.hold(everywhere, "z")
shell.supports.hold_director(everywhere)
shell.supports.hold("bottom")
shell.supports.move("top", displacement=(0.2 * gamma, 0.2 * eps, 0.0))
with sf.Statics(shell) as statics:
    statics.solve(4)
print(f"{sum(step.iterations for step in statics.steps)} iterations")

# %%
# Crests
# ------
# ``shell.wrinkling()`` tells of each cell whether it is taut, wrinkled or slack, how the crests run
# and what strain the wrinkles take up.

found = shell.wrinkling()
corners = shell.positions()[strip.cells]
middle = corners.mean(axis=1)
inside = np.abs(middle[:, 0] - 0.4) < 0.12
angles = np.degrees(np.arctan2(found.crest[:, 1], found.crest[:, 0])) % 180.0
alpha = 90.0 - 0.5 * np.degrees(np.arctan2(gamma, eps))
mean = angles[inside].mean()
print(f"crests at {mean:.2f} degrees, those of a long strip at {alpha:.2f}")

# %%
# At the free ends the crests lean towards the corners that the clamps draw apart.

figure, axes = plt.subplots(figsize=(9, 3.4), layout="constrained")
shades = np.array(["#a9cfa0", CLOTH, "#e3dfd3"])[found.state]
for quad, shade in zip(corners, shades, strict=True):
    axes.fill(quad[:, 0], quad[:, 1], color=shade, lw=0)
ends = middle[:, :2, None] + 0.008 * found.crest[:, :2, None] * [-1.0, 1.0]
wrinkled = found.state == 1
axes.plot(*ends[wrinkled].transpose(1, 2, 0), color=EDGE, lw=1.0)
for shade, name in (("#a9cfa0", "taut"), (CLOTH, "wrinkled"), ("#e3dfd3", "slack")):
    axes.fill([], [], color=shade, label=name)
axes.legend(frameon=False, ncols=3, loc="lower center", bbox_to_anchor=(0.5, -0.3))
axes.set_aspect("equal")
axes.set_axis_off()
