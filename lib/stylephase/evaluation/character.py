"""What a driven character is like: feet, bones, jerks, hands, speeds, changes of style, recognition in a crowd.

Each measure has a null that must fail it: feet that are held at the wrong times, a lock without softness, gains in
place of speeds, a mixture that jumps, a crowd whose styles are dealt anew.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray
from torch import Tensor

from stylephase.data.catalogue import cut_frames, load_clip, usable
from stylephase.evaluation.bench.rows import interleaved, threads
from stylephase.evaluation.interpolation import Pair, blended_codes, blended_gains
from stylephase.evaluation.motion import foot_skate, heading_error
from stylephase.evaluation.robustness import random_paths
from stylephase.evaluation.rollouts import SETTLE, local_poses
from stylephase.evaluation.style import StyleSpace, space_of, statistics
from stylephase.features.body import Body
from stylephase.features.clips import WALKS
from stylephase.features.layout import FPS, INPUT_SAMPLES, OUTPUT_SAMPLES
from stylephase.features.store import StyleVectors, VectorStore
from stylephase.models.bundle import Bundle
from stylephase.motion.clip import forward_kinematics
from stylephase.runtime.calibration import speed_of
from stylephase.runtime.controller import Controller, ControllerSettings, Predict, State, input_of
from stylephase.runtime.finish import finish
from stylephase.runtime.finishing import Finisher, Finishing
from stylephase.runtime.foot_lock import LockSettings
from stylephase.runtime.mixtures import CORNERS, around
from stylephase.runtime.pace import Pace, at_pace
from stylephase.runtime.paths import FollowPaths
from stylephase.runtime.plans import OnPath, Plan, Steady, TurnOnce, heading
from stylephase.runtime.player import BLEND, Player
from stylephase.runtime.rig import rig_of
from stylephase.runtime.rollout import Rollout, as_rollout, roll_out
from stylephase.runtime.trajectory import PAST, Steering
from stylephase.runtime.walkers import NetworkWalker, drive
from stylephase.runtime.ways import way_of

_CONTACT = 0.5
# Captures at 30 frames a second have no faster changes, so accelerations are told over this many frames of 60.
_STRIDE = 2
# A lock that stops and lets go at once.
SUDDEN = LockSettings(stopping=1e-3, returning=1e-3)
# The way of about a second, by samples of the trajectory; who goes this straight ahead walks forward.
_BEFORE, _AFTER, _AHEAD = -30, 24, 0.9
# A hand this far from its place (m) is in the wrong place.
_MISPLACED = 0.05
# Clips (frames) by which a crowd is told apart where there are no data.
_CLIP = int(1.5 * FPS)
# From so far on a way is aside (rad).
ASIDE = np.radians(10)
# Points of the triangle at which a mixture is held: corners, middles of the sides.
_HELD = np.concatenate([CORNERS, (CORNERS + np.roll(CORNERS, -1, axis=0)) / 2])


@dataclass(frozen=True)
class Looks:
    """What one sees of some characters.

    Mean slide of the feet while in contact (m/s), largest acceleration of any joint (m/s2), largest distance of a bone
    from its true length (mm), speed (m/s).
    """

    skate: Float[ndarray, " characters"]
    acceleration: Float[ndarray, " characters"]
    bones: Float[ndarray, " characters"]
    speed: Float[ndarray, " characters"]


def looks_of(run: Rollout, body: Body, settle: int = SETTLE) -> Looks:
    """The looks after the settling frames."""
    rig, who = rig_of(body), range(run.positions.shape[1])
    toes, true = [leg.tip for leg in rig.legs], np.linalg.norm(rig.offsets[1:], axis=-1)
    p, contacts = run.positions[settle:], run.contacts[settle:] > _CONTACT
    lengths = np.linalg.norm(p[:, :, 1:] - p[:, :, list(rig.parents[1:])], axis=-1)
    return Looks(
        np.array([foot_skate(p[:, k][:, toes], contacts[:, k]) for k in who]),
        np.array([largest_acceleration(p[:, k]) for k in who]),
        1000 * np.abs(lengths - true).max(axis=(0, 2)),
        np.array([speed_of(run.root_positions[settle:, k]) for k in who]),
    )


def largest_acceleration(positions: Float[ndarray, "frames joints 3"], stride: int = _STRIDE) -> float:
    """Largest acceleration (m/s2) of any joint, told over so many frames to either side."""
    turned = positions[2 * stride :] - 2 * positions[stride:-stride] + positions[: -2 * stride]
    return float(np.linalg.norm(turned, axis=-1).max() * (FPS / stride) ** 2)


def recorded_accelerations(store: VectorStore, styles: Sequence[str], seconds: float) -> Float[ndarray, " styles"]:
    """Largest acceleration (m/s2) in about so many seconds of recorded forward walks of each style.

    Faster gaits, which are rougher, do not fill up what walks leave; a style without walks gives what it has.
    """
    return np.array([_recorded_acceleration(store, style, seconds) for style in styles])


def _recorded_acceleration(store: VectorStore, style: str, seconds: float) -> float:
    catalogue, body, left, found = store.catalogue, store.body, int(seconds * FPS), [0.0]
    takes = catalogue.of(style)
    for entry in [take for take in takes if take.gait in WALKS] or takes:
        clip = load_clip(entry, catalogue.dataset, fps=FPS, skeleton=body.skeleton)
        start, stop = cut_frames(entry, catalogue.dataset, clip)
        if not usable(stop - start):
            continue
        clip = clip.frames(start, min(stop, start + left))
        found += [largest_acceleration(forward_kinematics(clip).positions[:, list(body.joints)])]
        left -= len(clip)
        if left <= 2 * _STRIDE:
            break
    return max(found)


def ways_of_finishing(
    bundle: Bundle,
    codes: Float[Tensor, "characters values"],
    start: State,
    gains: Float[ndarray, " characters"],
    wanted: Float[ndarray, " characters"],
    seconds: float,
) -> dict[str, Rollout]:
    """The same straight walks raw, grounded, and finished, and with two locks that are wrong.

    `scrambled` holds each foot while the other one stands, `sudden` has no softness. The contacts are the network's.
    """
    frames, rig = int(seconds * FPS), rig_of(bundle.body)

    def walked(*, grounded: bool) -> Rollout:
        plan = at_pace(Steady(gains), wanted)
        return roll_out(bundle, codes, start, frames, plan, grounded=grounded)

    raw, grounded = walked(grounded=False), walked(grounded=True)
    swapped = finish(replace(grounded, contacts=grounded.contacts[..., ::-1]), rig)
    return {
        "raw": raw,
        "grounded": grounded,
        "finished": finish(grounded, rig),
        "scrambled": replace(swapped, contacts=grounded.contacts),
        "sudden": finish(grounded, rig, SUDDEN),
    }


@dataclass(frozen=True)
class Arms:
    """Where hands come to by the predicted rotations alone, and with arms that are led, against where predicted.

    Mean distances (m) of each character's hands, and the share of frames in which one is in the wrong place.
    """

    by_rotations: Float[ndarray, " characters"]
    led: Float[ndarray, " characters"]
    wrong: Float[ndarray, " characters"]
    wrong_led: Float[ndarray, " characters"]


def arms_of(run: Rollout, body: Body, settle: int = SETTLE) -> Arms:
    """Both distances in an unfinished rollout."""
    rig = rig_of(body)
    hands = [arm.tip for arm in rig.arms]
    p, rotations = run.positions[settle:], run.rotations[settle:]
    turned, led = rig.place(p[:, :, 0], rotations), finish(run, rig).positions[settle:]
    by_rotations, after = (np.linalg.norm((q - p)[:, :, hands], axis=-1) for q in (turned, led))
    wrong = [(off > _MISPLACED).any(axis=-1).mean(axis=0) for off in (by_rotations, after)]
    return Arms(by_rotations.mean(axis=(0, 2)), after.mean(axis=(0, 2)), *wrong)


def half_way(
    bundle: Bundle,
    gains: Mapping[str, float],
    wanted: Mapping[str, float],
    pairs: Sequence[Pair],
    seconds: float,
) -> Rollout:
    """Grounded walks of the mixtures half-way between the two styles of each pair, begun and led as pure ones are.

    `gains` and `wanted` speeds (m/s) are those of the styles, by name.
    """
    half = np.array([0.5])
    codes = blended_codes(bundle, pairs, half)
    plan = at_pace(Steady(blended_gains(gains, pairs, half)), blended_gains(wanted, pairs, half))
    return roll_out(bundle, codes, NetworkWalker(bundle).start(codes), int(seconds * FPS), plan, grounded=True)


def ring(styles: Sequence[str], seed: int = 0) -> list[Pair]:
    """Pairs in which each style is once the first and once the last, in an order drawn by chance."""
    drawn = [styles[int(k)] for k in np.random.default_rng(seed).permutation(len(styles))]
    return list(zip(drawn, [*drawn[1:], drawn[0]], strict=True))


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


def mixing(player: Player, seconds: float = 12.0) -> dict[str, float]:
    """Largest acceleration (m/s2) of a walk whose mixture goes round the triangle, is held, and jumps, as long each.

    Held at corners and middles of the sides in turn, each after a second that does not count; `jumping` throws the code
    from corner to corner every second at once, as a null.
    """
    frames = int(seconds * FPS)

    def walked(frames: int) -> list[State]:
        return [player.step() for _ in range(frames)]

    player.hold({"w"})
    walked(int(2 * FPS))
    changing, jumping, held = [], [], []
    for frame in range(frames):
        player.mix(around(3 * frame / frames))
        changing += walked(1)
    for point in _HELD:
        player.mix(point)
        walked(int(FPS))
        held += [walked(frames // len(_HELD))]
    for second in range(int(seconds)):
        player.mix(CORNERS[second % 3])
        player.jump_to_mixture()
        jumping += walked(int(FPS))
    player.hold(())
    return {
        "changing": _largest([changing]),
        "held": _largest(held),
        "jumping": _largest([jumping]),
    }


def _largest(parts: Sequence[Sequence[State]]) -> float:
    return max(largest_acceleration(as_rollout(part).positions[:, 0]) for part in parts)


def costs(
    bundle: Bundle,
    code: Float[Tensor, " values"],
    state: State,
    fast: Mapping[str, Predict],
    *,
    rounds: int = 10,
    each: int = 10,
) -> dict[str, float]:
    """Milliseconds of one character's frame on one thread: the controller, what finishing adds, and fast networks."""
    plain, finisher = Controller(bundle, code[None], ControllerSettings()), Finisher(bundle.body, Finishing())
    wish = Steady(np.ones(1))(0, state)
    after = plain.step(state, wish)
    rivals = {"frame": lambda: plain.step(state, wish), "finishing": lambda: finisher(state, after)}
    x, p = input_of(state), state.phases
    rivals |= {"network": lambda: plain.predict(x, p)}
    rivals |= {name: lambda f=f: f(x, p, code[None].numpy()) for name, f in fast.items()}
    with threads(1):
        found = interleaved(rivals, rounds=rounds, each=each)
    return {name: 1000 * seconds for name, seconds in found.items()}


def one_frame(
    bundle: Bundle,
    codes: Float[Tensor, "characters values"],
    start: State,
    gains: Float[ndarray, " characters"],
    *,
    fast: Predict | None = None,
) -> Rollout:
    """A single raw frame after the start, twice, since poses are seen with their velocities."""
    walker = NetworkWalker(bundle, fast=fast)
    after = walker.step(codes, start, Steady(gains)(0, start))
    return as_rollout([start, after])


def difference(run: Rollout, other: Rollout, body: Body) -> float:
    """Mean distance (mm) between the joints of two rollouts as seen from their roots, over all characters.

    Two walks fall out of step in time, so rollouts of a frame or a second are told apart by it.
    """
    size = len(body.joints)
    apart = [
        (local_poses(run, k) - local_poses(other, k)).reshape(-1, size, 12)[..., :3]
        for k in range(run.positions.shape[1])
    ]
    return float(1000 * np.linalg.norm(np.stack(apart), axis=-1).mean())


def crowd(
    bundle: Bundle,
    codes: Float[Tensor, "characters values"],
    start: State,
    gains: Float[ndarray, " characters"],
    seconds: float,
    *,
    settings: ControllerSettings | None = None,
    seed: int = 0,
) -> Rollout:
    """Characters that each follow a random path of their own, side by side, raw, so that styles are the network's."""
    follow = FollowPaths(random_paths(len(codes), seconds, np.random.default_rng(seed)), gains)
    return roll_out(bundle, codes, start, int(seconds * FPS), follow, settings)


def nearest_styles(run: Rollout, space: StyleSpace, settle: int = SETTLE) -> list[str]:
    """The nearest style to each character's walk, among all of the space; empty for one that did not stay finite."""
    walks = [local_poses(run, k)[settle:] if run.finite[k] else None for k in range(len(run.finite))]
    return ["" if walk is None else space.nearest(walk) for walk in walks]


def crowd_space(runs: Sequence[Rollout], styles: Sequence[str], settle: int = SETTLE) -> StyleSpace:
    """The space of the styles of a crowd by its own walks, one character a style in each run, where no data are.

    Clips of a second and a half tell what varies within a style. A style that stays finite in no run has no place.
    """
    groups: dict[str, list[ndarray]] = {style: [] for style in styles}
    for run in runs:
        for k in np.flatnonzero(run.finite):
            poses = local_poses(run, int(k))[settle:]
            cuts = range(0, len(poses) - _CLIP + 1, _CLIP)
            groups[styles[int(k)]] += [statistics(poses[at : at + _CLIP]) for at in cuts]
    return space_of({style: np.array(group) for style, group in groups.items()})


def dealt_anew(codes: Float[Tensor, "characters values"]) -> Float[Tensor, "characters values"]:
    """Each character with the code of the next: the null of a crowd."""
    return torch.roll(codes, 1, dims=0)
