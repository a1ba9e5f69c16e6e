"""One character that somebody plays: keys or a path, a mixture of three styles, a speed in metres per second."""

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray

from stylephase.errors import InputError
from stylephase.models.bundle import Bundle
from stylephase.models.released_pfnn import ReleasedPfnn
from stylephase.runtime.controller import ControllerSettings, Predict, State
from stylephase.runtime.finishing import Finisher, Finishing
from stylephase.runtime.keyboard import KEYS, RUN, KeySettings, at_rest, steer_by_keys
from stylephase.runtime.limits import FASTEST, limited
from stylephase.runtime.mixtures import CORNERS, barycentric, triangle_mixture
from stylephase.runtime.pace import Pace
from stylephase.runtime.paths import FollowPaths, drawn_path
from stylephase.runtime.speeds import SpeedCurve, mixed_gain, mixed_speed
from stylephase.runtime.trajectory import Steering
from stylephase.runtime.walkers import walker_of

# A new mixture is taken on by this share a frame: a quarter of a second for most of it, so that nothing jumps.
BLEND = 0.1


def _numbers(value: object, what: str) -> Float[ndarray, "..."]:
    """Numbers that came from outside; raises InputError for what holds none.

    None would become a number that is none: JSON's null is no such number but a gap.
    """
    try:
        if any(part is None for part in np.asarray(value, dtype=object).flat):
            raise TypeError("a gap where a number belongs")
        return np.asarray(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(f"{what} should be of numbers, not {_told(value)}") from error


def _told(value: object) -> str:
    """The beginning of an odd value, for a message of one line."""
    return " ".join(repr(value).split())[:40]


class Player:
    """The character and what is wanted of it; `step` is one frame.

    `weights` are of any network (walkers.py). `styles` are the corners of the triangle, left, right and top. `curves`
    of styles that are known already spare their measuring, which takes about a second a style. The frames that `step`
    gives are finished unless `finishing` says otherwise (`RAW` for the network's own), and the character is led to the
    wanted speed (pace.py). What is set takes effect with the next frame; odd values have a defined effect: a speed that
    is no number is 0, one above `FASTEST` is that, unknown keys mean nothing. Raises InputError for an unknown style, a
    path without length, a point that is not finite, and what is no number or no name; then nothing changes.
    """

    def __init__(
        self,
        weights: Bundle | ReleasedPfnn,
        styles: Sequence[str],
        *,
        speed: float = 1.0,
        curves: Mapping[str, SpeedCurve] | None = None,
        settings: ControllerSettings | None = None,
        keys: KeySettings | None = None,
        finishing: Finishing | None = None,
        fast: Predict | None = None,
    ):
        self.walker, self.key_settings = walker_of(weights, settings, fast), keys or KeySettings()
        self.styles, self.point = self.three(styles), np.asarray(CORNERS.mean(axis=0))
        self.finisher, self.curves = Finisher(self.walker.body, finishing), dict(curves or {})
        self.code = self._wanted_code()
        self.start = self.walker.start(self.code[None])
        self.measure(self.styles)
        self.speed, self.held = speed, frozenset[str]()
        self.reset()

    def measure(self, styles: Sequence[str]) -> None:
        """Measure the speed curves of styles that have none yet."""
        for style in dict.fromkeys(styles):
            if style not in self.curves:
                self.curves |= self.walker.curves([style], grounded=self.finisher.how.grounded)

    @property
    def speed(self) -> float:
        """The walking speed wanted (m/s)."""
        return self._speed

    @speed.setter
    def speed(self, speed: Any) -> None:
        wanted = _numbers(speed, "a speed")
        if wanted.ndim:
            raise InputError(f"a speed should be one number, not {_told(speed)}")
        self._speed = float(np.clip(np.nan_to_num(wanted, nan=0.0), 0.0, FASTEST))

    @property
    def weights(self) -> Float[ndarray, "3"]:
        """Weights of the three styles."""
        return barycentric(self.point)

    def hold(self, keys: Any) -> None:
        """The names of the keys that are held now, or the name of one; a key ends the following of a path."""
        keys = (keys,) if isinstance(keys, str) else keys
        if not isinstance(keys, Collection) or not all(isinstance(key, str) for key in keys):
            raise InputError(f"keys should be names of keys, not {_told(keys)}")
        self.held = frozenset(key.lower() for key in keys) & KEYS
        self.path = None if self.held else self.path

    def mix(self, point: Any) -> None:
        """Move the mixture to a point of the triangle, or the nearest to it."""
        found = _numbers(point, "a point of the triangle")
        if found.shape != (2,):
            raise InputError(f"a point of the triangle should be two finite numbers, not {_told(point)}")
        barycentric(found)
        self.point = found

    def jump_to_mixture(self) -> None:
        """Take on the mixture at once, and not within a quarter of a second."""
        self.code = self._wanted_code()

    def three(self, styles: Any) -> tuple[str, ...]:
        """Names of three styles as they may be chosen; raises InputError for anything else."""
        if isinstance(styles, str) or not isinstance(styles, Sequence) or not all(isinstance(s, str) for s in styles):
            raise InputError(f"the corners of the triangle should be three names of styles, not {_told(styles)}")
        if len(styles) != 3:
            raise InputError(f"the triangle has three corners, not {len(styles)}")
        for style in styles:
            self.walker.code({style: 1.0})
        return tuple(styles)

    def choose(self, styles: Any) -> None:
        """Other styles at the corners; their curves must have been measured."""
        chosen = self.three(styles)
        if missing := [style for style in chosen if style not in self.curves]:
            raise InputError(f"the speeds of style {missing[0]} have not been measured")
        self.styles = chosen

    def follow(self, points: Any) -> None:
        """Walk along a path that was drawn on the ground (x, z in metres), from where the character is."""
        found = _numbers(points, "a path")
        if found.ndim != 2:
            raise InputError(f"a path should be points of two finite numbers each, not {_told(points)}")
        drawn = drawn_path(found)
        whole = drawn_path(np.concatenate([self.state.path.root.positions, drawn]))
        self.path, self.frame = FollowPaths([whole], np.ones(1)), 0

    def reset(self) -> None:
        """Back to the start, standing."""
        self.state, self.wish, self.path, self.frame = self.start, at_rest(self.start), None, 0
        self.pace = Pace(1)
        self.finisher.forget()

    def steering(self) -> Steering:
        """What is wanted now."""
        mixture = triangle_mixture(self.styles, self.point)
        speed = min(self.speed * (self.key_settings.run if RUN in self.held else 1.0), FASTEST)
        gain = np.array([mixed_gain(self.curves, mixture, speed)])
        if self.path is not None:
            self.path.speeds = gain
            self.wish = self.path(self.frame, self.state)
            if self.path.reached[0] >= self.path.last[0]:
                self.path = None
        else:
            # The gain is already that of running.
            self.wish = steer_by_keys(self.held - {RUN}, self.wish, self.state, gain, self.key_settings)
        wanted = np.array([mixed_speed(self.curves, mixture, speed)])
        return limited(self.pace.lead(self.wish, wanted, self.state), self.state)

    def step(self) -> State:
        """The next frame, as it is shown. A character that left the finite numbers starts anew."""
        self.code = self.code + BLEND * (self._wanted_code() - self.code)
        before = self.state
        self.state, shown = self.finisher(before, self.walker.step(self.code[None], before, self.steering()))
        self.frame += 1
        if not all(np.isfinite(part).all() for part in (shown.positions, self.state.positions, shown.path.positions)):
            self.reset()
            return self.state
        return shown

    def _wanted_code(self) -> torch.Tensor:
        return self.walker.code(triangle_mixture(self.styles, self.point))
