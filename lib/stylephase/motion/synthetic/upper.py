"""Hips, trunk, arms and head: joint angles by forward kinematics."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.ndimage import gaussian_filter1d

from stylephase.motion.rotations import from_euler
from stylephase.motion.synthetic.path import FPS, Course
from stylephase.motion.synthetic.styles import Arm, WalkStyle

TURN = 2 * np.pi
_GRAVITY = 9.81
# When, in cycles after a right strike, the body stands over the right foot, walking and running.
MIDDLE, RUN_MIDDLE = 0.31, 0.18
_SPINE = ("Chest", "Chest2", "Chest3", "Chest4")
_HIPS_SHARE = 0.3


def smooth_noise(frames: int, seconds: float, rng: np.random.Generator) -> Float[ndarray, " frames"]:
    """Gaussian noise with unit deviation, smooth over about `seconds`."""
    sigma = seconds * FPS
    noise = gaussian_filter1d(rng.standard_normal(frames), sigma, mode="reflect", truncate=3.0)
    return noise * np.sqrt(2 * sigma * np.sqrt(np.pi))


def effort(course: Course) -> Float[ndarray, " frames"]:
    """Size of the stride against the style's own, at most 1.3."""
    return np.minimum(np.linalg.norm(course.stride, axis=1), 1.3)


def hips_shift(
    style: WalkStyle, course: Course, rng: np.random.Generator
) -> tuple[Float[ndarray, " frames"], Float[ndarray, " frames"]]:
    """The hips' way to the left and upwards (m) against the path: over the standing foot, up and down twice a cycle."""
    clock, size, frames = course.clock, effort(course), len(course.clock)
    left = -style.sway * (0.3 + 0.7 * size) * (1 - 0.5 * course.run) * np.cos(TURN * (clock - MIDDLE))
    left = left * np.minimum(size * 3, 1) + 0.006 * smooth_noise(frames, 1.2, rng)
    # In the air the hips fall freely; a sine of this amplitude comes close.
    flying = 0.8 * _GRAVITY * (style.run_cycle / (2 * TURN)) ** 2 * np.minimum(size, 1)
    if style.hop:
        bob = -4 * flying * np.cos(TURN * (clock - 0.25))
    else:
        walking = style.bounce * size * (1 - course.run) * np.cos(2 * TURN * (clock - MIDDLE))
        bob = walking - flying * course.run * np.cos(2 * TURN * (clock - RUN_MIDDLE)) - 0.045 * course.run
    return left, bob + 0.002 * smooth_noise(frames, 1.0, rng)


def trunk(style: WalkStyle, course: Course, rng: np.random.Generator) -> dict[str, Float[ndarray, "frames 3"]]:
    """Angles (yaw, pitch, roll; rad) of hips, spine, neck and head."""
    clock, size, frames = course.clock, effort(course), len(course.clock)
    ahead = np.clip(course.stride[:, 0], -1.2, 1.2)
    step = np.cos(TURN * clock)
    lean = style.lean + 0.05 * ahead + 0.1 * course.run * ahead + 0.012 * smooth_noise(frames, 0.8, rng)
    bank = -0.8 * np.arctan(course.velocity[:, 0] * course.turn / _GRAVITY)
    listing = -style.pelvis_list * np.minimum(size, 1.2) * np.cos(TURN * (clock - 0.18))
    twist = -style.chest_twist * ahead * step
    yaw = style.pelvis_yaw * ahead * step
    look, nod = _look(style, course, rng)
    hips = np.stack([yaw, _HIPS_SHARE * lean, 0.4 * bank + listing], axis=1)
    if style.drag:
        hips[:, 2] += 0.07 * np.minimum(size, 1) * np.cos(TURN * (clock - 0.78))
    chest = np.stack([twist + 0.4 * look - yaw, (1 - _HIPS_SHARE) * lean, 0.6 * bank - 1.2 * hips[:, 2]], axis=1)
    # The head keeps most of its level and heading: it undoes the trunk's twist and much of its lean.
    head = np.stack([0.6 * look - twist, nod - style.gaze - 0.8 * lean, 0.2 * hips[:, 2] - 0.4 * bank], axis=1)
    return {"Hips": hips} | {name: chest / len(_SPINE) for name in _SPINE} | {"Neck": 0.4 * head, "Head": 0.6 * head}


def _look(
    style: WalkStyle, course: Course, rng: np.random.Generator
) -> tuple[Float[ndarray, " frames"], Float[ndarray, " frames"]]:
    """Where the head looks against the facing: yaw into the turn, drifting a little; and the looks behind."""
    frames = len(course.clock)
    yaw = 0.25 * course.turn + 0.05 * smooth_noise(frames, 0.9, rng)
    pitch = 0.025 * smooth_noise(frames, 0.7, rng)
    seconds = np.arange(frames) / FPS
    for start in seconds[rng.random(frames) < style.glances / FPS]:
        length, side = rng.uniform(1.0, 1.8), rng.choice([-1.0, 1.0])
        share = np.clip((seconds - start) / length, 0, 1)
        yaw = yaw + side * rng.uniform(1.3, 1.7) * np.sin(np.pi * share) ** 2 * (1 - np.minimum(np.abs(yaw), 1))
    return yaw, pitch


def hand_phases(style: WalkStyle, course: Course) -> Float[ndarray, "frames 2"]:
    """Running phases (cycles) of left and right hand: 0.25 is furthest forward.

    A hand goes with the opposite foot. Backwards that is half a cycle later, and the hand gains another half when it
    comes back, so that its phase never runs backwards. With a period of its own it takes no notice of the feet.
    """
    if style.arm_period is not None:
        seconds = np.arange(len(course.clock)) / FPS
        return np.stack([seconds, seconds + 0.5 * style.arm_period], axis=1) / style.arm_period
    back = gaussian_filter1d((course.stride[:, 0] < -0.15).astype(float), 0.2 * FPS, mode="nearest")
    left = course.clock + 0.25 + 0.5 * np.cumsum(np.abs(np.diff(back, prepend=0.0)))
    return np.stack([left, left if style.hop else left + 0.5], axis=1)


def arms(
    style: WalkStyle, course: Course, phases: Float[ndarray, "frames 2"], rng: np.random.Generator
) -> dict[str, Float[ndarray, "frames 4"]]:
    """Local rotations (wxyz) of collar, shoulder, elbow and wrist of both arms."""
    ahead, across = course.stride.T
    size = np.where(ahead < 0, 0.6, 1.0) * np.abs(ahead) + 0.35 * np.abs(across)
    size = np.minimum(size, 1.3) if style.arm_period is None else 0.6 + 0.4 * np.minimum(size, 1)
    rotations = {}
    for k, (side, arm) in enumerate((("Left", style.left_arm or style.arms), ("Right", style.arms))):
        wave = np.sin(TURN * phases[:, k]) * size * (1 + 0.06 * smooth_noise(len(size), 1.0, rng))
        rotations |= _arm(side, arm, style, wave, course.run, rng)
    return rotations


def _arm(
    side: str, arm: Arm, style: WalkStyle, wave: ndarray, run: ndarray, rng: np.random.Generator
) -> dict[str, Float[ndarray, "frames 4"]]:
    sign, frames = (1.0 if side == "Left" else -1.0), len(wave)
    # A swinging arm bends more in a run; one that is held keeps its pose.
    free = min(1.0, arm.swing / 0.3)
    flex = arm.flex + style.lean + arm.swing * wave + 0.01 * smooth_noise(frames, 0.8, rng)
    abduct = arm.abduct + 0.05 * run * free + 0.008 * smooth_noise(frames, 0.9, rng)
    elbow = arm.elbow + arm.bend * wave + run * free * np.maximum(1.45 - arm.elbow, 0)
    none = np.zeros(frames)
    down = -sign * (np.pi / 2 - abduct)
    twist = arm.twist + 0.3 * run * free + none
    return {
        f"{side}Collar": _euler("ZYX", sign * (style.shrug + none), -sign * 0.08 * wave * free, none),
        f"{side}Shoulder": _euler("XZX", -flex, down - sign * style.shrug, twist),
        f"{side}Elbow": _euler("YXZ", -sign * elbow, 0.1 + none, none),
        f"{side}Wrist": _euler("YXZ", -sign * (0.1 + 0.05 * wave), none, none),
    }


def _euler(order: str, *angles: Float[ndarray, " frames"]) -> Float[ndarray, "frames 4"]:
    return from_euler(order, np.degrees(np.stack(angles, axis=1)))
