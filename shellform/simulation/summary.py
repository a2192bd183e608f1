# SPDX-License-Identifier: LGPL-3.0-or-later
"""Results of a dressed walk, for summary.json and as lines for a person."""

import json
from pathlib import Path

from shellform.material.card import fabric_of
from shellform.motion.gait.strides import side_of, strides
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
    return (
        {
            "joints": {
                j: resistance(joints.rows, j, walked[side_of(j)], wearer.start, counted)
                for j in joints.joints
            },
            "counted_s": list(counted),
            "parts": joints.parts,
            "window": scene.output.window,
            "weight": weight,
            "force_balance_error": residual / (weight * scene.output.window)
            if weight
            else residual,
            "max_penetration": depth,
            "pinched_most": int(pinched),
            "pinched_depth": pinch_depth,
            "dressing": fit,
            "strides": walked,
            "stride_length": facts.get("stride_length"),
            "cadence": facts.get("cadence"),
            "segment_lengths": wearer.recording.lengths(),
            "notes": [*wearer.recording.notes, *model.surface.notes],
        }
        | _cloth(scene.cloth)
        | _itself(model, recorders)
    )


def _cloth(fabric):
    """What of a fabric is measured and what estimated, where that is known."""
    if fabric.provenance is None:
        return {}
    return {"fabric": f"{fabric.name}: {fabric.provenance.line()}"}


def _itself(model, recorders):
    """What contact of cloth with cloth found, and its limits; nothing where it is not asked for."""
    cloth = model.contact.cloth
    if cloth is None:
        return {}
    lost = {name: recorders.ledger.rows[-1][f"self_{name}_loss"] for name in ("impact", "friction")}
    return {
        "intersections": recorders.crossings.most,
        "self_contact": {
            "thickness": cloth.thickness,
            "pairs_most": cloth.most_pairs,
            "closest": cloth.closest if cloth.closest < float("inf") else None,
            "steps_at_limit": cloth.limited,
            "searches": cloth.listings,
            "impact_loss": lost["impact"],
            "friction_loss": lost["friction"],
        },
    }


def summary_lines(results: dict) -> list[str]:
    """Lines for a person: how it went and what the garment does to every joint."""
    fit = results["dressing"]
    held = f"on the shoulders, which carry {fit.get('carried', 0.0):.3f} N"
    if "belt_tension" in fit:
        held = f"belt {fit['belt_tension']:.2f} N, {fit['belt_pressed']:.1f} N of it on the body"
    lines = [
        f"weight {results['weight']:.3f} N; {held}; dressed in {fit['seconds']:.1f} s, cloth "
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
    if "self_contact" in results:
        dressed = results["dressing"].get("intersections", 0)
        lines += _itself_lines(results["self_contact"], results["intersections"], dressed)
    if "fabric" in results:
        lines.append(f"fabric {results['fabric']}")
    return lines + torque_lines(results)


def _itself_lines(found, crossings, dressed):
    near = "never near itself"
    if found["closest"] is not None:
        near = (
            f"{found['pairs_most']} pairs at most, {1e3 * found['closest']:.2f} mm apart at least"
        )
    line = f"cloth on cloth: {near}; {crossings} edges through triangles at most"
    if dressed:
        line += f", {dressed} of them as it was dressed"
    elif crossings:
        line += ": layers pressed together without room for all, as in a crease of the body"
    lines = [line]
    if found["steps_at_limit"]:
        lines.append(f"cloth on cloth was not solved to the end in {found['steps_at_limit']} steps")
    return lines


def torque_lines(results: dict) -> list[str]:
    """Lines of the torque about every joint, with standard errors where there are several runs."""
    runs = max((row.get("runs", 1) for row in results["joints"].values()), default=1)
    begin, end = results["counted_s"]
    lines = [
        f"torque about the axis of flexion, means over {results['window']:g} s, of what counts: "
        f"{begin:.2f} to {end:.2f} s"
    ]
    if runs > 1:
        lines.append(f"mean of {runs} runs and its standard error")
    wide = 18 if runs > 1 else 10
    titles = ("peak N m", "rms N m", "work J", "resisted J")
    lines.append(f"{'joint':>14}" + "".join(f" {title:>{wide}}" for title in titles))
    for joint, row in results["joints"].items():
        lines.append(f"{joint:>14}" + _numbers(row, wide))
        if "mean_stride" in row:
            lines.append(f"{'its stride':>14}" + _numbers(row["mean_stride"], wide))
    return lines


def _numbers(row, wide):
    """Numbers of a joint, each with its standard error if it has one."""
    out = ""
    for name in ("peak_torque", "rms_torque", "work", "resistance"):
        error = row.get(f"{name}_error")
        out += f" {_with_error(row[name], error):>{wide}}"
    return out


def _with_error(value, error):
    return f"{value:.3f}" if error is None else f"{value:.3f} +- {error:.3f}"


def summary_of(out: str | Path) -> dict:
    """Contents of summary.json in a folder."""
    return json.loads((Path(out) / "summary.json").read_text(encoding="utf-8"))


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
