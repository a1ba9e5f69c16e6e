"""What the notebook of the played character measures and shows."""

import copy
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray
from torch import Tensor

from stylephase.evaluation.robustness import Endurance
from stylephase.features.body import Body
from stylephase.features.layout import FPS
from stylephase.features.store import StyleVectors
from stylephase.models.bundle import Bundle
from stylephase.report.recorder import Recorder
from stylephase.report.render.motion import Motion
from stylephase.report.walks import walking_motion
from stylephase.runtime.calibration import speed_of, warm_start
from stylephase.runtime.controller import RELEASE, Controller, ControllerSettings, State
from stylephase.runtime.keyboard import KeySettings, at_rest, steer_by_keys
from stylephase.runtime.mixtures import CORNERS
from stylephase.runtime.plans import Steady
from stylephase.runtime.player import Player
from stylephase.runtime.rollout import roll_out
from stylephase.runtime.viewer.frames import frame_numbers
from stylephase.runtime.viewer.widget import RECORDED_FPS
from stylephase.runtime.walkers import as_rollout
from stylephase.training.codes import clip_codes
from stylephase.training.sampler import Scaling

_SPEED_SECONDS, _CROWD_SECONDS = 10.0, 4.0
# Gain of the release's documented set-up ([M22] release 5.2).
_RELEASE_GAIN = 6.0
# Noise on all weights, against their own deviation.
_SHAKE = 2.0


def speeds_at(
    bundle: Bundle, codes: Float[Tensor, "characters values"], start: State, gains: Float[ndarray, " characters"]
) -> Float[ndarray, " characters"]:
    """Speeds (m/s) of straight walks at some gains, over their second half."""
    run = roll_out(bundle, codes, start, int(_SPEED_SECONDS * FPS), Steady(gains))
    half = run.root_positions[len(run) // 2 :]
    return np.array([speed_of(half[:, k]) for k in range(len(gains))])


def speed_table(styles: Sequence[str], wanted: ndarray, gains: ndarray, reached: ndarray) -> str:
    """A Markdown table of speeds."""
    lines = ["| style | wanted m/s | gain | reached m/s | off % |", "|---" * 5 + "|"]
    for style, w, g, r in zip(styles, wanted, gains, reached, strict=True):
        lines.append(f"| {style} | {w:.2f} | {g:.2f} | {r:.2f} | {100 * (r / w - 1):+.0f} |")
    return "\n".join(lines)


def scripted(player: Player, script: Sequence[tuple[str | list[str], float | int]]) -> list[State]:
    """States while keys are held, each group for some seconds."""
    states = []
    for keys, seconds in script:
        player.hold(list(keys))
        states += [player.step() for _ in range(int(seconds * FPS))]
    player.hold(())
    return states


def round_trip(player: Player, styles: Sequence[str], seconds: float) -> list[State]:
    """States of a walk ahead while the mixture goes round the triangle once, corner by corner."""
    player.choose(styles)
    ring, frames = np.concatenate([CORNERS, CORNERS[:1]]), int(seconds * FPS)
    player.hold("w")
    states = []
    for frame in range(frames):
        way = 3 * frame / frames
        k = int(way)
        player.mix(ring[k] + (way - k) * (ring[k + 1] - ring[k]))
        states.append(player.step())
    player.hold(())
    return states


def corner_walk(player: Player, corner: int, seconds: float) -> list[State]:
    """States of a walk ahead in the style of one corner, once the mixture has become it."""
    player.mix(CORNERS[corner])
    scripted(player, [("w", 2)])
    return scripted(player, [("w", seconds)])


def motion_of(states: Sequence[State], body: Body, label: str) -> Motion:
    """States of one character as a motion to draw."""
    return walking_motion(as_rollout(states), 0, body, label)


def recording(states: Sequence[State], seconds: float = 6.0) -> Float[ndarray, "frames values"]:
    """Frames for the viewer to play when no kernel answers."""
    step = int(FPS / RECORDED_FPS)
    shown, roots = states[: int(seconds * FPS)], as_rollout(states).root_positions[:, 0]
    speeds = np.linalg.norm(np.gradient(roots, axis=0), axis=1) * FPS
    return np.stack([frame_numbers(state, float(v)) for state, v in zip(shown, speeds, strict=False)][::step])


def jolt(states: Sequence[State]) -> float:
    """Largest acceleration (m/s2) of any joint of one character, after the first half second."""
    positions = np.stack([s.positions[0] for s in states])[int(FPS / 2) :]
    return float(np.linalg.norm(np.diff(positions, 2, axis=0), axis=-1).max() * FPS**2)


def heading_drift(
    bundle: Bundle,
    codes: Float[Tensor, "characters values"],
    start: State,
    gains: Float[ndarray, " characters"],
    settings: KeySettings,
    *,
    seconds: float,
) -> Float[ndarray, " characters"]:
    """Degrees between the first heading and that after some seconds of W."""
    controller, state, wish = Controller(bundle, codes, ControllerSettings()), start, at_rest(start)
    angles = []
    for _ in range(int(seconds * FPS)):
        wish = steer_by_keys("w", wish, state, gains, settings)
        state = controller.step(state, wish)
        angles.append(state.path.root.angles)
    # Over a second, so that the sway of a step does not count.
    unwrapped = np.unwrap(angles, axis=0)
    return np.degrees(np.abs(unwrapped[-int(FPS) :].mean(axis=0) - start.path.root.angles))


def one_clip_codes(bundle: Bundle, styles: Sequence[StyleVectors]) -> Float[Tensor, "styles values"]:
    """The code of one training clip of each style; the stored ones where the network has no generator."""
    generator = bundle.network.generator
    if generator is None:
        return torch.stack([bundle.code(style.style) for style in styles])
    scaling = Scaling(bundle.normaliser, bundle.body.layout)
    return torch.cat([clip_codes(generator, style, scaling, most=1) for style in styles])


def shaken(bundle: Bundle, seed: int = 0) -> Bundle:
    """The same network with noise on its weights: what a check must find broken."""
    network, generator = copy.deepcopy(bundle.network), torch.Generator().manual_seed(seed)
    with torch.no_grad():
        for weight in network.synthesis.parameters():
            weight += _SHAKE * weight.std(correction=0) * torch.randn(weight.shape, generator=generator)
    return replace(bundle, network=network)


def crowd_motions(bundle: Bundle, *, start: State | None, gains: Float[ndarray, " characters"]) -> list[Motion]:
    """A second of walking of each style; without a `start` from the mean frame, at the release's gain and settings."""
    codes = torch.stack([bundle.code(style) for style in bundle.styles])
    how = ControllerSettings()
    if start is None:
        gains, how = np.full(len(codes), _RELEASE_GAIN), RELEASE
        start = warm_start(bundle, codes, gains)
    run = roll_out(bundle, codes, start, int(_CROWD_SECONDS * FPS), Steady(gains), how)
    motions = [walking_motion(run, k, bundle.body, style) for k, style in enumerate(bundle.styles) if run.finite[k]]
    return [motion.frames(len(motion) - int(FPS), len(motion)) for motion in motions]


def record(
    recorder: Recorder,
    *,
    walkers: int,
    alone: Sequence[Endurance],
    jolts: dict[str, float],
    released: bool,
    dataset: str,
) -> None:
    """The claims of [M22] 4.4 and Figure 1 that this notebook can judge."""
    held, smooth = sum(not e.broken for e in alone), jolts["mixing"] <= 2 * jolts["one style"]
    most = held >= 0.8 * len(alone)
    recorder.claim("m22-demo-trajectory-blend", verdict="reproduced", value=True)
    if released:
        note = "judged by eye, with the authors' network"
        recorder.claim(
            "m22-fig1-many-styles", verdict="reproduced", value=walkers, n=walkers, note=note, dataset="100style"
        )
    else:
        recorder.claim("m22-fig1-many-styles", verdict="reproduced on other data", value=walkers, n=walkers)
    note = f"largest acceleration {jolts['mixing']:.0f} m/s2 while mixing, {jolts['one style']:.0f} m/s2 in one style"
    recorder.claim("m22-demo-three-styles", verdict="reproduced" if smooth else "differs", value=smooth, note=note)
    seconds = max(e.after for e in alone)
    note = f"{held} of {len(alone)} styles stay plausible for {seconds:.0f} s from the code of one clip of {dataset}"
    verdict = "reproduced on other data" if most else "differs"
    for identifier in ("m22-demo-precomputed-code", "m22-arbitrary-length"):
        recorder.claim(identifier, verdict=verdict, value=held, n=len(alone), note=note)
