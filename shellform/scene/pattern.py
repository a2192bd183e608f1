# SPDX-License-Identifier: LGPL-3.0-or-later
"""A garment cut from the flat pattern of a file and sewn around the standing wearer."""

import numpy as np

from meshes.patterns import Axis, StandingBody, Surface, sew
from meshes.repair import boundary_loops
from meshes.topology import segments_of_line
from shellform.motion.recording import SIDES
from shellform.motion.stance import stance
from shellform.motion.wearer import Wearer

from .parts import Garment
from .shoulders import pattern_read

CLEAR = 0.005  # of the cloth from the body while it is sewn [m]


def sewn_garment(
    garment: Garment, wearer: Wearer, cell_size: float, waist_height: float
) -> Surface:
    """Surface of the garment of a pattern file, x forward, y left, z up over the floor.

    Parameters
    ----------
    cell_size : [m]; waist_height : of the wearer over the floor [m], where the highest panel ends

    Raises
    ------
    meshes.MeshError for a pattern that cannot be sewn; ImportError without the reader's package
    """
    pattern, body = pattern_read(garment), body_of(wearer)
    surface = sew(pattern, cell_size, axes_of(body, wearer, waist_height), body, top=waist_height)
    return _whole_loop(surface, garment.waist)


def body_of(wearer: Wearer) -> StandingBody:
    """The wearer's ellipsoids but the feet, in axes forward, left, up from the floor."""
    height, middle, heading = stance(wearer)
    up = np.array([0.0, 0.0, 1.0])
    axes = np.array([heading, np.cross(up, heading), up])
    pose = wearer.new_pose(wearer.start)
    which = [k for k, name in enumerate(wearer.carriers) if not name.endswith("foot")]
    centres = (pose.centres[which] - middle) @ axes.T + [0.0, 0.0, height]
    return StandingBody(centres, pose.axes[which] @ axes.T, wearer.radii[which] + CLEAR)


def axes_of(body: StandingBody, wearer: Wearer, top: float) -> dict[str, Axis]:
    """Vertical cylinders about the trunk and the legs, from the height `top` [m] down."""
    names = [name for name in wearer.names if not name.endswith("foot")]
    places = {"pelvis": Axis((0.0, 0.0, top))}
    for side in SIDES:
        x, y, _ = body.centres[names.index(f"{side}_thigh")]
        places[f"{side}_thigh"] = Axis((float(x), float(y), top))
    return places


def _whole_loop(surface, waist):
    """The surface with the whole opening named `waist`, where that is an edge of it."""
    if waist not in surface.edges:
        return surface
    own = np.unique(surface.edges[waist])
    for loop in boundary_loops(surface):
        if np.isin(own, loop).all():
            line = segments_of_line(np.append(loop, loop[0]))
            return surface.with_edges(**{waist: line})
    return surface
