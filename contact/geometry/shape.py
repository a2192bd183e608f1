# SPDX-License-Identifier: LGPL-3.0-or-later
"""The seam for shapes: what contact must know of the shape of a segment.

A shape is convex and closed. One file holds it: a value that says its sizes, with two kernels that
get these sizes and a point in the axes of the segment. A new shape is such a file and its name in
`SHAPES`: nothing else in the package knows of any shape.

The kernels of all shapes are compiled into one that looks at the kind of the segment: a body mixes
shapes freely, and one of a single shape pays a comparison.
"""

from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np

from contact.kernel import kernel

from .capsule import Capsule
from .ellipsoid import Ellipsoid

SHAPES: tuple[type, ...] = (Ellipsoid, Capsule)
SIZES = 7  # numbers that a shape may have

# what kernels know of a shape; part of the record of a segment (contact.solver.segment_motion)
SHAPE_FIELDS = [
    ("kind", np.int64),  # place in SHAPES
    ("size", float, SIZES),  # what its kernels get
    ("bounding_radius", float),  # [m]
    ("inner_radius", float),  # [m]
    ("curvature_radius", float),  # [m]
]


class Shape(Protocol):
    """What the file of a shape gives; lengths in m.

    size : at most SIZES numbers, handed to both kernels
    half_extents : of the box around it, along e1, e2, e3
    bounding_radius : of the sphere around its origin that holds it
    inner_radius : of a sphere inside it; half the least thickness
    curvature_radius : smallest radius of curvature of its surface
    foot_and_normal(size, y0, y1, y2) : kernel; signed distance of a point (negative inside), its
        closest point of the surface (3 numbers) and the unit normal out of the body (3 numbers),
        all in the axes of the segment
    least_distance(size, y0, y1, y2) : kernel, cheap; a number that is never more than the distance
        of a point outside
    """

    @property
    def size(self) -> tuple[float, ...]: ...

    @property
    def half_extents(self) -> tuple[float, float, float]: ...

    @property
    def bounding_radius(self) -> float: ...

    @property
    def inner_radius(self) -> float: ...

    @property
    def curvature_radius(self) -> float: ...

    foot_and_normal: Any
    least_distance: Any


def set_shapes(shapes: Sequence[Shape], segments: np.ndarray) -> None:
    """Fill SHAPE_FIELDS of the records of m segments.

    Raises
    ------
    ValueError for a shape that is not in SHAPES
    """
    for shape, record in zip(shapes, segments, strict=True):
        if type(shape) not in SHAPES:
            known = ", ".join(kind.__name__ for kind in SHAPES)
            raise ValueError(f"{shape!r} is no shape that contact knows: {known}")
        record["kind"] = SHAPES.index(type(shape))
        record["size"][: len(shape.size)] = shape.size
        record["bounding_radius"] = shape.bounding_radius
        record["inner_radius"] = shape.inner_radius
        record["curvature_radius"] = shape.curvature_radius


def _of_all(kernels: Sequence[Callable], kind: int = 0) -> Callable:
    """One kernel that calls the one of its first argument, the kind."""
    own = kernels[kind]
    if kind == len(kernels) - 1:

        @kernel(makes_arrays=False)
        def chosen(which, size, y0, y1, y2):
            return own(size, y0, y1, y2)

    else:
        others = _of_all(kernels, kind + 1)

        @kernel(makes_arrays=False)
        def chosen(which, size, y0, y1, y2):
            if which == kind:
                return own(size, y0, y1, y2)
            return others(which, size, y0, y1, y2)

    return chosen


_foot_and_normal = _of_all([kind.foot_and_normal for kind in SHAPES])  # type: ignore[attr-defined]
_least_distance = _of_all([kind.least_distance for kind in SHAPES])  # type: ignore[attr-defined]


@kernel(makes_arrays=False)
def foot_and_normal(
    segment: Any, y0: float, y1: float, y2: float
) -> tuple[float, float, float, float, float, float, float]:
    """Distance [m], foot [m] and normal of a point in the axes of a segment, see `Shape`."""
    return _foot_and_normal(segment.kind, segment.size, y0, y1, y2)


@kernel(makes_arrays=False)
def least_distance(segment: Any, y0: float, y1: float, y2: float) -> float:
    """No more than the distance [m] of a point outside, in the axes of a segment."""
    return _least_distance(segment.kind, segment.size, y0, y1, y2)
