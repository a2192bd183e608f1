# SPDX-License-Identifier: LGPL-3.0-or-later
"""Friction inside the cloth of masses and springs: against a slow twin, exact loops, the shell."""

import subprocess
import sys

import numpy as np
import pytest
from scipy.integrate import trapezoid

import meshes
from shellform import Fabric, Shell
from shellform.dynamics import checkpoint
from shellform.dynamics.explicit import Newmark
from shellform.dynamics.mass_spring import Particles, hand_over
from shellform.dynamics.spring_friction import slide
from shellform.dynamics.state import State
from shellform.fem.director import rotation_matrix
from shellform.material.friction import ClothFriction, follow
from shellform.results.ledger import Ledger

pytestmark = pytest.mark.serial
FRICTION = ClothFriction(
    tension_warp=[(3000.0, 0.0, 150.0)],
    shear=[(60.0, 0.5, 8.5), (200.0, 0.3)],
    bend_warp=[(6e-5, 3e-4), (2e-5, 4e-4)],
    bend_weft=[(5e-5, 2.4e-4)],
    twist=[(3e-5, 1e-4)],
)


def cloth(friction=FRICTION):
    return Fabric.from_stiffness(
        [[400.0, 150.0, 0], [150.0, 350.0, 0], [0, 0, 110.0]],
        np.diag([1.3e-5, 1e-5, 6e-6]),
        0.2,
        5e-4,
    ).with_friction(friction)


def sheet(cells=(4, 3), size=(1.0, 1.0), friction=FRICTION, distort=0.0, angle=0.0):
    parameters = meshes.distorted(cells, distort, seed=1) if distort else None
    surface = meshes.rectangle(*size, cells, parameters=parameters)
    warp = np.cos(np.radians(angle)), np.sin(np.radians(angle)), 0.0
    return Shell(surface.replace(warp=warp), cloth(friction))


def shaken(shell, size=0.02, seed=0):
    """Springs of a shell whose nodes are displaced at random, and their friction."""
    p = Particles(shell)
    rng = np.random.default_rng(seed)
    p.owned[:, :3] = size * rng.standard_normal((p.n_owned, 3))
    return p, p.force_model.friction


def test_a_slider_in_one_step():
    """Stress and slip as many small steps have them, and the loss that these add up to."""
    rng = np.random.default_rng(2)
    for k, m, g in ((60.0, 0.5, 8.5), (60.0, 0.5, 0.0), (60.0, 0.0, 20.0)):
        for start, end in rng.uniform(-0.4, 0.4, (20, 2)):
            p = rng.uniform(-0.2, 0.2)
            p += slide(start, p, k, m, g)[1]  # within its yield stress at the start
            stress, slip, lost = slide(end, p, k, m, g)
            fine, at, total, work, before = np.linspace(start, end, 2001), p, 0.0, 0.0, None
            for e in fine:
                f, more, gone = slide(e, at, k, m, g)
                at, total = at + more, total + gone
                work += 0.0 if before is None else 0.5 * (f + before) * (end - start) / 2000
                before = f
            assert stress == pytest.approx(f, rel=1e-9)
            assert slip == pytest.approx(at - p, rel=1e-9, abs=1e-15)
            assert lost == pytest.approx(total, rel=1e-9, abs=1e-15)
            # a slider that turns round within a step is off by the corners of its path
            stored = (stress**2 - (k * (start - p)) ** 2) / (2 * k)
            assert work == pytest.approx(stored + lost, abs=1e-4)


def twin_turns(x, friction):
    """Curvatures of grid lines and twists by the formulas, node by node."""
    out = []
    for turn in friction._turns:
        n = turn["nodes"]
        v = sum(weight * x[i] for weight, i in zip(turn["weights"], n, strict=True))
        N = np.cross(x[n[1]] - x[n[0]], x[n[3]] - x[n[2]])
        out.append(turn["scale"] * v @ N / np.sqrt(N @ N + turn["blunt"]) - turn["rest"])
    return np.array(out)


def twin_strains(x, friction):
    """Strains (m, 6) of cells, one by one."""
    turns, out = twin_turns(x, friction), []
    for cell in friction._cells:
        n = cell["nodes"]
        ends = zip([0, 2, 0, 1, 2, 0], [1, 3, 2, 3, 1, 3], strict=True)
        half = np.array([0.5 * np.sum((x[n[b]] - x[n[a]]) ** 2) for a, b in ends])
        out.append([*(cell["B"] @ (half - cell["lengths"])), *(cell["C"] @ turns[cell["turns"]])])
    return np.array(out)


def test_kernel_against_its_slow_twin():
    """Forces by differences of strains, sums and slips, from a state that has slipped."""
    p, friction = shaken(sheet((3, 3), distort=0.15, angle=25.0))
    friction.add_force(p.w, np.zeros((p.n_owned, 6)))
    slips = friction.slips
    p.owned[:, :3] += 0.02 * np.random.default_rng(1).standard_normal((p.n_owned, 3))
    x = p.points + p.owned[:, :3]
    e = twin_strains(x, friction)
    np.testing.assert_allclose(friction.strains(p.w), e, rtol=1e-12, atol=1e-13)
    stress, stored, lost = np.zeros_like(e), 0.0, 0.0
    for cell, areas in enumerate(friction._cells["areas"]):
        for s, (k, m, g) in enumerate(FRICTION.table()):
            j = np.repeat(np.arange(6), FRICTION.counts())[s]
            f, slip, gone = slide.py_func(e[cell, j], slips[cell, s], k, m, g)
            slips[cell, s] += slip
            stress[cell, j] += areas[j // 3] * f
            stored, lost = stored + areas[j // 3] * f * f / (2 * k), lost + areas[j // 3] * gone
    wanted, h = np.zeros((p.n_owned, 3)), 1e-6
    for node, c in np.ndindex(wanted.shape):
        sides = []
        for sign in (1, -1):
            moved = x.copy()
            moved[node, c] += sign * h
            sides.append(np.vdot(stress, twin_strains(moved, friction)))
        wanted[node, c] = (sides[0] - sides[1]) / (2 * h)
    r, before = np.zeros((p.n_owned, 6)), friction.lost
    assert friction.stored(p.w) == pytest.approx(stored, rel=1e-12)
    friction.add_force(p.w, r)
    assert np.abs(r[:, :3] - wanted).max() < 1e-8 * np.abs(wanted).max() and not r[:, 3:].any()
    assert friction.lost - before == pytest.approx(lost, rel=1e-12)
    np.testing.assert_allclose(friction.slips, slips, rtol=1e-12, atol=1e-15)
    again = np.zeros_like(r)
    friction.add_force(p.w, again)  # nothing slips further
    assert np.abs(again - r).max() < 1e-12 * np.abs(r).max()
    assert friction.lost - before == pytest.approx(lost, rel=1e-12)


def test_sliders_neither_push_nor_turn_the_sheet():
    p, friction = shaken(sheet(distort=0.1, angle=30.0))
    r = np.zeros((p.n_owned, 6))
    friction.add_force(p.w, r)
    x, size = p.points + p.owned[:, :3], np.abs(r).max()
    assert np.abs(r.sum(axis=0)).max() < 1e-13 * size
    assert np.abs(np.cross(x, r[:, :3]).sum(axis=0)).max() < 1e-13 * size
    R = rotation_matrix([0.4, -2.1, 1.7])
    p.owned[:, :3] = x @ R.T + [0.3, 0.1, -0.2] - p.points
    turned = np.zeros_like(r)
    friction.add_force(p.w, turned)
    assert np.abs(turned[:, :3] - r[:, :3] @ R.T).max() < 1e-11 * size


@pytest.mark.parametrize("angle", [0.0, 90.0, 30.0])
def test_strains_are_those_of_the_shell(angle):
    """Of a sheet rolled along x and of a twisted one, the closer the smaller the cells."""
    gaps = []
    for n in (8, 16):
        shell = sheet((n, n), (0.1, 0.1), angle=angle)
        p, at = Particles(shell), {}
        x, y = p.points[:, 0], p.points[:, 1]
        k, s = 10.0, 4.0
        rolled = np.stack([np.sin(k * x) / k - x, 0 * x, (np.cos(k * x) - 1) / k], 1)
        at["rolled"] = rolled, np.stack([np.sin(k * x), 0 * x, np.cos(k * x)], 1)
        normal = np.stack([s * y, s * x, 1 + 0 * x], 1)
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        at["twisted"] = np.stack([0 * x, 0 * x, -s * x * y], 1), normal
        for name, (u, d) in at.items():
            p.owned[:, :3], p.owned[:, 3:] = u, d
            mine, shells = p.force_model.friction.strains(p.w), shell.cell_stress.strains(p.w)
            gap = np.abs(mine - shells) / np.abs(shells).max(axis=0).clip([1e-2] * 3 + [1.0] * 3)
            gaps.append((name, gap.max()))
    assert gaps[0][1] < 0.1 and gaps[1][1] < 0.01  # an arc of 0.12 rad is longer than its chord
    for coarse, fine in zip(gaps[:2], gaps[2:], strict=True):
        assert fine[1] < 0.3 * coarse[1] + 2e-4  # |N| is blunt


CYCLES = {
    "shear": (lambda x: np.array([[1, x, 0], [0, np.sqrt(1 - x * x), 0], [0, 0, 1.0]]), 0.2),
    "tension_warp": (lambda x: np.diag([np.sqrt(1 + 2 * x), 1.0, 1.0]), 0.05),
}


@pytest.mark.parametrize("cells", [(1, 1), (8, 8)])
@pytest.mark.parametrize("angle", [0.0, 90.0, 30.0])
@pytest.mark.parametrize("what", CYCLES)
def test_loops_in_the_plane(what, angle, cells):
    """Loads of a sheet led to and fro are the loop of its sliders; its area is what is lost."""
    shell = sheet(cells, angle=angle)
    p, (shape, most) = Particles(shell), CYCLES[what]
    friction, elements = p.force_model.friction, getattr(FRICTION, what)
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])  # from warp and weft to x and y
    steps = np.linspace(0, 1, 41)
    low = -most if what == "shear" else 0.0
    cycle = np.concatenate(
        [most * steps, most + (low - most) * steps[1:], low + (most - low) * steps[1:]]
    )
    lost, loads = [], []
    for e in cycle:
        rates = [turn @ shape(e + h) @ turn.T for h in (1e-7, -1e-7)]
        F, dF = turn @ shape(e) @ turn.T, (rates[0] - rates[1]) / 2e-7
        p.owned[:, :3] = p.points @ (F - np.eye(3)).T
        r = np.zeros((p.n_owned, 6))
        friction.add_force(p.w, r)
        loads.append(np.vdot(r[:, :3], p.points @ dF.T))
        lost.append(friction.lost)
    wanted = sum(follow(element, cycle) for element in elements)
    np.testing.assert_allclose(loads, wanted, rtol=1e-6, atol=1e-6 * np.abs(wanted).max())
    fine = np.interp(np.linspace(0, 2, 60_001), np.linspace(0, 2, 81), cycle[40:])
    start = np.concatenate([np.linspace(0, most, 2001), fine])
    area = sum(trapezoid(follow(element, start)[2001:], fine) for element in elements)
    assert lost[-1] - lost[40] == pytest.approx(area, rel=1e-6)
    stored = sum(follow(one, cycle)[-1] ** 2 / (2 * one[0]) for one in elements)
    assert friction.stored(p.w) == pytest.approx(stored, rel=1e-9, abs=1e-15)


def test_bending_loop():
    """Rolled to and fro through flat: loss of a closed cycle 4 m (a - m/k) of each slider."""
    errors = []
    for n in (20, 40):
        p = Particles(sheet((n, n // 5), (0.1, 0.02)))
        friction, x, a, lost = p.force_model.friction, p.points[:, 0], 40.0, []
        for k in (a, -a, a, -a, a):
            p.owned[:, 0], p.owned[:, 2] = np.sin(k * x) / k - x, (np.cos(k * x) - 1) / k
            friction.add_force(p.w, np.zeros((p.n_owned, 6)))
            lost.append(friction.lost)
        # chords and arcs differ: there is some strain, too
        exact = sum(4 * m * (a - m / k) for k, m, _ in FRICTION.bend_warp) * 0.002
        errors.append(abs((lost[4] - lost[2]) / exact - 1))
    assert errors[1] < 0.3 * errors[0] and errors[1] < 0.02


def hung(friction=FRICTION, factor=0.9, cells=(8, 6)):
    """A sheet held at one edge, falling, as masses and springs."""
    shell = sheet(cells, (0.4, 0.3), friction, angle=20.0)
    shell.supports.hold("left")
    shell.loads.gravity()
    return Particles(shell, factor)


def test_books_close():
    """What sliders lose and store is in the ledger; the residual is an error of the steps."""
    residuals = []
    for factor in (0.8, 0.4):
        p = hung(factor=factor)
        ledger = p.add(Ledger())
        p.advance(0.25)
        row = ledger.record()
        residuals.append(abs(row["energy_residual"]) / row["hysteresis_loss"])
        assert row["momentum_residual"] < 1e-13 and row["hysteresis_loss"] > 1e-5
        assert p.rewind.cutbacks == 0 and p.strain_energy()["friction"] > 0
    assert residuals[0] < 1e-2 and residuals[1] < 0.6 * residuals[0] + 1e-6
    assert "friction inside the cloth" in p.describe()["terms"]


def test_friction_takes_energy():
    """The same fall without it has more energy, no such column and no such term."""
    left, losses = [], []
    for friction in (FRICTION, None):
        p = hung(friction)
        ledger = p.add(Ledger())
        p.advance(0.25)
        row = ledger.record()
        left.append(row["kinetic"] + row["strain"])
        losses.append(row.get("hysteresis_loss", 0.0))
    assert left[1] - left[0] > 0.5 * losses[0] > 0
    assert "hysteresis_loss" not in row and "friction" not in p.strain_energy()


def test_goes_on_bit_for_bit(tmp_path):
    """From a checkpoint; of other friction it is refused; steps cut back bring slips back."""
    first = hung()
    for _ in range(150):
        first.step(first.dt)
    checkpoint.save(tmp_path / "c.npz", first)
    state, slips = State(first).keep(), first.force_model.friction.slips
    second = hung()
    checkpoint.load(tmp_path / "c.npz", second)
    for p in (first, second):
        for _ in range(150):
            p.step(p.dt)
    assert np.array_equal(first.owned, second.owned)
    assert np.array_equal(first.force_model.friction.slips, second.force_model.friction.slips)
    assert first.force_model.friction.lost == second.force_model.friction.lost
    assert not np.array_equal(first.force_model.friction.slips, slips)
    state.restore()
    assert np.array_equal(first.force_model.friction.slips, slips)
    with pytest.raises(ValueError, match="holds no state of this cloth's friction"):
        checkpoint.load(tmp_path / "c.npz", hung(ClothFriction(shear=[(60.0, 0.5)])))


def test_a_shell_takes_friction_over():
    """Its sliders bear what those of springs did, the books go on; others are unloaded."""
    p = hung()
    p.advance(0.25)
    p.balance()  # sliders slip to the present
    before, lost = p.force_model.friction.borne(p.w), p.force_model.friction.lost
    shell = sheet((8, 6), (0.4, 0.3), angle=20.0)
    newmark = Newmark(shell)
    hand_over(p, newmark)
    after = shell.cell_stress.borne(newmark.w)
    # but for the yield stress, which goes with the strain
    most = FRICTION.table()[:, 1] + 0.1 * FRICTION.table()[:, 2]
    assert (np.abs(after - before).max(axis=0) < 1e-3 * most).all()
    assert np.abs(before).max() > 0
    assert newmark.balance()["hysteresis"] == pytest.approx(lost, rel=1e-3)
    other = Newmark(sheet((8, 6), (0.4, 0.3), ClothFriction(shear=[(60.0, 0.5)]), angle=20.0))
    hand_over(p, other)
    assert np.abs(other.shell.cell_stress.borne(other.w)).max() < 1e-12
    assert other.shell.friction_loss() == 0


def test_nothing_is_made_that_is_not_named(monkeypatch):
    """No records, no state and no kernel of friction without it; curvatures only where they rub."""
    made = []
    name = "shellform.dynamics.spring_friction"
    monkeypatch.setattr(f"{name}.SpringFriction.__init__", lambda *a: made.append("friction"))
    monkeypatch.setattr(f"{name}.rub", None)
    p = hung(None)
    p.advance(0.01)
    assert made == [] and p.force_model.friction is None
    monkeypatch.undo()
    monkeypatch.setattr(f"{name}.turns_of", None)
    p = hung(ClothFriction(shear=[(60.0, 0.5)]))
    p.advance(0.1)
    assert p.strain_energy()["friction"] > 0
    with pytest.raises(TypeError):  # the trap works
        hung()


def test_springs_load_no_kernel_of_friction():
    """Of a fabric without it: in a process of its own, the file is not imported."""
    program = """
import sys, meshes, shellform as sf
fabric = sf.Fabric.isotropic(1e5, 0.3, 1e-3, 200.0)
p = sf.Particles(sf.Shell(meshes.rectangle(1, 1, (2, 2)), fabric))
p.step(p.dt)
assert "shellform.dynamics.springs" in sys.modules
assert not {f"shellform.dynamics.spring_{n}" for n in ("friction", "strains")} & set(sys.modules)
"""
    subprocess.run([sys.executable, "-c", program], check=True)
