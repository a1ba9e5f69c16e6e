"""How long a character stays plausible: random input for minutes or hours, in every style, all styles side by side.

Each character follows a random path of its own at a random speed that changes every few seconds, with stops. Nothing is
kept of the motion but what is judged, so an hour takes no memory.
"""

import copy
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
import torch
from jaxtyping import Bool, Float
from numpy import ndarray
from torch import Tensor

from stylephase.features.body import Body
from stylephase.features.layout import FPS
from stylephase.models.bundle import Bundle
from stylephase.motion.skeleton import MIN_BONE
from stylephase.runtime.controller import Controller, ControllerSettings, Predict, State
from stylephase.runtime.finishing import Finisher, Finishing
from stylephase.runtime.limits import limited
from stylephase.runtime.pace import Pace
from stylephase.runtime.paths import SPACING, FollowPaths
from stylephase.runtime.rollout import Tick, quiet
from stylephase.runtime.speeds import SpeedCurve
from stylephase.runtime.trajectory import Steering

# The random path turns with this deviation (rad) over this length (m), and never sharper than this (rad/m).
_TURNING, _BEND_LENGTH, _SHARPEST = 0.9, 3.0, 0.8
# Speeds are multiples of the character's own, changed after so many seconds; some are stops.
_SLOWEST, _QUICKEST, _STOPS = 0.5, 1.3, 0.1
_SHORTEST, _LONGEST = 2.0, 8.0
# Longest way that a character may go (m/s), for the length of its path.
_FASTEST = 3.0
_SETTLE_SECONDS = 3.0


@dataclass(frozen=True)
class Plausible:
    """What a person can do, whatever the style.

    `hips` (m) bound the height of the hips, `bones` how far the mean of all bones' lengths may be off the true ones, as
    a share of them, `off_path` (m) the distance from the path, and `speed` (m/s) that of the hips over half a second.
    """

    hips: tuple[float, float] = (0.3, 1.5)
    bones: float = 0.15
    off_path: float = 3.0
    speed: float = 6.0


@dataclass(frozen=True)
class Endurance:
    """What became of one style: extremes over the time watched, and what was not plausible first, and when (s).

    `broken` is empty where all stayed plausible; then `after` is the time watched.
    """

    style: str
    after: float
    broken: str
    hips: tuple[float, float]
    bones: float
    off_path: float
    speed: float


def random_paths(count: int, seconds: float, rng: np.random.Generator) -> list[Float[ndarray, "points 2"]]:
    """Smooth random ways over the ground from the origin, that begin towards +z."""
    points = max(20, int(seconds * _FASTEST / SPACING))
    shocks = rng.normal(size=(count, points)) * _TURNING / _BEND_LENGTH * np.sqrt(2 * SPACING / _BEND_LENGTH)
    bend, angle, paths = np.zeros(count), np.zeros(count), np.zeros((count, points, 2))
    for k in range(1, points):
        bend = np.clip(bend * (1 - SPACING / _BEND_LENGTH) + shocks[:, k], -_SHARPEST, _SHARPEST)
        angle = angle + bend * SPACING
        paths[:, k] = paths[:, k - 1] + SPACING * np.stack([np.sin(angle), np.cos(angle)], axis=-1)
    return list(paths)


class Wander:
    """A plan of random input: paths, speeds around each character's own, and stops.

    Without `curves` the gains (m/s) themselves vary; with them, `wanted` does (m/s), about the speeds of the gains, and
    gains are read off the curves as a player does.
    """

    def __init__(
        self,
        gains: Float[ndarray, " characters"],
        seconds: float,
        rng: np.random.Generator,
        curves: Sequence[SpeedCurve] = (),
    ):
        self.path = FollowPaths(random_paths(len(gains), seconds, rng), gains)
        self.gains, self.rng, self.curves = gains, rng, curves
        self.own = np.array([np.interp(g, c.gains, c.speeds) for g, c in zip(gains, curves, strict=False)])
        self.left, self.factor, self.wanted = np.zeros(len(gains)), np.ones(len(gains)), self.own

    def __call__(self, frame: int, state: State) -> Steering:
        """What is wanted at a frame."""
        self.left = self.left - 1
        due = self.left < 0
        fresh = self.rng.uniform(_SLOWEST, _QUICKEST, len(due)) * (self.rng.random(len(due)) > _STOPS)
        self.factor = np.where(due, fresh, self.factor)
        self.left = np.where(due, self.rng.uniform(_SHORTEST, _LONGEST, len(due)) * FPS, self.left)
        if due.any():
            self.path.speeds = self._gains()
        return limited(self.path(frame, state), state)

    def _gains(self) -> Float[ndarray, " characters"]:
        if not len(self.curves):
            return self.gains * self.factor
        asked = list(zip(self.curves, self.own * self.factor, strict=True))
        self.wanted = np.array([curve.reached(speed) for curve, speed in asked])
        return np.array([curve.gain(speed) for curve, speed in asked])


class _Watch:
    """Extremes so far of each character, and what broke it."""

    def __init__(self, body: Body, count: int, limits: Plausible):
        lengths = np.array([np.linalg.norm(body.skeleton.offsets[body.joints[child]]) for _, child in body.bones])
        kept = lengths > MIN_BONE
        self.parents, self.children = np.array(body.bones)[kept].T
        self.lengths, self.limits, self.window = lengths[kept], limits, int(FPS / 2)
        self.before: list[Float[ndarray, "characters 2"]] = []
        self.low, self.high = np.full(count, np.inf), np.full(count, -np.inf)
        self.bones, self.off, self.speed = np.zeros(count), np.zeros(count), np.zeros(count)
        self.broken, self.after = [""] * count, np.zeros(count)

    @property
    def whole(self) -> Bool[ndarray, " characters"]:
        """Who is plausible still."""
        return np.array([not reason for reason in self.broken])

    @np.errstate(invalid="ignore", over="ignore")
    def see(self, state: State, shown: State, off: Float[ndarray, " characters"], seconds: float) -> None:
        """Judge a frame of those who are whole still, by the network's own pose; what is shown must be finite too."""
        p, limits = state.positions, self.limits
        parts = (p, state.path.positions, shown.positions)
        finite = np.all([np.isfinite(part).all(axis=(1, 2)) for part in parts], axis=0)
        bones = np.linalg.norm(p[:, self.children] - p[:, self.parents], axis=-1)
        bones = np.abs(bones / self.lengths - 1).mean(axis=1)
        self.before = [*self.before[-self.window :], p[:, 0, ::2]]
        moved = np.linalg.norm(self.before[-1] - self.before[0], axis=-1)
        speed = moved * FPS / max(len(self.before) - 1, 1) * (len(self.before) > self.window)
        height = p[:, 0, 1]
        faults = {
            "not finite": ~finite,
            "hips too low": height < limits.hips[0],
            "hips too high": height > limits.hips[1],
            "bones of wrong lengths": bones > limits.bones,
            "off its path": off > limits.off_path,
            "too fast": speed > limits.speed,
        }
        whole = self.whole
        for reason, is_so in faults.items():
            for k in np.flatnonzero(is_so & self.whole):
                self.broken[k] = reason
        self.after[whole] = seconds
        seen = whole & finite
        for name, values, choose in (
            ("low", height, np.minimum),
            ("high", height, np.maximum),
            ("bones", bones, np.maximum),
            ("off", off, np.maximum),
            ("speed", speed, np.maximum),
        ):
            setattr(self, name, np.where(seen, choose(getattr(self, name), values), getattr(self, name)))

    def report(self, styles: Sequence[str]) -> list[Endurance]:
        """One line for each style; extremes include the frame that broke it."""
        return [
            Endurance(
                style,
                float(self.after[k]),
                self.broken[k],
                (float(self.low[k]), float(self.high[k])),
                float(self.bones[k]),
                float(self.off[k]),
                float(self.speed[k]),
            )
            for k, style in enumerate(styles)
        ]


def endure(
    bundle: Bundle,
    styles: Sequence[str],
    codes: Float[Tensor, "characters values"],
    start: State,
    gains: Float[ndarray, " characters"],
    seconds: float,
    *,
    seed: int = 0,
    limits: Plausible | None = None,
    settings: ControllerSettings | None = None,
    curves: Sequence[SpeedCurve] = (),
    finishing: Finishing | None = None,
    fast: Predict | None = None,
    tick: Tick = quiet,
) -> list[Endurance]:
    """Let each style wander for some seconds at `gains` (m/s) times 0.5 to 1.3; who breaks is watched no longer.

    Characters are finished as they are when somebody drives them, unless `finishing` says otherwise (finishing.py);
    bones are judged in the network's own pose, since finished ones cannot be wrong. With `curves` (one a character)
    they are led to speeds in m/s, as a player is. `fast` takes the network's place.
    Those who are broken are taken out of the batch, so that they cost nothing and their numbers stay what they were.
    """
    limits, rng, settings = limits or Plausible(), np.random.default_rng(seed), settings or ControllerSettings()
    watch, plan = _Watch(bundle.body, len(styles), limits), Wander(gains, seconds, rng, curves)
    controller, finisher, state = Controller(bundle, codes, settings, fast), Finisher(bundle.body, finishing), start
    pace = Pace(len(gains))
    with _faded_is_zero():
        for frame in range(int(seconds * FPS)):
            before, wish = state, plan(frame, state)
            if len(curves):
                wish = limited(pace.lead(wish, plan.wanted, state), state)
            state, shown = finisher(before, controller.step(before, wish))
            if frame >= _SETTLE_SECONDS * FPS or not np.isfinite(state.positions).all():
                off = np.zeros(len(gains)) if frame < _SETTLE_SECONDS * FPS else plan.path.off
                watch.see(state, shown, off, (frame + 1) / FPS)
            if not watch.whole.any():
                break
            state = _restarted(state, start, watch.whole)
            tick(1)
    return watch.report(styles)


@contextmanager
def _faded_is_zero() -> Iterator[None]:
    """Arithmetic on numbers that fade to nothing is slow, and they mean nothing: for a while they are zero."""
    torch.set_flush_denormal(True)
    try:
        yield
    finally:
        torch.set_flush_denormal(False)


def _restarted(state: State, start: State, whole: Bool[ndarray, " characters"]) -> State:
    """The same with who is broken put back to the start, so that nothing grows without bound."""
    if whole.all():
        return state

    def mixed(now: ndarray, first: ndarray) -> ndarray:
        return np.where(whole.reshape(-1, *[1] * (now.ndim - 1)), now, first)

    path = type(state.path)(
        *(mixed(getattr(state.path, n), getattr(start.path, n)) for n in ("positions", "directions"))
    )
    arrays = ("positions", "rotations", "velocities", "phases", "contacts")
    return State(path, *(mixed(getattr(state, name), getattr(start, name)) for name in arrays))


def as_json(found: Sequence[Endurance]) -> list[dict[str, Any]]:
    """Plain values; None for what was never seen finite."""
    rows = [asdict(each) for each in found]
    for row in rows:
        row["hips"] = [None if not np.isfinite(value) else value for value in row["hips"]]
    return rows


def table(found: Sequence[Endurance]) -> str:
    """A Markdown table, who broke first on top."""
    heads = ("style", "plausible for", "what broke", "hips m", "bones off %", "off path m", "fastest m/s")
    lines = ["| " + " | ".join(heads) + " |", "|---" * len(heads) + "|"]
    for each in sorted(found, key=lambda e: (not e.broken, e.after)):
        cells = (each.style, f"{each.after:.0f} s", each.broken, f"{each.hips[0]:.2f} to {each.hips[1]:.2f}")
        numbers = (f"{100 * each.bones:.1f}", f"{each.off_path:.2f}", f"{each.speed:.2f}")
        lines.append("| " + " | ".join(cells + numbers) + " |")
    return "\n".join(lines)


# Noise on all weights, against their own deviation.
_SHAKE = 2.0


def shaken(bundle: Bundle, seed: int = 0) -> Bundle:
    """The same network with noise on its weights: what a check must find broken."""
    network, generator = copy.deepcopy(bundle.network), torch.Generator().manual_seed(seed)
    with torch.no_grad():
        for weight in network.synthesis.parameters():
            weight += _SHAKE * weight.std(correction=0) * torch.randn(weight.shape, generator=generator)
    return replace(bundle, network=network)
