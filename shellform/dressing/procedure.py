# SPDX-License-Identifier: LGPL-3.0-or-later
"""How a garment is put on: the stages of Fig. 7 and how long each lasts."""

from collections.abc import Callable
from dataclasses import dataclass

from shellform.dynamics.explicit import Newmark

Watch = Callable[[str, Newmark], None]  # called with the stage and the stepper

# what of Fig. 7 is seen at the end of a stage
SHOULDER_STAGES = {"sewn": "arms held up", "lowered": "arms down", "settled": ""}
SKIN_STAGES = {"grown": "body grown", "belted": "belt", "settled": ""}
STAGES = {"below": "feet left out", "pull": "pulled up", "belted": "feet back, belt", "settled": ""}


@dataclass(frozen=True)
class Dressing:
    """How a garment is put on.

    pull, belt, release, settle : float [s], time to pull it up, to tighten the belt, to let go, and
        at most to settle
    drag : float [1/s], of the air while dressing; slip : float, friction while pulling up
    grip : float [N/m], of the hands on each node of the waist
    quiet : float [m/s], root mean square speed of the settled cloth
    """

    pull: float = 1.2
    belt: float = 0.3
    release: float = 0.2
    settle: float = 3.0
    drag: float = 4.0
    slip: float = 0.02
    grip: float = 150.0
    quiet: float = 0.01

    @property
    def seconds(self) -> float:
        """Longest time it can take [s]."""
        return self.pull + self.belt + self.release + self.settle


def unwatched(stage: str, stepper: Newmark) -> None:
    """The `Watch` of nobody."""
