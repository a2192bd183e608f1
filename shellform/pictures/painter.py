# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pictures of surfaces painted straight into pixels, near facets over far ones.

What a plot of polygons would show, without a plotting library, for frames of an animation. Every
pixel is cut into SUB x SUB points; a polygon gives its colour to those whose centres it holds by
the even-odd rule, so folded quads are right and neighbours leave no seams. The picture is the mean.
"""

from collections.abc import Sequence

import numpy as np

from contact.kernel import kernel

from .surfaces import EDGE, LINE_WIDTH, colour_of, seen_surfaces, view_axes

SUB = 3
PAD = 0.04  # around a picture [in], as a plot leaves it
DASH = 3.7, 1.6  # a dash and a gap, in line widths


@kernel
def fill_polygons(polygons: np.ndarray, colours: np.ndarray, image: np.ndarray) -> None:
    """Fill polygons (m, k, 2), points in columns and rows of the image, one after the other.

    colours : (m, 3) uint8; image : (rows, columns, 3) uint8
    """
    rows, columns = image.shape[0], image.shape[1]
    k = polygons.shape[1]
    cuts = np.empty(k)
    for p in range(len(polygons)):
        low, high = np.inf, -np.inf
        for a in range(k):
            low, high = min(low, polygons[p, a, 1]), max(high, polygons[p, a, 1])
        for row in range(max(0, int(np.ceil(low - 0.5))), min(rows, int(np.ceil(high - 0.5)))):
            y, count = row + 0.5, 0
            for a in range(k):
                b = a + 1 if a + 1 < k else 0
                y0, y1 = polygons[p, a, 1], polygons[p, b, 1]
                if (y0 <= y) != (y1 <= y):
                    x0, x1 = polygons[p, a, 0], polygons[p, b, 0]
                    cut, place = x0 + (y - y0) / (y1 - y0) * (x1 - x0), count
                    while place > 0 and cuts[place - 1] > cut:
                        cuts[place] = cuts[place - 1]
                        place -= 1
                    cuts[place], count = cut, count + 1
            for pair in range(0, count, 2):
                first = max(0, int(np.ceil(cuts[pair] - 0.5)))
                for column in range(first, min(columns, int(np.ceil(cuts[pair + 1] - 0.5)))):
                    for c in range(3):
                        image[row, column, c] = colours[p, c]


@kernel
def mean_of_parts(image: np.ndarray, parts: int, out: np.ndarray) -> None:
    """Mean (rows, columns, 3) uint8 of parts x parts points of an image so many times as large."""
    width = 3 * out.shape[1]
    sums = np.empty(parts * width, np.uint16)
    for i in range(out.shape[0]):
        # down the columns first: long loops over neighbours
        sums[:] = 0
        for a in range(parts):
            row = image[i * parts + a].reshape(parts * width)
            for j in range(parts * width):
                sums[j] += row[j]
        for j in range(out.shape[1]):
            for c in range(3):
                total = parts * parts // 2
                for b in range(parts):
                    total += sums[3 * (j * parts + b) + c]
                out[i, j, c] = total // (parts * parts)


def bars(lines: np.ndarray, width: float) -> np.ndarray:
    """Polygons (m, 4, 2) along lines (m, 2, 2) of a width."""
    along = lines[:, 1] - lines[:, 0]
    length = np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
    across = 0.5 * width * along[:, ::-1] * (-1.0, 1.0) / length
    first, last = lines[:, 0], lines[:, 1]
    return np.stack([first - across, last - across, last + across, first + across], axis=1)


def dashes(curve: np.ndarray, width: float) -> np.ndarray:
    """Lines (m, 2, 2) that make a dashed curve through points (k, 2)."""
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])
    starts = np.arange(0.0, way[-1], sum(DASH) * width)
    ends = np.minimum(starts + DASH[0] * width, way[-1])
    at = np.stack([starts, ends], axis=1)
    return np.stack([np.interp(at, way, curve[:, c]) for c in range(2)], axis=2)


def painted(
    surfaces: Sequence[tuple],
    curves: Sequence[tuple[np.ndarray, str, float]],
    corners: np.ndarray,
    size: tuple[float, float],
    dpi: int,
    azimuth: float,
    elevation: float,
    margin: float = 0.05,
) -> np.ndarray:
    """Picture (rows, columns, 3) uint8 of surfaces with dashed curves before them.

    Parameters
    ----------
    surfaces : as for `draw_surfaces`; curves : list of (points (k, 3), colour, line width [pt])
    corners : (n, 3), what must be in the picture [m]; margin : around them [m]
    size : width and height [in]; dpi : points an inch
    azimuth, elevation : float, degrees
    """
    columns, rows = (round(dpi * length) for length in size)
    right, up, _ = view = view_axes(azimuth, elevation)
    plane = np.array([right, up])
    spans = corners @ plane.T
    low, high = spans.min(axis=0) - margin, spans.max(axis=0) + margin
    frame = np.array([columns, rows]) - 2 * PAD * dpi
    scale = SUB * (frame / (high - low)).min()
    middle, centre = 0.5 * SUB * np.array([columns, rows]), 0.5 * (low + high)

    def placed(points):
        return middle + scale * (points - centre) * (1.0, -1.0)

    points = SUB * dpi / 72
    polygons, colours, depths = [], [], []
    for facets, shades, sides, depth, side_depth in seen_surfaces(surfaces, view):
        four = np.concatenate([facets, facets[:, -1:]], axis=1) if facets.shape[1] == 3 else facets
        polygons += [placed(four[..., :2])]
        colours += [shades]
        depths += [depth]
        if len(sides):
            polygons += [bars(placed(sides[..., :2]), LINE_WIDTH * points)]
            colours += [np.tile(colour_of(EDGE), (len(sides), 1))]
            depths += [side_depth]
    order = np.argsort(np.concatenate(depths), kind="stable")
    image = np.full((SUB * rows, SUB * columns, 3), 255, np.uint8)
    _fill(np.concatenate(polygons)[order], np.concatenate(colours)[order], image)
    for curve, colour, width in curves:
        drawn = bars(dashes(placed(curve @ plane.T), width * points), width * points)
        _fill(drawn, np.tile(colour_of(colour), (len(drawn), 1)), image)
    out = np.empty((rows, columns, 3), np.uint8)
    mean_of_parts(image, SUB, out)
    return out


def _fill(polygons, colours, image):
    fill_polygons(np.ascontiguousarray(polygons), np.uint8(np.rint(255 * colours)), image)
