"""The walker's body: an adult in the layout of 100STYLE, and inverse kinematics of a leg.

The zero pose stands upright and faces +z, arms along +x (left) and -x (right), legs straight down. The bone lengths
are the walker's own.
"""

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.motion.rotations import unit
from stylephase.motion.skeleton import Skeleton

THIGH, SHANK = 0.425, 0.415
HIP = np.array([0.092, -0.03, 0.0])
# The foot in its own frame, from the ankle (m): ball (joint Toe), tip (its end site) and heel; the sole lies at -ANKLE.
ANKLE = 0.09
BALL = np.array([0.0, -0.072, 0.135])
TIP = np.array([0.0, -0.018, 0.062])
HEEL = np.array([0.0, -ANKLE, -0.05])
# A leg is never stretched further than this share of its length: at full stretch the knee would snap.
REACH = 0.987 * (THIGH + SHANK)
STANDING = THIGH + SHANK + ANKLE - HIP[1]

_SPINE = (("Chest", 0.115), ("Chest2", 0.11), ("Chest3", 0.10), ("Chest4", 0.10))
_SIDES = (("Right", -1.0), ("Left", 1.0))


def _arm(side: str, x: float) -> list[tuple[str, str, tuple[float, float, float]]]:
    return [
        (f"{side}Collar", "Chest4", (0.03 * x, 0.085, 0.0)),
        (f"{side}Shoulder", f"{side}Collar", (0.155 * x, 0.0, 0.0)),
        (f"{side}Elbow", f"{side}Shoulder", (0.295 * x, 0.0, 0.0)),
        (f"{side}Wrist", f"{side}Elbow", (0.255 * x, 0.0, 0.0)),
        (f"{side}WristSite", f"{side}Wrist", (0.18 * x, 0.0, 0.0)),
    ]


def _leg(side: str, x: float) -> list[tuple[str, str, tuple[float, float, float]]]:
    return [
        (f"{side}Hip", "Hips", (HIP[0] * x, HIP[1], HIP[2])),
        (f"{side}Knee", f"{side}Hip", (0.0, -THIGH, 0.0)),
        (f"{side}Ankle", f"{side}Knee", (0.0, -SHANK, 0.0)),
        (f"{side}Toe", f"{side}Ankle", tuple(BALL)),
        (f"{side}ToeSite", f"{side}Toe", tuple(TIP)),
    ]


def _build() -> Skeleton:
    above = ["Hips", *(name for name, _ in _SPINE)]
    rows = [("Hips", "", (0.0, 0.0, 0.0))]
    rows += [(name, parent, (0.0, length, 0.0)) for (name, length), parent in zip(_SPINE, above, strict=False)]
    rows += [("Neck", "Chest4", (0.0, 0.15, 0.0)), ("Head", "Neck", (0.0, 0.095, 0.015))]
    rows += [("HeadSite", "Head", (0.0, 0.17, 0.0))]
    rows += [row for side in _SIDES for row in _arm(*side)] + [row for side in _SIDES for row in _leg(*side)]
    names = tuple(name for name, _, _ in rows)
    return Skeleton(
        names=names,
        parents=tuple(names.index(parent) if parent else -1 for _, parent, _ in rows),
        offsets=np.array([offset for _, _, offset in rows]),
        sites=tuple(name.endswith("Site") for name in names),
    )


SKELETON = _build()


def solve_leg(
    hip: Float[ndarray, "frames 3"], ankle: Float[ndarray, "frames 3"], forward: Float[ndarray, "frames 3"]
) -> tuple[Float[ndarray, "frames 3 3"], Float[ndarray, "frames 3 3"]]:
    """World rotations of thigh and shank that bring the ankle to its place, the knee bent towards `forward`.

    Two-bone inverse kinematics: thigh and shank share their x axis, so the knee is a hinge. An ankle out of reach
    is met in its direction, at `REACH`.
    """
    straight = ankle - hip
    distance = np.clip(np.linalg.norm(straight, axis=1, keepdims=True), 0.1, REACH)
    along = unit(straight)
    across = unit(np.cross(forward, along))
    bend = np.cross(along, across)
    cosine = (THIGH**2 + distance**2 - SHANK**2) / (2 * THIGH * distance)
    knee = THIGH * (cosine * along + np.sqrt(1 - cosine**2) * bend)
    return _bone(-knee, across), _bone(knee - distance * along, across)


def _bone(up: Float[ndarray, "frames 3"], across: Float[ndarray, "frames 3"]) -> Float[ndarray, "frames 3 3"]:
    """Rotation of a leg bone whose y axis points up along the bone and whose x axis is the knee's hinge."""
    y = unit(up)
    return np.stack([across, y, np.cross(across, y)], axis=-1)
