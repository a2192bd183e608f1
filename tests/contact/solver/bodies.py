# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bodies, points around them and balances that the tests of contact share."""

import numpy as np

from contact.body.segments import Body, Fixed, Segment, Steady
from contact.geometry.ellipsoid import closest_points

G = 9.81


LIMB = np.array([0.1, 0.05, 0.08])


def spheres(*centres, radius=0.1, motion=Fixed):
    return Body(
        [Segment(f"s{k}", [radius] * 3, motion(centre)) for k, centre in enumerate(centres)]
    )


def random_axes(rng):
    q = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    return q * np.sign(np.linalg.det(q))


def limbs(rng, count=4, moving=True):
    """Overlapping ellipsoids, in motion or at rest."""
    segments = []
    for k in range(count):
        pose = rng.uniform(-0.05, 0.05, 3), random_axes(rng)
        rates = rng.uniform(-3, 3, 3), rng.uniform(-20, 20, 3)
        motion = Steady(*pose, *rates) if moving else Fixed(*pose)
        segments.append(Segment(f"limb {k}", LIMB * rng.uniform(0.7, 1.3), motion))
    return Body(segments)


def outside(body, t, rng, count, margin, offset=0.0):
    """Points up to `margin` off the surface of the body at time t."""
    pose = body.pose(t, body.new_pose())
    points = pose.centres.mean(axis=0) + rng.uniform(-0.2, 0.2, (int(1 / margin) * count, 3))
    gap = clearance(body, t, points).min(axis=0)
    points = points[(gap > offset) & (gap < offset + margin)][:count]
    assert len(points) == count
    return points


def clearance(body, t, x):
    """Distance of points from every segment, (m, n)."""
    pose = body.pose(t, body.new_pose())
    return np.array(
        [
            closest_points(x, r, c, a)[2]
            for r, c, a in zip(body.radii, pose.centres, pose.axes, strict=True)
        ]
    )


def energy(mass, v):
    return 0.5 * np.sum(mass * np.sum(v * v, axis=1))
