# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact of a sheet with itself, between explicit steps: found, solved, remembered.

Nothing is looked at before it can matter (trust_region.py). Pairs within a skin are listed; the
list holds until parts of the sheet may have come closer by the skin, this step's motion included.
Each pair is measured when listed, and again when the distance found may have been used up: no node
travels more than half of what lay between it and anything else when that was measured.

Rows come in the order of their keys and take over impulses of the last step by them, so what is
computed does not depend on when pairs were listed: a run that is gone on with needs the rows alone.

Where nodes touch a body as well, the body says what it makes of the velocities (`respond`). Nodes
that it holds are then fixed in the sweeps, those that slide on it move along it only; body and
sweeps take turns until the body changes nothing any more. Where they do not agree, as of layers
that two parts of the body leave no room, impulses that would give energy are replaced by such that
only take it.
"""

from collections.abc import Callable

import numpy as np

from contact.solver.friction import Friction

from .boxes import members_of
from .broad_phase import list_pairs
from .features import Features
from .row_impulses import book, speed_up, spread, wake
from .rows import MARGIN, ROW, find_rows
from .sweeps import LEFT, turn_kernel
from .trust_region import TrustRegion, groups_of

SWEEPS = 300  # at most, between two answers of the body
TURNS = 6  # of the body, at most
LEFT_BY_BODY = 1e-2  # as LEFT: what a turn of the body may change
SKIN = 0.4  # of the mean size of the cells: pairs within it are listed
STALE = 0.5  # of the skin: groups that have used it up are listed anew with others
NEAR = 8.0  # part of the skin within which pairs are gone through in every step

# nodes (k,) that touch a body, their velocities (k, 3) by it, mobilities (k, 3, 3) that it leaves
Answer = tuple[np.ndarray, np.ndarray, np.ndarray]
NO_BODY: Answer = np.empty(0, np.int64), np.empty((0, 3)), np.empty((0, 3, 3))
# (velocities (n, 3) by the impulses so far, whether nodes are in rows) -> answer, None without such
Respond = Callable[[np.ndarray, np.ndarray], Answer | None]


def new_list(size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Room for keys, distances and groups of pairs, see `list_pairs`."""
    return np.empty(size, np.int64), np.empty(size), np.empty(size, np.int64)


class SelfContactSolver:
    """Contact of a sheet with itself.

    Parameters
    ----------
    features : Features of all triangles; rest : (n, 3), positions at rest [m], by places
    mass : (n,) [kg]; held : (n, 3) bool, components that supports hold
    thickness : float, distance kept between mid-surfaces [m]; friction : Friction
    recovery : float, greatest speed at which what starts closer is moved apart [m/s]
    size : float, mean size of the cells [m]; own : slice of the nodes of this rank

    Attributes
    ----------
    features : as given; friction : Friction, may be changed; region : TrustRegion
    rows : (k,) ROW of the last step
    listed : int, pairs on the list; listings : int, times that it was made
    sweeps : int, in the last step; limited : int, steps that ended with more than LEFT
    closest : float [m], least distance of any row so far over the thickness it has to keep, or more
    """

    def __init__(
        self,
        features: Features,
        rest: np.ndarray,
        mass: np.ndarray,
        held: np.ndarray,
        thickness: float,
        friction: Friction,
        recovery: float,
        size: float,
        own: slice,
    ):
        self.features, self._rest = features, np.ascontiguousarray(rest)
        self._mass, self.friction = mass, friction
        self._thickness, self._recovery, self._skin = thickness, recovery, SKIN * size
        free = np.where(held, 0.0, 1.0) / mass[:, None]
        self.mobility = free[:, :, None] * np.eye(3)
        self._found, self._due = new_list(1024), np.empty(0)
        self._keys = np.empty(0, np.int64)
        self._rows, self._old = np.zeros(64, ROW), np.zeros(64, ROW)
        self.rows = self._rows[:0]
        self._near, self._groups = np.empty(0, np.int64), np.empty(0, np.int64)
        self._live = np.zeros(len(self._rest), bool)
        at_rest = np.empty_like(self._rest)  # in an order that no number of ranks changes
        at_rest[features.numbers] = self._rest
        group = groups_of(at_rest, features.numbers[features.triangles])
        self._members = members_of(features, group)
        self.region = TrustRegion(
            group, features.triangles, len(self._rest), own, MARGIN * thickness
        )
        self._work = np.empty_like(self._rest), np.empty_like(self._rest)
        self._solved = True
        self.listings = self.sweeps = self.limited = 0
        self.closest = np.inf

    @property
    def listed(self) -> int:
        return len(self._keys)

    def needs(self, dt: float) -> bool:
        """Whether a step of dt [s] has to be looked at, by `region`; if not, there are no rows.

        Nothing has to where positions or velocities are not finite: the stepper will say so.

        Raises
        ------
        FloatingPointError where parts of the sheet pass each other by a cell in the step
        """
        self._listing, self._nearing, measuring, finite = self.region.advance(dt)
        if not finite:
            self.restore(self.rows[:0])
            return False
        if self._listing and not self.region.step.max() < self._skin / SKIN:
            self.restore(self.rows[:0])
            raise FloatingPointError(
                f"parts of the cloth move by {self.region.step.max():.3g} m against each other in "
                f"a step of {dt:.3g} s, more than a cell: the step has exploded; take a smaller one"
            )
        needed = self._listing or self._nearing or measuring
        if not needed:
            self.rows = self._rows[:0]
        return needed

    def solve(
        self,
        x: np.ndarray,
        v: np.ndarray,
        before: np.ndarray,
        dt: float,
        respond: Respond | None = None,
    ) -> bool:
        """Find rows and their impulses, kept in `rows`; whether there are any.

        x, v, before : (n, 3), positions at the start [m], velocities without rows and those of the
            last step [m/s], left as they are; dt : float [s]
        """
        if self._listing:
            self._list(x)
        self._find(x, before, dt)
        live = len(self.rows) and wake(self.rows, v, before, self._live)
        if not live:
            return False
        self._relax(v, respond)
        return True

    @property
    def impulse(self) -> np.ndarray:
        """What the rows of the last step gave to the nodes (n, 3) [N s]."""
        impulse = np.zeros_like(self._rest)
        spread(self.rows, impulse)
        return impulse

    @property
    def kept(self) -> np.ndarray:
        """Rows whose impulses the next step begins with: none after a step without an end.

        Layers that leave no room for each other are pushed from both sides, by impulses that grow
        with every sweep and must not outlive the step.
        """
        return self.rows if self._solved else self.rows[:0]

    def book(self, before: np.ndarray, after: np.ndarray, losses: np.ndarray) -> None:
        """Add what pushes and friction took to losses (2,) [J], see `row_impulses.book`."""
        book(self.rows, before, after, losses)

    def restore(self, rows: np.ndarray) -> None:
        """Go on from the rows (k,) ROW of a step before."""
        if len(rows) > len(self._rows):
            self._rows = np.zeros(2 * len(rows), ROW)
        self._rows[: len(rows)] = rows
        self.rows, self._solved = self._rows[: len(rows)], True
        self.region.forget()

    def _list(self, x):
        f, region = self.features, self.region
        skin = max(self._skin, min(8.0 * float(region.step.max()), self._skin / SKIN))
        wanted, stale = self._thickness * (1.0 + MARGIN), region.stale(STALE * skin)
        while True:
            found = list_pairs(
                x, *f[:4], f.numbers, f.places, tuple(self._members), stale, wanted + skin,
                *self._found,
            )  # fmt: skip
            if found <= len(self._found[0]):
                break
            self._found = new_list(2 * found)
        new, distance, groups = (part[:found] for part in self._found)
        kept = ~stale.ravel()[self._groups]
        due = region.flat_path[groups] + distance - wanted
        keys = np.concatenate([self._keys[kept], new])
        order = np.argsort(keys)
        self._keys = keys[order]
        self._due = np.concatenate([self._due[kept], due])[order]
        self._groups = np.concatenate([self._groups[kept], groups])[order]
        self.listings += 1
        region.begin_list(x, skin, wanted, stale)

    def _find(self, x, v, dt):
        f, region = self.features, self.region
        if self._listing or self._nearing:
            region.set_common(v)
            region.begin_near(self._skin / NEAR)
            self._near = np.flatnonzero(self._due <= region.near_limit.ravel()[self._groups])
        while True:
            found, slack, nearest = find_rows(
                x, self._rest, v, f.piece, f.places, *f[:4], self._keys, self._due, self._groups,
                self._near, region.flat_path, region.flat_step, self._thickness, self._recovery,
                dt, self._mass, self.kept, self._old,
            )  # fmt: skip
            if found <= len(self._old):
                break
            self._old = np.zeros(2 * found, ROW)
        region.found(slack)
        self._rows, self._old = self._old, self._rows
        self.rows = self._rows[:found]
        self.closest = min(self.closest, nearest)

    def _relax(self, v, respond):
        """Impulses of the rows for velocities v without them."""
        rows, one_turn = self.rows, turn_kernel(self.friction.kinetic_coefficient)
        parameters = np.array(self.friction.parameters, float)
        now, swept = self._work
        limited = self.limited
        self.sweeps, left, scale = 0, 0.0, 0.0
        for turn in range(1 if respond is None else TURNS):
            now, swept = swept, now
            speed_up(rows, self.mobility, v, now)
            held = None if respond is None else respond(now, self._live)
            done, settled, left, scale = one_turn(
                rows, now, self.mobility, self._mass, *(held or NO_BODY), swept, turn, left, scale,
                parameters, SWEEPS, LEFT_BY_BODY,
            )  # fmt: skip
            self.sweeps += done
            if held is None or settled:
                break
        else:
            self.limited += left <= LEFT * scale
        self._solved = bool(left <= LEFT * scale)
        self.limited += not self._solved
        if self.limited > limited and respond is not None and self._gains(v, respond):
            self._solved = False
            self._stop(v, one_turn)

    def _gains(self, v, respond):
        """Whether impulses give the layers more than moves apart those that start too close."""
        rows, after = self.rows, self._work[0]
        speed_up(rows, self.mobility, v, after)
        nodes, held, _ = respond(after, self._live) or NO_BODY
        after[nodes] = held
        taken = np.zeros(2)
        book(rows, v, after, taken)
        return not -taken.sum() <= rows["push"] @ np.maximum(rows["bound"], 0.0)

    def _stop(self, v, one_turn):
        """Impulses that only take energy, for a step in which body and layers do not agree.

        From none, without friction and recovery, and as if there were no body, every sweep is a
        projection onto n . v >= min(bound, 0), which v = 0 fulfils: with pushes p >= 0 the kinetic
        energy changes by at most sum p min(bound, 0), wherever sweeps end. The body comes after it.
        """
        rows, (now, swept) = self.rows, self._work
        rows["push"], rows["rub"] = 0.0, 0.0
        rows["bound"] = np.minimum(rows["bound"], 0.0)
        speed_up(rows, self.mobility, v, now)
        done, *_ = one_turn(
            rows, now, self.mobility, self._mass, *NO_BODY, swept, 0, 0.0, 0.0,
            np.zeros(len(self.friction.parameters)), SWEEPS, LEFT_BY_BODY,
        )  # fmt: skip
        self.sweeps += done
