# SPDX-License-Identifier: LGPL-3.0-or-later
"""How much closer parts of a sheet may have come since something was measured: the trust region.

A sheet is cut into groups of neighbouring triangles. Relative to the common velocity c_k of a group
its nodes move by at most s_k dt in a step, so that anything of groups k and l comes closer by at
most

    step_kl = dt (s_k + s_l + |c_k - c_l|);

`path` adds these up, with the ways that nodes have really gone. What was found at a distance d when
the path was P need not be looked at while path + step < P + d - reach. As any common velocity will
do, they are changed whenever convenient.

Speeds are those of the step before: forces of the step push nodes into a body that will hold them.
What a node gains in one step is left to AHEAD and an allowance.
"""

import numpy as np

from contact.kernel import kernel

SIZE = 80  # triangles a group, about
MOST = 40  # groups
AHEAD = 1.25  # times the speeds of the last step bound those of the next


def groups_of(x: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Group (m,) int of each triangle (m, 3): halves of halves along their longest extents.

    x : (n, 3), positions at rest [m]
    """
    middles = x[triangles].mean(axis=1)
    parts = [np.arange(len(triangles))]
    wanted = min(MOST, max(1, len(triangles) // SIZE))
    while len(parts) < wanted:
        parts.sort(key=len)
        part = parts.pop()
        extents = np.ptp(middles[part], axis=0)
        order = part[np.argsort(middles[part, extents.argmax()], kind="stable")]
        parts += [order[: len(order) // 2], order[len(order) // 2 :]]
    group = np.empty(len(triangles), np.int64)
    for k, part in enumerate(parts):
        group[part] = k
    return group


@kernel(makes_arrays=False)
def measure_motion(
    x: np.ndarray,
    v: np.ndarray,
    before: np.ndarray,
    last_dt: float,
    common: np.ndarray,
    nodes: np.ndarray,
    begin: np.ndarray,
    out: np.ndarray,
) -> None:
    """Fill out (2, k) with the greatest way and speed in each group, relative to its velocity.

    Infinite where a position or a velocity is not finite.

    x, v, before : (n, 3), now [m, m/s] and the step before, set to x; common : (k, 3) [m/s]
    nodes, begin : (l,), (k + 1,), nodes of group after group
    """
    for k in range(len(common)):
        way = speed = total = 0.0
        c0, c1, c2 = common[k, 0], common[k, 1], common[k, 2]
        for at in range(begin[k], begin[k + 1]):
            i = nodes[at]
            a = x[i, 0] - before[i, 0] - last_dt * c0
            b = x[i, 1] - before[i, 1] - last_dt * c1
            c = x[i, 2] - before[i, 2] - last_dt * c2
            way = max(way, a * a + b * b + c * c)
            a, b, c = v[i, 0] - c0, v[i, 1] - c1, v[i, 2] - c2
            speed = max(speed, a * a + b * b + c * c)
            total += x[i, 0] + x[i, 1] + x[i, 2] + v[i, 0] + v[i, 1] + v[i, 2]
        if not np.isfinite(total):
            way = speed = np.inf
        out[0, k], out[1, k] = np.sqrt(way), np.sqrt(speed)
    for i in range(len(x)):
        before[i, 0], before[i, 1], before[i, 2] = x[i, 0], x[i, 1], x[i, 2]


@kernel(makes_arrays=False)
def advance(
    moved: np.ndarray,
    apart: np.ndarray,
    last_dt: float,
    dt: float,
    path: np.ndarray,
    step: np.ndarray,
    mark: np.ndarray,
    limit: np.ndarray,
    near_limit: np.ndarray,
    allowance: float,
) -> tuple[bool, bool, float]:
    """Add the last step to `path` (k, k) and fill `step` (k, k) for the next one of dt [s].

    moved : (2, k), see `measure_motion`; apart : (k, k), |c_k - c_l|; mark, limit, near_limit : see
    TrustRegion; allowance : float [m], added to every step

    Returns whether the list and those near have to be made anew, and the most that the path may
    have grown since `mark` when this step is over.
    """
    listing = nearing = False
    used = 0.0
    for k in range(len(path)):
        for m in range(k + 1):
            path[k, m] += moved[0, k] + moved[0, m] + last_dt * apart[k, m]
            speed = moved[1, k] + moved[1, m] + apart[k, m]
            step[k, m] = AHEAD * dt * speed + allowance
            ahead = path[k, m] + step[k, m]
            # what is not finite has to be looked at
            listing = listing or not ahead < limit[k, m]
            nearing = nearing or not ahead < near_limit[k, m]
            used = max(used, ahead - mark[k, m])
            path[m, k], step[m, k] = path[k, m], step[k, m]
    return listing, nearing, used


@kernel
def group_boxes(x: np.ndarray, nodes: np.ndarray, begin: np.ndarray, apart: np.ndarray) -> None:
    """Fill apart (k, k) with the distances of the boxes of groups [m]; x (n, 3), of all nodes."""
    box = np.empty((len(begin) - 1, 2, 3))
    for k in range(len(box)):
        box[k, 0], box[k, 1] = np.inf, -np.inf
        for at in range(begin[k], begin[k + 1]):
            for c in range(3):
                box[k, 0, c] = min(box[k, 0, c], x[nodes[at], c])
                box[k, 1, c] = max(box[k, 1, c], x[nodes[at], c])
    for k in range(len(box)):
        for m in range(len(box)):
            square = 0.0
            for c in range(3):
                gap = max(box[k, 0, c] - box[m, 1, c], box[m, 0, c] - box[k, 1, c])
                square += max(0.0, gap) ** 2
            apart[k, m] = np.sqrt(square)


@kernel(makes_arrays=False)
def mean_velocities(
    v: np.ndarray, nodes: np.ndarray, begin: np.ndarray, common: np.ndarray, apart: np.ndarray
) -> None:
    """Fill common (k, 3) with mean velocities of groups, apart (k, k) with their differences."""
    for k in range(len(common)):
        count = max(1, begin[k + 1] - begin[k])
        for c in range(3):
            total = 0.0
            for at in range(begin[k], begin[k + 1]):
                total += v[nodes[at], c]
            common[k, c] = total / count
    for k in range(len(common)):
        for m in range(len(common)):
            square = 0.0
            for c in range(3):
                square += (common[k, c] - common[m, c]) ** 2
            apart[k, m] = np.sqrt(square)


class TrustRegion:
    """Bounds on the motion of groups of a sheet.

    Parameters
    ----------
    group : (m,) int of the triangles (m, 3) int; n : number of nodes
    own : slice of the nodes whose motion is measured here; allowance : float [m], of a step

    Attributes
    ----------
    path, step : (k, k) [m], so far and in the next step
    flat_path, flat_step : (k k,), the same arrays
    limit, near_limit : (k, k) [m], paths up to which the list, and those near in it, hold
    moved : (2, k), of this rank, to be made the greatest over all
    """

    def __init__(
        self, group: np.ndarray, triangles: np.ndarray, n: int, own: slice, allowance: float
    ):
        k = int(group.max()) + 1
        pairs = np.unique(np.repeat(group, 3) * n + triangles.ravel())
        self._nodes, of = pairs % n, pairs // n
        self._begin = np.searchsorted(of, np.arange(k + 1))
        mine = (self._nodes >= own.start) & (self._nodes < own.stop)
        self._own_nodes = self._nodes[mine] - own.start
        self._own_begin = np.searchsorted(of[mine], np.arange(k + 1))
        self._before, self._fresh = np.zeros((own.stop - own.start, 3)), True
        self._common, self._apart, self._last_dt = np.zeros((k, 3)), np.zeros((k, k)), 0.0
        self.moved, self.path, self.step = np.zeros((2, k)), np.zeros((k, k)), np.zeros((k, k))
        self.flat_path, self.flat_step = self.path.ravel(), self.step.ravel()
        self.limit, self.near_limit = np.full((2, k, k), -np.inf)
        self._allowance = allowance
        self._mark, self._slack = np.zeros((k, k)), -np.inf

    def measure(self, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        """`moved` of this rank's nodes, at x (n_owned, 3) [m], v those of the last step [m/s]."""
        if self._fresh:
            self._before[:], self._fresh = x, False
        measure_motion(
            x, v, self._before, self._last_dt, self._common, self._own_nodes, self._own_begin,
            self.moved,
        )  # fmt: skip
        return self.moved

    def advance(self, dt: float) -> tuple[bool, bool, bool, bool]:
        """Go on by a step of dt [s], by `moved`.

        Returns whether pairs have to be listed, those near chosen, and any measured, and whether
        all motion is finite.
        """
        listing, nearing, used = advance(
            self.moved, self._apart, self._last_dt, dt, self.path, self.step, self._mark,
            self.limit, self.near_limit, self._allowance,
        )  # fmt: skip
        self._last_dt = dt
        return listing, nearing, not used < self._slack, used < np.inf

    def forget(self) -> None:
        """Nothing is known: positions have been set by others."""
        self.limit[:] = -np.inf
        self.path[:] = 0.0
        self._fresh = True

    def stale(self, left: float) -> np.ndarray:
        """Groups (k, k) bool that have less than a way [m] left until they have to be listed."""
        return ~(self.path + self.step < self.limit - left)

    def begin_list(self, x: np.ndarray, skin: float, reach: float, which: np.ndarray) -> None:
        """A list is made of pairs within reach + skin of the groups `which` (k, k) bool.

        x : (n, 3), positions of all nodes [m]
        """
        boxes = np.empty_like(self.path)
        group_boxes(x, self._nodes, self._begin, boxes)
        limit = self.path + np.maximum(boxes - reach, skin)
        self.limit[which] = limit[which]
        self.near_limit[which] = -np.inf

    def begin_near(self, skin: float) -> None:
        """Those near are chosen, by paths up to `near_limit`."""
        np.maximum(4.0 * self.step, skin, out=self.near_limit)
        self.near_limit += self.path

    def found(self, slack: float) -> None:
        """Pairs near need no look while the path grows by less than `slack` [m]."""
        self._mark[:] = self.path
        self._slack = slack

    def set_common(self, v: np.ndarray) -> None:
        """Take the means of the velocities v (n, 3) of all nodes [m/s] for those of the groups."""
        mean_velocities(v, self._nodes, self._begin, self._common, self._apart)
