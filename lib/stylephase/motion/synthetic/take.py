"""One take in memory: the clip, and what is true of it."""

import zlib
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray
from scipy.interpolate import PchipInterpolator
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from stylephase.motion.clip import Clip
from stylephase.motion.rotations import from_euler, from_matrix, to_matrix
from stylephase.motion.synthetic import upper
from stylephase.motion.synthetic.body import HIP, REACH, SKELETON, STANDING, solve_leg
from stylephase.motion.synthetic.gait import Falls, Foot, move_foot, plan_falls, raised_foot
from stylephase.motion.synthetic.path import FPS, PAD, Course, Plan, follow, from_facing, plan_gait
from stylephase.motion.synthetic.styles import WalkStyle

SIDES = ("left", "right")
# The hips are lowered ahead of a leg's full reach, over this time (s).
_YIELD = 0.16


@dataclass(frozen=True)
class Truth:
    """What is true of a take, frame by frame at 60 fps.

    `phase` (cycles, [0, 1)) and `frequency` (Hz) of LeftHand, RightHand, LeftFoot, RightFoot. A foot's phase is 0.25
    in the middle of its contact and 0.75 half a cycle later, a hand's is 0.25 where it is furthest forward, so
    sin(2 pi phase) is high in stance and in front; a foot that never touches the floor counts as a hand. Phases
    increase in time and rest while the walker stands. `contacts`: the toe's end site (right, left) is at rest on the
    floor. `global_phase` (rad, [0, 2 pi)): 0 where the right toe comes to rest, pi where the left does; NaN where it
    is not defined, which is standing takes, hops, and before the first and after the last contact of a take.
    `cut`: the frames [start, stop) that show the gait.
    """

    phase: Float[ndarray, "frames 4"]
    frequency: Float[ndarray, "frames 4"]
    contacts: Bool[ndarray, "frames 2"]
    global_phase: Float[ndarray, " frames"]
    cut: tuple[int, int]
    fps: float = FPS


def walk(
    style: WalkStyle, gait: str, *, seconds: float = 15.0, seed: int = 0, plan: Plan | None = None
) -> tuple[Clip, Truth]:
    """One take of `seconds` in a gait of 100STYLE (`FW`, `BR`, `ID`, `TR1` ...), with a short stand on either side.

    With a `plan` the walker follows that instead, and `gait` only names the take. Style, gait and seed decide the
    result. Raises InputError for an unknown gait.
    """
    rng = np.random.default_rng([seed, zlib.crc32(style.name.encode()), zlib.crc32(gait.encode())])
    plan = plan_gait(style, gait, seconds, rng) if plan is None else plan
    course = follow(style, plan)
    falls = {side: plan_falls(style, course, side, rng) for side in SIDES if style.hop in (None, side)}
    rotations, hips = _body(style, course, falls, rng)
    kept = slice(PAD, len(hips) - PAD)
    clip = Clip(SKELETON, FPS, rotations[kept], hips[kept], f"{style.name}_{gait}")
    return clip, _truth(style, course, falls, plan.cut)


def _body(
    style: WalkStyle, course: Course, falls: dict[str, Falls], rng: np.random.Generator
) -> tuple[Float[ndarray, "frames joints 4"], Float[ndarray, "frames 3"]]:
    """Local rotations of all joints and the hips' path."""
    angles = upper.trunk(style, course, rng)
    left, bob = upper.hips_shift(style, course, rng)
    angles["Hips"] = angles["Hips"] + np.stack([course.facing, *np.zeros((2, len(left)))], axis=1)
    local = {name: from_euler("YXZ", np.degrees(value)) for name, value in angles.items()}
    local |= upper.arms(style, course, upper.hand_phases(style, course), rng)
    turned = to_matrix(local["Hips"])
    # A trunk that leans forward puts the hips behind the feet.
    back = np.full(len(left), -0.12 * np.sin(style.lean))
    flat = course.position + from_facing(course.facing, np.stack([back, left], axis=1))
    hips = np.stack([flat[:, 0], STANDING - style.crouch - 0.008 + bob, flat[:, 1]], axis=1)
    feet = {side: move_foot(fall, course.clock) for side, fall in falls.items()}
    hips[:, 1] -= _drop(hips, turned, feet)
    for side in SIDES:
        foot = feet[side] if side in feet else raised_foot(style, course, hips, side)
        local |= _leg(side, hips, turned, foot)
    still = np.tile([1.0, 0.0, 0.0, 0.0], (len(left), 1))
    return np.stack([local.get(name, still) for name in SKELETON.names], axis=1), hips


def _hip(
    hips: Float[ndarray, "frames 3"], turned: Float[ndarray, "frames 3 3"], side: str
) -> Float[ndarray, "frames 3"]:
    return hips + turned @ (HIP * ([1, 1, 1] if side == "left" else [-1, 1, 1]))


def _drop(
    hips: Float[ndarray, "frames 3"], turned: Float[ndarray, "frames 3 3"], feet: dict[str, Foot]
) -> Float[ndarray, " frames"]:
    """How far the hips must sink for both legs to reach their feet: a smooth curve never below the need."""
    need = np.zeros(len(hips))
    for side, foot in feet.items():
        gap = _hip(hips, turned, side) - foot.ankle
        level = np.minimum(np.linalg.norm(gap[:, [0, 2]], axis=1), 0.95 * REACH)
        need = np.maximum(need, gap[:, 1] - np.sqrt(REACH**2 - level**2))
    half = round(_YIELD * FPS)
    return gaussian_filter1d(maximum_filter1d(need, 2 * half + 1), half / 3, radius=half)


def _leg(
    side: str, hips: Float[ndarray, "frames 3"], turned: Float[ndarray, "frames 3 3"], foot: Foot
) -> dict[str, Float[ndarray, "frames 4"]]:
    """Local rotations of hip, knee, ankle and toe; the knee points half-way between hips and foot."""
    towards = turned[:, :, 2] + np.stack([np.sin(foot.yaw), np.zeros(len(hips)), np.cos(foot.yaw)], axis=1)
    thigh, shank = solve_leg(_hip(hips, turned, side), foot.ankle, towards)
    sole = to_matrix(from_euler("YX", np.degrees(np.stack([foot.yaw, -foot.pitch], axis=1))))
    toe = np.stack([foot.pitch - foot.toe_pitch, *np.zeros((2, len(hips)))], axis=1)
    return {
        f"{side.capitalize()}Hip": from_matrix(np.swapaxes(turned, 1, 2) @ thigh),
        f"{side.capitalize()}Knee": from_matrix(np.swapaxes(thigh, 1, 2) @ shank),
        f"{side.capitalize()}Ankle": from_matrix(np.swapaxes(shank, 1, 2) @ sole),
        f"{side.capitalize()}Toe": from_euler("XYZ", np.degrees(toe)),
    }


def _truth(style: WalkStyle, course: Course, falls: dict[str, Falls], cut: tuple[int, int]) -> Truth:
    clock = course.clock
    feet = [_foot_phase(falls[side], clock) if side in falls else clock + 0.25 for side in SIDES]
    running = np.column_stack([upper.hand_phases(style, course), *feet])
    contacts = [
        move_foot(falls[side], clock).contact if side in falls else np.zeros(len(clock), dtype=bool)
        for side in ("right", "left")
    ]
    kept = slice(PAD, len(clock) - PAD)
    return Truth(
        phase=np.mod(running, 1.0)[kept],
        frequency=np.gradient(running, 1 / FPS, axis=0)[kept],
        contacts=np.stack(contacts, axis=1)[kept],
        global_phase=_global_phase(falls, clock[kept]),
        cut=cut,
    )


def _foot_phase(falls: Falls, clock: Float[ndarray, " frames"]) -> Float[ndarray, " frames"]:
    """Running phase: 0.25 and a whole number in the middle of each contact, smoothly between."""
    middles = (falls.on + falls.off) / 2
    return PchipInterpolator(middles, np.arange(len(middles)) + 0.25)(clock)


def _global_phase(falls: dict[str, Falls], clock: Float[ndarray, " frames"]) -> Float[ndarray, " frames"]:
    """Through the moments at which the toes come to rest; NaN outside the first and the last of the take."""
    if len(falls) < len(SIDES):
        return np.full(len(clock), np.nan)
    events = np.concatenate([falls["right"].on, falls["left"].on])
    turns = np.concatenate([np.arange(len(falls["right"].on)), np.arange(len(falls["left"].on)) + 0.5])
    order = np.argsort(events)
    events, turns = events[order], turns[order]
    shown = (events > clock[0]) & (events <= clock[-1])
    if shown.sum() < 2:
        return np.full(len(clock), np.nan)
    phase = np.mod(2 * np.pi * PchipInterpolator(events, turns)(clock), 2 * np.pi)
    return np.where((clock < events[shown][0]) | (clock > events[shown][-1]), np.nan, phase)
