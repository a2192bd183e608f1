# SPDX-License-Identifier: LGPL-3.0-or-later
"""Only what a scene needs is imported, compiled, allocated, computed: counted, not assumed."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from dolfinx import fem

import meshes
from contact.body.segments import Body, Fixed, Segment
from contact.solver import node_contact as point
from contact.solver import velocity_correction as correction
from contact.solver.velocity_correction import Correction
from shellform import Fabric, Shell, Statics
from shellform.contact_coupling.explicit_contact import Touch
from shellform.dynamics import explicit_kernels
from shellform.dynamics import time_stepper as stepper
from shellform.dynamics.explicit import Newmark
from shellform.fem import lumped_mass as inertia
from shellform.fem.internal_force import by_segments
from shellform.results.report import Report
from shellform.scene.garment import garment_of
from shellform.scene.parts import Contact, Garment, Motion, Output, Steps
from shellform.scene.reach import SLIPPED, STRETCHED, along_cloth, reachable
from shellform.scene.scene import Scene
from shellform.scene.wearer import cut, dressed_wearer, ellipsoids_of, wearer_of
from shellform.simulation.model import Activity
from shellform.simulation.plan import plan_of, plan_of_run, told
from shellform.simulation.summary import describe

ROOT = Path(__file__).resolve().parents[2]
CLOTH = Fabric.isotropic(1e6, 0.3, thickness=1e-3, density=300.0)

# what is loaded at the end of each stage of one process
IMPORTS = """
import json, sys
told = {}
def stage(name):
    told[name] = sorted(sys.modules)

import meshes
from shellform import Fabric, Shell, Statics, console
from shellform.results.report import Report
cloth = Fabric.isotropic(1e6, 0.3, thickness=1e-3, density=300.0)
sheet = meshes.rectangle(1.0, 1.0, (2, 2))
shell = Shell(sheet, cloth)
shell.supports.clamp("left")
shell.loads.line("right", (0.0, 0.0, 1e-4))
with Statics(shell) as statics:
    list(console.progress(statics.march(1), 1, "load"))
stage("statics")

from shellform.dynamics.explicit import Newmark
shell = Shell(sheet, cloth)
shell.loads.gravity()
Newmark(shell).advance(1e-3)
stage("falling")

from contact.body.segments import Body, Fixed, Segment
from shellform.contact_coupling.explicit_contact import Touch
shell = Shell(sheet, cloth)
shell.loads.gravity()
stepper = Newmark(shell)
Touch(stepper, Body([Segment("ball", (0.1, 0.1, 0.1), Fixed((0.5, 0.5, -0.2)))]))
stepper.advance(1e-3)
stage("touching")

from shellform.scene.garment import garment_of
from shellform.scene.scene import Scene
from shellform.scene.wearer import wearer_of
garment_of(Scene(), wearer_of(Scene()))
stage("walking")
print(json.dumps(told))
"""
PICTURES = {"matplotlib", "vtk", "gmsh", "ezc3d", "meshio", "tqdm"}


def sheet(cells=4, fabric=CLOTH, comm=None, **options):
    surface = meshes.rectangle(1.0, 1.0, (cells, cells))
    return Shell(surface, fabric, **({} if comm is None else {"comm": comm}), **options)


@pytest.fixture(scope="module")
def loaded():
    command = [sys.executable, "-c", IMPORTS]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr
    modules = json.loads(run.stdout.splitlines()[-1])
    return {stage: set(names) for stage, names in modules.items()}


@pytest.mark.serial
def test_a_static_demo_compiles_no_steps(tmp_path):
    """The whole command, its errors and its results: nothing of the explicit stepper is loaded."""
    code = (
        "import runpy, sys; sys.argv = sys.argv[1:]; runpy.run_path(sys.argv[0], None, '__main__');"
        "print([m for m in ('numba', 'shellform.dynamics.time_stepper') if m in sys.modules])"
    )
    command = [sys.executable, "-c", code, "demos/roll_up.py", "--cells", "2", "--turns", "0.1"]
    command += ["--out", str(tmp_path)]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr
    assert run.stdout.splitlines()[-1] == "[]"


@pytest.mark.serial
def test_imports(loaded):
    """A stage loads what it uses, and none of what it does not; later ones show it can be seen."""
    contact = {stage: {m for m in names if m.split(".")[0] == "contact"} for stage, names in
               loaded.items()}  # fmt: skip
    statics, falling = loaded["statics"], loaded["falling"]
    assert not statics & {
        "numba",
        "shellform.dynamics.explicit",
        "shellform.fem.quad_kernel",
        *PICTURES,
    }
    assert not contact["statics"]
    assert contact["falling"] == {"contact", "contact.kernel"}  # the decorator, no contact
    assert "numba" in falling and not falling & {"shellform.dynamics.implicit", *PICTURES}
    assert "contact.solver.velocity_correction" in contact["touching"]
    assert not loaded["touching"] & {
        "shellform.motion.gait.synthetic_walk",
        "shellform.motion.wearer",
        "shellform.motion.capture.read_motion",
        *PICTURES,
    }
    assert "shellform.motion.gait.synthetic_walk" in loaded["walking"]
    assert not loaded["walking"] & {
        "shellform.motion.capture.read_motion",
        "shellform.motion.capture.c3d_file",
        *PICTURES,
    }


def test_statics_has_no_mass(monkeypatch, comm):
    """Its weight needs areas, no nodal mass: the function that makes masses is never called."""
    calls = []
    for home in (inertia, stepper):
        lumped = home.lumped
        monkeypatch.setattr(home, "lumped", lambda *a, f=lumped: calls.append(1) or f(*a))
    shell = sheet(comm=comm)
    shell.supports.clamp("left")
    shell.loads.gravity((0.0, 0.0, -1e-3))
    with Statics(shell) as statics:
        statics.solve(1)
        held = {*vars(shell), *vars(statics), *vars(statics.equilibrium)}
        assert statics.equilibrium.inertia is None
    assert calls == [] and not held & {"mass", "v", "q"}
    Newmark(sheet(comm=comm))
    assert calls == [1]


@pytest.fixture
def forms(monkeypatch):
    """List that grows with every form compiled."""
    made, form = [], fem.form
    monkeypatch.setattr(fem, "form", lambda f, **more: made.append(f) or form(f, **more))
    return made


@pytest.mark.parametrize("pressure, compiled", [(0.0, 0), (5.0, 1)])
def test_forms_of_explicit_steps(forms, pressure, compiled, comm):
    """4-node quads fall without a compiled form; a follower pressure needs one."""
    shell = sheet(comm=comm)
    shell.loads.pressure(pressure)
    shell.loads.gravity()
    Newmark(shell).advance(1e-3)
    assert len(forms) == compiled == len(shell.loads.pressures)


def test_forms_of_statics(forms, comm):
    """Force and tangent of two rules, corners and Gauss points; the energy only when asked for."""
    shell = sheet(comm=comm)
    shell.supports.clamp("left")
    shell.loads.line("right", (0.0, 0.0, 1e-4))
    with Statics(shell) as statics:
        statics.solve(1)
    assert len(forms) == 2 * len({term.rule for term in energy(shell)}) == 4
    assert set(shell.energy()) == {"membrane", "bending", "shear"}
    assert len(forms) == 4 + 3


def energy(shell):
    return shell.weak_form.terms


def test_coupling_only_where_stretching_bends(comm):
    """B enters the energy, and takes the quads off their fast kernel, only where it is not zero."""
    rows = {}
    A, D, S = CLOTH.membrane, CLOTH.bending, CLOTH.shear
    for name, B in (("plain", None), ("coupled", 1e-4 * A)):
        fabric = Fabric(A, D, S, CLOTH.areal_mass, CLOTH.thickness, coupling=B)
        shell = sheet(fabric=fabric, comm=comm)
        total = 0
        for dx, terms in shell.weak_form.by_rule():
            for term in terms:
                strain = shell.weak_form.strain(term, shell.w)
                total += term.product(strain, strain) * dx
        rows[name] = shell.plan()["terms"], len(total.constants()), by_segments(shell)
    strains = ["membrane", "bending", "transverse shear"]
    assert rows["plain"] == (strains, 3, True)  # A, D, S
    assert rows["coupled"] == ([*strains, "membrane with bending"], 4, False)


def test_no_array_nor_kernel_of_damping_without_it(monkeypatch, comm):
    """Without damping no field ahead of the nodes, no rates; with it one call a force."""
    calls, ahead = [], explicit_kernels.ahead
    monkeypatch.setattr(explicit_kernels, "ahead", lambda *a: calls.append(1) or ahead(*a))
    shell = sheet(comm=comm)
    plain = Newmark(shell)
    plain.advance(20 * plain.dt)
    assert calls == []
    assert plain._field is shell.w and not plain.internal.damped
    assert not {"before", "step"} & set(vars(shell))  # of tangents and of rates
    damped = Newmark(sheet(comm=comm), damping=1e-5)
    damped.advance(20 * damped.dt)
    assert len(calls) == damped.steps > 0 and damped._field is not damped.shell.w


def test_loads_of_zero_are_none(comm):
    shell = sheet(comm=comm)
    loads = shell.loads
    loads.gravity((0.0, 0.0, 0.0))
    loads.point(np.array([0]), (0.0, 0.0, 0.0))
    loads.line("left", (0.0, 0.0, 0.0))
    loads.surface((0.0, 0.0, 0.0))
    loads.edge_moment("left", (0.0, 0.0, 0.0))
    loads.point_moment(np.array([0]), (0.0, 0.0, 0.0))
    loads.pressure(0.0, amplitude=np.cos)
    assert loads.forces == loads.moments == loads.pressures == [] and loads.steady()
    assert loads.kinds() == shell.plan()["loads"] == {}
    loads.gravity()
    loads.pressure(1.0)
    assert loads.kinds() == {"gravity": 1, "pressure": 1}
    with pytest.raises(ValueError, match="amplitude"):
        loads.gravity((0.0, 0.0, 0.0), amplitude=3.0)


def in_python(kernel):
    """A kernel run by Python itself, so that what it calls can be counted."""

    def run(*given):
        records = lambda a: isinstance(a, np.ndarray) and a.dtype.names  # noqa: E731
        return kernel.py_func(*(a.view(np.recarray) if records(a) else a for a in given))

    return run


@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_no_friction_kernel_without_friction(monkeypatch, friction):
    """Points that press on a slope call the kernel of friction if there is friction, else never."""
    calls, rub = [], point._rub
    monkeypatch.setattr(point, "_rub", lambda *a: calls.append(1) or rub(*a))
    monkeypatch.setattr(correction, "_correct", in_python(correction._correct))
    monkeypatch.setattr(correction, "meet_body", in_python(point.meet_body))
    contact = Correction(ball(), 2, friction)
    x, v = np.array([[0.3, 0.0, 1.0], [0.0, 0.0, 1.5]]), np.zeros((2, 3))
    x[0] /= np.linalg.norm(x[0])
    v[:, 2] = -1.0
    contact(x, v, np.ones(2), 1e-3, 0.0)
    assert contact.active == 1  # the other one is high above
    assert len(calls) == (1 if friction else 0)
    slip = v[0] - v[0] @ x[0] * x[0]
    expected = np.sqrt(1 - x[0, 2] ** 2) - friction * x[0, 2]  # down the slope, less mu N
    assert np.linalg.norm(slip) == pytest.approx(expected, rel=1e-9)


def ball(*more):
    places = [(0.0, 0.0, 0.0), *more]
    return Body([Segment(f"ball {k}", (1.0, 1.0, 1.0), Fixed(c)) for k, c in enumerate(places)])


def test_bodies_out_of_reach_are_not_evaluated():
    """A body far away costs no closest point and changes nothing, to the last bit."""
    seen = {}
    for name, more in (("alone", ()), ("far", ((9.0, 0.0, 0.0),)), ("near", ((0.0, 0.5, 0.0),))):
        random = np.random.default_rng(5)
        x = random.normal(size=(200, 3))
        x *= (1.0 + 0.01 * random.random(200) ** 2)[:, None] / np.linalg.norm(x, axis=1)[:, None]
        v, count = random.normal(size=(200, 3)), 0
        contact = Correction(ball(*more), 200, 0.3)
        for step in range(10):
            contact(x, v, np.ones(200), 1e-3, 1e-3 * step)
            count += contact.evaluated
            x += 1e-3 * v
        seen[name] = count, x
    assert seen["far"][0] == seen["alone"][0] > 0
    assert np.array_equal(seen["far"][1], seen["alone"][1])
    assert seen["near"][0] > seen["alone"][0]


def test_bodies_that_are_not_allowed_are_not_evaluated():
    x, v = np.array([[0.0, 0.0, 1.0]]), np.array([[0.0, 0.0, -1.0]])
    contact = Correction(ball(), 1, 0.3, allowed=np.zeros(1, int))
    contact(x, v, np.ones(1), 1e-3, 0.0)
    assert contact.evaluated == 0 and v[0, 2] == -1.0


# -- what a garment can come to -------------------------------------------------------------------


def level_walk(**more):
    return Scene(motion=Motion(strides=1, obstacle=0.0), **more)


SHORTS = Garment(
    measures={"hem_height": 0.62, "knee_height": 0.65, "hem": 0.62, "knee": 0.66}, cell_size=0.04
)


@pytest.fixture(scope="module")
def dressed():
    """(wearer, shorts) of a level walk."""
    scene = level_walk(garment=SHORTS)
    wearer = wearer_of(scene)
    return wearer, garment_of(scene, wearer)


def test_along_cloth_is_the_length():
    """On a strip along its axis, and up a cylinder: what a ruler says; no less than straight."""
    strip = meshes.rectangle(2.0, 0.5, (8, 2))
    assert along_cloth(strip, "left") == pytest.approx(strip.points[:, 0], abs=1e-14)
    tube = meshes.cylinder(0.3, 1.0, cells=(24, 5))
    up = tube.points[:, 2] - tube.points[:, 2].min()
    edge = next(e for e, s in tube.edges.items() if np.ptp(up[s]) == 0 and up[s].max() == 0)
    assert along_cloth(tube, edge) == pytest.approx(up, abs=1e-12)


def skin(wearer, b, pose, count=40):
    """Points all over ellipsoid b."""
    angle, height = np.meshgrid(np.linspace(0, 2 * np.pi, count), np.linspace(0, np.pi, count))
    unit = [np.cos(angle) * np.sin(height), np.sin(angle) * np.sin(height), np.cos(height)]
    unit = np.stack(unit, axis=-1).reshape(-1, 3)
    return pose.centres[b] + (unit * wearer.radii[b]) @ pose.axes[b]


def test_reach_of_shorts(dressed):
    """Nearest points of waist and every ellipsoid in the walk, by brute force, against the rule."""
    wearer, shorts = dressed
    limit = (1 + STRETCHED) * along_cloth(shorts, "waist").max() + SLIPPED
    k = wearer.index("pelvis")
    start = wearer.new_pose(wearer.start)
    waist = shorts.points[np.unique(shorts.edges["waist"])] - start.centres[k]
    waist = waist @ start.axes[k].T
    nearest = np.full(len(wearer.names), np.inf)
    for time in np.linspace(wearer.start, wearer.end, 80):
        pose = wearer.new_pose(time)
        at = pose.centres[k] + waist @ pose.axes[k]
        for b in range(len(nearest)):
            away = np.linalg.norm(skin(wearer, b, pose)[:, None] - at[::4], axis=2)
            nearest[b] = min(nearest[b], away.min())
    assert np.abs(nearest - limit).min() > 0.01  # else the samples could not tell
    assert np.array_equal(reachable(wearer, shorts, belt=20.0), nearest < limit)


def test_only_what_is_under_the_garment_is_built(dressed):
    """Feet are bare under shorts in a level walk; a belt or a table of parts decides otherwise."""
    wearer, shorts = dressed
    feet = {"right_foot", "left_foot"}
    bare = dressed_wearer(level_walk(), wearer, shorts)
    assert set(wearer.names) - set(bare.names) == feet
    pose, whole = bare.new_pose(1.0), wearer.new_pose(1.0)
    for k, name in enumerate(bare.names):
        b = wearer.index(name)
        assert np.array_equal(pose.centres[k], whole.centres[b])
        assert np.array_equal(bare.radii[k], wearer.radii[b])
    assert bare.joints == wearer.joints
    assert dressed_wearer(level_walk(belt=0.0), wearer, shorts) is wearer
    named = level_walk(output=Output(parts={"right_knee": ["right_shank", "right_foot"]}))
    assert set(dressed_wearer(named, wearer, shorts).names) == {
        *wearer.names
    } - {"left_foot"}  # fmt: skip


def test_a_high_step_brings_the_foot_to_the_hem():
    """The whole motion counts, not its start: over an obstacle the feet are kept."""
    scene = Scene(motion=Motion(strides=3, obstacle=0.5), garment=SHORTS)
    wearer = wearer_of(scene)
    shorts = garment_of(scene, wearer)
    assert dressed_wearer(scene, wearer, shorts) is wearer
    assert not reachable(standing(wearer), shorts, belt=20.0).all()


def test_a_run_leaves_out_what_its_plan_does(shared_tmp_path, comm):
    """Bare feet are not in the body that the cloth meets, and summary.json says so."""
    activity = Activity(level_walk(garment=SHORTS), comm)
    met = activity.touch.correction.body.names
    report = Report(shared_tmp_path, "walk", {}, comm)
    describe(report, activity)
    plan = report.summary["plan"]
    assert plan["out_of_reach"] == [name for name in activity.whole.names if name not in met]
    assert plan["out_of_reach"] == ["right_foot", "left_foot"] and plan["contact"] == list(met)
    assert (activity.touch.correction.allowed < 1 << len(met)).all()


def standing(wearer):
    """The same wearer, for its first moments only."""
    recording = cut(wearer.recording, None, wearer.start + 0.1)
    return type(wearer)(recording, ellipsoids_of(Scene(), wearer.recording))


# -- the plan -------------------------------------------------------------------------------------


def test_plan_names_what_is_there_and_nothing_else(dressed):
    wearer, shorts = dressed
    full = plan_of(level_walk(garment=SHORTS), wearer, shorts)
    assert full == plan_of(level_walk(garment=SHORTS))  # of the scene alone
    assert full["terms"] == [
        *("membrane", "bending", "transverse shear", "inertia", "rotary inertia"),
        *("gravity", "drag"),
    ]
    assert full["out_of_reach"] == ["right_foot", "left_foot"]
    assert full["friction"] == [0.3, 0.3] and full["belt"] == 20.0
    assert "pressure.npz" in full["outputs"]
    assert json.loads(json.dumps(full)) == full

    less = level_walk(
        garment=SHORTS, gravity=0.0, belt=0.0, contact=Contact(friction=0.0),
        steps=Steps(drag=0.0, damping=1e-6), output=Output(pressure=0.0),
    )  # fmt: skip
    bare = plan_of(less, wearer, shorts)
    assert bare["terms"][5:] == ["damping"]
    assert set(full) - set(bare) == {"friction", "belt", "out_of_reach"}
    assert "pressure.npz" not in bare["outputs"]
    assert bare["contact"] == list(wearer.names)
    text = "\n".join(told(bare))
    assert "no friction" in text and "no belt" in text and "gravity" not in text
    assert "friction: 0.3, 0.3" in "\n".join(told(full))
    kinetic = replace(less, contact=Contact(friction=0.5, kinetic_friction=0.4))
    assert plan_of(kinetic, wearer, shorts)["friction"] == [0.5, 0.4]


def test_plan_of_a_run_is_stored(shared_tmp_path, comm):
    """In summary.json: of a static problem, a fall, and cloth on a ball; only what each has."""
    plans = {}
    for name in ("statics", "fall", "ball"):
        shell, stepper, touch = sheet(comm=comm), None, None
        if name != "statics":
            shell.loads.gravity()
            stepper = Newmark(shell)
        if name == "ball":
            touch = Touch(stepper, ball(), 0.0)
        report = Report(shared_tmp_path / name, name, {}, comm)
        report.describe(shell, **plan_of_run(shell, stepper, touch))
        report.write({})
        comm.Barrier()
        plans[name] = json.loads((shared_tmp_path / name / "summary.json").read_text())["plan"]
    strains = ["membrane", "bending", "transverse shear"]
    assert plans["statics"]["terms"] == strains and plans["statics"]["loads"] == {}
    assert plans["fall"]["terms"] == [*strains, "inertia", "rotary inertia"]
    assert plans["fall"]["loads"] == {"gravity": 1}
    assert not {"contact", "friction"} & set(plans["fall"])
    assert plans["ball"]["contact"] == ["ball 0"] and "friction" not in plans["ball"]
