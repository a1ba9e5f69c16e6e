"""Two bones that reach for a point: legs to where a foot should stand, arms to where a hand should be.

The solution is in closed form, for any number of limbs at once. Lengths are kept exactly.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.motion.rotations import unit

# A stretched limb gives way over this share of its length, so that it does not snap straight.
_EASE = 0.01
_TINY = 1e-9


@dataclass(frozen=True)
class Reached:
    """Where two bones came to lie: middle and end joint (m), and how each bone's joint turns for it, in the world."""

    middle: Float[ndarray, "*limbs 3"]
    end: Float[ndarray, "*limbs 3"]
    upper_turn: Float[ndarray, "*limbs 3 3"]
    lower_turn: Float[ndarray, "*limbs 3 3"]


def two_bones(
    start: Float[ndarray, "*limbs 3"],
    middle: Float[ndarray, "*limbs 3"],
    end: Float[ndarray, "*limbs 3"],
    target: Float[ndarray, "*limbs 3"],
    pole: Float[ndarray, "*limbs 3"] | None = None,
) -> Reached:
    """Turn the bones start-middle and middle-end so that the end comes to the target, as near as the bones are long.

    The plane of the bend swings with the limb by the shortest way. `pole` points to the side to which the middle joint
    bends; left out, it stays on its side. Targets at up to 99 % of the limb's length are reached exactly, and a limb
    that lies on such a target does not move at all.
    """
    upper, lower, chord = middle - start, end - middle, end - start
    lengths = [np.linalg.norm(bone, axis=-1, keepdims=True) for bone in (upper, lower)]
    towards, side = _directions(chord, upper, upper if pole is None else pole)
    aim, distance = _aim(target - start, towards, *lengths)
    swing = _swing(towards, aim, np.cross(towards, side))
    along = (lengths[0] ** 2 - lengths[1] ** 2 + distance**2) / np.maximum(2 * distance, _TINY)
    height = np.sqrt(np.maximum(lengths[0] ** 2 - along**2, 0))
    new_side = _apply(swing, side)
    new_middle = start + along * aim + height * new_side
    new_end = start + distance * aim
    normals = np.cross(towards, side), np.cross(aim, new_side)
    turns = [
        _frame(now, normals[1]) @ np.swapaxes(_frame(was, normals[0]), -1, -2)
        for was, now in ((upper, new_middle - start), (lower, new_end - new_middle))
    ]
    return Reached(new_middle, new_end, turns[0], turns[1])


def eased(distance: Float[ndarray, "*limbs 1"], length: Float[ndarray, "*limbs 1"]) -> Float[ndarray, "*limbs 1"]:
    """How far a limb of a length reaches for a target at a distance (m).

    All the way up to 99 % of its length; beyond, ever less of what is added, so that the joint in the middle does not
    jump as the limb becomes straight.
    """
    free, left = (1 - _EASE) * length, _EASE * length
    return np.where(distance <= free, distance, length - left * np.exp(-np.maximum(distance - free, 0) / left))


def _directions(
    chord: ndarray, upper: ndarray, bend: ndarray
) -> tuple[Float[ndarray, "*limbs 3"], Float[ndarray, "*limbs 3"]]:
    """Unit vectors from the limb's start to its end, and at right angles to that to the side of the bend."""
    towards = unit(np.where(np.linalg.norm(chord, axis=-1, keepdims=True) > _TINY, chord, upper))
    across = bend - (bend * towards).sum(axis=-1, keepdims=True) * towards
    bent = np.linalg.norm(across, axis=-1, keepdims=True) > _TINY
    return towards, unit(np.where(bent, across, _any_across(towards)))


def _any_across(vectors: Float[ndarray, "*limbs 3"]) -> Float[ndarray, "*limbs 3"]:
    """A vector at right angles to each of some unit vectors."""
    axis = np.eye(3)[np.abs(vectors).argmin(axis=-1)]
    return axis - (axis * vectors).sum(axis=-1, keepdims=True) * vectors


def _aim(
    wanted: ndarray, towards: ndarray, upper: ndarray, lower: ndarray
) -> tuple[Float[ndarray, "*limbs 3"], Float[ndarray, "*limbs 1"]]:
    """Unit vector to the target, and how far the limb reaches along it."""
    far = np.linalg.norm(wanted, axis=-1, keepdims=True)
    aim = np.where(far > _TINY, wanted / np.maximum(far, _TINY), towards)
    return aim, np.maximum(eased(far, upper + lower), np.abs(upper - lower))


def _swing(before: ndarray, after: ndarray, axis: ndarray) -> Float[ndarray, "*limbs 3 3"]:
    """The smallest rotation that takes unit vectors to others; to their opposite it goes about `axis`."""
    cross, cosine = np.cross(before, after), (before * after).sum(axis=-1)[..., None, None]
    turned = _skew(cross)
    smallest = np.eye(3) + turned + turned @ turned / np.maximum(1 + cosine, _TINY)
    half_turn = 2 * axis[..., :, None] * axis[..., None, :] - np.eye(3)
    return np.where(1 + cosine > 1e-7, smallest, half_turn)


def _skew(v: Float[ndarray, "*limbs 3"]) -> Float[ndarray, "*limbs 3 3"]:
    """Matrices that take the cross product with vectors."""
    zero = np.zeros_like(v[..., 0])
    rows = [[zero, -v[..., 2], v[..., 1]], [v[..., 2], zero, -v[..., 0]], [-v[..., 1], v[..., 0], zero]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _frame(bone: ndarray, normal: ndarray) -> Float[ndarray, "*limbs 3 3"]:
    """Rotations whose y axis lies along the bone and whose x axis comes nearest to the normal."""
    y = unit(bone)
    x = unit(normal - (normal * y).sum(axis=-1, keepdims=True) * y)
    return np.stack([x, y, np.cross(x, y)], axis=-1)


def _apply(matrices: Float[ndarray, "*limbs 3 3"], vectors: Float[ndarray, "*limbs 3"]) -> Float[ndarray, "*limbs 3"]:
    return (matrices @ vectors[..., None])[..., 0]
