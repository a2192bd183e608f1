# SPDX-License-Identifier: LGPL-3.0-or-later
"""A shirt sewn around the standing wearer, whose arms are held as its sleeves are cut.

The highest point of its panels is brought over the shoulders, where these meet the neck.
"""

from __future__ import annotations

import numpy as np

from meshes.garments.shirt import prepare_shirt
from meshes.patterns import Axis, StandingBody, Surface, sew
from meshes.validity import with_hint
from shellform.motion.recording import SIDES
from shellform.motion.stance import stance
from shellform.motion.wearer import Wearer

from .fit import STRETCH, body_girth, girth_at, inside
from .parts import Garment
from .pattern import CLEAR, body_of
from .shoulders import pattern_read

STEPS = 1000  # of the relaxation
OVER = 0.025  # of the cloth over the shoulders before it is sewn: arms are well within sleeves [m]
ON_TOP = 0.95  # of the shoulders' semi-axis up, where the neck begins


def shirt_of(garment: Garment, wearer: Wearer, cell_size: float) -> Surface:
    """Surface of a shirt on the wearer, with the edges of `prepare_shirt`.

    Parameters
    ----------
    wearer : who holds the arms up at the start, see `dressing_wearer`; cell_size : [m]

    Raises
    ------
    meshes.MeshError, ValueError for a pattern that cannot be sewn, or a wearer who is not inside
    """
    pattern, body = pattern_read(garment), _across_shoulders(body_of(wearer), wearer)
    names = [name for name in wearer.names if not name.endswith("foot")]
    k = names.index("shoulders")
    # patterns are drawn about x = y = 0: arms and trunk are brought there in the mean
    arms = [names.index(f"{side}_upper_arm") for side in SIDES]
    off = 0.5 * (body.centres[k] + body.centres[arms].mean(axis=0)) * [1.0, 1.0, 0.0]
    body = body._replace(centres=body.centres - off)
    top = body.centres[k, 2] + ON_TOP * (body.radii[k, 1] - CLEAR)
    axes, above = _axes(body, names, top), float(top + OVER)
    surface = sew(pattern, cell_size, axes, body, STEPS, above, threaded=True)
    surface = prepare_shirt(surface.transform(translation=off))
    if garment.place is not None:
        surface = surface.transform(translation=garment.place)
    height, middle, heading = stance(wearer)
    cosine, sine = heading[:2]
    turn = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1.0]])
    surface = surface.transform(turn, (*middle[:2], middle[2] - height))
    try:
        check_shirt(surface, wearer)
    except ValueError as error:
        raise with_hint(error, surface.notes) from None
    return surface


def check_shirt(surface: Surface, wearer: Wearer) -> None:
    """ValueError if trunk, neck and arms of the wearer cannot be inside the shirt."""
    pose, source = wearer.new_pose(wearer.start), surface.source
    at = {name: k for k, name in enumerate(wearer.names)}
    loops = {name: surface.points[surface.edges[name][:, 0]] for name in ("neck", "hem")}
    for edge, name in (("neck", "neck"), ("hem", "pelvis")):
        centre = pose.centres[at[name], :2]
        if not inside(loops[edge][:, :2], centre):
            raise ValueError(
                f"the {edge} of {source} does not enclose the wearer's {name} at "
                f"{np.round(centre, 3).tolist()} m: it is centred at "
                f"{np.round(loops[edge][:, :2].mean(axis=0), 3).tolist()} m; shift it by place_m "
                "under [garment]"
            )
    for side in SIDES:
        cuff = surface.points[surface.edges[f"{side}_cuff"][:, 0]]
        arms = [at[f"{side}_{part}"] for part in ("upper_arm", "forearm")]
        k = min(arms, key=lambda k: np.linalg.norm(pose.centres[k] - cuff.mean(axis=0)))
        flat = (cuff - pose.centres[k]) @ pose.axes[k, 1:].T
        if not inside(flat, np.zeros(2)):
            raise ValueError(
                f"the {side} cuff of {source}, about {np.round(cuff.mean(axis=0), 2).tolist()} m, "
                f"does not enclose the wearer's arm at {np.round(pose.centres[k], 2).tolist()} m: "
                "place its sleeves along arms that begin at the shoulders"
            )
    k = at["thorax"]
    level = pose.centres[k, 2]
    body = body_girth(wearer, pose, [k], level)
    cloth = girth_at(surface, level, np.ones(len(surface.cells), bool), pose.centres[k, :2])
    cloth /= stretched_around(surface, level)
    if 0 < cloth * (1 + STRETCH) < body:
        raise ValueError(
            f"the wearer measures {body:.3f} m around the chest, {source} only {cloth:.3f} m "
            "there: take a larger size, or check the wearer's girths"
        )


def stretched_around(surface: Surface, level: float) -> float:
    """Mean stretch of the cloth, level to the floor, in the cells at a height [m]: 1 without.

    Sewing around a body that is too large stretches it.
    """
    points, flat = surface.points[surface.cells], surface.flat
    assert flat is not None  # what is sewn has it
    heights = points[:, :, 2]
    crossed = (heights.min(axis=1) < level) & (heights.max(axis=1) > level)
    G, X = (
        np.stack([c[:, 1] - c[:, 0] + c[:, 2] - c[:, 3], c[:, 3] - c[:, 0] + c[:, 2] - c[:, 1]], 2)
        for c in (flat[crossed], points[crossed])
    )
    along = np.cross(np.cross(X[:, :, 0], X[:, :, 1]), [0.0, 0.0, 1.0])
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    inside_panel = np.einsum("mij,mjk,mk->mi", G, np.linalg.pinv(X), along)
    return float(np.mean(1.0 / np.linalg.norm(inside_panel, axis=1)))


def _across_shoulders(body: StandingBody, wearer: Wearer) -> StandingBody:
    """The body with the ellipsoid of the shoulders lying across: cloth leaves it upwards."""
    k = [name for name in wearer.names if not name.endswith("foot")].index("shoulders")
    axes, radii = body.axes.copy(), body.radii.copy()
    axes[k], radii[k] = np.roll(axes[k], 1, axis=0), np.roll(radii[k], 1)
    return StandingBody(body.centres, axes, radii)


def _axes(body: StandingBody, names: list[str], top: float) -> dict[str, Axis]:
    """Cylinders about trunk and arms, for panels without a place."""
    trunk = Axis((0.0, 0.0, top))
    axes = dict.fromkeys(("thorax", "abdomen", "pelvis"), trunk)
    for side in SIDES:
        k = names.index(f"{side}_upper_arm")
        down = body.axes[k, 0]
        start = body.centres[k] - body.radii[k, 0] * down
        x, y, z = (float(v) for v in start)
        across, aside, along = (float(v) for v in down)
        axes[f"{side}_upper_arm"] = Axis((x, y, z), (across, aside, along))
    return axes
