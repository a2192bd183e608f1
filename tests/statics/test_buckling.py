# SPDX-License-Identifier: LGPL-3.0-or-later
"""Buckling loads against Euler's column and Bryan's plate, and against the path itself."""

import sys

import numpy as np
import pytest

import meshes
from shellform import Fabric, Shell, Statics, buckling_loads, follow
from shellform.statics.path import PathState

pytestmark = pytest.mark.filterwarnings("ignore::shellform.material.fabric.UnitWarning")


@pytest.fixture(autouse=True)
def slepc(request):
    """Tests but those of its absence need SLEPc."""
    if "without" not in request.node.name:
        pytest.importorskip("slepc4py")


def column(cells=16, degree=1, thickness=1e-3, triangles=False):
    """A strip clamped at its left, pressed at its right by 1 N/m."""
    surface = meshes.rectangle(1.0, 0.1, (cells, 1), degree=degree, triangles=triangles)
    shell = Shell(surface, Fabric.isotropic(1e7, 0.0, thickness, 1.0))
    shell.supports.clamp("left")
    shell.loads.line("right", (-1.0, 0.0, 0.0))
    return shell


@pytest.mark.parametrize(
    ("cells", "degree", "triangles", "bar"),
    [(16, 1, False, 1e-3), (16, 1, True, 1e-3), (8, 2, False, 1e-4)],
    ids=["quads", "triangles", "nine nodes"],
)
@pytest.mark.parametrize("thickness", [1e-2, 1e-4])
def test_euler_column(cells, degree, triangles, bar, thickness):
    """pi^2 B / (4 L^2) within 0.1 %, 9-node quads 0.01 %, and 9 times it; the mode is 1 - cos."""
    shell = column(cells, degree, thickness, triangles)
    found = buckling_loads(shell, 2)
    euler = np.pi**2 * shell.fabric.bending[0, 0] / 4
    assert found.levels[0] == pytest.approx(euler, rel=bar)
    assert found.levels[1] == pytest.approx(9 * euler, rel=10 * bar)
    mode = found.modes[0][:, 2]
    mode *= np.sign(mode[np.abs(mode).argmax()])
    x = shell.surface.points[:, 0]
    assert mode == pytest.approx(1 - np.cos(np.pi * x / 2), abs=2e-3)
    # the shell is left as it was
    assert not shell.displacements().any()


def test_order_of_the_column():
    """The error of 8, 16 and 32 quads falls with the second power."""
    thin = 1e-4
    euler = np.pi**2 * column(8, thickness=thin).fabric.bending[0, 0] / 4
    errors = [buckling_loads(column(n, thickness=thin)).levels[0] / euler - 1 for n in (8, 16, 32)]
    assert np.log2(errors[0] / errors[1]) > 1.9
    assert np.log2(errors[1] / errors[2]) > 1.9


def test_plate():
    """A square simply supported all around, pressed one way: k = 4, then 6.25 (Bryan 1891)."""
    surface = meshes.rectangle(1.0, 1.0, (8, 8), degree=2)
    shell = Shell(surface, Fabric.isotropic(1e7, 0.3, 1e-3, 1.0))
    for edge, along in (("left", 1), ("right", 1), ("bottom", 0), ("top", 0)):
        shell.supports.hold(edge, "z")
        shell.supports.hold_director(edge, plane=np.eye(3)[along])
    shell.supports.hold((0.0, 0.0, 0.0), "xy")
    shell.supports.hold((0.0, 1.0, 0.0), "x")
    shell.loads.line("right", (-1.0, 0.0, 0.0))
    shell.loads.line("left", (1.0, 0.0, 0.0))
    found = buckling_loads(shell, 2)
    k = found.levels / (np.pi**2 * shell.fabric.bending[0, 0])
    assert k == pytest.approx([4.0, 6.25], rel=1e-3)


def test_pulled_instead_of_pressed():
    """Under loads that only tighten it a column has no buckling load."""
    shell = column()
    shell.loads.line("right", (2.0, 0.0, 0.0))
    assert buckling_loads(shell).levels.shape == (0,)


def arch(cells=12):
    """A hinged arch, too shallow to swerve before it snaps through."""

    def place(a, b):
        x = 2 * a - 1
        return x, 0.1 * b, 0.05 * np.cos(np.pi * x / 2)

    shell = Shell(meshes.patch(place, (cells, 1)), Fabric.isotropic(1e7, 0.0, 0.04, 1.0))
    for edge in ("left", "right"):
        shell.supports.hold(edge)
    for edge in ("bottom", "top"):
        shell.supports.symmetry(edge, (0.0, 1.0, 0.0))
    shell.loads.point(lambda points: np.abs(points[:, 0]) < 1e-9, (0.0, 0.0, -1.0))
    return shell


def test_along_a_path():
    """From states ever nearer to a limit point the buckling load tends to the limit load."""
    shell = arch()
    limit = follow(shell, 3.0).limit_levels()[0]
    shell = arch()
    states = []
    with Statics(shell) as statics:
        for _ in statics.march(limit * np.array([0.5, 0.8, 0.95, 0.995, 0.9999])):
            states.append(PathState.of(shell, statics.level))
    found = np.array([buckling_loads(shell, start=state).levels[0] for state in states])
    off = np.abs(found / limit - 1)
    assert np.all(np.diff(off) < 0)
    assert off[-1] < 5e-3


def test_an_unstable_state_is_refused():
    shell = arch()
    path = follow(shell, 3.0, keep_states=True)
    falling = path.states[int(np.flatnonzero(np.diff(path.levels) < 0)[0]) + 1]
    with pytest.raises(ValueError, match="is not stable"):
        buckling_loads(shell, start=falling)


def test_refusals():
    with pytest.raises(ValueError, match="1 or more, not 0"):
        buckling_loads(column(), 0)
    shell = column()
    shell.loads.forces.clear()
    with pytest.raises(ValueError, match="the loads move nothing"):
        buckling_loads(shell)


def test_without_slepc(monkeypatch):
    """One sentence that says what to install."""
    monkeypatch.setitem(sys.modules, "slepc4py", None)
    with pytest.raises(ImportError, match="install Debian's or Ubuntu's python3-slepc4py"):
        buckling_loads(column())
