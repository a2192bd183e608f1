# SPDX-License-Identifier: LGPL-3.0-or-later
"""A patch of cloth pressed between two elastic beds and shortened: it bears 2 sqrt(k D).

All edges are led, so nothing localises. The beds are springs k A on every node, across the sheet;
nodes start some micrometres off the plane, directors a little off its normal, so that they zigzag
if that relieves anything. Explicit steps with drag, shortened along the yarns, both ways, or along
yarns at 45 degrees to the mesh lines. The mean compression along the yarns comes from the forces of
the edge nodes, sum f x X / area.
"""

import numpy as np

import meshes
from shellform import Fabric, Newmark, Shell
from shellform.dynamics.part import AppliedForce

SIDE, BED = 0.12, 4e5  # m; Pa/m, of both beds together
ANGLES = {"along": 0.0, "both": 0.0, "bias": 45.0}  # degrees, of the yarns to the mesh lines
BENDING = 1.2e-5  # N m


def cloth() -> Fabric:
    """A balanced weave: 5,000 N/m along yarns, 80 N/m in shear."""
    return Fabric.from_kes(
        tensile_warp_N_per_m=5000,
        tensile_weft_N_per_m=5000,
        shear_N_per_m_per_radian=80,
        bending_warp_N_m=BENDING,
        bending_weft_N_m=BENDING,
        areal_mass_kg_per_m2=0.21,
        thickness_m=0.36e-3,
    )


class Beds(AppliedForce):
    """Springs across the sheet on every node, k of its area."""

    def __init__(self, area: np.ndarray):
        self.constants = BED * area

    def add_force(self, stepper, force):
        force[:, 2] -= self.constants * stepper.owned[:, 2]


def directions(state: str) -> tuple[np.ndarray, np.ndarray]:
    """Unit vector along the yarns (2,), and strains (2, 2) for a shortening of 1."""
    angle = np.radians(ANGLES[state])
    yarn = np.array([np.cos(angle), np.sin(angle)])
    return yarn, -np.eye(2) if state == "both" else -np.outer(yarn, yarn)


def patch(
    cells: int,
    state: str,
    wrinkles: str = "relaxed",
    shortening: float = 0.02,
    seconds: float = 0.4,
    readings: int = 20,
    tilt: float = 1e-3,
) -> dict:
    """Shorten a patch of `cells` a side slowly.

    Returns
    -------
    dict: cell size [m], `shortening` (k,), `load` (k,) [N/m], compression along the yarns, and the
    root mean squares of nodes' heights [m] and of the directors' tilt at the end
    """
    yarn, strain = directions(state)
    surface = meshes.rectangle(SIDE, SIDE, (cells, cells)).replace(warp=(*yarn, 0.0))
    fabric = cloth()
    shell = Shell(surface, fabric, wrinkles=wrinkles)
    if shell.wrinkles is not None:
        shell.wrinkles.set_beds(BED)
    X = surface.points
    edge = np.unique(np.concatenate([surface.edges[name] for name in surface.edges]))

    led_by = np.column_stack([X[edge, :2] @ strain, np.zeros(len(edge))])

    def led(time):
        return shortening * min(max(time, 0.0) / seconds, 1.0) * led_by

    shell.supports.move(edge, displacement=led)
    stepper = Newmark(shell, 0.5, drag=60.0)
    rng = np.random.default_rng(1)
    # both scatters are those of the place: all cell sizes start alike in strength
    rim = np.isin(shell.partition.owned_nodes, edge)
    inside, X = np.flatnonzero(~rim), stepper.points[rim, :2]
    stepper.owned[inside, 2] += 2e-6 * rng.normal(size=len(inside))
    lean = tilt * rng.normal(size=(len(inside), 2))
    stepper.owned[inside, 3:5] += lean
    stepper.owned[inside, 3:] /= np.linalg.norm(stepper.owned[inside, 3:], axis=1)[:, None]
    stepper.scatter()
    stepper.add(Beds(stepper.mass / fabric.areal_mass))
    found = []
    at = shortening * np.arange(1, readings + 1) / readings
    for k in range(1, readings + 1):
        stepper.advance(seconds * k / readings)
        f = stepper.internal_force()[rim, :2]
        moment = np.einsum("ni,nj->ij", f, X) / SIDE**2
        found.append(-yarn @ moment @ yarn)
    owned = stepper.owned[inside]
    return {
        "size": SIDE / cells,
        "state": state,
        "wrinkles": wrinkles,
        "shortening": at,
        "load": np.array(found),
        "height": float(owned[:, 2].std()),
        "tilt": float(np.sqrt(np.mean(owned[:, 3:5] ** 2))),
        "steps": stepper.steps,
    }


def theory() -> float:
    """2 sqrt(k D) [N/m]."""
    return float(2.0 * np.sqrt(BED * BENDING))
