# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bodies of triangles: how far off they are, and what they cost beside ellipsoids.

    python -m demos.studies.triangle_bodies.run error
    python -m demos.studies.triangle_bodies.run cost

`error`: an ellipsoid of semi-axes 100, 60, 80 mm cut into triangles; distance and normal of points
0.3 mm off it, of the flat triangles and of the smooth surface that contact meets: root mean
squares, and orders from line to line.

`cost`: a thigh that swings and walks on, and cloth around it that is pulled along, half of its
nodes within reach of the skin; microseconds a node and step of contact alone with the ellipsoid,
with triangles, and with fifteen more ellipsoids that nothing touches. It is the mean over all
steps, in the quickest of five repeats, as other work on a machine disturbs some.
"""

import argparse
import time

import numpy as np

from contact.body.blended_surface import BlendedSurface
from contact.body.segments import Body, Fixed, Segment, turned
from contact.geometry.ellipsoid import closest_points
from contact.geometry.triangle_mesh.closest import STACK, closest
from contact.geometry.triangle_mesh.placed import new_placed, refit
from contact.geometry.triangle_mesh.smooth import flat_gap, smooth_gap
from contact.geometry.triangle_mesh.sphere import sphere
from contact.geometry.triangle_mesh.topology import mesh_of
from contact.kernel import kernel
from contact.solver.surface_correction import SurfaceCorrection
from contact.solver.velocity_correction import VelocityCorrection

RADII = np.array([0.1, 0.06, 0.08])
THIGH = np.array([0.09, 0.09, 0.25])
OFFSET, DT = 2.5e-4, 5e-5


@kernel
def gaps(mesh, placed, points, out):
    """Distance and normal of points (n, 3), smooth and flat, into out (n, 8)."""
    stack, bounds = np.empty(STACK, np.int64), np.empty(STACK)
    for i in range(len(points)):
        x0, x1, x2 = points[i, 0], points[i, 1], points[i, 2]
        t, square = closest(mesh, placed, x0, x1, x2, -1, -1, stack, bounds)
        _, _, _, gap, n0, n1, n2 = smooth_gap(mesh, placed, t, square, x0, x1, x2)
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = gap, n0, n1, n2
        _, _, gap, n0, n1, n2 = flat_gap(mesh, placed, t, x0, x1, x2)
        out[i, 4], out[i, 5], out[i, 6], out[i, 7] = gap, n0, n1, n2


def errors(divisions: int, count: int = 4000) -> tuple[int, float, np.ndarray]:
    """Triangles, their greatest sagitta [m], and errors of smooth and flat distance [m], normal."""
    vertices, triangles = sphere(1.0, divisions)
    vertices = vertices * RADII
    mesh = mesh_of(triangles, vertices)
    placed = new_placed(mesh, len(vertices))
    placed.vertices[:] = vertices
    refit(mesh, placed)
    x = np.random.default_rng(0).standard_normal((count, 3))
    x *= RADII / np.linalg.norm(x, axis=1, keepdims=True)
    foot, normal, _ = closest_points(x, RADII)
    out = np.empty((count, 8))
    gaps(mesh, placed, foot + 3e-4 * normal, out)
    off = out - np.column_stack([np.full(count, 3e-4), normal, np.full(count, 3e-4), normal])
    sagitta = -closest_points(vertices[triangles].mean(axis=1), RADII)[2].min()
    parts = off[:, :1], off[:, 1:4], off[:, 4:5], off[:, 5:]
    return len(triangles), sagitta, np.array([np.sqrt(np.mean(np.sum(e**2, 1))) for e in parts])


def show_errors() -> None:
    """The table of errors and of their orders."""
    print("triangles  sagitta   smooth distance   normal         flat distance     normal")
    before = None
    for divisions in (2, 3, 4, 5, 6):
        n, sagitta, found = errors(divisions)
        orders = np.full(4, np.nan) if before is None else np.log2(before / found)
        d, m, f, g = (
            f"{e * s:9.4f} {u} ({o:3.1f})"
            for e, s, u, o in zip(
                found, (1e3, 1, 1e3, 1), ("mm", "", "mm", ""), orders, strict=True
            )
        )
        print(f"{n:9d} {sagitta * 1e3:6.2f} mm {d} {m} {f} {g}")
        before = found


def swing(t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Pose of the thigh."""
    angle, rate = 0.5 * np.sin(2 * np.pi * t), np.pi * np.cos(2 * np.pi * t)
    axes = turned(np.eye(3), np.array([0.0, angle, 0.0]))
    along = np.array([1.3, 0.0, 0.0])
    return along * t, axes, along, np.array([0.0, rate, 0.0])


def cost(correction: VelocityCorrection | SurfaceCorrection, x: np.ndarray, steps: int) -> float:
    """Seconds a step of contact of cloth that follows the thigh; see above."""
    rest, x, v = x.copy(), x.copy(), np.tile([1.3, 0.0, 0.0], (len(x), 1))
    mass, t, spent = np.full(len(x), 1e-5), 0.0, []
    for _ in range(steps):
        centre, axes, _, _ = swing(t)
        v += DT * (4e4 * (centre + rest @ axes - x) - 200 * (v - [1.3, 0.0, 0.0]))
        v[:, 2] -= 9.81 * DT
        begin = time.perf_counter()
        correction(x, v, mass, DT, t)
        spent.append(time.perf_counter() - begin)
        x += DT * v
        t += DT
    return float(np.mean(spent))


def show_costs(steps: int) -> None:
    """The table of costs."""
    a, z = np.meshgrid(2 * np.pi * np.arange(60) / 60, np.linspace(-0.2, 0.2, 56), indexing="ij")
    a, z = a.ravel(), z.ravel()
    off = np.maximum(0, np.random.default_rng(0).uniform(-1, 1, len(a))) * 0.02
    r = THIGH[0] * np.sqrt(1 - (z / THIGH[2]) ** 2) + 3e-4 + off
    x = np.column_stack([r * np.cos(a), r * np.sin(a), z])
    thigh = Segment("thigh", THIGH, swing)
    others = [Segment(f"s{k}", [0.1] * 3, Fixed((0.5, 0.0, 1.0 + k))) for k in range(15)]
    bodies = {"1 ellipsoid": Body([thigh]), "16 ellipsoids": Body([thigh, *others])}
    corrections = {
        name: VelocityCorrection(body, len(x), 0.3, OFFSET) for name, body in bodies.items()
    }
    for divisions in (4, 5, 6):
        vertices, triangles = sphere(1.0, divisions)
        skin = BlendedSurface(
            vertices * THIGH, triangles, np.ones((len(vertices), 1)), bodies["1 ellipsoid"]
        )
        corrections[f"{len(triangles)} triangles"] = SurfaceCorrection(
            skin, len(x), friction=0.3, offset=OFFSET
        )
    print(f"{len(x)} nodes: us a node and step, beside one ellipsoid; nodes in contact")
    first = None
    for name, correction in corrections.items():
        cost(correction, x, 3)
        spent = min(cost(correction, x, steps) for _ in range(5)) / len(x) * 1e6
        first = first or spent
        print(f"{name:18s} {spent:6.3f} {spent / first:6.2f} {correction.active:6d}")


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("table", choices=["error", "cost"])
    parser.add_argument("--steps", type=int, default=1000)
    asked = parser.parse_args(argv)
    if asked.table == "error":
        show_errors()
    else:
        show_costs(asked.steps)


if __name__ == "__main__":
    main()
