"""What the notebook of the played character measures and shows."""

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray
from torch import Tensor

from stylephase.evaluation.character import Arms, Looks
from stylephase.evaluation.comparison import mean_with_interval
from stylephase.evaluation.robustness import Endurance
from stylephase.features.body import Body
from stylephase.features.layout import FPS
from stylephase.features.store import StyleVectors
from stylephase.models.bundle import Bundle
from stylephase.report.recorder import Recorder
from stylephase.report.render.motion import Motion
from stylephase.report.walks import walking_motion
from stylephase.runtime.calibration import warm_start
from stylephase.runtime.controller import RELEASE, Controller, ControllerSettings, State
from stylephase.runtime.keyboard import KeySettings, at_rest, steer_by_keys
from stylephase.runtime.mixtures import CORNERS
from stylephase.runtime.plans import Steady
from stylephase.runtime.player import Player
from stylephase.runtime.rollout import as_rollout, roll_out
from stylephase.runtime.viewer.frames import frame_numbers
from stylephase.runtime.viewer.widget import RECORDED_FPS
from stylephase.training.codes import clip_codes
from stylephase.training.sampler import Scaling

_CROWD_SECONDS = 4.0
# A speed within this share of the wanted one is reached; most is this share of the styles; a jolt is this many times
# the largest acceleration without.
NEAR, MOST, JOLT = 0.1, 0.8, 1.5
OTHER = "reproduced on other data"
# Gain of the release's documented set-up ([M22] release 5.2).
_RELEASE_GAIN = 6.0
# Noise on all weights, against their own deviation.
_SHAKE = 2.0


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


def motion_of(states: Sequence[State], body: Body, label: str) -> Motion:
    """States of one character as a motion to draw."""
    return walking_motion(as_rollout(states), 0, body, label)


def recording(states: Sequence[State], seconds: float = 6.0) -> Float[ndarray, "frames values"]:
    """Frames for the viewer to play when no kernel answers."""
    step = int(FPS / RECORDED_FPS)
    shown, roots = states[: int(seconds * FPS)], as_rollout(states).root_positions[:, 0]
    speeds = np.linalg.norm(np.gradient(roots, axis=0), axis=1) * FPS
    return np.stack([frame_numbers(state, float(v)) for state, v in zip(shown, speeds, strict=False)][::step])


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
    generator = bundle.network.generator if bundle.makes_codes else None
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


def looks_table(looks: Mapping[str, Looks], recorded: Float[ndarray, " styles"]) -> str:
    """A Markdown table of what is seen of each way of finishing: median and most over the styles."""
    heads = "| | slide in contact m/s | largest acceleration, of the recorded | bones off mm |"
    lines = [heads, "|---" * 4 + "|"]
    for name, found in looks.items():
        parts = found.skate, found.acceleration / recorded
        cells = [f"{np.median(part):.3f}, at most {part.max():.3f}" for part in parts]
        lines.append(f"| {name} | {cells[0]} | {cells[1]} | at most {found.bones.max():.1f} |")
    return "\n".join(lines)


def effect(values: Float[ndarray, " cases"], seed: int = 0) -> tuple[float, float, float]:
    """Mean over styles or pairs, and the interval when they are drawn again."""
    return mean_with_interval(values[None], np.random.default_rng(seed))


def triples(styles: Sequence[str], most: int = 7, seed: int = 0) -> list[tuple[str, str, str]]:
    """Threes of styles without one twice, drawn by chance; one of repeated styles where there are fewer than three."""
    drawn = [styles[int(k)] for k in np.random.default_rng(seed).permutation(len(styles))]
    found = [(drawn[k], drawn[k + 1], drawn[k + 2]) for k in range(0, len(drawn) - 2, 3)]
    return found[:most] or [(drawn[0], drawn[-1], drawn[0])]


@dataclass(frozen=True)
class Found:
    """What the notebook measured, for its claims."""

    dataset: str
    recorded: Float[ndarray, " styles"]
    looks: Mapping[str, Looks]
    pure: Arms
    half: Arms
    more_wrong: tuple[float, float, float]
    mixing: Float[ndarray, "triples 3"]
    costs: Mapping[str, float]
    wanted: Float[ndarray, " styles"]
    led: Float[ndarray, " styles"]
    endured: Sequence[Endurance]
    alone: Sequence[Endurance]
    recognised: float
    walkers: int
    one_clip: bool
    released: bool


def record(recorder: Recorder, found: Found) -> None:
    """The claims of [M22] 4.4 and Figure 1 and of our own that this notebook can judge."""
    recorder.claim("m22-demo-trajectory-blend", verdict="reproduced", value=True)
    note = "judged by eye, with the authors' network" if found.released else ""
    verdict, dataset = ("reproduced", "100style") if found.released else (OTHER, None)
    many = found.walkers
    recorder.claim("m22-fig1-many-styles", verdict=verdict, value=many, n=many, note=note, dataset=dataset)
    _record_finishing(recorder, found)
    _record_mixing(recorder, found)
    _record_codes(recorder, found)
    near = np.abs(found.led / found.wanted - 1) <= NEAR
    off = f"the farthest off goes at {np.abs(found.led / found.wanted - 1).max():.0%} more or less than asked"
    recorder.claim("ours-play-speeds", value=float(near.mean()), n=len(near), note=off)
    held = sum(not e.broken for e in found.endured)
    recorder.claim("ours-play-endurance", value=held / len(found.endured), n=len(found.endured), note=_broken(found))
    chance = f"one in {len(found.wanted)} by chance"
    recorder.claim("ours-play-crowd-recognised", value=found.recognised, n=len(found.wanted), note=chance)


def _record_finishing(recorder: Recorder, found: Found) -> None:
    skate = {name: looks.skate for name, looks in found.looks.items()}
    value, low, high = effect(skate["raw"] - skate["finished"])
    better = low > 0 and (skate["scrambled"] > skate["raw"]).mean() > 0.5
    note = f"slide falls by {value:.3f} m/s [{low:.3f}, {high:.3f}] over {len(found.recorded)} styles, to "
    note += f"{np.median(skate['finished']):.4f}; feet held at wrong times slide {np.median(skate['scrambled']):.2f}"
    verdict = OTHER if better else "differs"
    recorder.claim("m22-demo-foot-ik", verdict=verdict, value=float(np.median(skate["finished"])), note=note)
    value, low, high = found.more_wrong
    share = [100 * float(part.mean()) for part in (found.pure.wrong, found.half.wrong, found.half.wrong_led)]
    note = f"a hand over 5 cm off in {share[1]:.1f} % of frames of interpolated styles by rotations alone, in "
    note += f"{share[0]:.1f} % of pure ones (difference {100 * value:.1f} [{100 * low:.1f}, {100 * high:.1f}]), "
    note += f"and in {share[2]:.1f} % with led arms"
    mended = low > 0 and share[2] < 0.2 * share[1]
    recorder.claim("m22-demo-arm-ik", verdict=OTHER if mended else "differs", value=share[1:], note=note)
    finished = found.looks["finished"]
    jerks, costs = finished.acceleration / found.recorded, found.costs
    median = f"{np.median(finished.skate):.4f} m/s in the median"
    recorder.claim("ours-play-skate", value=float(finished.skate.max()), n=len(jerks), note=median)
    most = f"at most {jerks.max():.2f} times the recorded"
    recorder.claim("ours-play-pops", value=float(np.median(jerks)), n=len(jerks), note=most)
    before = f"{found.looks['raw'].bones.max():.0f} mm before"
    recorder.claim("ours-play-bones", value=float(finished.bones.max()), note=before)
    parts = f"{costs['finishing']:.2f} ms beside {costs['network']:.2f} ms of the network"
    recorder.claim("ours-play-finishing-cost", value=costs["finishing"] / costs["network"], note=parts)


def _record_mixing(recorder: Recorder, found: Found) -> None:
    changing, held, jumping = np.log(found.mixing).T
    (value, _, high), (null, low, _) = (np.exp(effect(part)) for part in (changing - held, jumping - changing))
    smooth = bool(high <= JOLT and low > 1)
    note = f"largest acceleration {value:.2f} times that of held mixtures (at most {high:.2f}); where the mixture "
    note += f"jumps {null:.2f} times as much again (at least {low:.2f}); {len(held)} triangles"
    recorder.claim("m22-demo-three-styles", verdict="reproduced" if smooth else "differs", value=smooth, note=note)


def _record_codes(recorder: Recorder, found: Found) -> None:
    held, seconds = sum(not e.broken for e in found.alone), max(e.after for e in found.alone)
    verdict = OTHER if held >= MOST * len(found.alone) else "differs"
    source = "the code of one clip" if found.one_clip else "a stored mean of clips"
    note = f"{held} of {len(found.alone)} styles stay plausible for {seconds:.0f} s from {source} of {found.dataset}"
    stored = {"verdict": verdict, "value": held, "n": len(found.alone), "note": note}
    recorder.claim("m22-demo-precomputed-code", **stored)
    if found.one_clip:
        recorder.claim("m22-arbitrary-length", **stored)
    else:
        recorder.not_testable("m22-arbitrary-length", "the style network, which the weights kept here leave out")


def _broken(found: Found) -> str:
    broken = [f"{e.style} {e.broken} after {e.after:.0f} s" for e in found.endured if e.broken]
    return "; ".join(broken) or f"none broke in {found.endured[0].after:.0f} s"
