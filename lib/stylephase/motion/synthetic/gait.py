"""Foot falls on the path, and the feet between them.

All motion of the feet is a function of the clock, so a clock at rest means feet at rest. A stance has three parts:
the foot lands (pitch from `land` to level), stays flat, and pushes off (pitch from level to `push`). Toes-up pitch
rolls on the heel, heel-up pitch on the ball while the toes stay flat, so the toe's end site is fixed to the floor
from `on` to `off`. The swing is a quintic between the two: position, velocity and acceleration are continuous.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from stylephase.motion.synthetic.body import ANKLE, BALL, HEEL, HIP
from stylephase.motion.synthetic.path import Course, from_facing
from stylephase.motion.synthetic.styles import WalkStyle

# Parts of a cycle in which the foot lands and pushes off, walking and running, and the running duty.
_LANDING, _PUSHING = (0.10, 0.09), (0.24, 0.2)
_RUN_DUTY = 0.35
_ARRIVAL = 1.5
# In the frame that lies flat below the ankle: (forward, up).
_BALL = np.array([BALL[2], ANKLE + BALL[1]])
_HEEL = np.array([HEEL[2], 0.0])


@dataclass(frozen=True)
class Falls:
    """Stances of one foot, in order: clock readings of their events, place on the floor (x, z), yaw and pitches."""

    strike: Float[ndarray, " falls"]
    flat: Float[ndarray, " falls"]
    heel_off: Float[ndarray, " falls"]
    lift: Float[ndarray, " falls"]
    ground: Float[ndarray, "falls 2"]
    yaw: Float[ndarray, " falls"]
    land: Float[ndarray, " falls"]
    push: Float[ndarray, " falls"]
    rise: Float[ndarray, " falls"]

    @property
    def on(self) -> Float[ndarray, " falls"]:
        """When the toe comes to rest on the floor."""
        return np.where(self.land > 0, self.flat, self.strike)

    @property
    def off(self) -> Float[ndarray, " falls"]:
        """When the toe leaves the floor."""
        return np.where(self.push > 0, self.heel_off, self.lift)


@dataclass(frozen=True)
class Foot:
    """One foot through a take: ankle (m), yaw, pitch and the toes' pitch (rad, toes up positive), toe on the floor."""

    ankle: Float[ndarray, "frames 3"]
    yaw: Float[ndarray, " frames"]
    pitch: Float[ndarray, " frames"]
    toe_pitch: Float[ndarray, " frames"]
    contact: Bool[ndarray, " frames"]


def plan_falls(style: WalkStyle, course: Course, side: str, rng: np.random.Generator) -> Falls:
    """The stances of a foot along the course, from before its first frame to after its last."""
    dragged = style.drag == side
    offset = 0.0 if side == "right" or style.hop else 0.58 if dragged else 0.5
    strike = np.arange(np.floor(course.clock[0]) - 2, np.ceil(course.clock[-1]) + 2) + offset
    strike = strike + rng.uniform(-0.008, 0.008, len(strike))
    run = course.at(strike, course.run)
    duty = _duty(style, side, run)
    lift = strike + duty
    over = strike + duty * _passing(course, strike)
    ground, yaw = _places(style, course, side, over, rng)
    land, push = _pitches(style, course, strike, lift)
    size = np.minimum(np.linalg.norm(_stride_at(course, lift), axis=1), 1.0)
    ahead, across = np.clip(_stride_at(course, lift), -1, 1).T
    # Backwards the toes point down on landing and need more room.
    rise = 0.015 if dragged else style.rise * (1 - 0.3 * np.abs(across)) + 0.015 * np.maximum(-ahead, 0)
    return Falls(
        strike=strike,
        flat=strike + _mixed(_LANDING, run),
        heel_off=lift - np.minimum(_mixed(_PUSHING, run), 0.5 * duty) * np.where(push > 0, 0.5, 1.0),
        lift=lift,
        ground=ground,
        yaw=yaw,
        land=land * (0.2 if dragged else 1.0),
        push=push * (0.5 if dragged else 1.0),
        rise=rise * (0.4 + 0.6 * size) + 0.1 * run * size,
    )


def _passing(course: Course, strike: Float[ndarray, " falls"]) -> Float[ndarray, " falls"]:
    """Share of the stance after which the hips pass the foot: the leg reaches further on its toes than on its heel."""
    return 0.5 - 0.12 * np.clip(_stride_at(course, strike)[:, 0], -1, 1)


def _mixed(pair: tuple[float, float], run: Float[ndarray, " falls"]) -> Float[ndarray, " falls"]:
    return pair[0] + run * (pair[1] - pair[0])


def _stride_at(course: Course, clock: Float[ndarray, " falls"]) -> Float[ndarray, "falls 2"]:
    return np.stack([course.at(clock, course.stride[:, k]) for k in (0, 1)], axis=1)


def _duty(style: WalkStyle, side: str, run: Float[ndarray, " falls"]) -> Float[ndarray, " falls"]:
    """Share of the cycle from strike to lift; a dragged leg carries shorter, the other one longer."""
    if style.hop:
        return style.duty - 0.06 * run
    shift = 0.0 if style.drag is None else -0.12 if style.drag == side else 0.1
    return _mixed((style.duty + shift, _RUN_DUTY + shift), run)


def _places(
    style: WalkStyle, course: Course, side: str, clock: Float[ndarray, " falls"], rng: np.random.Generator
) -> tuple[Float[ndarray, "falls 2"], Float[ndarray, " falls"]]:
    """Where the foot stands: beside the path; far enough beside it, going sideways, for the feet not to cross."""
    sign = 1.0 if side == "left" else -1.0
    facing = course.at(clock, course.facing)
    narrower = 1 - 0.4 * course.at(clock, course.run)
    way = np.abs(course.at(clock, course.velocity[:, 1])) / np.maximum(course.at(clock, course.rate), 0.4)
    left = sign * (style.half_width * narrower + 0.25 * way) + rng.normal(0, 0.004, len(clock))
    forward = rng.normal(0, 0.006, len(clock)) - (0.1 if style.drag == side else 0.0)
    path = np.stack([course.at(clock, course.position[:, k]) for k in (0, 1)], axis=1)
    ground = path + from_facing(facing, np.stack([forward, left], axis=1))
    return ground, facing + sign * (style.toe_out + (0.35 if style.drag == side else 0.0))


def _pitches(
    style: WalkStyle, course: Course, strike: Float[ndarray, " falls"], lift: Float[ndarray, " falls"]
) -> tuple[Float[ndarray, " falls"], Float[ndarray, " falls"]]:
    """Pitch at landing and at push-off: heel first forwards, toe first backwards, nearly flat sideways."""
    landing, pushing = _stride_at(course, strike), _stride_at(course, lift)
    run = course.at(strike, course.run)
    ahead, back = np.clip(landing[:, 0], 0, 1.2), np.clip(-landing[:, 0], 0, 1.2)
    land = style.land * (1 - 0.6 * run) * ahead - 0.4 * style.push * (1 - 0.4 * run) * back
    ahead, back = np.clip(pushing[:, 0], 0, 1.2), np.clip(-pushing[:, 0], 0, 1.2)
    rolling = 0.5 * abs(style.land) * (1 - run) * back
    push = rolling - style.push * (1 - 0.3 * run) * ahead - 0.2 * np.clip(np.abs(pushing[:, 1]), 0, 1.2)
    return land, push


def move_foot(falls: Falls, clock: Float[ndarray, " frames"]) -> Foot:
    """The foot at every reading of the clock."""
    index = np.clip(np.searchsorted(falls.strike, clock, side="right") - 1, 0, len(falls.strike) - 2)
    swinging = clock >= falls.lift[index]
    pitch = _stance_pitch(falls, index, clock)
    ankle = _world(falls.ground[index], falls.yaw[index], _rolled(pitch)[0])
    share = np.clip((clock - falls.lift[index]) / (falls.strike[index + 1] - falls.lift[index]), 0, 1)
    swung_ankle, swung_pitch = _swing(falls, index, share)
    pitch = np.where(swinging, swung_pitch, pitch)
    straight = _straightening(falls, index, share)
    return Foot(
        ankle=np.where(swinging[:, None], swung_ankle, ankle),
        yaw=falls.yaw[index] + _smooth(share) * (falls.yaw[index + 1] - falls.yaw[index]),
        pitch=pitch,
        toe_pitch=np.where(swinging, straight * pitch, np.maximum(pitch, 0.0)),
        contact=(clock >= falls.on[index]) & (clock < falls.off[index]),
    )


def _smooth(share: Float[ndarray, " frames"]) -> Float[ndarray, " frames"]:
    """From 0 to 1 with velocity and acceleration zero at both ends."""
    return share**3 * (10 - 15 * share + 6 * share**2)


def _onset(share: Float[ndarray, " frames"]) -> Float[ndarray, " frames"]:
    """From rest at 0 to 1, arriving with velocity `_ARRIVAL` and no acceleration."""
    return share**3 * (4 - 4.5 * share + 1.5 * share**2)


def _stance_pitch(falls: Falls, index: ndarray, clock: Float[ndarray, " frames"]) -> Float[ndarray, " frames"]:
    landing = (falls.flat[index] - clock) / (falls.flat[index] - falls.strike[index])
    pushing = (clock - falls.heel_off[index]) / (falls.lift[index] - falls.heel_off[index])
    return falls.land[index] * _onset(np.clip(landing, 0, 1)) + falls.push[index] * _onset(np.clip(pushing, 0, 1))


def _rolled(pitch: Float[ndarray, " n"]) -> tuple[Float[ndarray, "n 2"], Float[ndarray, "n 2"]]:
    """The ankle (forward, up) over the flat footprint at a pitch, and from the point it rolls on to the ankle."""
    pivot = np.where(pitch[:, None] > 0, _HEEL, _BALL)
    arm = np.array([0.0, ANKLE]) - pivot
    sine, cosine = np.sin(pitch), np.cos(pitch)
    turned = np.stack([arm[:, 0] * cosine - arm[:, 1] * sine, arm[:, 1] * cosine + arm[:, 0] * sine], axis=1)
    return pivot + turned, turned


def _world(
    ground: Float[ndarray, "n 2"], yaw: Float[ndarray, " n"], sagittal: Float[ndarray, "n 2"]
) -> Float[ndarray, "n 3"]:
    flat = from_facing(yaw, np.stack([sagittal[:, 0], np.zeros(len(yaw))], axis=1)) + ground
    return np.stack([flat[:, 0], sagittal[:, 1], flat[:, 1]], axis=1)


def _swing(
    falls: Falls, index: ndarray, share: Float[ndarray, " frames"]
) -> tuple[Float[ndarray, "frames 3"], Float[ndarray, " frames"]]:
    """Ankle and pitch in the swing after each stance; the ends take over the rolling of the stances."""
    length = np.diff(falls.strike, append=falls.strike[-1] + 1) - (falls.lift - falls.strike)
    before = np.r_[length[0], length[:-1]]
    push_rate = _ARRIVAL * falls.push / (falls.lift - falls.heel_off) * length
    land_rate = -_ARRIVAL * falls.land / (falls.flat - falls.strike) * before
    leave, arrive = _end(falls, falls.push, push_rate), _end(falls, falls.land, land_rate)
    nothing = np.zeros(len(index))
    following = index + 1
    ankle = _quintic(share[:, None], [part[index] for part in leave], [part[following] for part in arrive])
    ankle[:, 1] += falls.rise[index] * 64 * (share * (1 - share)) ** 3
    pitch = _quintic(
        share,
        [falls.push[index], push_rate[index], nothing],
        [falls.land[following], land_rate[following], nothing],
    )
    return ankle, pitch


def _end(falls: Falls, pitch: Float[ndarray, " n"], rate: Float[ndarray, " n"]) -> list[Float[ndarray, "n 3"]]:
    """The ankle's position, velocity and acceleration where the foot rolls through `pitch` at `rate`."""
    place, arm = _rolled(pitch)
    velocity = rate[:, None] * np.stack([-arm[:, 1], arm[:, 0]], axis=1)
    origin = np.zeros_like(falls.ground)
    return [
        _world(falls.ground, falls.yaw, place),
        _world(origin, falls.yaw, velocity),
        _world(origin, falls.yaw, -(rate[:, None] ** 2) * arm),
    ]


def _quintic(share: ndarray, start: list[ndarray], end: list[ndarray]) -> ndarray:
    """The quintic with given value, velocity and acceleration at both ends of [0, 1]."""
    s2, s3, s4, s5 = (share**k for k in (2, 3, 4, 5))
    rise = 10 * s3 - 15 * s4 + 6 * s5
    return (
        start[0] * (1 - rise)
        + start[1] * (share - 6 * s3 + 8 * s4 - 3 * s5)
        + start[2] * (0.5 * s2 - 1.5 * s3 + 1.5 * s4 - 0.5 * s5)
        + end[0] * rise
        + end[1] * (-4 * s3 + 7 * s4 - 3 * s5)
        + end[2] * (0.5 * s3 - s4 + 0.5 * s5)
    )


def _straightening(falls: Falls, index: ndarray, share: Float[ndarray, " frames"]) -> Float[ndarray, " frames"]:
    """How far the toes follow the foot's pitch in the swing: not at all where they leave or meet the floor flat."""
    leaving = np.where(falls.push[index] <= 0, _smooth(np.clip((share - 0.15) / 0.7, 0, 1)), 1.0)
    arriving = np.where(falls.land[index + 1] <= 0, _smooth(np.clip((0.75 - share) / 0.5, 0, 1)), 1.0)
    return leaving * arriving


def raised_foot(style: WalkStyle, course: Course, hips: Float[ndarray, "frames 3"], side: str) -> Foot:
    """The foot of a hopper that never touches the floor: held behind, swinging a little once a hop."""
    sign = 1.0 if side == "left" else -1.0
    size = np.minimum(np.linalg.norm(course.stride, axis=1), 1.2)
    forward = -0.2 + 0.06 * size * np.cos(2 * np.pi * course.clock)
    left = np.full(len(forward), sign * (HIP[0] + 0.01))
    flat = from_facing(course.facing, np.stack([forward, left], axis=1))
    ankle = hips + np.stack([flat[:, 0], np.full(len(forward), -0.52), flat[:, 1]], axis=1)
    pitch = np.full(len(forward), -0.9)
    return Foot(ankle, course.facing + sign * style.toe_out, pitch, pitch, np.zeros(len(forward), dtype=bool))
