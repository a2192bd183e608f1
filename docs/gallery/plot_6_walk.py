# SPDX-License-Identifier: LGPL-3.0-or-later
r"""
A stride in trousers
====================

The paper's Figs. 7, 8 and 10 in small: a wearer of ellipsoids, posed by joint points (Eq. 17),

.. math::

    x^c = \tfrac12 (J_1 + J_2), \quad e_1 = \frac{J_2 - J_1}{|J_2 - J_1|}, \quad
    e_2 \parallel (M - x^c) - \left( (M - x^c) \cdot e_1 \right) e_1, \quad e_3 = e_1 \times e_2 ,

is dressed, walks one level stride and feels the trousers at every joint. ``make walk`` does four
strides, the third over an obstacle, in compliant and in stiff cloth.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import shellform as sf
from shellform.pictures import walk as walk_pictures
from shellform.results.mean_torque import mean_rows
from shellform.scene.parts import Garment, Motion
from shellform.scene.wearer import wearer_of

# %%
# The scene
# ---------
# Cells of 40 mm are coarse: they bend where cloth folds.

scene = sf.Scene(
    fabric="compliant",
    motion=Motion(strides=1, obstacle=0.0),
    garment=Garment(cell_size=0.04),
)

# %%
# Dressing and walking
# --------------------

folder = Path(tempfile.mkdtemp())
results = sf.run(scene, folder)
balance = results["force_balance_error"]
print(f"weight {results['weight']:.3f} N, forces balance to {balance:.0e}")

# %%
# Torque about hips and knees
# ---------------------------
# In level strides it is some tenths of a N m. Its course is there with coarse cells, its size is
# not converged: finer cells pull less, as they fold (see the page on accuracy). Drawn is the mean
# of three runs, whose starts differ by a thousandth of the belt's tension, with its standard error.

rows = mean_rows(folder)
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
for joint in ("right_hip", "left_hip", "right_knee", "left_knee"):
    own = [row for row in rows if row["joint"] == joint]
    keys = ("time", "torque_flexion", "standard_error")
    time, torque, error = (np.array([row[key] for row in own]) for key in keys)
    (drawn,) = axes.plot(time, torque, lw=1.2, label=joint.replace("_", " "))
    axes.fill_between(time, torque - error, torque + error, color=drawn.get_color(), alpha=0.3)
    found = results["joints"][joint]
    print(f"{joint:>11}: peak {found['peak_torque']:6.2f} +- {found['peak_torque_error']:.2f} N m")
axes.axhline(0.0, color="0.6", lw=0.8)
axes.set_xlabel("time [s]")
axes.set_ylabel("flexion torque [N m]")
axes.legend(frameon=False)

# %%
# The last frame
# --------------

# sphinx_gallery_thumbnail_number = 2
wearer = wearer_of(scene)
figure, shown = plt.subplots(figsize=(4, 5), layout="constrained")
frame = walk_pictures.read_frames(folder)[-1]
corners = walk_pictures.draw_clothed(shown, frame, wearer)
walk_pictures.fit_view(shown, corners)
