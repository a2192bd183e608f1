# SPDX-License-Identifier: LGPL-3.0-or-later
r"""
A strip over a cylinder
=======================

A strip of bending stiffness :math:`D` and weight :math:`q` per area lies without friction on a
cylinder and hangs down on both sides. With the radius :math:`\rho` of its mid-surface and the slope
angle :math:`\varphi`, the part beyond the contact obeys the heavy elastica

.. math::

    D \varphi'' = -q (S - s) \cos \varphi, \qquad \varphi'(S) = 0, \qquad
    \varphi = s/\rho, \; \varphi' = 1/\rho \; \text{where it lifts off.}

On the arc the body pushes with :math:`p = T/\rho + q \cos \varphi`, and where the strip lifts off
with a point force :math:`P = q (S - s_c) \cos \varphi_c`.
"""

import matplotlib.pyplot as plt
import numpy as np
import strip_over_cylinder as demo

# %%
# The reference
# -------------
# The angle at which the strip lifts off is found by shooting from there to the free end.

scene = demo.Scene(radius=0.05, length=0.25, bending_length=0.03)
exact = demo.elastica(scene)
x, z = exact.tip
print(f"lifts off at {np.degrees(exact.angle):.2f} degrees, tip {x:.5f} {z:.5f} m")

# %%
# Two meshes, at rest
# -------------------
# Half a strip in explicit steps, with drag, until it is at rest; nodes meet the body.

found = {}
for cells in (8, 16):
    stepper, contact = demo.strip(scene, cells, samples=0)
    found[cells] = demo.measure(exact, stepper, contact, until=2.0)
    print(f"{cells:3d} cells: tip off by {found[cells]['tip']:.1e} of half the length")

# %%
# Shape, and forces summed from the top
# -------------------------------------
# The curve of the sum jumps by the point force at the angle where the strip lifts off.

figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.8), layout="constrained")
turn = np.linspace(0, 2 * np.pi, 200)
left.fill(scene.radius * np.sin(turn), scene.radius * np.cos(turn), color="#d8a48f")
left.plot(*exact.profile().T, "k", lw=0.8, label="elastica")
angles = np.linspace(0, 0.6 * np.pi, 1000)
right.plot(np.degrees(angles), exact.pushed(angles), "k", lw=0.8, label="elastica")
for mark, (cells, run) in zip("os", found.items()):
    left.plot(*run["nodes"].T, mark, ms=4, mfc="none", label=f"{cells} cells")
    on = run["phi"] < 0.6 * np.pi
    sums = np.cumsum(run["force"])
    angle = np.degrees(run["phi"][on])
    right.step(angle, sums[on], where="post", lw=1.2, label=f"{cells} cells")
left.set_aspect("equal")
left.set_xlabel("x [m]")
left.set_ylabel("z [m]")
left.legend(frameon=False, fontsize=8)
right.set_xlabel("angle from the top [degrees]")
right.set_ylabel("sum of normal forces [N/m]")
