# SPDX-License-Identifier: LGPL-3.0-or-later
"""Results of a dressed walk, for summary.json and as lines for a person."""

import json
from pathlib import Path

from shellform.material.card import fabric_of
from shellform.motion.gait.strides import strides
from shellform.results.joint_torque import resistance
from shellform.results.report import Report
from shellform.scene.parts import PARTS
from shellform.scene.scene import Scene

from .model import Model
from .plan import plan_of
from .recorders import Recorders


def summary(model: Model, recorders: Recorders, fit: dict) -> dict:
    """Results of a run for summary.json; fit : report of the dressing."""
    scene, wearer, joints = model.scene, model.wearer, recorders.joints
    facts, weight = wearer.recording.facts, model.weight
    walked = {side: found.tolist() for side, found in strides(wearer).items()}
    counted = recorders.counted
    residual = max(row["momentum_residual"] for row in recorders.ledger.rows)
    depth, pinched, pinch_depth = recorders.extremes.saved()["extremes"]
    return {
        "joints": {
            j: resistance(joints.rows, j, walked[j.split("_")[0]], wearer.start, counted)
            for j in joints.joints
        },
        "counted_s": list(counted),
        "parts": joints.parts,
        "window": scene.output.window,
        "weight": weight,
        "force_balance_error": residual / (weight * scene.output.window) if weight else residual,
        "max_penetration": depth,
        "pinched_most": int(pinched),
        "pinched_depth": pinch_depth,
        "dressing": fit,
        "strides": walked,
        "stride_length": facts.get("stride_length"),
        "cadence": facts.get("cadence"),
        "segment_lengths": wearer.recording.lengths(),
        "notes": wearer.recording.notes,
    }


def summary_lines(results: dict) -> list[str]:
    """Lines for a person: how it went and what the garment does to every joint."""
    fit = results["dressing"]
    lines = [
        f"weight {results['weight']:.3f} N; belt {fit['belt_tension']:.2f} N, "
        f"{fit['belt_pressed']:.1f} N of it on the body; dressed in {fit['seconds']:.1f} s, cloth "
        f"stretched by {100 * fit['stretch']:.1f} %",
        f"deepest point {1e3 * results['max_penetration']:.2f} mm in the body, "
        f"{1e3 * results['pinched_depth']:.1f} mm between segments that pinch, "
        f"{results['pinched_most']} nodes at most",
        f"forces balance to {100 * results['force_balance_error']:.1e} % of the weight",
    ]
    if results["stride_length"]:
        lines.append(
            f"stride {results['stride_length']:.3f} m, cadence {results['cadence']:.1f} steps/min"
        )
    begin, end = results["counted_s"]
    lines.append(
        f"torque about the axis of flexion, means over {results['window']:g} s, of what counts: "
        f"{begin:.2f} to {end:.2f} s"
    )
    lines.append(
        f"{'joint':>12} {'peak N m':>10} {'rms N m':>10} {'work J':>10} {'resisted J':>11}"
    )
    for joint, row in results["joints"].items():
        numbers = f"{row['peak_torque']:10.3f} {row['rms_torque']:10.3f} {row['work']:10.3f}"
        lines.append(f"{joint:>12} {numbers} {row['resistance']:11.3f}")
    return lines


def summary_of(out: str | Path) -> dict:
    """Contents of summary.json in a folder."""
    return json.loads((Path(out) / "summary.json").read_text())


def settings(scene: Scene) -> dict:
    """A scene as plain values for summary.json."""
    values = {name: getattr(scene, name) for name in ("title", "belt", "gravity")}
    values |= {name: dict(vars(getattr(scene, name))) for name in PARTS}
    cloth = fabric_of(scene.fabric)
    return values | {"fabric": {"name": cloth.name, "summary": cloth.summary()}}


def describe(report: Report, model: Model) -> None:
    """Enter what is modelled into a report."""
    plan = plan_of(model.scene, model.whole, model.surface, model.wearer.names)
    report.describe(model.shell, **plan, time_step=model.stepper.dt)
