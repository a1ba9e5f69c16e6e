"""One character that somebody plays: keys or a path, a mixture of three styles, a speed in metres per second."""

from collections.abc import Callable, Collection, Mapping, Sequence

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray

from stylephase.errors import InputError
from stylephase.models.bundle import Bundle
from stylephase.runtime.calibration import warm_start
from stylephase.runtime.controller import Controller, ControllerSettings, Predict, State
from stylephase.runtime.keyboard import KEYS, KeySettings, at_rest, steer_by_keys
from stylephase.runtime.limits import FASTEST, limited
from stylephase.runtime.mixtures import CORNERS, barycentric, triangle_mixture
from stylephase.runtime.paths import FollowPaths, drawn_path
from stylephase.runtime.rollout import mixed_code
from stylephase.runtime.speeds import SpeedCurve, mixed_gain, speed_curves
from stylephase.runtime.trajectory import Steering

# Changes what is shown and fed back, such as inverse kinematics with locked feet.
Post = Callable[[State], State]
# A new mixture is taken on by this share a frame: a quarter of a second for most of it, so that nothing jumps.
_BLEND = 0.1


class Player:
    """The character and what is wanted of it; `step` is one frame.

    `styles` are the corners of the triangle, left, right and top. `curves` of styles that are known already spare
    their measuring, which takes about a second a style. What is set takes effect with the next frame; odd values have
    a defined effect: a speed that is no number is 0, one above `FASTEST` is that, unknown keys mean nothing. Raises
    InputError for an unknown style, a path without length, and a point that is not finite; then nothing changes.
    """

    def __init__(
        self,
        bundle: Bundle,
        styles: Sequence[str],
        *,
        speed: float = 1.0,
        curves: Mapping[str, SpeedCurve] | None = None,
        settings: ControllerSettings | None = None,
        keys: KeySettings | None = None,
        post: Post | None = None,
        fast: Predict | None = None,
    ):
        self.bundle, self.post, self.key_settings = bundle, post, keys or KeySettings()
        self.settings, self.curves = settings or ControllerSettings(), dict(curves or {})
        self.styles, self.point = _three(bundle, styles), np.asarray(CORNERS.mean(axis=0))
        self.code = self._wanted_code()
        self.start = warm_start(bundle, self.code[None], np.ones(1))
        self.measure(self.styles)
        self.controller = Controller(bundle, self.code[None], self.settings, fast)
        self.state, self.wish = self.start, at_rest(self.start)
        self.speed, self.held, self.frame = speed, frozenset[str](), 0
        self.path: FollowPaths | None = None

    def measure(self, styles: Sequence[str]) -> None:
        """Measure the speed curves of styles that have none yet."""
        for style in dict.fromkeys(styles):
            if style not in self.curves:
                self.curves |= speed_curves(self.bundle, [style], self.start, settings=self.settings)

    @property
    def speed(self) -> float:
        """The walking speed wanted (m/s)."""
        return self._speed

    @speed.setter
    def speed(self, speed: float) -> None:
        self._speed = float(np.clip(np.nan_to_num(speed, nan=0.0), 0.0, FASTEST))

    @property
    def weights(self) -> Float[ndarray, "3"]:
        """Weights of the three styles."""
        return barycentric(self.point)

    def hold(self, keys: Collection[str]) -> None:
        """The keys that are held now; a key that moves ends the following of a path."""
        self.held = frozenset(key.lower() for key in keys) & KEYS
        self.path = None if self.held else self.path

    def mix(self, point: Float[ndarray, " coordinates"] | Sequence[float | int]) -> None:
        """Move the mixture to a point of the triangle, or the nearest to it."""
        barycentric(point)
        self.point = np.asarray(point, dtype=float)

    def choose(self, styles: Sequence[str]) -> None:
        """Other styles at the corners; their curves must have been measured."""
        chosen = _three(self.bundle, styles)
        if missing := [style for style in chosen if style not in self.curves]:
            raise InputError(f"the speeds of style {missing[0]} have not been measured")
        self.styles = chosen

    def follow(self, points: Float[ndarray, "points width"] | Sequence[Sequence[float | int]]) -> None:
        """Walk along a path that was drawn on the ground (x, z in metres), from where the character is."""
        drawn = drawn_path(points)
        whole = drawn_path(np.concatenate([self.state.path.root.positions, drawn]))
        self.path, self.frame = FollowPaths([whole], np.ones(1)), 0

    def reset(self) -> None:
        """Back to the start, standing."""
        self.state, self.wish, self.path = self.start, at_rest(self.start), None

    def steering(self) -> Steering:
        """What is wanted now."""
        gain = np.array([mixed_gain(self.curves, triangle_mixture(self.styles, self.point), self.speed)])
        if self.path is not None:
            self.path.speeds = gain
            self.wish = self.path(self.frame, self.state)
            if self.path.reached[0] >= self.path.last[0]:
                self.path = None
        else:
            self.wish = steer_by_keys(self.held, self.wish, self.state, gain, self.key_settings)
        return limited(self.wish, self.state)

    def step(self) -> State:
        """The next frame. A character that left the finite numbers starts anew."""
        self.code = self.code + _BLEND * (self._wanted_code() - self.code)
        self.controller.codes = self.code[None]
        state = self.controller.step(self.state, self.steering())
        state = state if self.post is None else self.post(state)
        self.frame += 1
        self.state = state
        if not (np.isfinite(state.positions).all() and np.isfinite(state.path.positions).all()):
            self.reset()
        return self.state

    def _wanted_code(self) -> torch.Tensor:
        return mixed_code(self.bundle, triangle_mixture(self.styles, self.point))


def _three(bundle: Bundle, styles: Sequence[str]) -> tuple[str, ...]:
    if len(styles) != 3:
        raise InputError(f"the triangle has three corners, not {len(styles)}")
    for style in styles:
        bundle.code(style)
    return tuple(styles)
