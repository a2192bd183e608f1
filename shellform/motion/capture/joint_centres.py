# SPDX-License-Identifier: LGPL-3.0-or-later
"""Points of the body from tracks of markers: middles, hip and knee centres by published rules.

    { same = a }                                    another point or marker
    { midpoint = [a, b, ...] }                      their mean
    { offset = a, along = [b, c], by = L }          L metres from a in the direction b to c
    { normal = a, to = [b, c], across = [d, e], by = L }
                                                    L metres from a along (c - b) x (e - d)
    { hip = "right", asis = [R, L], back = b }      Harrington et al. 2007; b: mid PSIS or sacrum
    { inward = a, by = L, proximal = p, across = [b, c], cluster = [..] }
                                                    joint centre L metres inward of marker a
    { agree = [a, b], by = L }                      a, or b where these are further than L apart

Inward: the centre J lies at L from the lateral marker a, in the plane of a, the joint above p and
the joint's axis, with a right angle at J between p and a (the chord of Davis et al. 1991). The axis
runs outward as b to c does, the front of the pelvis. With three markers of a cluster the axis is
fixed in the cluster, at the mean direction over the capture, so that it turns with the limb.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

Rule = Mapping[str, Any]

NARROW = 0.01  # a cluster that stands off a line by less does not tell its turn about it [m]

# rule -> keys it must have and may have beside its own
RULES = {
    "same": ((), ()),
    "midpoint": ((), ()),
    "offset": (("along", "by"), ()),
    "normal": (("to", "across", "by"), ()),
    "hip": (("asis", "back"), ()),
    "inward": (("by", "proximal", "across"), ("cluster",)),
    "agree": (("by",), ()),
}


def references(rule: Rule) -> tuple[list[str], list[str]]:
    """Names of the markers and points that a rule needs, and of those it uses where they are."""
    if "same" in rule:
        names = _texts([rule["same"]], 1, "same")
    elif "midpoint" in rule:
        names = _texts(rule["midpoint"], None, "midpoint")
    elif "offset" in rule:
        names = [*_texts([rule["offset"]], 1, "offset"), *_texts(rule["along"], 2, "along")]
    elif "normal" in rule:
        names = [*_texts([rule["normal"]], 1, "normal"), *_texts(rule["to"], 2, "to")]
        names += _texts(rule["across"], 2, "across")
    elif "agree" in rule:
        names = _texts(rule["agree"], 2, "agree")
    elif "hip" in rule:
        if rule["hip"] not in ("right", "left"):
            raise ValueError(f"hip is 'right' or 'left', not {rule['hip']!r}")
        names = [*_texts(rule["asis"], 2, "asis"), *_texts([rule["back"]], 1, "back")]
    else:
        names = _texts([rule["inward"], rule["proximal"]], 2, "inward, proximal")
        names = [*names, *_texts(rule["across"], 2, "across")]
    if "by" in rule and not (isinstance(rule["by"], (int, float)) and 0 < rule["by"] < 1):
        raise ValueError(f"by is a length in metres, not {rule['by']!r}")
    return names, _texts(rule["cluster"], None, "cluster") if rule.get("cluster") else []


def lies_at(rule: Rule) -> list[str]:
    """Names of the markers and points beside which a rule's point lies, on the same part of the
    body; what only gives it a direction is not among them."""
    for kind in ("midpoint", "agree"):
        if kind in rule:
            return list(rule[kind])
    if "hip" in rule:
        return [*rule["asis"], rule["back"]]
    return [next(rule[kind] for kind in ("same", "offset", "normal", "inward") if kind in rule)]


def _texts(value, count, key):
    if not isinstance(value, list) or not all(isinstance(v, str) for v in value):
        raise ValueError(f"{key} needs names, not {value!r}")
    if not value or len(value) != (count or len(value)):
        raise ValueError(f"{key} needs {count or 'some'} names, not {len(value)}")
    return value


def point(rule: Rule, at: Mapping[str, np.ndarray]) -> np.ndarray:
    """Track (n, 3) of a point [m] by its rule, from the tracks `at` by name."""
    if "same" in rule:
        return at[rule["same"]]
    if "midpoint" in rule:
        return np.mean([at[name] for name in rule["midpoint"]], axis=0)
    if "agree" in rule:
        first, second = rule["agree"]
        return at[first if apart(at[first], at[second]) <= rule["by"] else second]
    if "offset" in rule:
        start, end = (at[name] for name in rule["along"])
        return at[rule["offset"]] + rule["by"] * _unit(end - start)
    if "normal" in rule:
        (b, c), (d, e) = ([at[name] for name in rule[key]] for key in ("to", "across"))
        return at[rule["normal"]] + rule["by"] * _unit(np.cross(c - b, e - d))
    if "hip" in rule:
        right, left = (at[name] for name in rule["asis"])
        return hip_centre(right, left, at[rule["back"]], rule["hip"])
    start, end = (at[name] for name in rule["across"])
    cluster = [at[name] for name in rule.get("cluster", ())]
    return inward(at[rule["inward"]], at[rule["proximal"]], end - start, rule["by"], cluster)


def hip_centre(
    right_asis: np.ndarray, left_asis: np.ndarray, back: np.ndarray, side: str
) -> np.ndarray:
    """Centre of a hip by the regression on the pelvis' width PW and depth PD.

    From the middle of the ASIS, in mm: 0.24 PD + 9.9 backward, 0.30 PW + 10.9 downward,
    0.33 PW + 7.3 to the side (Harrington et al., J. Biomech. 40, 2007, 595-602). PW and PD are
    medians over the frames, as the pelvis is rigid.

    Parameters
    ----------
    right_asis, left_asis, back : (n, 3) float [m]; back: middle of the PSIS, or sacrum
    side : "right" or "left"

    Returns
    -------
    (n, 3) float [m]
    """
    middle = 0.5 * (right_asis + left_asis)
    across = right_asis - left_asis
    width = np.nanmedian(np.linalg.norm(across, axis=1))
    depth = np.nanmedian(np.linalg.norm(middle - back, axis=1))
    right = _unit(across)
    up = _unit(np.cross(right, middle - back))
    forward = np.cross(up, right)
    aside = (0.33 * width + 7.3e-3) * (1.0 if side == "right" else -1.0)
    return (
        middle - (0.24 * depth + 9.9e-3) * forward - (0.30 * width + 10.9e-3) * up + aside * right
    )


def apart(one: np.ndarray, other: np.ndarray) -> float:
    """Median distance of two tracks (n, 3) [m]."""
    return float(np.nanmedian(np.linalg.norm(one - other, axis=1)))


def inward(
    lateral: np.ndarray,
    proximal: np.ndarray,
    axis: np.ndarray,
    by: float,
    cluster: Sequence[np.ndarray] = (),
) -> np.ndarray:
    """Joint centre inward of a lateral marker, by the chord rule.

    Parameters
    ----------
    lateral, proximal : (n, 3) float, the marker and the centre of the joint above [m]
    axis : (n, 3) float, roughly the joint's axis, pointing outward
    by : float, half the joint's width with the marker's radius [m]
    cluster : sequence of (n, 3) float, markers fixed on the limb above the joint

    Returns
    -------
    (n, 3) float [m]
    """
    if len(cluster) >= 3 and breadth(np.stack(cluster, axis=1)) > NARROW:
        axis = fixed_in(np.stack(cluster, axis=1), axis)
    up = proximal - lateral
    length = np.linalg.norm(up, axis=1, keepdims=True)
    up = up / length
    outward = _unit(axis - np.sum(axis * up, axis=1, keepdims=True) * up)
    share = by / length  # cosine at the marker; the right angle is at the centre
    return lateral + by * (share * up - np.sqrt(np.maximum(1 - share**2, 0)) * outward)


def breadth(cluster: np.ndarray) -> float:
    """How far the markers (n, k, 3) of a cluster stand off a line, median over the frames [m]."""
    shape = cluster - cluster.mean(axis=1, keepdims=True)
    return float(np.median(np.linalg.svd(shape, compute_uv=False)[:, 1]))


def fixed_in(cluster: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """The direction fixed in a cluster that follows `axis` best, as directions (n, 3).

    The cluster's turn against its first frame is the best rotation in the sense of least squares
    (Soederkvist, Wedin, J. Biomech. 26, 1993); the direction in it is the mean over all frames.
    """
    shape = cluster - cluster.mean(axis=1, keepdims=True)
    u, _, vt = np.linalg.svd(np.einsum("nka,kb->nab", shape, shape[0]))
    u[:, :, 2] *= np.linalg.det(u @ vt)[:, None]
    turn = u @ vt  # from the first frame to each one
    mean = np.einsum("nab,na->b", turn, _unit(axis))
    return np.einsum("nab,b->na", turn, mean / np.linalg.norm(mean))


def _unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
