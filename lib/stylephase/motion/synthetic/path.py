"""Where the walker goes: a plan of velocities, the path it makes, and the clock of its steps."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from stylephase.errors import InputError
from stylephase.motion.synthetic.styles import WalkStyle

FPS = 60.0
# Frames planned before and after a take, so that its first and last steps are whole.
PAD = 180
GAITS = ("BR", "BW", "FR", "FW", "ID", "SR", "SW", "TR1")
# A take begins and ends with this many seconds of standing and setting off, outside its cut.
LEAD = 2.2
_STANDING = 1.2
_EASE = 0.35
# Speeds backwards and sideways, against the style's own forwards.
_BACK, _SIDE = 0.65, 0.42


@dataclass(frozen=True)
class Plan:
    """What the walker is to do, frame by frame at 60 fps.

    `velocity` (m/s) forward and to the left of the facing, `turn` (rad/s, left positive), `run` from 0 (walk) to 1;
    `cut` the frames [start, stop) in which the gait is shown.
    """

    velocity: Float[ndarray, "frames 2"]
    turn: Float[ndarray, " frames"]
    run: Float[ndarray, " frames"]
    cut: tuple[int, int]


def steady(seconds: float, *, forward: float = 0.0, left: float = 0.0, turn: float = 0.0, run: float = 0.0) -> Plan:
    """Constant velocity (m/s) and turning (rad/s) from the first frame to the last."""
    frames = round(seconds * FPS)
    velocity = np.tile([float(forward), float(left)], (frames, 1))
    return Plan(velocity, np.full(frames, float(turn)), np.full(frames, float(run)), (0, frames))


def plan_gait(style: WalkStyle, gait: str, seconds: float, rng: np.random.Generator) -> Plan:
    """A varied plan for one gait of 100STYLE: speed changes, curves to both sides, and standing at both ends."""
    if gait not in GAITS:
        raise InputError(f"no gait {gait!r}; there are {', '.join(GAITS)}")
    stand = np.zeros(4)
    parts = [(_STANDING, stand)]
    parts += [(share * seconds, target) for share, target in _segments(style, gait, seconds, rng)]
    # At the end the feet first have to come home.
    parts += [(_STANDING + 0.5 * style.cycle, stand)]
    # The cut starts and ends well inside the gait itself, since the easing reaches over the joints.
    parts[1] = (parts[1][0] + LEAD - _STANDING, parts[1][1])
    parts[-2] = (parts[-2][0] + LEAD - _STANDING, parts[-2][1])
    targets = np.concatenate([np.tile(target, (round(length * FPS), 1)) for length, target in parts])
    eased = gaussian_filter1d(targets, _EASE * FPS, axis=0, mode="nearest", truncate=2.0)
    lead = round(LEAD * FPS)
    return Plan(eased[:, :2], eased[:, 2], eased[:, 3], (lead, lead + round(seconds * FPS)))


def _segments(
    style: WalkStyle, gait: str, seconds: float, rng: np.random.Generator
) -> list[tuple[float, Float[ndarray, " 4"]]]:
    """Parts of a take: share of its length, and forward, left, turn, run."""
    if gait == "ID":
        return [(1.0, np.zeros(4))]
    walk, run = style.speed, style.run_speed
    if gait == "TR1":
        parts = [(0.17, [walk, 0, 0.2, 0]), (0.24, [0, 0, 0, 0]), (0.17, [run, 0, -0.2, 1]), (0.12, [walk, 0, 0, 0])]
        parts += [(0.11, [0, _SIDE * walk, 0, 0]), (0.06, [0, 0, 0, 0]), (0.13, [-_BACK * walk, 0, 0, 0])]
        return [(share, np.array(target, dtype=float)) for share, target in parts]
    return _varied(style, gait, seconds, rng)


def _varied(
    style: WalkStyle, gait: str, seconds: float, rng: np.random.Generator
) -> list[tuple[float, Float[ndarray, " 4"]]]:
    """Equal parts of about two and a half seconds; turns (or, sideways, directions) alternate between the sides."""
    count = 4 * max(1, round(seconds / 10))
    running = float(gait[1] == "R")
    speed = style.run_speed if running else style.speed
    way = {"F": (1.0, 0.0), "B": (-_BACK, 0.0), "S": (0.0, _SIDE)}[gait[0]]
    side = rng.choice([-1.0, 1.0])
    parts = []
    for k in range(count):
        pace = speed * rng.uniform(0.85, 1.2)
        turn = style.turn * rng.uniform(0.7, 1.2) * side * (0.0, 1.0, 0.0, -1.0)[k % 4]
        across = side * (1.0, 1.0, -1.0, -1.0)[k % 4]
        forward_only = way[1] == 0.0
        target = [way[0] * pace, way[1] * pace * across, turn if forward_only else 0.3 * turn, running]
        parts.append((1.0 / count, np.array(target)))
    return parts


@dataclass(frozen=True)
class Course:
    """The plan carried out, with `PAD` frames on either side of the take.

    `position` (m) the path on the floor (x, z), `facing` (rad, 0 is +z, left positive); `stride` the velocity
    (forward, left) as a share of the style's own speed; `run`, `turn` as in the plan; `clock` counts cycles, a right
    foot strikes at every whole number, a left one half a cycle later; `rate` (Hz) is its speed.
    """

    position: Float[ndarray, "frames 2"]
    facing: Float[ndarray, " frames"]
    velocity: Float[ndarray, "frames 2"]
    stride: Float[ndarray, "frames 2"]
    run: Float[ndarray, " frames"]
    turn: Float[ndarray, " frames"]
    clock: Float[ndarray, " frames"]
    rate: Float[ndarray, " frames"]

    def at(self, clock: Float[ndarray, " events"], values: Float[ndarray, " frames"]) -> Float[ndarray, " events"]:
        """`values` at the times at which the clock shows `clock`."""
        return np.interp(clock, self.clock, values)


def follow(style: WalkStyle, plan: Plan) -> Course:
    """The course of a plan; the path starts at the origin, facing +z."""
    ends = ((PAD, PAD), (0, 0))
    velocity = np.pad(plan.velocity, ends, mode="edge")
    turn, run = (np.pad(values, ends[0], mode="edge") for values in (plan.turn, plan.run))
    facing = np.cumsum(turn) / FPS
    facing = facing - facing[PAD]
    position = np.cumsum(from_facing(facing, velocity), axis=0) / FPS
    stride = _stride(style, velocity, run)
    rate, clock = _clock(style, velocity, turn, run, stride)
    return Course(position - position[PAD], facing, velocity, stride, run, turn, clock, rate)


def from_facing(facing: Float[ndarray, " frames"], vectors: Float[ndarray, "frames 2"]) -> Float[ndarray, "frames 2"]:
    """Vectors (forward, left) as world (x, z)."""
    forward, left = vectors[:, 0], vectors[:, 1]
    sine, cosine = np.sin(facing), np.cos(facing)
    return np.stack([forward * sine + left * cosine, forward * cosine - left * sine], axis=1)


def _stride(
    style: WalkStyle, velocity: Float[ndarray, "frames 2"], run: Float[ndarray, " frames"]
) -> Float[ndarray, "frames 2"]:
    own = style.speed + run * (style.run_speed - style.speed)
    forward = velocity[:, 0] / np.where(velocity[:, 0] < 0, _BACK * own, own)
    return np.stack([forward, velocity[:, 1] / (_SIDE * own)], axis=1)


def _clock(
    style: WalkStyle,
    velocity: Float[ndarray, "frames 2"],
    turn: Float[ndarray, " frames"],
    run: Float[ndarray, " frames"],
    stride: Float[ndarray, "frames 2"],
) -> tuple[Float[ndarray, " frames"], Float[ndarray, " frames"]]:
    """Rate (Hz) and reading (cycles) of the clock; it rests while the walker stands, with the feet on the floor."""
    own = 1 / style.cycle + run * (1 / style.run_cycle - 1 / style.cycle)
    pace = np.clip(np.linalg.norm(stride, axis=1), 0.3, 2.0) ** 0.4 * (1 + 0.2 * np.minimum(np.abs(stride[:, 1]), 1))
    moving = (np.linalg.norm(velocity, axis=1) > 0.03) | (np.abs(turn) > 0.05)
    stepping = _until_feet_are_home(moving, style.cycle)
    rate = own * pace * gaussian_filter1d(stepping.astype(float), 0.06 * FPS, truncate=3.0)
    start, grid = rest(style)
    edges = np.flatnonzero(np.diff((rate > 0).astype(int), prepend=0, append=0))
    for begin, end in edges.reshape(-1, 2):
        if end < len(rate):
            cycles = rate[begin:end].sum() / FPS
            rate[begin:end] *= max(1, round(cycles / grid)) * grid / cycles
    return rate, start + np.cumsum(rate) / FPS


def rest(style: WalkStyle) -> tuple[float, float]:
    """Reading of the clock at which the walker can stand, and after how many cycles it can again."""
    if style.hop:
        return 0.25, 1.0
    return 0.06, 0.5 if style.drag is None else 1.0


def _until_feet_are_home(moving: Bool[ndarray, " frames"], cycle: float) -> Bool[ndarray, " frames"]:
    """Moving, and half a cycle after it, in which the feet come to stand side by side."""
    half = round(0.25 * cycle * FPS)
    return maximum_filter1d(moving, 2 * half + 1, origin=half, mode="nearest")
