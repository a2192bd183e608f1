# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which parts of the body count for the torque about a joint (Fig. 9)."""

from collections.abc import Mapping, Sequence

from .wearer import Wearer


def chosen_parts(wearer: Wearer, parts: str | Mapping[str, Sequence[str]]) -> dict[str, list[str]]:
    """joint -> names of the ellipsoids that count.

    Parameters
    ----------
    parts : 'distal', all below the joint; 'child', those of the segment just below it; or a table,
        joint -> names, for joints that are not in it all below

    Raises
    ------
    ValueError for a joint or an ellipsoid that the wearer does not have
    """
    if parts == "distal":
        return {joint: wearer.below(joint) for joint in wearer.joints}
    if parts == "child":
        return {joint: wearer.just_below(joint) for joint in wearer.joints}
    if not isinstance(parts, dict):
        raise ValueError(f"parts of a torque are 'distal', 'child' or a table, not {parts!r}")
    for joint, names in parts.items():
        if joint not in wearer.joints:
            raise ValueError(f"no joint '{joint}'; there are: {', '.join(wearer.joints)}")
        for name in names:
            wearer.index(name)
    return {joint: list(parts.get(joint, wearer.below(joint))) for joint in wearer.joints}
