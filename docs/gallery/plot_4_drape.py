# SPDX-License-Identifier: LGPL-3.0-or-later
r"""
A square of cloth falls onto a sphere
=====================================

The paper's Fig. 6. The sheet lies level above the sphere, held at one corner; it is let go, folds
over the body and comes to rest. Explicit steps (Sec. 3.1.3 of the paper),

.. math::

    v_{n+1/2} = v_{n-1/2} + \Delta t \, M^{-1} \left( f_\mathrm{ext} - f_\mathrm{int}(x_n) \right),
    \qquad x_{n+1} = x_n + \Delta t \, v_{n+1/2} ,

with contact between the two lines: Eqs. 15 and 16 turn the free velocity of a node that would enter
the body into one that does not, within the cone of friction. Every push is booked as an impulse.
"""

import matplotlib.pyplot as plt
import numpy as np

import meshes
import shellform as sf
from shellform.pictures import surfaces as pictures

# %%
# Cloth and body
# --------------
# 1 m of cloth of 0.2 kg/m2, 1.962 N, and a sphere of 0.25 m whose top is 50 mm below it.

n, nu, gravity = 16, 0.3, 9.81
square = meshes.rectangle(1.0, 1.0, cells=(n, n)).transform(translation=(-0.5, -0.5, 0.0))
plane = np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
fabric = sf.Fabric.from_stiffness(
    1000.0 / (1 - nu**2) * plane, 9.16e-5 * plane, areal_mass=0.2, thickness=1e-3
)
shell = sf.Shell(square, fabric)
shell.supports.hold(np.array([0]))
shell.loads.gravity((0.0, 0.0, -gravity))
radius, centre = 0.25, np.array([0.0, 0.0, -0.3])
body = sf.Body([sf.Segment("sphere", (radius, radius, radius), sf.Fixed(centre))])

# %%
# Steps
# -----

stepper = sf.Newmark(shell, damping=2e-4, drag=2.0)
contact = stepper.add(sf.Contact(body, friction=0.3))
ledger = stepper.add(sf.Ledger())
times = np.linspace(0.0, 2.0, 41)[1:]
for time in times:
    stepper.advance(time)
    ledger.record()

# %%
# Who carries the weight
# ----------------------
# At rest the body and the pin do, together; the momentum of the whole run closes to roundoff.

push = np.array([row["force_sphere_z"] for row in ledger.rows])
impulse = [row["support_impulse_z"] for row in ledger.rows]
pin = np.diff(impulse, prepend=0.0) / np.diff(times, prepend=0.0)
weight = fabric.areal_mass * gravity
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4.2), layout="constrained")
left.plot(times, push, label="sphere")
left.plot(times, pin, label="pin")
left.plot(times, push + pin, "k", lw=0.8, label="both")
left.axhline(weight, color="0.6", lw=0.8, ls="--", label="weight")
left.set_xlabel("time [s]")
left.set_ylabel("force up [N]")
left.legend(frameon=False)
view = (-100.0, 10.0)  # degrees, the pin to the left
skin = pictures.ellipsoid_facets(centre, np.eye(3), np.full(3, radius))
skin = pictures.facing(skin, pictures.view_axes(*view)[2])
cloth = pictures.smooth(shell.positions(), shell.directors(), square.cells, 3)
blue, sand, red = "#7aa6c2", "#c9b79c", "#d8a48f"
pictures.draw_surfaces(right, [(*cloth, blue, sand, 0.0), (skin, None, red, red, 0.05)], *view)
sphere, held = push[-4:].mean(), pin[-4:].mean()
print(f"weight {weight:.4f} N, sphere {sphere:.4f} N, pin {held:.4f} N")
left_over = max(row["momentum_residual"] for row in ledger.rows)
print(f"momentum left over: {left_over:.1e} N s")
