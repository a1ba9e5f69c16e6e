"""Steering drawn by chance: a character changes its speed and its way every few seconds, within what a gait allows."""

import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.features.layout import FPS
from stylephase.runtime.plans import OnPath, heading
from stylephase.runtime.trajectory import Steering

# A wish holds for so many seconds, and the next one takes over within this time.
_HOLD, _CHANGE = (1.5, 4.0), 0.4
# A turning character faces this much ahead of itself (s).
_LEAD = 0.6


@dataclass(frozen=True)
class Gait:
    """What is asked for in one kind of take.

    `speeds` (m/s, times a gain) are the least and the most, `ways` the angles (rad) of the way to the facing, `turn`
    (rad/s) the fastest turn either way, `stops` the share of the time that a character is asked to stand.
    """

    name: str
    seconds: float
    speeds: tuple[float, float]
    ways: tuple[float, ...] = (0.0,)
    turn: float = 0.8
    stops: float = 0.0


class RandomSteering:
    """A wish for each frame and character of a gait. Those of one seed, name and gait are always the same.

    Way and facing are told from where the character faces, so nobody is left behind by a turn.
    """

    def __init__(self, gait: Gait, names: Sequence[str], frames: int, seed: int = 0):
        drawn = [_wishes(gait, frames, np.random.default_rng([seed, _number(f"{n}/{gait.name}")])) for n in names]
        self.velocities, self.turns = (np.stack(part, axis=1) for part in zip(*drawn, strict=True))

    def __call__(self, frame: int, state: OnPath) -> Steering:
        """What is wanted at a frame."""
        facing = state.path.root.angles
        left, ahead = self.velocities[frame].T
        velocity = ahead[:, None] * heading(facing) + left[:, None] * heading(facing + np.pi / 2)
        return Steering(velocity, facing + _LEAD * self.turns[frame])


def _number(name: str) -> int:
    return zlib.crc32(name.encode())


def _wishes(
    gait: Gait, frames: int, random: np.random.Generator
) -> tuple[Float[ndarray, "frames 2"], Float[ndarray, " frames"]]:
    """Velocities (left, ahead) and turns (rad/s) of one character, held for a while and then changed smoothly.

    Half of the wishes are without a turn. The change is eased over a window of the past.
    """
    kept: list[tuple[float, float, float]] = []
    while len(kept) < frames:
        speed = 0.0 if random.random() < gait.stops else random.uniform(*gait.speeds)
        way, turn = random.choice(gait.ways), random.choice([0.0, random.uniform(-gait.turn, gait.turn)])
        kept += [(speed * np.sin(way), speed * np.cos(way), turn)] * int(random.uniform(*_HOLD) * FPS)
    wishes, window = np.array(kept[:frames]), int(_CHANGE * FPS)
    sums = np.cumsum(np.concatenate([np.repeat(wishes[:1], window, axis=0), wishes]), axis=0)
    eased = (sums[window:] - sums[:-window]) / window
    return eased[:, :2], eased[:, 2]
