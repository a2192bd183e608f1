# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact of a sheet with itself, between explicit steps: found, solved, remembered.

Nothing is looked at before it can matter (trust_region.py). Pairs within a skin are listed; the
list holds until parts of the sheet may have come closer by the skin, this step's motion included.
Each pair is measured when listed, and again when the distance found may have been used up: no node
travels more than half of what lay between it and anything else when that was measured.

Rows come in the order of their keys and take over impulses of the last step by them, so what is
computed does not depend on when pairs were listed: a run that is gone on with needs the rows alone.
"""

import numpy as np

from contact.solver.friction import Friction

from .boxes import members_of
from .broad_phase import list_pairs
from .features import Features
from .relaxation import Relaxation, Respond
from .row_impulses import book, spread, wake
from .rows import MARGIN, ROW, find_rows
from .trust_region import TrustRegion, groups_of

SKIN = 0.4  # of the mean size of the cells: pairs within it are listed
STALE = 0.5  # of the skin: groups that have used it up are listed anew with others
LEAST_GAP = 0.1  # of the thickness, left where a body pushes layers: `keep_apart`
NEAR = 8.0  # part of the skin within which pairs are gone through in every step


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
    features : as given; region : TrustRegion; relaxation : Relaxation, with its counts
    rows : (k,) ROW of the last step
    listed : int, pairs on the list; listings : int, times that it was made
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
        self._mass = mass
        self._thickness, self._recovery, self._skin = thickness, recovery, SKIN * size
        self.relaxation = Relaxation(mass, held, friction)
        self._found, self._due = new_list(1024), np.empty(0)
        self._keys = np.empty(0, np.int64)
        self._rows, self._old = np.zeros(64, ROW), np.zeros(64, ROW)
        self.rows = self._rows[:0]
        self._near, self._groups = np.empty(0, np.int64), np.empty(0, np.int64)
        at_rest = np.empty_like(self._rest)  # in an order that no number of ranks changes
        at_rest[features.numbers] = self._rest
        group = groups_of(at_rest, features.numbers[features.triangles])
        self._members = members_of(features, group)
        self.region = TrustRegion(
            group, features.triangles, len(self._rest), own, MARGIN * thickness
        )
        self.listings = 0
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
        if not (len(self.rows) and wake(self.rows, v, before, self.relaxation.live)):
            return False
        self.relaxation.relax(self.rows, v, respond)
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
        return self.rows if self.relaxation.solved else self.rows[:0]

    def keep_apart(self, v: np.ndarray, dt: float) -> np.ndarray | None:
        """What keeps layers from passing that a body pushes: `Relaxation.keep_apart`."""
        return self.relaxation.keep_apart(self.rows, v, LEAST_GAP * self._thickness, dt)

    def book(
        self,
        before: np.ndarray,
        after: np.ndarray,
        losses: np.ndarray,
        last: np.ndarray | None = None,
    ) -> None:
        """Add what pushes and friction took to losses (2,) [J], see `row_impulses.book`.

        last : rows of `keep_apart`, which the next step does not begin with
        """
        book(self.rows, before, after, losses)
        if last is not None:
            book(last, before, after, losses)

    def restore(self, rows: np.ndarray) -> None:
        """Go on from the rows (k,) ROW of a step before."""
        if len(rows) > len(self._rows):
            self._rows = np.zeros(2 * len(rows), ROW)
        self._rows[: len(rows)] = rows
        self.rows, self.relaxation.solved = self._rows[: len(rows)], True
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
