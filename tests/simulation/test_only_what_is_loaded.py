# SPDX-License-Identifier: LGPL-3.0-or-later
"""Only what a scene needs is imported and compiled: counted, not assumed."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from dolfinx import fem

import meshes
from shellform import Fabric, Shell, Statics
from shellform.dynamics.explicit import Newmark

ROOT = Path(__file__).resolve().parents[2]


CLOTH = Fabric.isotropic(1e6, 0.3, thickness=1e-3, density=300.0)


# what is loaded at the end of each stage of one process
IMPORTS = """
import json, sys
loaded = {}
def stage(name):
    loaded[name] = sorted(sys.modules)

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
from shellform.contact_coupling.contact import Contact
shell = Shell(sheet, cloth)
shell.loads.gravity()
stepper = Newmark(shell)
stepper.add(Contact(Body([Segment("ball", (0.1, 0.1, 0.1), Fixed((0.5, 0.5, -0.2)))])))
stepper.advance(1e-3)
stage("touching")

from shellform.scene.garment import garment_of
from shellform.scene.scene import Scene
from shellform.scene.wearer import wearer_of
garment_of(Scene(), wearer_of(Scene()))
stage("walking")
print(json.dumps(loaded))
"""


PICTURES = {"matplotlib", "vtk", "gmsh", "ezc3d", "meshio", "tqdm"}


def sheet(cells=4, fabric=CLOTH, comm=None, **options):
    surface = meshes.rectangle(1.0, 1.0, (cells, cells))
    return Shell(surface, fabric, **({} if comm is None else {"comm": comm}), **options)


@pytest.fixture(scope="module")
def of_others():
    """{"numba"} where dolfinx itself loads it, as newer ones do; else nothing."""
    code = "import sys; from mpi4py import MPI; import dolfinx.fem; print('numba' in sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=300)
    return {"numba"} if run.stdout.split()[-1:] == ["True"] else set()


@pytest.fixture(scope="module")
def loaded():
    command = [sys.executable, "-c", IMPORTS]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr
    modules = json.loads(run.stdout.splitlines()[-1])
    return {stage: set(names) for stage, names in modules.items()}


@pytest.mark.serial
def test_a_static_demo_compiles_no_steps(tmp_path, of_others):
    """The whole command, its errors and its results: nothing of the explicit stepper is loaded."""
    code = (
        "import runpy, sys; sys.argv = sys.argv[1:]; runpy.run_path(sys.argv[0], None, '__main__');"
        "print([m for m in ('numba', 'shellform.dynamics.time_stepper') if m in sys.modules])"
    )
    command = [sys.executable, "-c", code, "demos/roll_up.py", "--cells", "2", "--turns", "0.1"]
    command += ["--out", str(tmp_path)]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr
    assert run.stdout.splitlines()[-1] == str([*of_others])


@pytest.mark.serial
def test_imports(loaded, of_others):
    """A stage loads what it uses, and none of what it does not; later ones show it can be seen."""
    contact = {stage: {m for m in names if m.split(".")[0] == "contact"} for stage, names in
               loaded.items()}  # fmt: skip
    statics, falling = loaded["statics"], loaded["falling"]
    unused = {"numba", "shellform.dynamics.explicit", "shellform.fem.quad_force", *PICTURES}
    assert not (statics - of_others) & unused
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
    """Force and tangent of two rules, corners and Gauss points, and the lengths of segments.

    Of these: lengths and how they change, force, and two parts of the tangent. The energy is
    compiled only when asked for, that of the membrane not at all.
    """
    shell = sheet(comm=comm)
    shell.supports.clamp("left")
    shell.loads.line("right", (0.0, 0.0, 1e-4))
    with Statics(shell) as statics:
        statics.solve(1)
    assert 2 * len({term.rule for term in energy(shell)}) == 4
    assert len(forms) == 4 + 5
    assert set(shell.energy()) == {"membrane", "bending", "shear"}
    assert len(forms) == 4 + 5 + 2


def energy(shell):
    return shell.weak_form.terms
