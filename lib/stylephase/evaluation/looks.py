"""What one sees of a character: feet that slide, jerks, bones, and where its hands come to.

Each has a null that must fail it: feet that are held at the wrong times, a lock without softness, a mixture that jumps.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from torch import Tensor

from stylephase.data.catalogue import cut_frames, load_clip, usable
from stylephase.evaluation.interpolation import Pair, blended_codes, blended_gains
from stylephase.evaluation.motion import foot_skate
from stylephase.evaluation.rollouts import SETTLE
from stylephase.features.body import Body
from stylephase.features.clips import WALKS
from stylephase.features.layout import FPS
from stylephase.features.store import VectorStore
from stylephase.models.bundle import Bundle
from stylephase.motion.clip import forward_kinematics
from stylephase.runtime.calibration import speed_of
from stylephase.runtime.controller import State
from stylephase.runtime.finish import finish
from stylephase.runtime.foot_lock import LockSettings
from stylephase.runtime.mixtures import CORNERS, around
from stylephase.runtime.pace import at_pace
from stylephase.runtime.plans import Steady
from stylephase.runtime.player import Player
from stylephase.runtime.rig import rig_of
from stylephase.runtime.rollout import Rollout, as_rollout, roll_out
from stylephase.runtime.walkers import NetworkWalker

_CONTACT = 0.5
# Captures at 30 frames a second have no faster changes, so accelerations are told over this many frames of 60.
_STRIDE = 2
# A lock that stops and lets go at once.
SUDDEN = LockSettings(stopping=1e-3, returning=1e-3)
# A hand this far from its place (m) is in the wrong place.
_MISPLACED = 0.05
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


def mixing_accelerations(player: Player, seconds: float = 12.0) -> dict[str, float]:
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
