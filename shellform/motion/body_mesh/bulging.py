# SPDX-License-Identifier: LGPL-3.0-or-later
r"""How far thighs and shanks bulge, so that each keeps its volume as knees and hips bend.

Blended skin loses flesh behind a bent knee, where it is pressed flat, and wins or loses some about
each joint, as one side of it is farther from the centre than the other. What is missing is given
back where a limb is fleshy: points move straight away from its axis by beta d
(`contact.body.bulge`), d fading towards the joints, on thighs towards the other leg, and over the
shin.

beta is found once, from volumes (`segment_volumes`) in poses of one joint after the other, with a
few amounts of beta each: where the polynomial through these has the volume of standing. Splines in
the cosine of the bend plus a constant angle, so that forward and back differ, are laid through what
all angles ask for. Standing has none; so girths stay exact.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.interpolate import PPoly, make_lsq_spline
from scipy.spatial.transform import Rotation

from contact.body.bulge import Bulge, Swell
from contact.body.segments import Pose
from contact.body.skinned_surface import Bend, SkinnedSurface
from shellform.motion.recording import SIDES

from .segment_volumes import SegmentVolumes
from .surface import BodySurface

AMOUNTS = (-0.012, 0.0, 0.012, 0.024)  # at which volumes are taken, least and most of beta [m]
LEAST = 1e-3  # of d, below which a point is left alone


class Hinge(NamedTuple):
    """A joint of a leg whose bend makes flesh bulge.

    above, below : its segments without the side, None for the pelvis
    angles : from, to and step of those at which volumes are taken [degree]
    offset : constant angle under the cosine [degree]
    sign : 1 where the bend turns what is below back, -1 forward
    pieces : of the spline
    """

    name: str
    above: str | None
    below: str
    angles: tuple[float, float, float]
    offset: float
    sign: float
    pieces: int


KNEE = Hinge("knee", "thigh", "shank", (-10.0, 145.0, 3.0), 15.0, 1.0, 12)
HIP = Hinge("hip", None, "thigh", (-40.0, 125.0, 10.0), 45.0, -1.0, 4)
# joints at the ends of a part that bulges; where d rises and falls, in its length from the first
PARTS = {
    "thigh": ("hip", "knee", (-0.1, 0.3), (0.6, 1.0)),
    "shank": ("knee", "ankle", (-0.05, 0.2), (0.35, 0.85)),
}
LEG = ("thigh", "shank", "foot")
INSIDE, SHIN = 0.7, 0.6  # by which d is less towards the other leg, over the shin


def directions_of(
    body: BodySurface, weights: np.ndarray, names: Sequence[str]
) -> tuple[np.ndarray, np.ndarray]:
    """Fields (n,), by their number in `field_names`, -1 for none, and directions d (n, 3).

    weights : (n, m) of the segments `names`
    """
    fields, directions = np.full(len(body.points), -1), np.zeros_like(body.points)
    for number, (side, part) in enumerate(field_names()):
        top, bottom, rise, fall = PARTS[part]
        first = body.landmarks[f"{side}_{top}"]
        line = body.landmarks[f"{side}_{bottom}"] - first
        arm = body.points - first
        along = arm @ line / (line @ line)
        out = arm - along[:, None] * line
        out /= np.maximum(np.linalg.norm(out, axis=1), 1e-9)[:, None]
        inward = body.left if side == "right" else -body.left
        ahead = np.cross(body.left, -line / np.linalg.norm(line))
        bare, most = (inward, INSIDE) if part == "thigh" else (ahead, SHIN)
        less = most * _rise(out @ bare)
        own = _rise(2.0 * weights[:, names.index(f"{side}_{part}")] - 1.0)
        size = own * (1.0 - less)
        size *= _rise((along - rise[0]) / (rise[1] - rise[0]))
        size *= _rise((fall[1] - along) / (fall[1] - fall[0]))
        pick = size > LEAST
        fields[pick], directions[pick] = number, (size[:, None] * out)[pick]
    return fields, directions


def field_names() -> list[tuple[str, str]]:
    """Side and part of each field."""
    return [(side, part) for side in SIDES for part in PARTS]


def _rise(u):
    """0 below 0, 1 above 1, smooth between."""
    u = np.clip(u, 0.0, 1.0)
    return u * u * (3.0 - 2.0 * u)


def bulge_of(
    body: BodySurface,
    weights: np.ndarray,
    names: Sequence[str],
    bound: Pose,
    bends: Sequence[Bend],
    smoothing: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None,
) -> Bulge:
    """The bulge of a standing body whose skin is bound as `SkinnedSurface` says.

    bends : of the knees; thighs that meet are left out, as they give way to each other only for
        a while
    """
    fields, directions = directions_of(body, weights, names)
    rows = {hinge: np.arange(*hinge.angles) for hinge in (KNEE, HIP)}
    table = [(KNEE, 0.0), *((hinge, angle) for hinge, row in rows.items() for angle in row)]

    def pose(t, out):
        return bent(body, names, bound, *table[int(t)], out)

    def skin(amount):
        return SkinnedSurface(
            body.points + amount * directions, body.triangles, weights, names, pose, bound, bends,
            smoothing,
        )  # fmt: skip

    plain, x = skin(0.0), np.empty_like(body.points)
    volumes = SegmentVolumes(plain, plain.positions(0.0, x).copy(), pose)
    rest = volumes(0.0, x)
    lacks = np.empty((len(AMOUNTS), len(table), len(names)))
    for k, amount in enumerate(AMOUNTS):
        one = skin(amount)
        for j in range(len(table)):
            lacks[k, j] = volumes(float(j), one.positions(float(j), x)) - rest
    swells = []
    for number, (side, part) in enumerate(field_names()):
        s, first = names.index(f"{side}_{part}"), 1
        for hinge, row in rows.items():
            of_hinge = lacks[:, first : first + len(row), s]
            first += len(row)
            if part in (hinge.above, hinge.below):
                wanted = np.array([amount_of(lack) for lack in of_hinge.T])
                swells.append(_swell(body, number, side, hinge, row, wanted))
    return Bulge(fields, directions, swells)


def amount_of(lacks: np.ndarray) -> float:
    """beta [m] of least size with no lack, of the polynomial through (len(AMOUNTS),) [m^3]."""
    polynomial = np.polyfit(AMOUNTS, lacks, len(AMOUNTS) - 1)
    polynomial[np.abs(polynomial * AMOUNTS[-1] ** np.arange(3, -1, -1)) < 1e-9] = 0.0
    roots = np.roots(polynomial)
    real = roots.real[np.abs(roots.imag) < 1e-9]
    if len(real) == 0:  # nothing bulges there
        return 0.0
    return float(np.clip(real[np.argmin(np.abs(real))], AMOUNTS[0], AMOUNTS[-1]))


def _swell(body, number, side, hinge, angles, wanted):
    """The spline of one field and joint near beta (k,) [m] wanted at angles (k,) [degree]."""
    top, bottom = PARTS[hinge.below][:2]
    down = body.landmarks[f"{side}_{bottom}"] - body.landmarks[f"{side}_{top}"]
    down /= np.linalg.norm(down)
    turned = Rotation.from_rotvec(-np.radians(hinge.sign * hinge.offset) * body.left).apply(down)
    cosines = np.cos(np.radians(angles + hinge.offset))[::-1]
    knots = np.linspace(cosines[0], cosines[-1], hinge.pieces + 1)
    padded = np.concatenate([knots[[0] * 3], knots, knots[[-1] * 3]])
    spline = PPoly.from_spline(make_lsq_spline(cosines, wanted[::-1], padded))
    amounts = spline.c[::-1, 3:-3].T
    above = "pelvis" if hinge.above is None else f"{side}_{hinge.above}"
    return Swell(
        number, above, f"{side}_{hinge.below}", turned, down, (knots[0], knots[-1]), amounts
    )


def bent(
    body: BodySurface, names: Sequence[str], bound: Pose, hinge: Hinge, angle: float, out: Pose
) -> Pose:
    """The standing pose with one joint of both legs bent by an angle [degree]."""
    for part, given in zip(out, bound, strict=True):
        part[:] = given
    turn = Rotation.from_rotvec(np.radians(hinge.sign * angle) * body.left).as_matrix()
    moving = LEG[LEG.index(hinge.below) :]
    for side in SIDES:
        centre = body.landmarks[f"{side}_{hinge.name}"]
        for segment in (f"{side}_{part}" for part in moving):
            if segment in names:
                j = names.index(segment)
                out.centres[j] = centre + turn @ (bound.centres[j] - centre)
                out.axes[j] = bound.axes[j] @ turn.T
    return out
