"""Points that a skeleton lacks but a body needs: crown, fists, heels, arches, balls and tips of the feet."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.motion.skeleton import MIN_BONE
from stylephase.report.render.anatomy import Anatomy

HIPS, WAIST, SHOULDERS, LEFT_FOOT, RIGHT_FOOT = range(5)
_ON_EACH_SIDE = ("Fist", "Heel", "Arch", "Ball", "Tip")
ADDED = ("Skull", "Crown", *(side + name for side in ("Left", "Right") for name in _ON_EACH_SIDE))

# Metres, for a person of scale 1.
_SKULL, _CROWN, _FIST = 0.055, 0.125, 0.085
_HEEL_BEHIND, _FOOT, _TIP_AHEAD = 0.045, 0.26, (0.03, 0.09)
HEEL_RADIUS, BALL_RADIUS, TIP_RADIUS = 0.036, 0.028, 0.022
# Heights of the ankle and of the toe joint above the sole; what is measured is kept within these.
_ANKLE_HEIGHTS, _TOE_HEIGHTS = (0.06, 0.14), (0.005, 0.06)


class Landmarks(NamedTuple):
    """The joints, then the points named in `ADDED` (m), and unit vectors to the character's left.

    The sideways vectors are those of hips, waist, shoulders, left foot and right foot.
    """

    points: Float[ndarray, "frames points 3"]
    sideways: Float[ndarray, "frames 5 3"]


def added(anatomy: Anatomy, name: str) -> int:
    """Index of an added point among the landmarks."""
    return len(anatomy.skeleton) + ADDED.index(name)


def landmarks(anatomy: Anatomy, positions: Float[ndarray, "frames joints 3"]) -> Landmarks:
    """All points of the body for every frame."""
    (left_arm, right_arm), (left_leg, right_leg) = anatomy.arms, anatomy.legs
    hips = _unit(positions[:, left_leg[0]] - positions[:, right_leg[0]])
    shoulders = _unit(positions[:, left_arm[0]] - positions[:, right_arm[0]])
    columns, feet = list(_head(anatomy, positions)), []
    for side in (0, 1):
        foot, across = _foot(anatomy, positions, side, hips)
        columns += [_fist(anatomy, positions, side), *foot]
        feet.append(across)
    sideways = np.stack([hips, _unit(hips + shoulders), shoulders, *feet], axis=1)
    return Landmarks(np.concatenate([positions, np.stack(columns, axis=1)], axis=1), sideways)


def _unit(vectors: Float[ndarray, "*batch 3"]) -> Float[ndarray, "*batch 3"]:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9)


def _head(anatomy: Anatomy, positions: ndarray) -> tuple[ndarray, ndarray]:
    """Lower and upper centre of the head: towards its end site if that lies away from it, else along the neck."""
    skeleton, head = anatomy.skeleton, anatomy.head
    ends = [j for j in skeleton.children(head) if np.linalg.norm(skeleton.offsets[j]) > MIN_BONE]
    below = next((j for j in skeleton.chain(head)[-2::-1] if _apart(positions, j, head)), None)
    if ends:
        up = _unit(positions[:, ends].mean(axis=1) - positions[:, head])
    elif below is not None:
        up = _unit(positions[:, head] - positions[:, below])
    else:
        up = np.broadcast_to([0.0, 1.0, 0.0], positions[:, head].shape)
    at, up = positions[:, head], anatomy.scale * up
    return at + _SKULL * up, at + _CROWN * up


def _apart(positions: ndarray, one: int, other: int) -> bool:
    return float(np.linalg.norm(positions[0, one] - positions[0, other])) > MIN_BONE


def _fist(anatomy: Anatomy, positions: ndarray, side: int) -> ndarray:
    """Centre of the hand: towards the end effector beyond the wrist, else straight on from the forearm."""
    _, elbow, wrist = anatomy.arms[side]
    hand = anatomy.skeleton.roles.hands[side]
    start, stop = (wrist, hand) if hand != wrist else (elbow, wrist)
    return positions[:, wrist] + _FIST * anatomy.scale * _unit(positions[:, stop] - positions[:, start])


def _foot(anatomy: Anatomy, positions: ndarray, side: int, hips: ndarray) -> tuple[list[ndarray], ndarray]:
    """Heel, arch, ball and tip of a foot, and its sideways vector.

    The sole lies as far below ankle and toe joint as they are above the ground when the feet stand flat, and keeps
    its angle to the line between them. The tip stays above the ground, as toes bend when the heel lifts.
    """
    _, knee, ankle = anatomy.legs[side]
    scale, at = anatomy.scale, positions[:, ankle]
    toe = _toes(anatomy, positions, side, hips)
    ankle_height, toe_height = _standing_heights(anatomy, positions, hips)
    along = _unit(toe - at)
    across = _unit(np.cross(positions[:, knee] - at, along) + 1e-3 * hips)
    length = np.linalg.norm(toe - at, axis=1).mean()
    pitch = np.arcsin(np.clip((ankle_height - toe_height) / length, -0.9, 0.9))
    above = np.cross(along, across)
    forward = np.cos(pitch) * along + np.sin(pitch) * above
    up = np.cos(pitch) * above - np.sin(pitch) * along
    heel = at - (ankle_height - HEEL_RADIUS * scale) * up - _HEEL_BEHIND * scale * forward
    ball = toe - (toe_height - BALL_RADIUS * scale) * up
    ahead = scale * np.clip(_FOOT - _HEEL_BEHIND - length / scale, *_TIP_AHEAD)
    tip = ball - (BALL_RADIUS - TIP_RADIUS) * scale * up + ahead * forward
    tip[:, 1] = np.maximum(tip[:, 1], np.minimum(TIP_RADIUS * scale, ball[:, 1]))
    return [heel, 0.55 * heel + 0.45 * ball, ball, tip], across


def _toes(anatomy: Anatomy, positions: ndarray, side: int, hips: ndarray) -> ndarray:
    """The toe joint; for a leg that ends at the ankle, a point ahead of it and below."""
    ankle, toe = anatomy.legs[side][-1], anatomy.toes[side]
    if toe != ankle:
        return positions[:, toe]
    ahead = _unit(np.cross(hips, [0.0, 1.0, 0.0]))
    return positions[:, ankle] + anatomy.scale * (_FOOT / 2 * ahead - np.array([0.0, 0.06, 0.0]))


def _standing_heights(anatomy: Anatomy, positions: ndarray, hips: ndarray) -> tuple[float, float]:
    """Heights (m) of ankle and toe joint above the ground when a foot stands, from the lowest that either foot goes."""
    ankles = positions[:, [leg[-1] for leg in anatomy.legs], 1]
    toes = np.stack([_toes(anatomy, positions, side, hips)[:, 1] for side in (0, 1)])
    lowest = [float(np.percentile(heights, 2)) for heights in (ankles, toes)]
    bounds = np.array([_ANKLE_HEIGHTS, _TOE_HEIGHTS]) * anatomy.scale
    ankle, toe = np.clip(lowest, bounds[:, 0], bounds[:, 1])
    return float(ankle), float(toe)
