# SPDX-License-Identifier: LGPL-3.0-or-later
"""Joint torque: a slow twin, turned and mirrored scenes, virtual power, and energy as an oracle."""

from mpi4py import MPI

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import meshes
from contact.body.blended_surface import BlendedSurface
from contact.geometry.triangle_mesh.sphere import sphere
from contact.solver.contact_ledger import WORK
from contact.solver.velocity_correction import VelocityCorrection
from shellform import Fabric, Shell
from shellform.contact_coupling.contact import Contact
from shellform.dynamics.explicit import Newmark
from shellform.fem.director import rotation_matrix
from shellform.motion.joint_parts import chosen_parts
from shellform.motion.recording import Recording
from shellform.motion.wearer import Wearer
from shellform.results.joint_torque import COLUMNS, Torque, add_torque
from tests.motion.test_wearer import standing, walking

LEG = (
    ("thigh", "right_thigh", (0.0, 0.0, 0.0), (0.18, 0.06, 0.06)),
    ("shank", "right_shank", (0.0, 0.0, 0.0), (0.17, 0.05, 0.05)),
)
WHOLE = (
    ("hips", "pelvis", (0.0, 0.0, 0.0), (0.10, 0.12, 0.16)),
    *((f"right {name}", *rest) for name, *rest in LEG),
    ("right foot", "right_foot", (0.0, 0.0, 0.0), (0.12, 0.04, 0.04)),
    *((f"left {name}", rest[0].replace("right", "left"), *rest[1:]) for name, *rest in LEG),
    ("left knee", "left_shank", (-0.2, 0.01, 0.0), (0.07, 0.06, 0.06)),
    ("left foot", "left_foot", (0.02, 0.0, 0.01), (0.12, 0.04, 0.04)),
)
MIRROR = np.array([1.0, -1.0, 1.0])


def swapped(name):
    """The name of the same part on the other side."""
    side, _, rest = name.partition("_")
    return {"right": f"left_{rest}", "left": f"right_{rest}"}.get(side, name)


def skin_of(wearer, divisions=4):
    """The ellipsoids of a wearer cut into triangles, each bound to its own."""
    pose, parts, faces, weights = wearer.new_pose(0.0), [], [], []
    for b, radii in enumerate(wearer.radii):
        vertices, triangles = sphere(1.0, divisions)
        faces.append(triangles + sum(map(len, parts)))
        parts.append(pose.centres[b] + (vertices * radii) @ pose.axes[b])
        weights.append(np.tile(np.eye(len(wearer.names))[b], (len(vertices), 1)))
    return BlendedSurface(np.vstack(parts), np.vstack(faces), np.vstack(weights), wearer)


def curtain(turn=None, mirror=False, comm=MPI.COMM_WORLD, skin=None):
    """A cloth that falls against the front of a striding right leg, all turned or mirrored."""
    turn = np.eye(3) if turn is None else turn
    recording = walking(np.arange(21) / 100)
    points, ellipsoids = recording.points, LEG
    surface = meshes.rectangle(
        0.3, 0.7, (8, 16), parameters=meshes.distorted((8, 16), 0.1, seed=1)
    ).transform(rotation=np.eye(3)[[2, 0, 1]], translation=(0.232, -0.24, 0.12))
    if mirror:
        points = {swapped(name): track * MIRROR for name, track in points.items()}
        ellipsoids = [(name, swapped(segment), *rest) for name, segment, *rest in LEG]
        surface = surface.replace(
            points=surface.points * MIRROR, cells=surface.cells[:, ::-1],
            directors=surface.directors * MIRROR, edges={},
        )  # fmt: skip
    recording = Recording(recording.times, {name: p @ turn.T for name, p in points.items()})
    fabric = Fabric.isotropic(1e6, 0.3, 1e-3, 200.0)
    stepper = Newmark(Shell(surface.transform(rotation=turn), fabric, comm), 0.8)
    stepper.v[:] = turn @ [-1.0, 0.0, 0.0]
    stepper.recheck, stepper.dt = 10**9, 2e-4
    wearer = Wearer(recording, ellipsoids)
    surface = None if skin is None else skin(wearer)
    touch = stepper.add(Contact(wearer, friction=0.3, surface=surface))
    return stepper, touch, stepper.add(Torque())


def vector(row):
    return np.array([row[f"torque_{axis}"] for axis in "xyz"])


def by_joint(rows):
    return {row["joint"]: row for row in rows}


def test_twin_in_plain_numpy():
    """Node by node, every node touching one segment; wrenches of segments and nodes agree."""
    stepper, touch, torque = curtain()
    wearer, comm = touch.correction.body, stepper.shell.comm
    about = np.array([3.0, -2.0, 5.0])
    sums = {joint: np.zeros(3) for joint in wearer.joints}
    leftover, size = np.zeros(6), 0.0

    def twin(stepper, dt):
        nonlocal size
        # velocities are corrected, nodes have not moved yet
        x, last = stepper.points + stepper.owned[:, :3], touch.correction.last
        segment, centres = touch.correction.segment, wearer.new_pose(stepper.time).centres
        for joint, J in zip(wearer.joints, wearer.new_joints(stepper.time).centres, strict=True):
            below = [wearer.index(name) for name in wearer.below(joint)]
            for i in np.flatnonzero(np.isin(segment, below)):
                sums[joint] += np.cross(x[i] - J, -last.impulse[i])
        table = last.table
        leftover[:3] += last.impulse.sum(axis=0) - table[:, :3].sum(axis=0)
        leftover[3:] += np.cross(x - about, last.impulse).sum(axis=0)
        leftover[3:] -= (table[:, 3:6] + np.cross(centres - about, table[:, :3])).sum(axis=0)
        size += np.abs(last.impulse).sum()

    stepper.add(twin)
    stepper.advance(150 * stepper.dt)
    rows = by_joint(torque.record(stepper.time))
    assert set(rows) == {"right_hip", "right_knee", "right_ankle", "left_hip", "left_knee"} | {
        "left_ankle"
    }
    for joint, row in rows.items():
        exact = comm.allreduce(sums[joint]) / stepper.time
        assert np.abs(vector(row) - exact).max() <= 1e-9 * np.abs(exact).max()
    assert np.abs(vector(rows["right_knee"])).max() > 0.01
    assert not np.allclose(vector(rows["right_knee"]), vector(rows["right_hip"]), rtol=0.1)
    assert not vector(rows["left_hip"]).any() and not vector(rows["right_ankle"]).any()
    assert comm.allreduce(touch.correction.pinched) == 0
    assert np.abs(comm.allreduce(leftover)).max() < 1e-9 * comm.allreduce(size)


@pytest.fixture(scope="module")
def plain():
    """Torques of the plain scene."""
    stepper, _, torque = curtain()
    stepper.advance(150 * stepper.dt)
    return by_joint(torque.record(stepper.time))


def test_torque_of_a_skin_is_that_of_the_ellipsoids_under_it(plain):
    """Cut into 2,048 triangles each: torque and power within 2 %, sums to roundoff."""
    stepper, touch, torque = curtain(skin=skin_of)
    comm, leftover, size = stepper.shell.comm, np.zeros(6), 0.0
    for _ in range(150):
        x = stepper.points + stepper.owned[:, :3]
        stepper.step(stepper.dt)
        last, centres = touch.last, touch.start_pose.centres
        given = np.hstack([last.impulse, np.cross(x, last.impulse)]).sum(axis=0)
        table = last.table[:, :6].copy()
        table[:, 3:] += np.cross(centres, table[:, :3])
        leftover += given - table.sum(axis=0)
        size += np.abs(last.impulse).sum()
    assert np.abs(comm.allreduce(leftover)).max() < 1e-12 * comm.allreduce(size)
    for joint, row in by_joint(torque.record(stepper.time)).items():
        exact = vector(plain[joint])
        assert np.abs(vector(row) - exact).max() <= 2e-2 * np.abs(exact).max()
        assert row["power"] == pytest.approx(plain[joint]["power"], rel=2e-2)


def test_torque_turns_with_the_scene(plain):
    R = rotation_matrix([0.7, -1.1, 0.4])
    stepper, _, torque = curtain(turn=R)
    stepper.advance(150 * stepper.dt)
    size = max(np.abs(vector(row)).max() for row in plain.values())
    for row in torque.record(stepper.time):
        one = plain[row["joint"]]
        assert np.abs(vector(row) - R @ vector(one)).max() < 1e-9 * size
        assert abs(row["torque_flexion"] - one["torque_flexion"]) < 1e-9 * size
        assert abs(row["power"] - one["power"]) < 1e-9 * abs(plain["right_knee"]["power"])


def test_torque_in_a_mirror(plain):
    """Right and left change places; about the flexion axis they are equal."""
    stepper, _, torque = curtain(mirror=True)
    stepper.advance(150 * stepper.dt)
    size = max(np.abs(vector(row)).max() for row in plain.values())
    for row in torque.record(stepper.time):
        one = plain[swapped(row["joint"])]
        # a moment is an axial vector
        assert np.abs(vector(row) + MIRROR * vector(one)).max() < 1e-9 * size
        assert abs(row["torque_flexion"] - one["torque_flexion"]) < 1e-9 * size
        assert abs(row["power"] - one["power"]) < 1e-9 * abs(plain["right_knee"]["power"])


@pytest.mark.skipif(MPI.COMM_WORLD.size == 1, reason="compares many ranks with one")
def test_torque_on_many_ranks(plain, shared_tmp_path):
    """As on one rank to 1e-9, the file written once; also from a state taken half-way."""
    stepper, _, torque = curtain(comm=MPI.COMM_SELF)
    path = shared_tmp_path / f"{MPI.COMM_WORLD.rank}.csv"
    torque = stepper.add(Torque(path))
    stepper.advance(75 * stepper.dt)
    torque.restore(torque.state())
    stepper.advance(150 * stepper.dt)
    size = max(np.abs(vector(row)).max() for row in plain.values())
    for row in torque.record(stepper.time):
        assert np.abs(vector(row) - vector(plain[row["joint"]])).max() < 1e-9 * size
    lines = path.read_text().splitlines()
    assert lines[0] == ",".join(COLUMNS) and len(lines) == 7


def test_power_of_joints_and_pelvis_is_that_of_contact():
    """Virtual power of the linkage: sum tau . omega + F . v + M . omega of the pelvis, 1e-6."""
    times = np.arange(301) / 1000
    turning = Rotation.from_rotvec(np.outer(times, [0.3, -0.5, 1.0]))
    points = walking(times).points
    points = {n: np.array([R.apply(p) for R, p in zip(turning, points[n])]) for n in points}
    wearer = Wearer(Recording(times, points), WHOLE, from_rest=False)
    rng, dt = np.random.default_rng(2), 1e-7
    for t in (0.1, 0.2):
        # points on all ellipsoids, some of them deep in others, thrown at them
        pose = wearer.new_pose(t)
        normal = rng.standard_normal((len(WHOLE), 40, 3))
        normal /= np.linalg.norm(normal, axis=2, keepdims=True)
        x = pose.centres[:, None] + np.einsum(
            "bni,bij->bnj", wearer.radii[:, None] * normal, pose.axes
        )
        v = pose.velocities[:, None] + rng.standard_normal(x.shape)
        x, v = x.reshape(-1, 3), v.reshape(-1, 3)
        correction = VelocityCorrection(wearer, len(x), friction=0.3)
        correction(x, v, np.full(len(x), 1e-3), dt, t)
        table, total = correction.last.table, np.zeros((6, 5))
        counts = np.array([[n in wearer.below(j) for n in wearer.names] for j in wearer.joints])
        joints = wearer.new_joints(t)
        add_torque(table, pose.centres, counts, *joints, total)
        force = -table[:, :3].sum(axis=0)
        moment = -(table[:, 3:6] + np.cross(pose.centres - pose.centres[0], table[:, :3]))
        power = total[:, 4].sum() + force @ pose.velocities[0]
        power += moment.sum(axis=0) @ pose.spins[0]
        assert np.count_nonzero(np.abs(total[:, 4]) > 1e-4 * np.abs(total[:, 4]).max()) > 3
        # what the moving body does to the cloth, it loses
        assert abs(power + table[:, WORK].sum()) < 1e-6 * np.abs(table[:, WORK]).sum()


def test_parts_that_count():
    points = {name: np.array([p, p]) for name, p in standing().items()}
    wearer = Wearer(Recording(np.array([0.0, 1.0]), points), WHOLE)
    distal, child = chosen_parts(wearer, "distal"), chosen_parts(wearer, "child")
    assert set(distal) == set(child) == set(wearer.joints) and len(wearer.joints) == 6
    assert distal["right_hip"] == ["right thigh", "right shank", "right foot"]
    assert distal["left_knee"] == ["left shank", "left knee", "left foot"]
    assert child["right_hip"] == ["right thigh"]
    assert child["left_knee"] == ["left shank", "left knee"]
    own = chosen_parts(wearer, {"left_knee": ["left knee"]})
    assert own == distal | {"left_knee": ["left knee"]}
    with pytest.raises(ValueError, match="no joint 'knee'; there are: right_hip, "):
        chosen_parts(wearer, {"knee": ["left knee"]})
    with pytest.raises(ValueError, match="no segment 'knee'; there are: hips, "):
        chosen_parts(wearer, {"left_knee": ["knee"]})
    for wrong in ("all", None, ["left knee"]):
        with pytest.raises(ValueError, match="'distal', 'child' or a table"):
            chosen_parts(wearer, wrong)


def test_own_table_in_a_run(plain):
    """What a table names counts, the rest goes the default way; 'child' stops at the next joint."""
    stepper, _, _ = curtain()
    torque = stepper.add(Torque(parts={"right_hip": ["thigh", "shank"], "right_knee": ["thigh"]}))
    child = stepper.add(Torque(parts="child"))
    assert torque.parts["right_knee"] == ["thigh"] and child.parts["right_hip"] == ["thigh"]
    stepper.advance(150 * stepper.dt)
    own, child = by_joint(torque.record(0.0)), by_joint(child.record(0.0))
    size = np.abs(vector(plain["right_hip"])).max()
    assert np.abs(vector(own["right_hip"]) - vector(plain["right_hip"])).max() < 1e-9 * size
    assert np.abs(vector(child["right_knee"]) - vector(plain["right_knee"])).max() < 1e-9 * size
    # about two points the torques of one force differ by arm x force: not the same numbers
    assert np.abs(vector(own["right_knee"]) - vector(child["right_hip"])).max() > 1e-3 * size
