# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pressure at the vertices of a body of triangles: sleeve, sums, ranks, files."""

from mpi4py import MPI

import meshio
import numpy as np
import pytest
from PIL import Image

import meshes
from contact.body.segments import Body, Fixed, Segment
from shellform import Contact, Fabric, Newmark, Shell
from shellform.pictures.skin_pressure import pressure_figure
from shellform.results.pressure_map import load, save, summary, write
from shellform.results.surface_pressure import (
    SurfacePressure,
    flat_weights,
    vertex_areas,
    vertex_owners,
)
from tests.contact.solver.surfaces import tube
from tests.contact_coupling.test_surface_contact import sheet

STRETCH, RADIUS, LONG = 0.05 / 0.048, 0.05, 0.12


def sleeve(comm=MPI.COMM_WORLD):
    """A sleeve stretched onto a tube of triangles, settled; its pressure from then on."""
    surface = meshes.cylinder(RADIUS / STRETCH, LONG, (40, 8))
    surface = surface.transform(translation=(0, 0, -0.5 * LONG)).replace(warp=(0.0, 0.0, 1.0))
    fabric = Fabric.from_stiffness(
        1e3 * np.diag([1, 1, 0.5]), 1e-7 * np.diag([1, 1, 0.5]), areal_mass=0.2, thickness=1e-3
    )
    shell = Shell(surface, fabric, comm)
    points = surface.points[shell.partition.nodes]
    shell.w.x.array.reshape(-1, 6)[:, :3] = (STRETCH - 1) * points * [1.0, 1.0, 0.0]
    stepper = Newmark(shell, 0.9, damping=2e-4, drag=60.0)
    contact = stepper.add(Contact(tube(RADIUS - 5e-4, 0.3, 40, 36), 0.0))
    pressure = stepper.add(SurfacePressure())
    stepper.advance(0.08)
    contact.reset()
    pressure.record(stepper.time, counts=False)
    stepper.advance(0.12)
    pressure.record(stepper.time)
    return contact, pressure.result()


@pytest.mark.serial
def test_sleeve_presses_with_hoop_tension_over_radius():
    contact, found = sleeve()
    hoop = 1e3 * 0.5 * (STRETCH**2 - 1) * STRETCH  # N/m
    comm, window = MPI.COMM_WORLD, contact.window
    # five rows of the sleeve, 15 mm each: their force goes to vertices up to 33 mm from the middle
    band = np.abs(found.vertices[:, 2]) < 0.0375
    force = np.sum((found.mean * found.areas)[band])
    assert force == pytest.approx(2 * np.pi * 0.075 * hoop, rel=1e-2)
    # around the tube forces are even
    ring = np.abs(found.vertices[:, 2]) < 1e-9
    forces = (found.mean * found.areas)[ring]
    assert ring.sum() == 40 and np.ptp(forces) < 1e-2 * forces.mean()
    places = contact.stepper.points + contact.stepper.owned[:, :3]
    outward = places * [1, 1, 0] / np.linalg.norm(places[:, :2], axis=1, keepdims=True)
    total = comm.allreduce(np.sum(window.impulse * outward)) / window.seconds
    assert np.sum(found.mean * found.areas) == pytest.approx(total, rel=2e-3)
    assert np.sum(found.rubbing * found.areas) < 0.1 * total
    assert (found.mean[np.abs(found.vertices[:, 2]) > 0.1] == 0.0).all()
    # all of the cloth touches all the time, and covers its area at rest
    touched = summary(found)["tube"]
    assert touched["contact_area"] == pytest.approx(2 * np.pi * RADIUS / STRETCH * LONG, rel=2e-2)
    assert touched["normal_force"] == pytest.approx(np.sum(found.mean * found.areas), rel=1e-12)
    assert touched["peak_pressure"] == found.peak[touched["peak_vertex"]] == found.peak.max()


def test_weights_over_a_flat_triangle():
    rng = np.random.default_rng(3)
    vertices, corners = rng.standard_normal((3, 3)), np.arange(3)
    normal = np.cross(vertices[1] - vertices[0], vertices[2] - vertices[0])
    wanted = rng.dirichlet(np.ones(3))
    point = wanted @ vertices + 0.3 * normal
    found = flat_weights(vertices, corners, point - 0.1, np.full(3, 0.1))
    assert found == pytest.approx(wanted, abs=1e-12)
    # beyond a corner: all of it
    out = vertices[0] + 2.0 * (vertices[0] - vertices[1:].mean(axis=0))
    assert flat_weights(vertices, corners, out, np.zeros(3))[0] == pytest.approx(1.0)


def test_a_vertex_belongs_to_the_segment_of_most_area_around_it():
    # two small triangles of segment 0 and a large one of segment 1 around vertex 0
    angle = np.radians([0.0, 30.0, 60.0, 350.0])
    spokes = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(4)])
    vertices = np.vstack([np.zeros(3), spokes])
    triangles = np.array([(0, 1, 2), (0, 2, 3), (0, 3, 4)])
    owners = np.array([0, 0, 1])
    assert vertex_owners(owners, triangles, vertices).tolist() == [0, 0, 0, 1, 1]
    vertices[4] *= 9.0
    assert vertex_owners(owners, triangles, vertices)[0] == 1


def test_areas_and_the_same_on_all_ranks():
    runs = []
    for comm in (MPI.COMM_SELF, MPI.COMM_WORLD):
        stepper, _ = sheet(comm)
        pressure = stepper.add(SurfacePressure())
        for _ in range(2):
            for _ in range(80):
                stepper.step(stepper.dt)
            pressure.record(stepper.time)
        runs.append(pressure.result())
    one, all = runs
    assert one.mean.max() > 0 and one.seconds == pytest.approx(160 * 2e-4)
    assert np.abs(one.mean - all.mean).max() < 1e-9 * one.mean.max()
    assert np.abs(one.peak - all.peak).max() < 1e-9 * one.peak.max()
    assert vertex_areas(one.vertices, one.triangles).sum() == pytest.approx(
        np.linalg.norm(
            np.cross(*(one.vertices[one.triangles[:, k]] - one.vertices[one.triangles[:, 0]]
                       for k in (1, 2))), axis=1
        ).sum() / 2
    )  # fmt: skip


def test_goes_on_from_what_was_saved():
    stepper, _ = sheet()
    pressure = stepper.add(SurfacePressure())
    for _ in range(90):
        stepper.step(stepper.dt)
    pressure.record(stepper.time)
    for _ in range(10):
        stepper.step(stepper.dt)
    saved = pressure.saved()
    other, _ = sheet()
    again = other.add(SurfacePressure(saved))
    assert again.record(stepper.time) == pytest.approx(pressure.record(stepper.time), rel=1e-12)
    assert again.result().mean == pytest.approx(pressure.result().mean, rel=1e-12)
    third, _ = sheet()
    with pytest.raises(ValueError, match="holds no pressure at vertices"):
        third.add(SurfacePressure({}))
    saved["surface_pressure_open"] = np.zeros((3, 2))
    with pytest.raises(ValueError, match="of a surface of 3 vertices, not of"):
        third.add(SurfacePressure(saved))


@pytest.mark.serial
def test_file_for_paraview(tmp_path):
    stepper, _ = sheet()
    pressure = stepper.add(SurfacePressure())
    with pytest.raises(ValueError, match="before a window is closed"):
        pressure.result()
    for _ in range(120):
        stepper.step(stepper.dt)
    pressure.record(stepper.time)
    found = pressure.result()
    write(tmp_path / "skin.vtu", found)
    read = meshio.read(tmp_path / "skin.vtu")
    assert np.array_equal(read.cells_dict["triangle"], found.triangles)
    assert read.point_data["pressure_Pa"] == pytest.approx(found.mean)
    assert read.point_data["pressure_Pa"].max() > 0
    save(tmp_path / "pressure.npz", found)
    again = load(tmp_path / "pressure.npz")
    for name, value in found._asdict().items():
        assert np.array_equal(getattr(again, name), value, equal_nan=name == "peak_time"), name
    np.savez(tmp_path / "other.npz", triangles=found.triangles)
    with pytest.raises(ValueError, match=r"other\.npz holds no map of pressure: it has no 'areas'"):
        load(tmp_path / "other.npz")
    pressure_figure(tmp_path / "pressure.png", stepper.contact.body, found, 0.0, "a block")
    with Image.open(tmp_path / "pressure.png") as image:
        seen = np.asarray(image.convert("RGB")).reshape(-1, 3).astype(int)
    # red where it is pressed, grey where not
    assert (seen[:, 0] > seen[:, 2] + 80).sum() > 100


def test_ellipsoids_have_no_vertices():
    shell = Shell(meshes.rectangle(0.1, 0.1, (2, 2)), Fabric.isotropic(1e6, 0.3, 1e-3, 200.0))
    stepper = Newmark(shell)
    with pytest.raises(ValueError, match="needs a contact"):
        stepper.add(SurfacePressure())
    stepper.add(Contact(Body([Segment("ball", [0.1] * 3, Fixed((0, 0, -1.0)))])))
    with pytest.raises(ValueError, match="that of a body of triangles"):
        stepper.add(SurfacePressure())
