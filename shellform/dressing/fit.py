# SPDX-License-Identifier: LGPL-3.0-or-later
"""How a garment sits: depth in the body, stretch of the cloth, what the belt presses with."""

import numpy as np

from meshes import Surface
from shellform.contact_coupling.contact import require_contact
from shellform.dynamics.explicit import Newmark
from shellform.fem.arc import arc_lengths, sides_at_rest

from .belt import Belt, Ring

# Woven cloth under 490 N/m, the greatest load of the Kawabata test: mean of men's suiting, warp and
# weft (EMT; Kawabata, The Standardization and Analysis of Hand Evaluation, 1980, second hand)
USUAL = 0.06
AWAY = 2  # cells from the waist that count as the belt's


def fit(stepper: Newmark, belt: Belt | None) -> dict:
    """How the garment sits: depth in the body, stretch, what the belt does; on all ranks.

    Where cloth meets cloth, `intersections` are edges of it that pass through triangles.
    What has no belt, `belt` None, has none of its figures but `carried`, the force [N] by which the
    body holds it up: its weight, at rest.

    `belt_tension` is measured by what holds against it: a cable presses with its tension times the
    angle by which it turns. On the nodes of the waist that is the outward force of the body,
    which is `belt_pressed` by itself, and that of the cloth, which is gathered and resists.
    `stretch` is the largest `elongation` of the cloth along a cell edge farther from the waist.
    """
    shell, contact = stepper.shell, require_contact(stepper, "the fit of a garment")
    comm, surface = shell.comm, shell.surface
    contact.reset()
    # drag of the air would take dt/2 of its rate off the contact forces
    drag, stepper.drag = stepper.drag, 0.0
    stepper.advance(stepper.time + 200 * stepper.dt)
    stepper.drag = drag
    found = {
        "depth": max(comm.allgather(max(contact.max_depth, 0.0))),
        "stretch": float(elongation(shell.positions(), shell.directors(), surface).max()),
        "pinched": comm.allreduce(contact.pinched),
    }
    if contact.cloth is not None:
        found["intersections"] = contact.cloth.intersections()
    if belt is None:
        force = contact.window.table[:, 2].sum() / contact.window.seconds
        return found | {"carried": comm.allreduce(float(force))}
    return found | _held(stepper, belt)


def _held(stepper, belt):
    """What the belt was asked for, has, and presses the body with [N]."""
    contact, comm = require_contact(stepper, "the fit of a garment"), stepper.shell.comm
    ring = Ring(stepper, "waist")
    x = ring.look(stepper)
    body, cloth = np.zeros((2, *x.shape))
    body[ring.mine] = (contact.window.impulse / contact.window.seconds)[ring.own]
    cloth[ring.mine] = -stepper.internal_force()[ring.own, :3]
    along = np.roll(x, -1, axis=0) - x
    along /= np.linalg.norm(along, axis=1)[:, None]
    turn = np.roll(along, 1, axis=0) - along
    size = np.linalg.norm(turn, axis=1)
    outward = turn / np.maximum(size, 1e-12)[:, None]
    pressed, resisted = (
        float(np.sum(comm.allreduce(force) * outward) / size.sum()) for force in (body, cloth)
    )
    return {
        "belt_asked": belt.tension,
        "belt_tension": pressed + resisted,
        "belt_pressed": pressed,
    }


def stretch_warning(stretch: float, most: float, source: str) -> str | None:
    """What to tell a person of the `elongation` of dressed cloth; None up to USUAL.

    Parameters
    ----------
    most : elongation that the cloth bears; source : name of the garment

    Raises
    ------
    ValueError beyond `most`
    """
    mend = "take a larger size, or check the garment's place and the wearer's girths"
    if not stretch <= most:
        raise ValueError(
            f"{source}: the dressed cloth is stretched by {100 * stretch:.0f} %, and it bears "
            f"{100 * most:.0f} % (garment.max_elongation; woven cloth stretches by up to 18 % in a "
            f"Kawabata test): it is too small, or caught on the body; {mend}"
        )
    if stretch <= min(USUAL, most):
        return None
    return (
        f"warning: {source}: the dressed cloth is stretched by {100 * stretch:.0f} %, more "
        f"than the {100 * USUAL:.0f} % of suiting at the greatest load of a Kawabata test: torques "
        f"may be those of a garment too small or caught on the body; {mend}"
    )


def layers_warning(intersections: int, source: str) -> str | None:
    """What to tell a person of dressed cloth whose edges pass through it; None without such."""
    if not intersections:
        return None
    return (
        f"warning: {source}: in {intersections} places the dressed cloth passes through itself and "
        "stays so, as contact of cloth with cloth does not part what has passed: dress it anew "
        "with self_contact, if that was another scene's, or take another garment.cell_size or a "
        "wider garment"
    )


def near_waist(surface: Surface) -> np.ndarray:
    """Mask (n,) of the points at the waist, if it has one, and up to AWAY cells from it."""
    cells = surface.cells[:, :4]
    near = np.zeros(len(surface.points), bool)
    if "waist" not in surface.edges:
        return near
    near[np.unique(surface.edges["waist"])] = True
    for _ in range(AWAY):
        near[np.unique(cells[near[cells].any(axis=1)])] = True
    return near


def elongation(positions: np.ndarray, directors: np.ndarray, surface: Surface) -> np.ndarray:
    """Elongation (k,) of the cloth along the cell edges that are not `near_waist`.

    Of its length, not of the distance of the nodes: at the fork the cloth turns by 90 degrees along
    an edge, and a fold that opens moves its ends apart by up to 10 % without any strain.
    """
    near, cells = near_waist(surface), surface.cells[:, :4]
    pairs = np.stack([cells, np.roll(cells, -1, axis=1)], 2).reshape(-1, 2)
    seen = ~near[pairs].any(axis=1)
    pairs = pairs[seen]
    now = arc_lengths(positions[pairs], directors[pairs])
    return now / sides_at_rest(surface).ravel()[seen] - 1
