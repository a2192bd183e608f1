# SPDX-License-Identifier: LGPL-3.0-or-later
r"""
A belt around a cylinder: Euler's capstan
=========================================

A belt lies over the angle :math:`\varphi` on a cylinder, held back with the tension :math:`T_1` at
one end and drawn along at the other. With the friction of Eq. 16 everywhere at its limit

.. math:: \frac{T_2}{T_1} = e^{\mu \varphi} .

Nodes that turn the belt by :math:`\alpha` each are small capstans of their own,

.. math::

    \frac{T_2}{T_1} = \frac{1 + \mu \tan(\alpha/2)}{1 - \mu \tan(\alpha/2)},

so :math:`n` cells leave a relative error of about :math:`\mu \varphi (1 + \mu^2) \alpha^2 / 12`,
:math:`\alpha = \varphi/n`: second order.
"""

import capstan
import matplotlib.pyplot as plt
import numpy as np

# %%
# Runs with more and more cells
# -----------------------------
# The ratio swings as nodes come onto the cylinder and leave it; its mean is taken over the travel
# of one cell.

friction, radius, angle = 0.3, 0.1, np.pi
goal = capstan.exact(friction, angle)
cells, errors = [4, 6, 8], []
print(f"exact {goal:.5f}")
for n in cells:
    stepper, ends = capstan.belt(n, friction, radius, angle)
    found = capstan.ratios(stepper, ends, angle * radius / n)
    errors.append(capstan.deviation(found, goal))
    print(f"{n:2d} cells: T2/T1 = {found.mean():.5f}, off by {100 * errors[-1]:.2f} %")

# %%
# Order of convergence
# --------------------

n = np.array(cells)
expected = capstan.sensitivity(friction, angle) * (angle / n) ** 2 / 12
figure, axes = plt.subplots(figsize=(5, 3.6), layout="constrained")
axes.loglog(n, errors, "o", label="computed, root mean square")
axes.loglog(n, expected, "k", lw=0.8, label=r"$\mu \varphi (1 + \mu^2) \alpha^2/12$")
axes.set_xticks(cells, [str(k) for k in cells])
axes.set_yticks([0.01, 0.02, 0.04], ["1 %", "2 %", "4 %"])
axes.minorticks_off()
axes.set_xlabel("cells on half a turn")
axes.set_ylabel("relative error of $T_2/T_1$")
axes.legend(frameon=False)
