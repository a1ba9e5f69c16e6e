"""A start without data, and the gain that makes a character walk at a wanted speed.

The steering's velocity is a wish that the network's own path outweighs, so more has to be asked for than is wanted
([M22] release 5.2: a gain, not metres per second). How much depends on the style, and is measured.
"""

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from torch import Tensor

from stylephase.features.layout import FPS
from stylephase.models.bundle import Bundle
from stylephase.runtime.controller import Controller, ControllerSettings, State, input_of, start_state
from stylephase.runtime.plans import Steady
from stylephase.runtime.rollout import Rollout, Tick, quiet, roll_out

# Gains tried first, as multiples of the wanted speed, and the rounds of finer ones.
_GAINS = np.array([0.6, 1.0, 1.6, 2.5, 4.0, 6.3])
_ROUNDS = 3
_TRIAL_SECONDS = 6.0
_SPEED_WINDOW = 0.5
_WARM_UP_SECONDS = 4.0
# Asked for little at the start some styles set off backwards, asked for much some run, and they keep to it: so several
# gains are tried, shares of the wanted speed or of this (m/s).
_WARM_UP_GAIN, _WARM_UPS = 3.0, (0.3, 0.45, 0.6, 0.8, 1.0)


@np.errstate(over="ignore", invalid="ignore")
def speed_of(root: Float[ndarray, "frames 2"], fps: float = FPS) -> float:
    """Mean speed along the ground (m/s), of the path over half a second at a time, so that sway does not count.

    0 for a path of less than that; not finite where the path is not.
    """
    step = max(1, int(fps * _SPEED_WINDOW))
    if len(root) <= step:
        return 0.0
    return float(np.linalg.norm(root[step:] - root[:-step], axis=1).mean() * fps / step)


def warm_start(
    bundle: Bundle, codes: Float[Tensor, "characters values"], speeds: Float[ndarray, " characters"]
) -> State:
    """Characters at the origin, facing +z, after some seconds of walking that began at the mean frame of the data.

    Of several tries each character has the one that goes ahead most nearly at its speed (m/s).
    """
    n, tries = bundle.normaliser, len(_WARM_UPS)
    x, p = (np.tile(mean, (tries * len(codes), 1)) for mean in (n.x_mean, n.p_mean))
    plan = Steady((np.maximum(speeds, _WARM_UP_GAIN)[:, None] * _WARM_UPS).ravel())
    controller = Controller(bundle, codes.repeat_interleave(tries, dim=0), ControllerSettings())
    state, places = start_state(x, p, bundle.layout), []
    for frame in range(int(_WARM_UP_SECONDS * FPS)):
        state = controller.step(state, plan(frame, state))
        places.append(state.path.root.positions[:, 1])
    second = places[-int(FPS) :]
    ahead = (second[-1] - second[0]) * FPS / max(len(second) - 1, 1)
    off = np.abs(ahead.reshape(len(codes), tries) - speeds[:, None])
    best = np.where(np.isfinite(off), off, np.inf).argmin(axis=1) + tries * np.arange(len(codes))
    return start_state(input_of(state)[best], state.phases[best], bundle.layout)


def calibrate(
    bundle: Bundle,
    codes: Float[Tensor, "characters values"],
    start: State,
    targets: Float[ndarray, " characters"],
    *,
    settings: ControllerSettings | None = None,
    tick: Tick = quiet,
) -> Float[ndarray, " characters"]:
    """The gain (m/s) at which each character comes nearest to its target speed (m/s) when it walks straight.

    A handful of gains is tried side by side, then finer ones between the two that enclose the target.
    """
    gains = targets[:, None] * _GAINS
    for last in [False] * (_ROUNDS - 1) + [True]:
        speeds = _speeds(bundle, codes, start, gains, settings, tick)
        choose = _nearest if last else _finer
        gains = np.stack([choose(g, s, t) for g, s, t in zip(gains, speeds, targets, strict=True)])
    return gains[:, 0]


def _speeds(
    bundle: Bundle, codes: Tensor, start: State, gains: ndarray, settings: ControllerSettings | None, tick: Tick
) -> ndarray:
    """Speeds over the second half of a trial, for each character and gain."""
    each = gains.shape[1]
    spread = codes.repeat_interleave(each, dim=0)
    frames = int(_TRIAL_SECONDS * FPS)
    run: Rollout = roll_out(bundle, spread, start.repeated(each), frames, Steady(gains.ravel()), settings, tick)
    second_half = run.root_positions[frames // 2 :]
    return np.array([speed_of(second_half[:, k]) for k in range(gains.size)]).reshape(gains.shape)


def _finer(
    gains: Float[ndarray, " gains"], speeds: Float[ndarray, " gains"], target: float
) -> Float[ndarray, " gains"]:
    """Gains between the two neighbours that enclose the target most closely, or around the nearest one."""
    off = np.where(np.isfinite(speeds), speeds - target, np.inf)
    crossing = np.flatnonzero(np.sign(off[:-1]) != np.sign(off[1:]))
    if len(crossing):
        k = crossing[np.minimum(np.abs(off[crossing]), np.abs(off[crossing + 1])).argmin()]
        return np.linspace(gains[k], gains[k + 1], len(gains))
    best = int(np.abs(off).argmin())
    return np.linspace(gains[max(best - 1, 0)], gains[min(best + 1, len(gains) - 1)], len(gains))


def _nearest(gains: Float[ndarray, " gains"], speeds: Float[ndarray, " gains"], target: float) -> Float[ndarray, "1"]:
    off = np.where(np.isfinite(speeds), np.abs(speeds - target), np.inf)
    return gains[[int(off.argmin())]]
