# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where the joints of a gait model are in its bodies, and what scales them to the wearer's.

The pelvis of a gait model has its origin between the front spines of the iliac crest, ahead of the
hips and above them. A motion puts hips at the wearer's hips, so it must know how far. The published
models, before anybody scales them, have the hips at HIPS; one's own file says where its are.

OpenSim writes the place of a joint as `location_in_parent` in files of versions before 4, and since
then as the translation of the frame that the joint names its parent.
"""

from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

# model -> middle of the hips in the pelvis, ahead, up, right [m]: Rajagopal and others (2016) and
# Delp and others (1990), in the files that are published with OpenSim
HIPS = {"rajagopal": (-0.056276, -0.07849, 0.0), "gait2392": (-0.0707, -0.0661, 0.0)}
KNEES = "knee_{0}", "walker_knee_{0}"  # names of one joint in different models


@dataclass(frozen=True)
class GaitModel:
    """Sizes of a model in the pose in which all its angles are nought.

    hips : (3,) [m], middle of the hips in the pelvis; width : [m] between them
    thighs, shanks : (2,) [m], from hip to knee and from knee to ankle, right and left
    """

    hips: np.ndarray
    width: float
    thighs: np.ndarray
    shanks: np.ndarray

    def scales(self, width: float, thighs: np.ndarray, shanks: np.ndarray) -> dict[str, float]:
        """Factors that give the model the wearer's sizes: of pelvis (z), femur and tibia (y)."""
        found = {"pelvis z": width / self.width}
        for k, side in enumerate("rl"):
            found[f"femur_{side} y"] = float(thighs[k] / self.thighs[k])
            found[f"tibia_{side} y"] = float(shanks[k] / self.shanks[k])
        return found


def read_model(path: str | Path) -> GaitModel:
    """Sizes of the pelvis and the legs of an OpenSim model.

    Parameters
    ----------
    path : file (.osim) of any version; lengths in metres

    Raises
    ------
    ValueError if there is no such file or it is no such model
    """
    path = Path(path)
    if not path.is_file():
        raise ValueError(f"there is no model {path}: name the .osim file that OpenSim saved")
    try:
        top = ElementTree.parse(path).getroot()
    except ElementTree.ParseError as error:
        raise ValueError(
            f"{path.name} is no OpenSim model: {error}; give the .osim file that OpenSim saved"
        ) from None
    joints = {one.get("name"): one for one in top.iter() if one.tag.endswith("Joint")}
    places = {}
    for side in "rl":
        for kind, names in (("hip", ("hip_{0}",)), ("knee", KNEES), ("ankle", ("ankle_{0}",))):
            named = [n.format(side) for n in names]
            joint = next((joints[n] for n in named if n in joints), None)
            if joint is None:
                raise ValueError(
                    f"{path.name} has no joint {' or '.join(named)}: give a model with the joints "
                    f"of gait2392 or of Rajagopal and others"
                )
            places[kind, side] = _place(joint, path.name)
    hips = np.array([places["hip", side] for side in "rl"])
    lengths = {
        kind: np.array([np.linalg.norm(places[kind, side]) for side in "rl"])
        for kind in ("knee", "ankle")
    }
    width = float(np.linalg.norm(hips[0] - hips[1]))
    sizes = [("hips", width), *(("knees", x) for x in lengths["knee"])]
    sizes += [("ankles", x) for x in lengths["ankle"]]
    for what, size in sizes:
        if not 0.05 < size < 0.8:
            raise ValueError(
                f"{path.name} has its {what} {size:g} m from where they hang, which is no "
                f"person's: its lengths must be in metres"
            )
    return GaitModel(hips.mean(axis=0), width, lengths["knee"], lengths["ankle"])


def _place(joint: ElementTree.Element, file: str) -> np.ndarray:
    """Where a joint is in the body above it (3,) [m]."""
    text = joint.findtext("location_in_parent")
    if text is None:
        frame = (joint.findtext("socket_parent_frame") or "").strip().split("/")[-1]
        for one in joint.iter("PhysicalOffsetFrame"):
            if one.get("name") == frame:
                text = one.findtext("translation")
    try:
        place = np.array((text or "").split(), float)
    except ValueError:
        place = np.empty(0)
    if place.shape != (3,) or not np.isfinite(place).all():
        raise ValueError(
            f"{file} does not say where its joint {joint.get('name')} is: three numbers are "
            f"expected in the frame of its parent; save the model anew with OpenSim"
        )
    return place
