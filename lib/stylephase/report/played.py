"""What the notebook of the played character measures and shows."""

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy import ndarray
from torch import Tensor

from stylephase.evaluation import character
from stylephase.evaluation.character import Arms, Blend, Going, Looks
from stylephase.evaluation.comparison import mean_with_interval
from stylephase.evaluation.robustness import Endurance, endure
from stylephase.evaluation.rollouts import start_of
from stylephase.evaluation.style import StyleSpace
from stylephase.features.body import Body
from stylephase.features.layout import FPS
from stylephase.features.store import StyleVectors
from stylephase.models.bundle import Bundle, load_bundle
from stylephase.models.released import BROKEN
from stylephase.report import palette, plots
from stylephase.report.recorder import Recorder
from stylephase.report.render.motion import Motion
from stylephase.report.walks import walking_motion
from stylephase.runtime.controller import RELEASE, ControllerSettings, State
from stylephase.runtime.graph import FastNetwork, to_onnx
from stylephase.runtime.keyboard import KeySettings, at_rest, steer_by_keys
from stylephase.runtime.mixtures import around
from stylephase.runtime.pace import at_pace
from stylephase.runtime.plans import OnPath, heading
from stylephase.runtime.player import Player
from stylephase.runtime.rollout import Rollout, as_rollout
from stylephase.runtime.speeds import SpeedCurve, speed_curves
from stylephase.runtime.trajectory import Steering
from stylephase.runtime.viewer.frames import frame_numbers
from stylephase.runtime.viewer.widget import RECORDED_FPS
from stylephase.runtime.walkers import NetworkWalker, drive
from stylephase.training.codes import clip_codes
from stylephase.training.sampler import Scaling

_CROWD_SECONDS, _RECOGNISED_SECONDS = 8.0, 20.0
# Where styles are dealt anew, at most this share is nearest to its own.
_FEW = 0.1
# A speed within this share of the wanted one is reached; most is this share of the styles; a jolt is this many times
# the largest acceleration without.
NEAR, MOST, JOLT = 0.1, 0.8, 1.5
# A way within this angle (rad) of the wanted one is taken.
ANGLE = np.radians(15)
# Gain of the release's documented set-up ([M22] release 5.2).
_RELEASE_GAIN = 6.0
# Noise on all weights, against their own deviation.
_SHAKE = 2.0
# Length (m) of the stroke that says where a character faces.
_STROKE = 0.6


def speed_table(styles: Sequence[str], wanted: ndarray, gains: ndarray, reached: ndarray) -> str:
    """A Markdown table of speeds."""
    lines = ["| style | wanted m/s | gain | reached m/s | off % |", "|---" * 5 + "|"]
    for style, w, g, r in zip(styles, wanted, gains, reached, strict=True):
        lines.append(f"| {style} | {w:.2f} | {g:.2f} | {r:.2f} | {100 * (r / w - 1):+.0f} |")
    return "\n".join(lines)


# Keys that are held, and for how many seconds.
Script = Sequence[tuple[str | list[str], float | int]]


def scripted(player: Player, script: Script) -> list[State]:
    """States while keys are held, each group for some seconds."""
    states = []
    for keys, seconds in script:
        player.hold(list(keys))
        states += [player.step() for _ in range(int(seconds * FPS))]
    player.hold(())
    return states


def held_at_each(script: Script) -> list[str]:
    """What is held in each frame of `scripted`, as one writes it: `Shift W`, and `no key`."""
    words = [" ".join(key.title() for key in sorted(keys, key=len, reverse=True)) or "no key" for keys, _ in script]
    return [word for word, (_, seconds) in zip(words, script, strict=True) for _ in range(int(seconds * FPS))]


def track_plot(states: Sequence[State], held: Sequence[str]) -> Axes:
    """The way from above, one colour for what is held, and every half second a stroke as the character faces."""
    run = as_rollout(states)
    places, angles = run.root_positions[:, 0], run.root_angles[:, 0]
    changes = [0, *(k for k in range(1, len(held)) if held[k] != held[k - 1]), len(held)]
    with plots.style():
        axes = Figure(figsize=(7.2, 3.2)).subplots()
        for k, (first, last) in enumerate(pairwise(changes)):
            colour = palette.SEQUENCE[k % len(palette.SEQUENCE)]
            part = places[first : last + 1]
            # Ahead is to the right, so that a long way fits; the character's left is then above.
            axes.plot(part[:, 1], part[:, 0], color=colour, linewidth=2.4, label=held[first])
            at = slice(first, last, int(FPS / 2))
            ends = places[at] + _STROKE * heading(angles[at])
            axes.plot(places[at, 1], places[at, 0], "o", color=colour, markersize=4)
            axes.plot(*np.stack([places[at], ends])[..., ::-1].transpose(2, 0, 1), color=palette.INK, linewidth=0.9)
        axes.plot(*places[0, ::-1], "o", color=palette.INK, markersize=6, label="start")
        axes.set(xlabel="ahead (m)", ylabel="to the left (m)")
        axes.set_aspect("equal")
        axes.legend(loc="upper left", bbox_to_anchor=(1.02, 1))
    return axes


def round_trip(player: Player, styles: Sequence[str], seconds: float) -> list[State]:
    """States of a walk ahead while the mixture goes round the triangle once, corner by corner."""
    player.choose(styles)
    player.hold("w")
    states, frames = [], int(seconds * FPS)
    for frame in range(frames):
        player.mix(around(3 * frame / frames))
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


def one_clip_codes(bundle: Bundle, styles: Sequence[StyleVectors]) -> Float[Tensor, "styles values"]:
    """The code of one training clip of each style, by weights that make codes."""
    generator = bundle.network.generator
    assert generator is not None and bundle.makes_codes
    scaling = Scaling(bundle.normaliser, bundle.body.layout)
    return torch.cat([clip_codes(generator, style, scaling, most=1) for style in styles])


def shaken(bundle: Bundle, seed: int = 0) -> Bundle:
    """The same network with noise on its weights: what a check must find broken."""
    network, generator = copy.deepcopy(bundle.network), torch.Generator().manual_seed(seed)
    with torch.no_grad():
        for weight in network.synthesis.parameters():
            weight += _SHAKE * weight.std(correction=0) * torch.randn(weight.shape, generator=generator)
    return replace(bundle, network=network)


@dataclass(frozen=True)
class Recognised:
    """Of `count` characters, who are nearest to walks of their own style; `dealt` with each other's codes."""

    right: int
    dealt: int
    count: int

    @property
    def most(self) -> bool:
        """Whether most are, and few with each other's codes."""
        return self.right >= MOST * self.count and self.dealt <= _FEW * self.count


def _recognised(run: Rollout, anew: Rollout, styles: Sequence[str], space: StyleSpace, counted: set[str]) -> Recognised:
    """Who is nearest to their own style in a walk, and in one with each other's codes; only some styles count."""
    right, dealt = (
        sum(a == b for a, b in zip(character.nearest_styles(each, space), styles, strict=True) if b in counted)
        for each in (run, anew)
    )
    return Recognised(right, dealt, len(counted))


@dataclass(frozen=True)
class Crowd(Recognised):
    """A crowd held against other walks of its own, with a second of walking of each style that stays finite."""

    motions: Sequence[Motion]


def crowd_of(
    bundle: Bundle,
    start: State,
    *,
    gains: Float[ndarray, " characters"],
    how: ControllerSettings | None = None,
    uncounted: Sequence[str] = (),
) -> Crowd:
    """All styles side by side, each on random ways of its own; two other walks of each say what its style is like.

    Styles that are `uncounted` are shown, and count neither as recognised nor as not.
    """
    codes, counted = torch.stack([bundle.code(style) for style in bundle.styles]), set(bundle.styles) - set(uncounted)
    walked = partial(character.crowd, bundle, start=start, gains=gains, seconds=_CROWD_SECONDS, settings=how)
    space = character.crowd_space([walked(codes, seed=seed) for seed in (1, 2)], bundle.styles)
    run, anew = (walked(given, seed=0) for given in (codes, character.dealt_anew(codes)))
    motions = [walking_motion(run, k, bundle.body, style) for k, style in enumerate(bundle.styles) if run.finite[k]]
    seconds = [motion.frames(len(motion) - int(FPS), len(motion)) for motion in motions]
    seen = _recognised(run, anew, bundle.styles, space, counted)
    return Crowd(seen.right, seen.dealt, seen.count, motions=seconds)


def released_crowd(bundle: Bundle) -> Crowd:
    """The same of the authors' weights, at their gain and settings; whose code is broken does not count."""
    codes = torch.stack([bundle.code(style) for style in bundle.styles])
    gains = np.full(len(codes), _RELEASE_GAIN)
    return crowd_of(bundle, NetworkWalker(bundle).start(codes), gains=gains, how=RELEASE, uncounted=BROKEN)


def with_style_network(runs: Path, name: str) -> Bundle | None:
    """The first whole run of a name in the folder of runs whose weights make codes of clips."""
    whole = (load_bundle(path.parent) for path in sorted(runs.glob(f"{name}-seed*/model.json")))
    return next((bundle for bundle in whole if bundle.makes_codes), None)


def recognised(
    bundle: Bundle,
    codes: Float[Tensor, "styles values"],
    start: State,
    gains: Float[ndarray, " styles"],
    space: StyleSpace,
) -> Recognised:
    """All styles on random ways of their own, each held against recorded walks of all styles."""
    run, anew = (
        character.crowd(bundle, given, start, gains, _RECOGNISED_SECONDS)
        for given in (codes, character.dealt_anew(codes))
    )
    return _recognised(run, anew, bundle.styles, space, set(bundle.styles))


@dataclass(frozen=True)
class FromOneClip:
    """What became of each style from one clip of it, who was recognised, and whose network it was."""

    endured: Sequence[Endurance]
    recognised: Recognised
    weights: str


def endure_from_one_clip(
    bundle: Bundle,
    styles: Sequence[StyleVectors],
    speeds: Float[ndarray, " styles"],
    seconds: float,
    space: StyleSpace,
) -> FromOneClip:
    """Random input for some seconds, in each style with the code of one training clip, at the speeds of the data."""
    codes, start = one_clip_codes(bundle, styles), start_of(styles, bundle.body)
    curves = [curve for curve in speed_curves(bundle, bundle.styles, start, grounded=True).values()]
    gains = np.array([curve.gain(speed) for curve, speed in zip(curves, speeds, strict=True)])
    fast = FastNetwork(to_onnx(bundle))
    found = endure(bundle, bundle.styles, codes, start, gains, seconds, curves=curves, fast=fast)
    weights = f"{bundle.model}, preset {bundle.about.get('preset')}, {bundle.about.get('steps')} steps"
    return FromOneClip(found, recognised(bundle, codes, start, gains, space), weights)


def looks_table(looks: Mapping[str, Looks], recorded: Float[ndarray, " styles"]) -> str:
    """A Markdown table of what is seen of each way of finishing: median and most over the styles."""
    heads = "| | slide in contact m/s | largest acceleration, of the recorded | bones off mm |"
    lines = [heads, "|---" * 4 + "|"]
    for name, found in looks.items():
        parts = found.skate, found.acceleration / recorded
        cells = [f"{np.median(part):.3f}, at most {part.max():.3f}" for part in parts]
        lines.append(f"| {name} | {cells[0]} | {cells[1]} | at most {found.bones.max():.1f} |")
    return "\n".join(lines)


def reached_by_gait(gaits: Sequence[str], ratios: Float[ndarray, " speeds"]) -> dict[str, tuple[int, int]]:
    """Of each gait, how many speeds are reached within NEAR, and how many there are; ratios are reached over wanted."""
    near, names = np.abs(ratios - 1) <= NEAR, np.array(gaits)
    return {gait: (int(near[names == gait].sum()), int((names == gait).sum())) for gait in dict.fromkeys(gaits)}


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
    cases = [(style.style, gait, how) for style in styles for gait, how in character.aside(style).items()]
    if not cases:
        return []
    codes = torch.stack([bundle.code(style) for style, *_ in cases])
    data = [how for *_, how in cases]
    gains = np.array([curves[style].gain(how.speed) for style, _, how in cases])
    start = NetworkWalker(bundle).start(codes)
    ours, ahead = (
        character.reached_goings(bundle, codes, start, gains, asked)
        for asked in (data, [replace(how, angle=0.0) for how in data])
    )
    return [Aside(*case, *found) for case, *found in zip(cases, ours, ahead, strict=True)]


def aside_table(found: Sequence[Aside]) -> str:
    """A Markdown table, a row for each gait: medians over styles of angles (degrees to the left) and speeds (m/s)."""
    lines = ["| gait | takes | ours | led ahead | as the takes go |", "|---" * 5 + "|"]
    for gait in dict.fromkeys(one.gait for one in found):
        rows = [one for one in found if one.gait == gait]
        cells = [_median([getattr(one, part) for one in rows]) for part in ("data", "ours", "ahead")]
        lines.append(f"| {gait} | {' | '.join(cells)} | {sum(one.reached for one in rows)} of {len(rows)} |")
    return "\n".join(lines)


def _median(goings: Sequence[Going]) -> str:
    angle = np.degrees(np.median([abs(how.angle) for how in goings]))
    return f"{angle:.0f}° aside at {np.median([how.speed for how in goings]):.2f} m/s"


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
    """What the notebook measured, for its claims; `gaits` are speeds that were reached, and all, by gait."""

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
    gaits: Mapping[str, tuple[int, int]]
    aside: Sequence[Aside]
    endured: Sequence[Endurance]
    alone: Sequence[Endurance]
    one_clip: FromOneClip | None
    blend: Blend
    recognised: Recognised
    crowd: Crowd
    released: bool
    seconds: float


def record(recorder: Recorder, found: Found) -> None:
    """The claims of [M22] 4.4 and Figure 1 and of our own that this notebook can judge."""
    _record_blend(recorder, found.blend)
    _record_crowd(recorder, found)
    _record_finishing(recorder, found)
    _record_mixing(recorder, found)
    _record_codes(recorder, found)
    near = np.abs(found.led / found.wanted - 1) <= NEAR
    off = f"the farthest off goes at {np.abs(found.led / found.wanted - 1).max():.0%} more or less than asked"
    recorder.claim("ours-play-speeds", value=float(near.mean()), n=len(near), note=off)
    note = ", ".join(f"{gait} {reached} of {count}" for gait, (reached, count) in found.gaits.items())
    reached, count = np.sum(list(found.gaits.values()), axis=0).tolist()
    recorder.claim("ours-play-gaits", value=reached / count, n=count, note=note)
    _record_aside(recorder, found.aside)
    held = sum(not e.broken for e in found.endured)
    note = f"for {found.seconds:g} s each; {_broken(found)}"
    recorder.claim("ours-play-endurance", value=held / len(found.endured), n=len(found.endured), note=note)
    seen = found.recognised
    note = f"{seen.right} of {seen.count}, {seen.dealt} with each other's codes"
    recorder.claim("ours-play-crowd-recognised", value=seen.right / seen.count, n=seen.count, note=note)


def _record_aside(recorder: Recorder, aside: Sequence[Aside]) -> None:
    if not aside:
        recorder.not_testable("ours-play-aside", "takes that go aside or backward")
        return
    share, ahead = (float(np.mean([getattr(one, part) for one in aside])) for part in ("reached", "by_chance"))
    note = f"led straight ahead {ahead:.2f}; an angle within {np.degrees(ANGLE):.0f} degrees, a speed within 10 %"
    recorder.claim("ours-play-aside", value=share, n=len(aside), note=note)


def _record_blend(recorder: Recorder, blend: Blend) -> None:
    user, network = ([round(float(part[at]), 3) for at in (0, -1)] for part in (blend.user, blend.network))
    note = f"share of the wish {user[0]:.2f} at the next point and {user[1]:.2f} at the last, of the network's path "
    note += f"{network[0]:.2f} and {network[1]:.2f}; turns of 90 degrees end {blend.turned.mean():.0f} degrees off, "
    note += f"with the wish left out {blend.unheard.mean():.0f}"
    recorder.claim("m22-demo-trajectory-blend", blend.blended, note, value=user, n=len(blend.turned))


def _record_crowd(recorder: Recorder, found: Found) -> None:
    crowd = found.crowd
    whose = "the authors' network" if found.released else "our network"
    note = f"of {crowd.count} styles of {whose} {crowd.right} are told apart: nearest to other walks of their own, "
    note += f"{crowd.dealt} where styles are dealt anew; not held against recorded walks"
    dataset = "100style" if found.released else None
    recorder.claim("m22-fig1-many-styles", crowd.most, note, value=crowd.right, n=crowd.count, dataset=dataset)


def _record_finishing(recorder: Recorder, found: Found) -> None:
    skate = {name: looks.skate for name, looks in found.looks.items()}
    value, low, high = effect(skate["grounded"] - skate["finished"])
    better = low > 0 and (skate["scrambled"] > skate["raw"]).mean() > 0.5
    note = f"holding feet lessens the slide by {value:.3f} m/s [{low:.3f}, {high:.3f}] over {len(found.recorded)} "
    note += f"styles, from {np.median(skate['grounded']):.3f} grounded ({np.median(skate['raw']):.3f} raw) to "
    note += f"{np.median(skate['finished']):.4f}; feet held at wrong times slide {np.median(skate['scrambled']):.2f}"
    recorder.claim("m22-demo-foot-ik", bool(better), note, value=float(np.median(skate["finished"])))
    value, low, high = found.more_wrong
    share = [100 * float(part.mean()) for part in (found.pure.wrong, found.half.wrong, found.half.wrong_led)]
    note = f"a hand over 5 cm off in {share[1]:.1f} % of frames of interpolated styles by rotations alone, in "
    note += f"{share[0]:.1f} % of pure ones (difference {100 * value:.1f} [{100 * low:.1f}, {100 * high:.1f}]), "
    note += f"and in {share[2]:.1f} % with led arms"
    mended = low > 0 and share[2] < 0.2 * share[1]
    recorder.claim("m22-demo-arm-ik", mended, note, value=share[1:])
    finished = found.looks["finished"]
    jerks, costs = finished.acceleration / found.recorded, found.costs
    median = f"{np.median(finished.skate):.4f} m/s in the median"
    recorder.claim("ours-play-skate", value=float(finished.skate.max()), n=len(jerks), note=median)
    median = f"{np.median(jerks):.2f} times the recorded in the median"
    recorder.claim("ours-play-pops", value=float(jerks.max()), n=len(jerks), note=median)
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
    recorder.claim("m22-demo-three-styles", smooth, note, value=smooth)


def _record_codes(recorder: Recorder, found: Found) -> None:
    ways = {"a stored mean of clips": (found.alone, found.recognised)}
    if found.one_clip is not None:
        name = f"the code of one clip ({found.one_clip.weights})"
        ways |= {name: (found.one_clip.endured, found.one_clip.recognised)}
    kept = [sum(not e.broken for e in endured) for endured, _ in ways.values()]
    n, notes = len(found.alone), []
    for held, (way, (endured, seen)) in zip(kept, ways.items(), strict=True):
        after = max(e.after for e in endured)
        note = f"from {way} {seen.right} of {n} styles are nearest to their own, {seen.dealt} with each other's codes"
        notes.append(f"{note}; {held} stay plausible for {after:.0f} s")
    good = all(held >= MOST * n and seen.most for held, (_, seen) in zip(kept, ways.values(), strict=True))
    recorder.claim("m22-demo-precomputed-code", good, "; ".join(notes), value=kept, n=n)
    if found.one_clip is None:
        recorder.not_testable("m22-arbitrary-length", "the style network, which the weights kept here leave out")
        return
    # Motion of any length: whoever breaks speaks against it.
    recorder.claim("m22-arbitrary-length", kept[-1] == n, notes[-1], value=kept[-1], n=n)


def _broken(found: Found) -> str:
    broken = [f"{e.style} {e.broken} after {e.after:.0f} s" for e in found.endured if e.broken]
    return "; ".join(broken) or "none broke"
