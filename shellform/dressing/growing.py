# SPDX-License-Identifier: LGPL-3.0-or-later
"""A skin that grows under the cloth, from well inside it to its size.

Cloth that was draped on another body lies inside the skin in places. Pushed out from there it could
leave on the wrong side, as through a foot. A skin that grows from the axes of the limbs takes all
cloth along outwards. It stands still meanwhile.
"""

import numpy as np

from contact.body.skinned_surface import SkinnedSurface
from shellform.motion.wearer import Wearer

SHRUNK = 0.45  # of the way to the axes, at first


class Growing:
    """A surface between its shrunk shape and its own; a `SurfaceMotion`.

    Parameters
    ----------
    skin : SkinnedSurface on the segments of a recording
    wearer : Wearer, at rest up to its first frame
    begin, seconds : when it begins to grow, and for how long [s]
    """

    moves = True

    def __init__(self, skin: SkinnedSurface, wearer: Wearer, begin: float, seconds: float):
        self.skin, self.begin, self.seconds = skin, begin, seconds
        self.triangles, self.names, self.owners = skin.triangles, skin.names, skin.owners
        self.vertex_count = skin.vertex_count
        self._whole = skin.positions(wearer.start, np.empty((skin.vertex_count, 3))).copy()
        inner = np.zeros_like(self._whole)
        for k, name in enumerate(skin.names):
            part = np.where(skin.which == k, skin.weights, 0.0).sum(axis=1)[:, None]
            first, last, _ = wearer.recording.points[name][0]
            line = last - first
            along = (self._whole - first) @ line / (line @ line)
            if name != "pelvis":  # whose line goes on through the trunk
                along = np.clip(along, 0.0, 1.0)
            inner += part * (first + along[:, None] * line)
        self._inner = self._whole + SHRUNK * (inner - self._whole)

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
