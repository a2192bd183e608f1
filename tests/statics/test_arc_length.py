# SPDX-License-Identifier: LGPL-3.0-or-later
"""Equilibrium paths by arc length against the exact path of two bars that snap through.

Two bars of stiffness E A and length L go from supports at one height to an apex h above them. With
the apex at height z they are stretched by e = (z^2 - h^2) / (2 L^2) (Green-Lagrange) and carry
P(z) = E A z (h^2 - z^2) / L^3 there: its limit points are at z = +-h / sqrt(3).
"""

import re

from petsc4py import PETSc

import numpy as np
import pytest

import meshes
from shellform import Fabric, NotConverged, Shell, Statics, follow
from shellform.fem.director import rotation_matrix
from shellform.statics.equilibrium import Equilibrium
from shellform.statics.path import Path, PathState

pytestmark = pytest.mark.filterwarnings("ignore::shellform.material.fabric.UnitWarning")

HALF, RISE, MODULUS, THICKNESS = 1.0, 0.1, 1e6, 1e-4
APEX = (0.0, 0.0, RISE)
LIMIT = 2 / 3**1.5 * MODULUS * THICKNESS * RISE**3 / np.hypot(HALF, RISE) ** 3


def bars(load=None, cells=2):
    """Two flat panels, so thin that bending holds less than 1e-6 of the load."""

    def place(a, b):
        x = 2 * a - 1
        return HALF * x, b - 0.5, RISE * (1 - np.abs(x))

    surface = meshes.patch(place, (cells, 1))
    fabric = Fabric.isotropic(MODULUS, 0.0, THICKNESS, 1000.0)
    shell = Shell(surface, fabric, membrane="chords", curvature="plain")
    for edge in ("left", "right"):
        shell.supports.hold(edge)
    for edge in ("bottom", "top"):
        shell.supports.symmetry(edge, (0.0, 1.0, 0.0))
    if load is not None:
        # half of it on each of the two nodes of the ridge
        shell.supports.hold(ridge, "x")
        shell.loads.point(ridge, (0.0, 0.0, -load / 2))
    return shell


def ridge(points):
    return np.abs(points[:, 0]) < 1e-9


def exact(w):
    """Load [N] at which the apex has come down by w [m]."""
    z = RISE - w
    return MODULUS * THICKNESS / np.hypot(HALF, RISE) ** 3 * z * (RISE**2 - z**2)


def test_two_bars_snap_through():
    """Every point on the exact path to 1e-5 of the limit load, both limit loads to 0.1 %."""
    shell = bars(LIMIT)
    path = follow(shell, 2.0, watch={"ridge": ridge, "left": "left"})
    w = -path.displacements["ridge"][:, 2]
    assert path.stopped == "level"
    assert path.levels[-1] == pytest.approx(2.0, abs=1e-12)
    assert w[-1] > 2 * RISE
    assert path.levels * LIMIT == pytest.approx(exact(w), abs=1e-5 * LIMIT)
    assert path.limit_levels() == pytest.approx([1.0, -1.0], rel=1e-3)
    # each support carries half the load
    assert path.reactions["left"][:, 2] == pytest.approx(path.levels * LIMIT / 2, abs=1e-6 * LIMIT)


@pytest.mark.parametrize(("longest", "bar"), [(0.04, 2e-2), (0.02, 2e-3)])
def test_the_curve_between_the_points(longest, bar):
    """It is within 2 % of the limit load, and within 0.2 % with steps half as long."""
    end = (ridge, "z", -2 * RISE)
    path = follow(bars(LIMIT), longest=longest, watch={"ridge": ridge}, to_displacement=end)
    level, u = path.curve("ridge")
    assert level * LIMIT == pytest.approx(exact(-u[:, 2]), abs=bar * LIMIT)


def test_prescribed_displacement_as_the_level():
    """The ridge is let down by a support: its reaction is the exact load at every point."""
    shell = bars()
    shell.supports.move(ridge, (0.0, 0.0, -2.2 * RISE))
    path = follow(shell, watch={"ridge": ridge})
    w = -path.displacements["ridge"][:, 2]
    assert w == pytest.approx(2.2 * RISE * path.levels, abs=1e-12)
    assert -path.reactions["ridge"][:, 2] == pytest.approx(exact(w), abs=1e-5 * LIMIT)
    assert -path.reactions["ridge"][-1, 2] > LIMIT


def test_a_displacement_ends_the_path():
    """Where the ridge has come down by RISE, exactly: on the falling branch, at no load."""
    path = follow(bars(LIMIT), 2.0, to_displacement=(ridge, "z", -RISE), watch={"ridge": ridge})
    assert path.stopped == "displacement"
    assert path.displacements["ridge"][-1, 2] == pytest.approx(-RISE, abs=1e-12)
    assert path.levels[-1] == pytest.approx(0.0, abs=1e-5)
    assert path.levels.max() > 0.9


def test_a_path_on_inclined_axes():
    """All of it turned in space, supports on inclined planes: the same path, turned."""
    turn = rotation_matrix(np.array([0.4, -0.7, 0.3]))
    level_surface = bars().surface
    surface = level_surface.transform(rotation=turn)
    fabric = Fabric.isotropic(MODULUS, 0.0, THICKNESS, 1000.0)
    shell = Shell(surface, fabric, membrane="chords", curvature="plain")
    top = np.flatnonzero(ridge(level_surface.points))
    for edge in ("left", "right"):
        shell.supports.hold(edge)
    for edge in ("bottom", "top"):
        shell.supports.symmetry(edge, turn[:, 1])
    shell.supports.hold_normal(top, turn[:, 0])
    shell.loads.point(top, -LIMIT / 2 * turn[:, 2])
    end = (top, turn[:, 2], -RISE)
    path = follow(shell, 2.0, to_displacement=end, watch={"ridge": top, "left": "left"})
    along = path.displacements["ridge"] @ turn
    assert path.stopped == "displacement"
    assert along[-1] == pytest.approx([0.0, 0.0, -RISE], abs=1e-12)
    assert path.levels * LIMIT == pytest.approx(exact(-along[:, 2]), abs=1e-5 * LIMIT)
    assert path.reactions["left"] @ turn[:, 2] == pytest.approx(
        path.levels * LIMIT / 2, abs=1e-6 * LIMIT
    )
    # the curve turns with the points
    _, curve = path.curve("ridge")
    assert curve @ turn[:, :2] == pytest.approx(np.zeros((1000, 2)), abs=1e-9)


def test_levels_are_met_exactly_near_a_limit_point():
    """0.999 of the limit load is met on the rising branch, though a step may pass the top."""
    path = follow(bars(LIMIT), 0.999, watch={"ridge": ridge})
    assert path.levels[-1] == pytest.approx(0.999, abs=1e-12)
    assert -path.displacements["ridge"][-1, 2] < RISE * (1 - 3**-0.5)


def test_a_path_goes_on_from_a_saved_state(shared_tmp_path):
    """Stopped on the falling branch, saved, read, gone on with another shell: the same path."""
    begun = follow(bars(LIMIT), 2.0, max_steps=8, longest=0.01, watch={"ridge": ridge})
    assert begun.stopped == "steps"
    assert len(begun.levels) == 9
    assert begun.levels[-1] < begun.levels[-2]
    begun.save(shared_tmp_path / "path.npz")
    PETSc.COMM_WORLD.barrier()
    read = Path.load(shared_tmp_path / "path.npz")
    for name in ("levels", "arc", "iterations", "level_rates"):
        assert np.array_equal(getattr(read, name), getattr(begun, name))
    assert np.array_equal(read.curve("ridge")[1], begun.curve("ridge")[1])
    shell = bars(LIMIT)
    path = follow(shell, 2.0, start=read.states[-1], watch={"ridge": ridge})
    assert path.levels[0] == begun.levels[-1]
    assert path.levels[1] < path.levels[0]
    assert path.levels[-1] == pytest.approx(2.0, abs=1e-12)
    w = -path.displacements["ridge"][:, 2]
    assert path.levels * LIMIT == pytest.approx(exact(w), abs=1e-5 * LIMIT)


def test_states_are_kept_where_asked():
    """One for each point, and the shell is left as in the last."""
    shell = bars(LIMIT)
    path = follow(shell, 0.5, keep_states=True)
    assert [state.level for state in path.states] == path.levels.tolist()
    assert np.array_equal(path.states[-1].field[:, :3], shell.displacements())
    first = path.states[1]
    first.put(shell)
    assert np.array_equal(shell.displacements(), first.field[:, :3])
    other = Shell(meshes.rectangle(1.0, 1.0, 3), shell.fabric)
    with pytest.raises(ValueError, match="6 nodes does not fit rectangle with 16"):
        first.put(other)


def test_one_factorisation_an_iteration():
    """Two right-hand sides, one factorisation: counted by PETSc, and what `iterations` tells."""
    PETSc.Log.begin()
    event = PETSc.Log.Event("MatLUFactorNum")
    before = event.getPerfInfo()["count"]
    path = follow(bars(LIMIT), 2.0)
    spent = event.getPerfInfo()["count"] - before
    assert spent == path.iterations.sum()
    assert path.iterations[1:].min() >= 1
    assert path.iterations[0] == 0


@pytest.fixture
def petsc_options():
    """PETSc's options, from which those of the prefix `bars_` are taken away afterwards."""
    options = PETSc.Options()
    yield options
    for name in list(options.getAll()):
        if name.startswith("bars_"):
            options.delValue(name)


def test_options_of_petsc_choose_the_solver(petsc_options):
    """GMRES with a block preconditioner, by a prefix: the same path, no direct solver used."""
    petsc_options["bars_ksp_type"] = "gmres"
    petsc_options["bars_ksp_rtol"] = 1e-12
    petsc_options["bars_pc_type"] = "none"
    petsc_options["bars_snes_rtol"] = 1e-6
    PETSc.Log.begin()
    event = PETSc.Log.Event("MatLUFactorNum")
    before = event.getPerfInfo()["count"]
    path = follow(bars(LIMIT), 2.0, watch={"ridge": ridge}, prefix="bars_")
    assert event.getPerfInfo()["count"] == before
    w = -path.displacements["ridge"][:, 2]
    assert path.levels * LIMIT == pytest.approx(exact(w), abs=1e-5 * LIMIT)


def loaded(kind):
    """A curved sheet under loads of one kind."""

    def place(a, b):
        return a, 0.8 * b, 0.3 * a * (1 - a) + 0.2 * b**2

    shell = Shell(meshes.patch(place, (3, 2)), Fabric.isotropic(2e6, 0.3, 0.02, 1000.0))
    shell.supports.clamp("left")
    if kind == "force":
        shell.loads.line("right", (0.2, -0.5, 2.0))
    elif kind == "amplitude":
        shell.loads.line("right", (0.2, -0.5, 2.0), np.sin)
        shell.loads.gravity()
    elif kind == "moment":
        shell.loads.edge_moment("right", (0.1, 0.3, -0.1))
    elif kind == "pressure":
        shell.loads.pressure(30.0)
    elif kind == "motion":
        n = len(shell.partition.find("right"))

        def turned(level):
            c, s = np.cos(0.3 * level), np.sin(0.3 * level)
            directors = shell.surface.directors[shell.partition.find("right")]
            return directors @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])

        goal = np.linspace(0.01, 0.03, 3 * n).reshape(n, 3)
        shell.supports.move("right", lambda level: goal * level**2, turned)
    return shell


@pytest.mark.parametrize("kind", ["force", "amplitude", "moment", "pressure", "motion"])
def test_derivative_by_the_level(kind):
    """dF/dlevel is what differences of the residual give, for each kind of load and motion."""
    shell = loaded(kind)
    statics = Statics(shell, mip=False)
    statics.solve([0.8])
    state = statics.equilibrium.state()
    statics.destroy()
    equilibrium = Equilibrium(shell, mip=False)
    equilibrium.restore(state)
    found = equilibrium.x.duplicate()
    equilibrium.start(0.8)
    equilibrium.tangent(equilibrium.x)
    equilibrium.level_derivative(found)
    h, residuals = 1e-4, []
    for level in (0.8 + h, 0.8 - h):
        equilibrium.start(level)
        equilibrium.residual(equilibrium.x, equilibrium.F)
        residuals.append(equilibrium.F.array_r.copy())
    differences = (residuals[0] - residuals[1]) / (2 * h)
    comm = shell.comm
    size = np.sqrt(comm.allreduce(np.sum(differences**2)))
    off = np.sqrt(comm.allreduce(np.sum((found.array_r - differences) ** 2)))
    assert size > 0.0
    assert off <= 1e-6 * size
    found.destroy()
    equilibrium.destroy()


def test_load_stepping_names_the_limit_point():
    """Past it the message says where it is, within 1 %, and names what follows the path."""
    shell = bars(2 * LIMIT)
    with Statics(shell) as statics, pytest.raises(NotConverged) as error:
        # the sheet has snapped through where loads rise in few steps: it must not, in many
        statics.solve(np.linspace(0.0, 1.0, 41)[1:])
    said = str(error.value)
    level = re.search(r"turns back at level ([0-9.e+-]+)", said)
    assert level, said
    assert float(level[1]) == pytest.approx(0.5, rel=1e-2)
    assert "shellform.follow" in said


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"to_level": 0.0}, "a path must end at a finite level where it does not begin, not 0.0"),
        ({"to_level": np.nan}, "must end at a finite level"),
        ({"to_displacement": (ridge, "z", 0.0)}, "must end at a finite displacement"),
        ({"to_displacement": (ridge, "down", 1.0)}, "a direction is x, y, z or a vector"),
        ({"to_displacement": (ridge, (0.0, 0.0, 0.0), 1.0)}, "a direction is three finite"),
        ({"first": 0.0}, "the first step changes the level by a finite number, not 0.0"),
        ({"iterations": 1}, "iterations must be 2 or more"),
        ({"longest": -1.0}, "longest positive, not 5, 500 and -1.0"),
        ({"watch": {"top": "upper"}}, "has no edge 'upper'"),
    ],
    ids=lambda value: "" if isinstance(value, str) else "-".join(value),
)
def test_refusals(arguments, said):
    with pytest.raises(ValueError, match=said):
        follow(bars(LIMIT), **arguments)


def test_free_motions_are_refused():
    shell = Shell(meshes.rectangle(1.0, 1.0, 2), Fabric.isotropic(1e6, 0.3, 1e-3, 1000.0))
    with pytest.raises(ValueError, match="leave a rigid motion free"):
        follow(shell)


def test_a_path_that_cannot_go_on_is_kept():
    """An amplitude that ends at half the limit load: no step leads beyond, the path is kept."""
    shell = bars()
    shell.supports.hold(ridge, "x")
    shell.loads.point(ridge, (0.0, 0.0, -LIMIT / 2), lambda level: min(level, 0.5))
    with pytest.raises(NotConverged, match=r"cannot be followed beyond level 0\.5") as error:
        follow(shell, watch={"ridge": ridge})
    path = error.value.path
    assert path.stopped == "not converged"
    w = -path.displacements["ridge"][:, 2]
    assert w[-1] == pytest.approx(0.0, abs=RISE)
    assert np.minimum(path.levels, 0.5) * LIMIT == pytest.approx(exact(w), abs=1e-5 * LIMIT)


def test_a_state_of_a_shell_at_rest():
    """A path may begin at any state of equilibrium that is known, as one of `Statics`."""
    shell = bars(LIMIT)
    with Statics(shell) as statics:
        statics.solve([0.3, 0.6])
        state = PathState.of(shell, statics.level)
    path = follow(shell, 1.5, start=state, watch={"ridge": ridge})
    w = -path.displacements["ridge"][:, 2]
    assert path.levels[0] == 0.6
    assert path.levels * LIMIT == pytest.approx(exact(w), abs=1e-5 * LIMIT)
