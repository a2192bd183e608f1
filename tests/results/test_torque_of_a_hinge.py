# SPDX-License-Identifier: LGPL-3.0-or-later
"""Torque about one hinge against its energy: a cam, a sleeve on a bending knee."""

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

import meshes
from contact.solver.velocity_correction import VelocityCorrection
from shellform import Fabric, Shell
from shellform.contact_coupling.contact import Contact
from shellform.dynamics.explicit import Newmark
from shellform.motion.recording import Recording
from shellform.motion.wearer import Wearer
from shellform.results.joint_torque import Torque, add_torque
from shellform.results.ledger import Ledger
from tests.motion.test_wearer import bent, standing
from tests.results.test_joint_torque import by_joint


def test_power_in_a_steady_spin():
    """Torque and spin of a window give its power, exactly while the spin is constant."""
    times = np.arange(41) / 400
    ellipsoids = [("shank", "right_shank", (0, 0, 0), (0.2, 0.06, 0.06))]
    wearer = Wearer(Recording(times, hinge(times, 2.0 * times).points), ellipsoids, from_rest=False)
    surface = meshes.rectangle(0.1, 0.1, (4, 4)).transform(
        rotation=np.eye(3)[[2, 0, 1]], translation=(0.062, -0.06, -0.25)
    )
    stepper = Newmark(Shell(surface, Fabric.isotropic(1e6, 0.3, 1e-3, 200.0)), 0.8)
    stepper.v[:, 0] = -1.0
    stepper.add(Contact(wearer, friction=0.3))
    torque = stepper.add(Torque())
    for time in (0.01, 0.02):
        stepper.advance(time)
        row = by_joint(torque.record(time))["right_knee"]
        assert row["torque_y"] > 1e-4
        assert row["power"] == pytest.approx(2.0 * row["torque_y"], rel=1e-9)
        assert row["torque_flexion"] == pytest.approx(row["torque_y"], rel=1e-9)


def test_follower_on_a_cam():
    """A point that a spring holds to an eccentric ellipsoid: torque is -dE/dtheta, 0.5 %."""
    radii, home, k = np.array([0.10, 0.06, 0.07]), np.array([0.02, 0.01, -0.1]), 100.0
    swing, period = 0.4, 4.0

    def angle(t):
        return swing * np.sin(np.pi * np.clip(t, 0, None) / period) ** 2

    # standing legs 0.42 long: the shank's centre is 0.21 below the knee, here the ellipsoid's 0.08
    times = np.linspace(-0.5, period, 901)
    poses = [bent(standing(), "right_knee", angle(t), (0, 1, 0)) for t in times]
    points = {n: np.array([p[n] for p in poses]) for n in ("right_thigh", "right_shank")}
    wearer = Wearer(Recording(times, points), [("cam", "right_shank", (-0.13, 0, 0), radii)])
    knee = standing()["right_shank"][0]

    def energy(theta):
        """Of the spring, least over the surface (axes: down, to the right, backward)."""
        turn = Rotation.from_rotvec([0, theta, 0]).as_matrix()
        axes = turn @ np.array([[0, 0, -1.0], [0, -1.0, 0], [-1.0, 0, 0]]).T

        def of(s):
            local = [np.sin(s[1]), np.cos(s[1]) * np.sin(s[0]), -np.cos(s[1]) * np.cos(s[0])]
            x = axes @ (radii * local + [0.08, 0, 0])
            return 0.5 * k * np.sum((x - home) ** 2)

        return minimize(of, (0.0, 0.0), tol=1e-12).fun

    correction = VelocityCorrection(wearer, 1, friction=0.0)
    x, v, mass = (knee + home)[None] + [0.06, 0, 0], np.zeros((1, 3)), np.array([1e-3])
    joints, counts, windows, dt, span = wearer.new_joints(), np.array([[True]]), [], 1e-3, 100
    for n in range(-500, round(period / dt)):
        if n % span == 0:
            windows.append(np.zeros((1, 5)))
        old = v.copy()
        v += dt / mass[0] * (k * (knee + home - x) - 0.05 * v)
        correction(x, v, mass, dt, n * dt, old)
        wearer.joint_state(n * dt, joints)
        centres = correction.start_pose.centres
        add_torque(correction.last.table, centres, counts, *joints, windows[-1])
        x += dt * v
    windows = np.array(windows[5:])[:, 0]
    torque, work = windows[:, 3] / (span * dt), windows[:, 4].sum()
    middle = (np.arange(len(windows)) + 0.5) * span * dt
    exact = [(energy(angle(t) - 1e-3) - energy(angle(t) + 1e-3)) / 2e-3 for t in middle]
    assert np.abs(torque - exact).max() < 5e-3 * np.abs(exact).max()
    assert abs(work) < 5e-3 * abs(energy(swing) - energy(0.0))


def hinge(times, flexion):
    """Recording of a thigh that stands still and a shank that bends about the knee, the origin."""
    thigh = np.array([[0, 0, 0.4], [0, 0, 0], [0, -0.06, 0]])
    shank = np.array([[0, 0, 0], [0, 0, -0.4], [0, -0.06, -0.4]])
    turns = Rotation.from_rotvec(np.outer(flexion, [0.0, 1.0, 0.0]))
    below = np.array([turn.apply(shank) for turn in turns])
    return Recording(times, {"right_thigh": np.array([thigh] * len(times)), "right_shank": below})


class Sleeve:
    """A stretched sleeve around a knee of two ellipsoids, bent and straightened in cycles.

    Nothing holds it but contact: the girth of the limb is least at the knee, so the tension keeps
    it there. Its ends are free to slide, and it is stiff enough in bending not to fold at the back
    of the knee: a cycle of 0.4 s instead of 0.2 s changes the energy's swing by 2e-5 of itself.
    """

    still, swing = 0.05, 0.35

    def __init__(self, friction, period, cycles, drag, windows=40):
        self.period, self.windows = period, windows
        end = self.still + cycles * period
        times = np.linspace(0.0, end, round(end * 400) + 1)
        # widest 0.1 m above and below the knee, 5.66 cm there
        wearer = Wearer(
            hinge(times, self.flexion(times)),
            [
                ("thigh", "right_thigh", (0.1, 0, 0), (0.3, 0.06, 0.06)),
                ("shank", "right_shank", (-0.1, 0, 0), (0.3, 0.06, 0.06)),
            ],
        )
        rest, half = 0.055, 0.06
        surface = meshes.cylinder(rest, 2 * half, (32, 9)).transform(translation=(0, 0, -half))
        fabric = Fabric.from_stiffness(
            1e3 * np.diag([1, 1, 0.5]), 3e-4 * np.diag([1, 1, 0.5]), areal_mass=0.2, thickness=1e-3
        )
        shell = Shell(surface.replace(warp=(0.0, 0.0, 1.0)), fabric)
        X = surface.points[shell.partition.nodes]
        limb = 0.06 * np.sqrt(1 - ((0.1 - np.abs(X[:, 2:])) / 0.3) ** 2) + 1.5e-3
        shell.w.x.array.reshape(-1, 6)[:, :2] = (limb / rest - 1) * X[:, :2]
        self.stepper = stepper = Newmark(shell, 0.9, drag=100.0)
        self.touch = stepper.add(Contact(wearer, friction))
        self.torque = stepper.add(Torque())
        stepper.advance(self.still)
        stepper.drag = drag
        self.torque.record(self.still)
        self.touch.correction.reset()
        self.ledger = stepper.add(Ledger())

    def flexion(self, t):
        return self.swing * np.sin(np.pi * np.maximum(t - self.still, 0.0) / self.period) ** 2

    def cycle(self, number):
        """Play a cycle: times, angles, ledger at window ends; torque and power between; motion."""
        times = self.still + self.period * (number + np.linspace(0, 1, self.windows + 1))
        stepper, rows, books, moving = self.stepper, [], [self.ledger.record()], 0.0
        for time in times[1:]:
            stepper.advance(time)
            rows += self.torque.record(time)
            books.append(self.ledger.record())
            # of half steps: to bring velocities to the time of a row takes contact away from them
            speed2 = np.sum(stepper.v**2, axis=1)
            moving = max(moving, 0.5 * stepper.shell.comm.allreduce(stepper.mass @ speed2))
        table = {key: np.array([book[key] for book in books]) for key in books[0]}
        torque = np.array([row["torque_flexion"] for row in rows if row["joint"] == "right_knee"])
        power = np.array([row["power"] for row in rows if row["joint"] == "right_knee"])
        return times, self.flexion(times), table, torque, power, moving


def test_torque_is_the_slope_of_the_energy():
    """A slow cycle without friction: tau = -dU/dtheta, no net work; both within 2 %."""
    sleeve = Sleeve(friction=0.0, period=0.25, cycles=1, drag=20.0)
    times, theta, table, torque, power, moving = sleeve.cycle(0)
    energy = table["strain"]
    swing = np.ptp(energy)
    # slow enough: what moves and what the air takes are small beside the energy that comes and goes
    assert moving < 0.01 * swing and table["drag_loss"][-1] < 0.01 * swing
    turned = np.diff(theta)
    fast = np.abs(turned) > 0.1 * np.abs(turned).max()
    slope = np.diff(energy)[fast] / turned[fast]
    assert np.abs(torque[fast] + slope).max() < 0.02 * np.abs(slope).max()
    net = np.sum(power * np.diff(times))
    assert abs(net) < 0.02 * swing
    assert abs(np.sum(torque * turned)) < 0.02 * swing


def test_loop_area_is_the_friction_loss():
    """With friction: the loop of torque over angle holds what friction takes, within 3 %."""
    sleeve = Sleeve(friction=0.2, period=0.12, cycles=2, drag=10.0)
    sleeve.cycle(0)  # after this the sleeve comes back to where it was
    times, theta, table, torque, power, _ = sleeve.cycle(1)
    lost, swing = table["friction_loss"][1:].sum(), np.ptp(table["strain"])
    assert abs(table["strain"][-1] - table["strain"][0]) < 0.01 * swing
    assert lost > 0.3 * swing
    loop = -np.sum(torque * np.diff(theta))
    assert loop == pytest.approx(lost, rel=0.03)
    assert -np.sum(power * np.diff(times)) == pytest.approx(lost, rel=0.03)
