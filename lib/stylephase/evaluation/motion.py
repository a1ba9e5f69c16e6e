"""Metrics of one character's motion: bones, steps, speed, heading, skating."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from stylephase.features.layout import FPS
from stylephase.phase.global_phase import touchdowns

# Steps by which feet are said to alternate: so many in all, and this share with the other foot before.
FEWEST_STEPS, ALTERNATION = 10, 0.9
# Feet that come down within this time come down together (s).
_TOGETHER = 0.05


@dataclass(frozen=True)
class Bones:
    """How bone lengths hold.

    `median` and `worst` are coefficients of variation over time (%) of the median and of the worst bone; `off` is the
    largest distance (mm) of a bone's mean length from its true one, `drift` that of a bone's mean over the last second
    from its mean over the first.
    """

    median: float
    worst: float
    off: float
    drift: float


def bones_of(
    positions: Float[ndarray, "frames joints 3"], bones: tuple[tuple[int, int], ...], true: Float[ndarray, " bones"]
) -> Bones:
    """Bone statistics of a motion; bones are (parent, child), true lengths in metres. Those of no length count not."""
    parents, children = (list(column) for column in zip(*bones, strict=True))
    lengths = np.linalg.norm(positions[:, parents] - positions[:, children], axis=-1)[:, true > 1e-3]
    variation, second = 100 * lengths.std(axis=0) / lengths.mean(axis=0), int(FPS)
    off = np.abs(lengths.mean(axis=0) - true[true > 1e-3])
    drift = np.abs(lengths[-second:].mean(axis=0) - lengths[:second].mean(axis=0))
    return Bones(
        float(np.median(variation)), float(variation.max()), 1000 * float(off.max()), 1000 * float(drift.max())
    )


@dataclass(frozen=True)
class Steps:
    """Steps of a walk: how many, the share that follow one of the other foot, and the cycle time (s, 0 for none).

    Of two feet that come down together, neither follows the other.
    """

    count: int
    alternation: float
    cycle: float

    @property
    def alternate(self) -> bool:
        """Whether the feet alternate."""
        return self.count >= FEWEST_STEPS and self.alternation >= ALTERNATION


def steps_of(contacts: Bool[ndarray, "frames 2"], fps: float = FPS) -> Steps:
    """Steps from foot contacts (right, left).

    >>> right = np.tile(np.repeat([True, False], 30), 6)
    >>> steps_of(np.stack([right, ~right], axis=1))
    Steps(count=11, alternation=1.0, cycle=1.0)
    """
    downs = [touchdowns(contacts[:, foot], fps) for foot in range(2)]
    frames, feet = np.concatenate(downs), np.repeat([0, 1], [len(down) for down in downs])
    order = np.argsort(frames, kind="stable")
    changes = (np.diff(feet[order]) != 0) & (np.diff(frames[order]) > _TOGETHER * fps)
    cycles = [np.median(np.diff(d)) / fps for d in downs if len(d) > 1]
    return Steps(len(order), float(changes.mean()) if len(changes) else 0.0, float(np.mean(cycles)) if cycles else 0.0)


def correlation(values: Float[ndarray, "frames 2"]) -> float:
    """Correlation of two signals, such as the contacts of both feet; 0 where one of them stays the same."""
    centred = values - values.mean(axis=0)
    size = np.sqrt(np.square(centred).sum(axis=0)).prod()
    return float(centred.prod(axis=1).sum() / size) if size > 1e-9 else 0.0


def heading_error(angles: Float[ndarray, " frames"], target: float, seconds: float = 2.0) -> float:
    """Degrees between a wanted heading (rad) and the mean facing of the last seconds."""
    last = angles[-int(seconds * FPS) :]
    off = np.arctan2(np.sin(last - target).mean(), np.cos(last - target).mean())
    return float(np.degrees(abs(off)))


def foot_skate(toes: Float[ndarray, "frames 2 3"], contacts: Bool[ndarray, "frames 2"], fps: float = FPS) -> float:
    """Mean horizontal speed (m/s) of the toes (right, left) over frames in contact before and after; 0 without any."""
    speed = np.linalg.norm(np.diff(toes[..., [0, 2]], axis=0), axis=-1) * fps
    held = contacts[1:] & contacts[:-1]
    return float(speed[held].mean()) if held.any() else 0.0
