# SPDX-License-Identifier: LGPL-3.0-or-later
"""Lines for a person on the motion of a scene: what was read, chosen and mended."""

from shellform.motion.stance import stance

from .model import Model


def motion_lines(model: Model) -> list[str]:
    """The recording, its stride, what was mended in it."""
    wearer, recording = model.whole, model.whole.recording
    facts, height = recording.facts, stance(wearer)[0]
    lines = [
        f"motion     {recording.source}: {wearer.start:.3f} to {wearer.end:.3f} s, "
        f"{recording.rate:.4g} frames a second, hips {height:.3f} m high"
    ]
    if facts.get("stride_length"):
        lines.append(
            f"           stride {facts['stride_length']:.3f} m, cadence {facts['cadence']:.1f} "
            "steps/min"
        )
    return lines + [f"           {note}" for note in recording.notes]
