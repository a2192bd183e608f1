# SPDX-License-Identifier: LGPL-3.0-or-later
"""A skin that grows inside a garment, from near the axes of the limbs to its size.

A garment as it was made goes around every limb. A skin that begins thin enough to be clear of it
and grows takes the cloth along outwards, and no layer has to pass another or the body. It stands
still meanwhile. Feet grow from the floor, below the hems, which come to lie on the insteps.
"""

import numpy as np

from contact.body.skinned_surface import SkinnedSurface
from contact.geometry.triangle_mesh.closest import signed_distances
from contact.geometry.triangle_mesh.placed import new_placed, refit
from contact.geometry.triangle_mesh.topology import mesh_of
from meshes import Surface
from shellform.motion.wearer import Wearer

SHRUNK = (0.3, 0.4, 0.5, 0.6, 0.7, 0.8)  # parts of the way to the axes, at first
FLAT = 0.9  # part of their height that feet have not, at first
CLEAR = 0.005  # between the cloth and the thin skin, at least [m]


def ways_in(skin: SkinnedSurface, wearer: Wearer) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places (n, 3) of the vertices of the standing wearer [m], and two ways from there, (n, 3).

    The first goes to the axes of the limbs, the second is that of feet to the floor: toes that grew
    forward would take a hem along.
    """
    whole = skin.positions(wearer.start, np.empty((skin.vertex_count, 3))).copy()
    to_axes, to_floor = np.zeros_like(whole), np.zeros_like(whole)
    of_thighs, lines = [], wearer.recording.points
    for k, name in enumerate(skin.names):
        part = np.where(skin.which == k, skin.weights, 0.0).sum(axis=1)
        if name.endswith("_foot"):
            # half a foot is a foot: hems touch insteps that the shank carries too
            flat = np.minimum(2.0 * part, 1.0)
            to_floor[:, 2] += flat * (whole[:, 2].min() - whole[:, 2])
            continue
        first, last, _ = lines[name][0]
        line = last - first
        along = (whole - first) @ line / (line @ line)
        # the line of the pelvis goes on through the trunk
        along = np.clip(along, -np.inf if name == "pelvis" else 0.0, 1.0)
        to_axes += part[:, None] * (first + along[:, None] * line - whole)
        if name.endswith("_thigh"):
            of_thighs.append(part)
    # what both thighs carry rises to the hips, as what the pelvis carries
    both = 2.0 * np.min(of_thighs, axis=0)
    to_axes[:, 2] += both * (lines["pelvis"][0, 1, 2] - whole[:, 2])
    return whole, to_axes, to_floor


class Growing:
    """A surface between its shrunk shape and its own; a `SurfaceMotion`.

    Parameters
    ----------
    skin : SkinnedSurface on the segments of a recording
    wearer : Wearer, at rest up to its first frame
    begin, seconds : when it begins to grow, and for how long [s]
    shrunk : part of the way to the axes that it is from its own shape at first
    """

    moves = True

    def __init__(
        self, skin: SkinnedSurface, wearer: Wearer, begin: float, seconds: float, shrunk: float
    ):
        self.skin, self.begin, self.seconds = skin, begin, seconds
        self.triangles, self.names, self.owners = skin.triangles, skin.names, skin.owners
        self.vertex_count = skin.vertex_count
        self._whole, to_axes, to_floor = ways_in(skin, wearer)
        self._inner = self._whole + shrunk * to_axes + FLAT * to_floor

    def positions(self, t: float, out: np.ndarray) -> np.ndarray:
        """See `SurfaceMotion`."""
        s = min(max((t - self.begin) / self.seconds, 0.0), 1.0)
        out[:] = self._inner + s * s * (3.0 - 2.0 * s) * (self._whole - self._inner)
        return out

    def centres(self, t: float, out: np.ndarray) -> np.ndarray:
        """See `SurfaceMotion`."""
        return self.skin.centres(t, out)

    def add_to_segments(
        self,
        t: float,
        at_vertices: np.ndarray,
        book: np.ndarray,
        pushed: np.ndarray | None = None,
    ) -> None:
        """See `SurfaceMotion`."""
        self.skin.add_to_segments(t, at_vertices, book, pushed)


def shrunk_for(skin: SkinnedSurface, wearer: Wearer, garment: Surface) -> float:
    """Least part of SHRUNK at which a skin is clear of a garment as it was made.

    Nodes and middles of cells are CLEAR of it.

    Raises
    ------
    ValueError for a garment through which the body passes however thin
    """
    whole, to_axes, to_floor = ways_in(skin, wearer)
    cloth = np.concatenate([garment.points, garment.points[garment.cells].mean(axis=1)])
    mesh = mesh_of(skin.triangles, whole)
    placed = new_placed(mesh, len(whole))
    found, triangle = np.empty(len(cloth)), np.empty(len(cloth), np.int64)
    for shrunk in SHRUNK:
        placed.vertices[:] = whole + shrunk * to_axes + FLAT * to_floor
        refit(mesh, placed)
        signed_distances(mesh, placed, cloth, found, triangle)
        if found.min() >= CLEAR:
            return shrunk
    raise ValueError(
        f"{garment.source}: however thin the body is made to dress it, the cloth lies inside it, "
        f"first at {np.round(cloth[found.argmin()], 3).tolist()} m: the garment does not go around "
        "the legs as they stand, or its hems reach the feet; make it shorter, place or turn it "
        '(measures_m, place_m, turn_deg under [garment]), or take person.body = "ellipsoids"'
    )
