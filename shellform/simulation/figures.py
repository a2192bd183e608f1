# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pictures of a run from its files."""

from pathlib import Path

from shellform.dressing.procedure import SHOULDER_STAGES, STAGES
from shellform.motion.recording import SIDES
from shellform.results.mean_torque import mean_rows
from shellform.results.pressure_map import Map, load
from shellform.scene.scene_file import read_scene
from shellform.scene.skin import skin_of_scene
from shellform.scene.wearer import part_of, wearer_of


def draw(out: str | Path) -> None:
    """Pictures of a run from its files: walk.png, torque.png, walk.gif, wrinkles.png if relaxed."""
    # only here: they load matplotlib
    from shellform.pictures.skin_pressure import pressure_figure
    from shellform.pictures.walk import draw_all
    from shellform.pictures.wrinkles import draw_walk_wrinkles

    out = Path(out)
    scene = read_scene(out / "scene.toml")
    wearer = wearer_of(scene)
    skin = skin_of_scene(scene, wearer)
    rows = {scene.title: mean_rows(out)}
    joint = "right_shoulder" if "right_shoulder" in wearer.joints else "right_knee"
    draw_all(out, wearer, dressing_frames(out), out, rows, joint, scene.title, skin=skin)
    draw_walk_wrinkles(out / "wrinkles.png", wearer, out, scene.title)
    if (out / "pressure.npz").is_file():
        pressed = load(out / "pressure.npz")
        shown = part_of(scene, wearer, pressed.names) if isinstance(pressed, Map) else wearer
        pressure_figure(out / "pressure.png", shown, pressed, wearer.start, scene.title)


def dressing_frames(out: str | Path) -> list[tuple]:
    """(label, frame, ellipsoids left out) of the stages of dressing, from the files of a run."""
    from shellform.pictures.walk import read_frames

    if not (Path(out) / "dressing.pvd").is_file():
        return []
    frames = read_frames(out, "dressing")
    # three frames are those of what hangs on the shoulders, over all of the body
    stages = STAGES if len(frames) > len(SHOULDER_STAGES) else SHOULDER_STAGES
    feet = [f"{side}_foot" for side in SIDES if stages is STAGES]
    return [
        (f"({letter}) {label or 'settled'}", frame, feet if k < 2 else [])
        for k, (letter, label, frame) in enumerate(zip("abcd", stages.values(), frames))
    ]
