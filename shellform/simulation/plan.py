# SPDX-License-Identifier: LGPL-3.0-or-later
"""The plan: what a scene or a run models; nothing else is computed. `shellform check` prints it.

A plan is a plain dict, stored under `plan` in summary.json. What a scene does not need is not in it
and not in the run either:

element, terms    strains whose energy counts; inertia, gravity, drag, damping where there are any
contact           ellipsoids that the garment can come to; out_of_reach: those it cannot
friction          (mu_s, mu_k); creases: where parts of the body press cloth against each other
body              where it is of triangles, their source
self_contact      where cloth meets cloth
fabric            its name, what of it is estimated and what measured, where the card says so
seams             how much stiffer than the cloth they are, where they are
wrinkles, runs    those smaller than a cell; starts of the ensemble whose mean is reported
motion, joints    source and times; dressing, belt, outputs: how it is put on, held, recorded

Bending is in every plan. A sheet without it folds to the size of its cells, whatever these are, so
that folds are then those of the mesh: `demos/studies/performance/what_it_saves.py` measures it.
"""

from collections.abc import Sequence

from contact.body.flesh_bed import HARD
from meshes import Surface
from shellform.dressing.procedure import Dressing
from shellform.fem.element import terms_of
from shellform.motion.wearer import Wearer
from shellform.scene.checks import check_dressing
from shellform.scene.flesh import flesh_of
from shellform.scene.garment import garment_of, wrinkles_of
from shellform.scene.scene import Scene
from shellform.scene.shoulders import belt_of
from shellform.scene.wearer import dressed_wearer, wearer_of

WRINKLES = {
    "relaxed": "relaxed: those smaller than a cell let go of compression",
    "resolved": "resolved: cells alone fold",
}
SEEN = ("out_of_reach", "friction", "flesh", "creases", "joints")  # lines below that of contact


def plan_of(
    scene: Scene,
    wearer: Wearer | None = None,
    surface: Surface | None = None,
    near: Sequence[str] | None = None,
) -> dict:
    """Plan of a scene, from the scene alone; the others spare making them once more.

    Parameters
    ----------
    scene : Scene
    wearer : Wearer with all its ellipsoids; surface : meshes.Surface, the garment
    near : names of those that the garment can come to

    Raises
    ------
    ValueError for a body or a garment that is wrong
    """
    wearer = wearer_of(scene) if wearer is None else wearer
    surface = garment_of(scene, wearer) if surface is None else surface
    near = dressed_wearer(scene, wearer, surface).names if near is None else near
    steps, contact, output = scene.steps, scene.contact, scene.output
    fabric = scene.cloth
    check_dressing(steps.dressing, fabric)
    terms = [*terms_of(fabric), "inertia", "rotary inertia"]
    law = {} if fabric.law is None else {"law": repr(fabric.law)}
    wanted = {"gravity": scene.gravity, "drag": steps.drag, "damping": steps.damping}
    plan: dict = {
        "element": f"{surface.kind} of degree {surface.degree}",
        "terms": terms + [name for name, value in wanted.items() if value],
        "contact": list(near),
        "out_of_reach": [name for name in wearer.names if name not in near],
    } | law
    if scene.garment.seam_bending != 1.0:
        plan["seams"] = f"bending {scene.garment.seam_bending:g} times that of the cloth"
    if fabric.provenance is not None:
        plan["fabric"] = f"{fabric.name}: {fabric.provenance.line()}"
    if contact.friction:
        kinetic = contact.kinetic_friction
        plan["friction"] = [contact.friction, contact.friction if kinetic is None else kinetic]
    if contact.self_contact:
        plan["self_contact"] = True
    flesh = flesh_of(scene, wearer.names, near)
    if flesh is not None:
        by_name = zip(near, flesh.beds(near)["stiffness"], strict=True)
        plan["flesh"] = [f"{name} {k:g} Pa/m" for name, k in by_name if k < HARD]
    if scene.person.body != "ellipsoids":
        plan["body"] = f"triangles of {scene.person.body}" + (
            f", {scene.person.sex}" if scene.person.body == "mesh" else ""
        )
    elif flesh is None and len(near) > 1:
        soft = contact.flesh_stiffness
        plan["creases"] = f"soft, {soft:g} Pa/m" if soft else "hard"
    recording = wearer.recording
    plan |= {
        "wrinkles": wrinkles_of(scene.garment, surface, fabric),
        "runs": scene.runs,
        "motion": {"source": str(recording.source), "start": wearer.start, "end": wearer.end},
        "joints": list(wearer.joints),
        "dressing": {"model": steps.dressing, "seconds_at_most": Dressing().seconds},
        "belt": belt_of(scene.belt, scene.garment),
        "outputs": ["torque.csv", "ledger.csv", "dressing.pvd", "series.pvd"],
    }
    if scene.runs > 1:
        plan["outputs"].append("torque_mean.csv")
    if output.pressure:
        plan["outputs"] += ["pressure.npz", *(["pressure.vtu"] if "body" in plan else [])]
    return {name: value for name, value in plan.items() if value or value is False}


def plan_lines(plan: dict) -> list[str]:
    """Lines of a plan for a person."""
    lines = [f"modelled   {plan.get('element', '')}: {', '.join(plan['terms'])}"]
    if "seams" in plan:
        lines.append(f"seams      {plan['seams']}")
    if "law" in plan:
        lines.append(f"law        {plan['law']}")
    if "contact" in plan:
        kind = f"skin of {plan['body']} on" if "body" in plan else ""
        lines.append(
            f"contact    {kind or len(plan['contact'])} {'segments' if kind else 'ellipsoids'}: "
            f"{', '.join(plan['contact'])}"
        )
        for name in SEEN:
            if name in plan:
                value = plan[name]
                value = ", ".join(map(str, value)) if isinstance(value, list) else value
                lines.append(f"           {name.replace('_', ' ')}: {value}")
        if "friction" not in plan:
            lines.append("           no friction")
        itself = "cloth meets cloth" if "self_contact" in plan else "no contact of cloth with cloth"
        lines.append(f"           {itself}")
    else:
        lines.append("contact    none")
    if "dressing" in plan:
        model, most = plan["dressing"].values()
        held = f"a belt of {plan['belt']:g} N" if "belt" in plan else "no belt"
        lines.append(f"dressing   by {model} in {most:.1f} s at most, {held}")
    if "wrinkles" in plan:
        lines.append(f"wrinkles   {WRINKLES[plan['wrinkles']]}")
    if "runs" in plan:
        runs = (
            "one, without a band"
            if plan["runs"] == 1
            else f"{plan['runs']}, their mean is reported"
        )
        lines.append(f"runs       {runs}")
    if "outputs" in plan:
        lines.append(f"outputs    {', '.join(plan['outputs'])}")
    return lines
