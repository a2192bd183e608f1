# SPDX-License-Identifier: LGPL-3.0-or-later
r"""
A sleeve around a bending knee
==============================

The oracle of the joint torque. A stretched tube sits on a knee of two ellipsoids, held by contact
alone. The shank bends and straightens. The torque is the sum over all that acts below the joint,

.. math:: \tau_J = \sum_{i \in A_J} (x_i - J) \times f_i .

Without friction it must follow from the strain energy :math:`U` of the sleeve,

.. math:: \tau = -\frac{dU}{d\theta},

and a cycle takes nothing. With friction the torque opposes the motion; the loop it runs through
encloses what friction takes in a cycle.
"""

import hinge_sleeve as demo
import matplotlib.pyplot as plt
import numpy as np

# %%
# One cycle without friction and two with it
# ------------------------------------------
# In the first cycle with friction some energy stays in the sleeve; the second one closes.

settings = ["--around", "40", "--period", "0.2"]
free = demo.cycles(demo.arguments([*settings, "--cycles", "1"]), 0.0)
rough = demo.cycles(demo.arguments([*settings, "--cycles", "2"]), 0.2)

# %%
# Torque against angle
# --------------------

figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
axes.plot(np.degrees(rough["angle"]), rough["torque"], lw=1.2, label="friction 0.2")
axes.plot(np.degrees(free["angle"]), free["torque"], lw=1.2, label="no friction")
axes.plot(np.degrees(free["angle"]), free["slope"], "k.", ms=4, label=r"$-dU/d\theta$")
axes.set_xlabel("flexion [degrees]")
axes.set_ylabel("torque on the shank [N m]")
axes.legend(frameon=False)
loop, lost, kept = (rough[name][-1] for name in ("loop", "friction", "kept"))
print(f"second cycle: loop {1e3 * loop:.3f} mJ, ", end="")
print(f"friction took {1e3 * lost:.3f} mJ, ", end="")
print(f"stayed in the sleeve {1e3 * kept:.3f} mJ")
