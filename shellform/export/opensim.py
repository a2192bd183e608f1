# SPDX-License-Identifier: LGPL-3.0-or-later
"""A run for OpenSim: loads on the model's bodies, torques of its coordinates, the motion itself.

    external_loads.xml, external_loads.mot   force, point and torque on each body, in the ground
    coordinate_torques.sto                   the clothing's torque along each coordinate
    coordinate_forces.xml                    the garment as forces of coordinates, fitted
    coordinates.mot                          angles of the wearer, hips of the model at the wearer's

The ground is that of the scene: x ahead, y up, z to the right of the wearer, the floor at 0. A
model is put there by coordinates.mot, or by markers that were turned alike. Where loads are given
to inverse dynamics, it finds the torques of the joints less those of the clothing.
"""

from pathlib import Path
from typing import Any

import numpy as np

from shellform.motion.gait.strides import counted
from shellform.motion.recording import SIDES
from shellform.motion.wearer import Wearer
from shellform.scene.scene_file import read_scene
from shellform.scene.wearer import wearer_of
from shellform.simulation.ensemble import complete_of

from .coordinate_forces import Fit, fit
from .coordinate_torques import angles, coordinate_torques
from .opensim_model import HIPS, read_model
from .opensim_names import BODIES, coordinates_of, to_ground
from .opensim_xml import FORCE, POINT, TORQUE, write_coordinate_forces, write_external_loads
from .segment_loads import Loads, add_arms, joint_torques, recorded_torques, segment_loads
from .storage_file import write_storage

FILES = (
    "external_loads.xml",
    "external_loads.mot",
    "coordinate_torques.sto",
    "coordinate_forces.xml",
    "coordinates.mot",
)


def export(
    run: str | Path,
    folder: str | Path,
    model: str = "rajagopal",
    file: str | Path | None = None,
) -> dict[str, Any]:
    """Write FILES of a complete run, of the mean of its starts.

    Parameters
    ----------
    run : folder of the run; folder : made if missing
    model : whose names and signs the coordinates have, "rajagopal" or "gait2392"
    file : the user's own model (.osim), whose pelvis and legs are measured; by default the hips are
        where the published model has them

    Returns
    -------
    dict, `fits`, coordinate -> Fit; `runs`, how many starts; `times` (n,) [s]; `torques`,
    coordinate -> (n,) [N m]; `scales`, body and axis -> factor that gives the model of `file` the
    wearer's sizes

    Raises
    ------
    ValueError for a folder without a complete run, for a model of another name and for a file that
    is no model
    """
    chosen = coordinates_of(model)
    own = None if file is None else read_model(file)
    run, folder = Path(run), Path(folder)
    members = complete_of(run)
    scene = read_scene(run / "scene.toml")
    wearer = wearer_of(scene)
    if "lumbar" in wearer.joints:
        raise ValueError(
            f"{run}: its garment hangs on trunk and arms, and only loads of the lower body have "
            "names in OpenSim's models here: export a run of trousers or a skirt"
        )
    loads = segment_loads(wearer, [member.out / "ledger.csv" for member in members])
    if scene.output.parts == "distal":
        tables = [member.out / "torque.csv" for member in members]
        add_arms(wearer, loads, recorded_torques(wearer, tables))
    torques = coordinate_torques(wearer, loads.times, joint_torques(wearer, loads), chosen)
    motion = angles(wearer.recording, chosen, HIPS[model] if own is None else own.hips)
    fits = _fits(wearer, loads.times, torques, motion)
    folder.mkdir(parents=True, exist_ok=True)
    bodies = [BODIES[segment] for segment in loads.segments]
    source = f"of {run.name}, mean of {len(members)} starts; N, m, N m; on the wearer"
    write_storage(folder / FILES[1], loads.times, _columns(loads, bodies), source)
    write_external_loads(folder / FILES[0], FILES[1], bodies)
    write_storage(folder / FILES[2], loads.times, torques, f"torque of the clothing {source}")
    write_coordinate_forces(folder / FILES[3], fits)
    write_storage(folder / FILES[4], wearer.recording.times, motion, f"motion {source}")
    scales = {} if own is None else own.scales(*_sizes(wearer))
    return {
        "fits": fits,
        "runs": len(members),
        "times": loads.times,
        "torques": torques,
        "scales": scales,
    }


def _sizes(wearer: Wearer) -> tuple[float, np.ndarray, np.ndarray]:
    """Distance of the hips, and lengths of thighs and shanks (2,), right and left [m]."""
    state = wearer.joint_state(wearer.start, wearer.new_joints())
    at = dict(zip(wearer.joints, state.centres.copy(), strict=True))

    def lengths(above: str, below: str) -> np.ndarray:
        return np.array([np.linalg.norm(at[f"{s}_{above}"] - at[f"{s}_{below}"]) for s in SIDES])

    width = float(np.linalg.norm(at["right_hip"] - at["left_hip"]))
    return width, lengths("hip", "knee"), lengths("knee", "ankle")


def _columns(loads: Loads, bodies: list[str]) -> dict[str, np.ndarray]:
    """Columns of external_loads.mot."""
    found: dict[str, np.ndarray] = {}
    for k, body in enumerate(bodies):
        kinds = (FORCE, loads.forces), (POINT, loads.points), (TORQUE, loads.torques)
        for name, values in kinds:
            ground = to_ground(values[:, k])
            found |= {name.format(body) + axis: ground[:, i] for i, axis in enumerate("xyz")}
    return found


def _fits(wearer: Wearer, times, torques, motion) -> dict[str, Fit]:
    """Fits of the torques over the windows that count."""
    begin, end = counted(wearer)
    use = (times >= begin) & (times <= end)
    widths = np.gradient(times)[use] if len(times) > 1 else np.ones(use.sum())
    frames = wearer.recording.times
    found: dict[str, Fit] = {}
    for name, torque in torques.items():
        angle = np.interp(times, frames, motion[name])
        rate = np.interp(times, frames, np.gradient(motion[name], frames))
        if use.sum() > 5:
            found[name] = fit(torque[use], angle[use], rate[use], widths)
    return found


def export_lines(found: dict[str, Any], folder: str | Path) -> list[str]:
    """Lines for a person: what was written and how well the fits do."""
    lines = [f"{'coordinate':>18} {'torque N m rms':>15} {'left over':>10}"]
    for name, one in found["fits"].items():
        lines.append(f"{name:>18} {one.size:15.3f} {one.left:10.3f}")
    if found["scales"]:
        lines.append("factors that give this model the wearer's sizes:")
        lines += [f"{name:>18} {factor:15.3f}" for name, factor in found["scales"].items()]
    return [*lines, f"wrote {folder}/" + ", ".join(FILES)]
