"""How fast a style walks at each gain, measured once, so that a speed can be asked for in metres per second."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray

from stylephase.errors import InputError
from stylephase.features.layout import FPS
from stylephase.models.bundle import Bundle
from stylephase.runtime.calibration import speed_of
from stylephase.runtime.controller import ControllerSettings, State
from stylephase.runtime.plans import Steady
from stylephase.runtime.rollout import Tick, quiet, roll_out

# Gains (m/s) at which each style is let walk, for so long (s); the speed is that of the second half.
_GAINS = np.array([0.15, 0.3, 0.6, 0.9, 1.3, 1.8, 2.5, 3.5, 5.0, 7.0, 10.0, 14.0])
_SECONDS = 8.0
# Where the next gain is so much faster (m/s), the gait changes between the two, and no speed between is held.
_LEAP = 0.8


@dataclass(frozen=True)
class SpeedCurve:
    """Speeds (m/s) reached at rising gains; where a higher gain is slower, the curve counts as level."""

    gains: Float[ndarray, " gains"]
    speeds: Float[ndarray, " gains"]

    def gain(self, speed: float) -> float:
        """The least gain that reaches a speed, 0 for none; beyond the curve's ends it is that of the end.

        Within a leap from one gait to the next it is the gain of the nearer side.
        """
        if not speed > 0:
            return 0.0
        rising = np.maximum.accumulate(self.speeds)
        k = int(np.searchsorted(rising, speed))
        if k in (0, len(rising)):
            return float(self.gains[min(k, len(rising) - 1)])
        if rising[k - 1] <= 0:
            # At the lower gain it goes backwards, and may well do so in between.
            return float(self.gains[k])
        share = (speed - rising[k - 1]) / (rising[k] - rising[k - 1])
        share = round(share) if rising[k] - rising[k - 1] > _LEAP else share
        return float(self.gains[k - 1] + share * (self.gains[k] - self.gains[k - 1]))

    def reached(self, speed: float) -> float:
        """The speed (m/s) at the gain that is given for a speed: the same, or the nearest that the style has."""
        gain = self.gain(speed)
        return float(np.interp(gain, self.gains, np.maximum.accumulate(self.speeds))) if gain else 0.0

    @property
    def own(self) -> float:
        """The speed (m/s) at which the style goes ahead when just that is asked for: where gain and speed meet."""
        rising = np.maximum.accumulate(self.speeds)
        meet = (rising > 0) & (self.gains >= rising)
        return float(rising[int(np.argmax(meet))] if meet.any() else rising[-1])

    def __len__(self) -> int:
        return len(self.gains)

    @property
    def range(self) -> tuple[float, float]:
        """Least and greatest speed that were reached."""
        return float(self.speeds.min()), float(self.speeds.max())


def speed_curves(
    bundle: Bundle,
    styles: Sequence[str],
    start: State,
    *,
    settings: ControllerSettings | None = None,
    tick: Tick = quiet,
    grounded: bool = False,
) -> dict[str, SpeedCurve]:
    """The curve of each style, all gains side by side; `start` holds one character per style.

    With `grounded` they move as their standing feet let them, which is slower.

    Gains at which a character does not stay finite are left out. Raises InputError where none is left.
    """
    codes = torch.stack([bundle.code(style) for style in styles]).repeat_interleave(len(_GAINS), dim=0)
    gains, frames = np.tile(_GAINS, len(styles)), int(_SECONDS * FPS)
    many, plan = start.repeated(len(_GAINS)), Steady(gains)
    run = roll_out(bundle, codes, many, frames, plan, settings, tick, grounded=grounded)
    half = run.root_positions[frames // 2 :]
    # Who goes backwards, though wished ahead, goes at less than no speed.
    speeds = np.array([speed_of(half[:, k]) * np.sign(half[-1, k, 1] - half[0, k, 1]) for k in range(len(gains))])
    kept = (run.finite & np.isfinite(speeds)).reshape(len(styles), -1)
    curves = {}
    for style, row, good in zip(styles, speeds.reshape(len(styles), -1), kept, strict=True):
        if not good.any():
            raise InputError(f"style {style} does not stay finite at any speed")
        curves[style] = SpeedCurve(_GAINS[good], row[good])
    return curves


def mixed_speed(curves: Mapping[str, SpeedCurve], mixture: Mapping[str, float], speed: float) -> float:
    """The speed (m/s) of a mixture that comes nearest to a wanted one: the mean of its styles', by their weights."""
    whole = sum(mixture.values())
    return sum(weight / whole * curves[style].reached(speed) for style, weight in mixture.items())


def mixed_gain(curves: Mapping[str, SpeedCurve], mixture: Mapping[str, float], speed: float) -> float:
    """The gain of a mixture: the mean of its styles' gains, by their weights of any sum."""
    whole = sum(mixture.values())
    return sum(weight / whole * curves[style].gain(speed) for style, weight in mixture.items())
