"""Whether a character goes as it is told: speeds, ways aside and backward, turns, and straight on with a key held.

Each has a null that must fail it: gains in place of speeds, led straight ahead, a wish that is left out.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray
from torch import Tensor

from stylephase.evaluation.motion import heading_error
from stylephase.features.layout import FPS, INPUT_SAMPLES, OUTPUT_SAMPLES
from stylephase.features.store import StyleVectors
from stylephase.models.bundle import Bundle
from stylephase.runtime.calibration import speed_of
from stylephase.runtime.controller import Controller, ControllerSettings, State, input_of
from stylephase.runtime.finishing import Finisher
from stylephase.runtime.keyboard import KeySettings, at_rest, steer_by_keys
from stylephase.runtime.pace import Pace, at_pace
from stylephase.runtime.plans import OnPath, Plan, Steady, TurnOnce, heading
from stylephase.runtime.player import BLEND
from stylephase.runtime.rollout import roll_out
from stylephase.runtime.speeds import SpeedCurve
from stylephase.runtime.trajectory import PAST, Steering
from stylephase.runtime.walkers import NetworkWalker, drive
from stylephase.runtime.ways import way_of

# The way of about a second, by samples of the trajectory; who goes this straight ahead walks forward.
_BEFORE, _AFTER, _AHEAD = -30, 24, 0.9
# A speed within this share of the wanted one is reached.
NEAR = 0.1
# A way within this angle (rad) of the wanted one is taken.
ANGLE = np.radians(15)
# From so far on a way is aside (rad).
ASIDE = np.radians(10)


@dataclass(frozen=True)
class Going:
    """How a gait goes: its mean speed (m/s), and the angle of its way to the facing (rad, positive to the left)."""

    speed: float
    angle: float


def goings(style: StyleVectors) -> dict[str, Going]:
    """How each gait of a style goes whose takes agree on a direction."""
    rows, found = style.rows("train"), {}
    for gait in dict.fromkeys(style.gaits):
        chosen = rows[np.array(style.gaits)[style.take[rows]] == gait]
        if not len(chosen):
            continue
        path = style.x[chosen, : 4 * len(INPUT_SAMPLES)].reshape(-1, len(INPUT_SAMPLES), 4)
        way = path[:, INPUT_SAMPLES.index(_AFTER), :2] - path[:, INPUT_SAMPLES.index(_BEFORE), :2]
        length, mean = np.linalg.norm(way, axis=1).mean(), way.mean(axis=0)
        if np.linalg.norm(mean) >= _AHEAD * length:
            found[gait] = Going(float(length * FPS / (_AFTER - _BEFORE)), float(np.arctan2(*mean)))
    return found


def forward_speeds(style: StyleVectors) -> dict[str, float]:
    """Mean speed (m/s) of each gait in which the style goes straight ahead."""
    return {gait: how.speed for gait, how in goings(style).items() if abs(how.angle) < ASIDE}


def aside(style: StyleVectors) -> dict[str, Going]:
    """The gaits in which the style goes aside or backward."""
    return {gait: how for gait, how in goings(style).items() if abs(how.angle) >= ASIDE}


def reached_speeds(
    bundle: Bundle,
    codes: Float[Tensor, "characters values"],
    start: State,
    plan: Plan,
    *,
    seconds: float = 16.0,
) -> Float[ndarray, " characters"]:
    """Speeds (m/s) over the last half of finished walks under a plan."""
    walker, frames = NetworkWalker(bundle), int(seconds * FPS)
    run = drive(walker, codes, start, frames, plan)
    return np.array([speed_of(run.root_positions[frames // 2 :, k]) for k in range(len(codes))])


def reached_goings(
    bundle: Bundle,
    codes: Float[Tensor, "characters values"],
    start: State,
    gains: Float[ndarray, " characters"],
    asked: Sequence[Going],
    *,
    seconds: float = 16.0,
) -> list[Going]:
    """How finished characters go, over the last half, that are to go so, each facing ahead.

    Turning round and being led to a speed take some seconds.
    """
    speeds, angles = (np.array([getattr(how, part) for how in asked]) for part in ("speed", "angle"))

    def plan(_frame: int, _state: OnPath) -> Steering:
        return Steering(gains[:, None] * heading(angles), np.zeros(len(angles)))

    frames = int(seconds * FPS)
    run = drive(NetworkWalker(bundle), codes, start, frames, at_pace(plan, speeds))
    last = [run.root_positions[frames // 2 :, k] for k in range(len(asked))]
    ways = [np.radians(way_of(run, k, plan, []).strafe) for k in range(len(asked))]
    return [Going(speed_of(places), float(way)) for places, way in zip(last, ways, strict=True)]


@dataclass(frozen=True)
class Aside:
    """Ways aside and backward: the style and gait, how its takes go, how the character goes, and when asked to go on.

    `ahead` is the same character led straight ahead at that speed: who takes no notice of the angle goes so.
    """

    style: str
    gait: str
    data: Going
    ours: Going
    ahead: Going

    @property
    def reached(self) -> bool:
        """Whether speed and angle are those of the data."""
        return _as_asked(self.ours, self.data)

    @property
    def by_chance(self) -> bool:
        """Whether going straight ahead would pass too."""
        return _as_asked(self.ahead, self.data)


def _as_asked(found: Going, asked: Going) -> bool:
    off = (found.angle - asked.angle + np.pi) % (2 * np.pi) - np.pi
    return bool(abs(found.speed / asked.speed - 1) <= NEAR and abs(off) <= ANGLE)


def ways_aside(bundle: Bundle, styles: Sequence[StyleVectors], curves: Mapping[str, SpeedCurve]) -> list[Aside]:
    """Every gait aside or backward that the data have, asked for as its takes go."""
    cases = [(style.style, gait, how) for style in styles for gait, how in aside(style).items()]
    if not cases:
        return []
    codes = torch.stack([bundle.code(style) for style, *_ in cases])
    data = [how for *_, how in cases]
    gains = np.array([curves[style].gain(how.speed) for style, _, how in cases])
    start = NetworkWalker(bundle).start(codes)
    ours, ahead = (
        reached_goings(bundle, codes, start, gains, asked)
        for asked in (data, [replace(how, angle=0.0) for how in data])
    )
    return [Aside(*case, *found) for case, *found in zip(cases, ours, ahead, strict=True)]


def after_standing(plan: Plan, seconds: float) -> Plan:
    """The same plan once a character has stood for some seconds, as one does before a key is pressed."""

    def later(frame: int, state: OnPath) -> Steering:
        wish = plan(frame, state)
        return Steering(wish.velocity * (frame >= seconds * FPS), wish.facing)

    return later


def changed_speeds(
    bundle: Bundle,
    codes: Float[Tensor, "characters values"],
    start: State,
    gains: Float[ndarray, " characters"],
    wanted: Float[ndarray, " characters"],
    *,
    before: float = 4.0,
    seconds: float = 20.0,
) -> Float[ndarray, " characters"]:
    """Speeds (m/s) over the last half of finished walks that go on in the style of the next one after some seconds.

    The change comes as a player's does; code, gain and wanted speed are those of the next style then.
    """
    walker, finisher, pace = NetworkWalker(bundle), Finisher(bundle.body), Pace(len(codes))
    now, target, state, places = codes, torch.roll(codes, -1, dims=0), start, []
    for frame in range(int(seconds * FPS)):
        if frame >= before * FPS:
            now = now + BLEND * (target - now)
        own, speed = ((np.roll(v, -1) if frame >= before * FPS else v) for v in (gains, wanted))
        wish = pace.lead(Steady(own)(frame, state), speed, state)
        state, _ = finisher(state, walker.step(now, state, wish))
        places.append(state.path.root.positions)
    half = np.stack(places[len(places) // 2 :])
    return np.array([speed_of(half[:, k]) for k in range(len(codes))])


@dataclass(frozen=True)
class Blend:
    """What the path to come is made of ([M22] 4.4).

    How far a point ahead follows when the user's wish, or the network's predicted path, is moved by one (1: it alone
    decides); from the next point to the last, over all characters alike. And how far (degrees) characters are off a
    turn of 90 degrees that is asked for, and with the wish left out, as a null.
    """

    user: Float[ndarray, " points"]
    network: Float[ndarray, " points"]
    turned: Float[ndarray, " characters"]
    unheard: Float[ndarray, " characters"]

    @property
    def blended(self) -> bool:
        """Whether both count at every point, the wish more the further ahead, and it is the wish that turns them."""
        both = self.user.min() > 0 and self.network.min() > 0 and max(self.user.max(), self.network.max()) <= 1
        obeys = self.turned.mean() < 0.5 * self.unheard.mean()
        return bool(both and self.user[-1] > self.user[0] and obeys)


def trajectory_blend(
    bundle: Bundle,
    codes: Float[Tensor, "characters values"],
    start: State,
    gains: Float[ndarray, " characters"],
    *,
    settings: ControllerSettings | None = None,
    seconds: float = 6.0,
) -> Blend:
    """Probe the controller from outside: with the network's output held fixed, one thing is moved at a time."""
    how, layout = settings or ControllerSettings(), bundle.layout
    y = Controller(bundle, codes, how).predict(input_of(start), start.phases)
    ahead = np.array([sample for sample in OUTPUT_SAMPLES if sample > 0])
    moved = y.copy()
    samples = moved[:, layout.y_trajectory].reshape(len(y), len(OUTPUT_SAMPLES), 4)
    samples[:, np.array(OUTPUT_SAMPLES) > 0, 1] += 1.0
    moved[:, layout.y_trajectory] = samples.reshape(len(y), -1)

    def path(outputs: ndarray, speed: float) -> ndarray:
        fixed = Controller(bundle, codes, how, lambda *_: outputs)
        wish = Steering(np.tile([0.0, speed], (len(codes), 1)), start.path.root.angles)
        return fixed.step(start, wish).path.positions[:, PAST + ahead]

    plain = path(y, 1.0)
    user = np.linalg.norm(path(y, 2.0) - plain, axis=-1).mean(axis=0) * FPS / ahead
    network = np.linalg.norm(path(moved, 1.0) - plain, axis=-1).mean(axis=0)

    def off(given: ControllerSettings) -> ndarray:
        turn = TurnOnce(gains, np.pi / 2, int(FPS))
        run = roll_out(bundle, codes, start, int(seconds * FPS), turn, given)
        return np.array([heading_error(run.root_angles[:, k], np.pi / 2) for k in range(len(codes))])

    return Blend(user, network, off(how), off(replace(how, position_bias=0.0, direction_bias=0.0)))


@dataclass(frozen=True)
class Drift:
    """How far characters end off the first heading (degrees), and come at most off the straight way ahead (m)."""

    degrees: Float[ndarray, " characters"]
    metres: Float[ndarray, " characters"]


def drift(
    bundle: Bundle,
    codes: Float[Tensor, "characters values"],
    start: State,
    gains: Float[ndarray, " characters"],
    wanted: Float[ndarray, " characters"],
    settings: KeySettings,
    *,
    seconds: float,
    straightens: bool = True,
) -> Drift:
    """What some seconds of W come to, with characters led to speeds (m/s) and, unless told otherwise, to their ways.

    Who keeps its heading may still walk beside its way, so both are told.
    """
    wish, first = at_rest(start), start.path.root

    def held(_frame: int, state: OnPath) -> Steering:
        nonlocal wish
        wish = steer_by_keys("w", wish, state, gains, settings)
        return wish

    plan = at_pace(held, wanted, straightens=straightens)
    run = drive(NetworkWalker(bundle), codes, start, int(seconds * FPS), plan)
    right = heading(first.angles - np.pi / 2)
    aside = np.abs(((run.root_positions - first.positions) * right).sum(axis=2)).max(axis=0)
    # Over a second, so that the sway of a step does not count.
    last = np.unwrap(run.root_angles, axis=0)[-int(FPS) :].mean(axis=0)
    return Drift(np.degrees(np.abs(last - first.angles)), aside)
