"""Frames as they are shown: what a network gives, grounded and finished frame by frame, or as it is."""

from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.features.body import Body
from stylephase.runtime.controller import State
from stylephase.runtime.finish import finish_frame
from stylephase.runtime.foot_lock import Feet, LockSettings, free_feet
from stylephase.runtime.grounding import ground
from stylephase.runtime.limits import JUMP
from stylephase.runtime.rig import rig_of


@dataclass(frozen=True)
class Finishing:
    """What is done to a frame before it is shown.

    `grounded`: a character moves as its standing foot lets it (grounding.py). `finished`: feet in contact stay where
    they stand, hands come to where they were predicted, bones are constant (finish.py). With `fed_back` the finished
    pose is also what the network sees next, which makes its walks worse: it was trained on its own kind of pose.
    """

    grounded: bool = True
    finished: bool = True
    fed_back: bool = False
    lock: LockSettings = field(default_factory=LockSettings)


# What the network gives, as it is.
RAW = Finishing(grounded=False, finished=False)


def landed(feet: Feet, predicted: Float[ndarray, "characters 2 2"]) -> Feet:
    """The same feet, but those whose prediction jumps, as in `teleported`, at rest where they are predicted now.

    A jump is no movement: a lock would take it for a speed, and carry the foot on.
    """
    jumped = ~(np.linalg.norm(predicted - feet.predicted, axis=-1) < JUMP)
    there, new = jumped[..., None], free_feet(predicted)
    places, drift, before, moving = (
        np.where(there, getattr(new, part), getattr(feet, part)) for part in ("places", "drift", "predicted", "moving")
    )
    return Feet(places, drift, feet.held & ~jumped, before, moving)


class Finisher:
    """Finishes the frames of some characters one after the other; it keeps where their feet stand and how they slide.

    Raises InputError for a body whose legs or arms have fewer than two bones, unless nothing is to be done.
    """

    def __init__(self, body: Body, how: Finishing | None = None):
        self.how = how or Finishing()
        self.rig = rig_of(body) if self.how.grounded or self.how.finished else None
        self.feet: Feet | None = None
        self.slide: Float[ndarray, "characters 2"] | None = None

    def forget(self) -> None:
        """Begin anew: the next frame does not follow the last one, as after a jump to another place."""
        self.feet, self.slide = None, None

    # What turns infinite stays so, for the caller to judge.
    @np.errstate(over="ignore", invalid="ignore", divide="ignore")
    def __call__(self, before: State, after: State) -> tuple[State, State]:
        """The state to go on with and the state to show, after the network's frame from `before` to `after`."""
        if self.rig is None:
            return after, after
        if self.how.grounded:
            after, self.slide = ground(self.rig, before, after, self.slide)
        if not self.how.finished:
            return after, after
        toes = after.positions[:, [leg.tip for leg in self.rig.legs]][..., ::2]
        feet = None if self.feet is None else landed(self.feet, toes)
        held = finish_frame(self.rig, feet, after.positions, after.rotations, after.contacts, self.how.lock)
        positions, rotations, self.feet = held
        shown = replace(after, positions=positions, rotations=rotations)
        return (shown if self.how.fed_back else after), shown
