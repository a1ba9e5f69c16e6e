"""Where the collar bones point, seen from the chest ([M22] 5.1.2, Fig. 7)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.errors import InputError
from stylephase.evaluation.limbs import seen_from
from stylephase.features.body import Body


@dataclass(frozen=True)
class CollarJoints:
    """Feature joints: the last that both arms share, and of each side (left, right) both ends of the collar bone."""

    chest: int
    inner: tuple[int, int]
    outer: tuple[int, int]


def collar_joints(body: Body) -> CollarJoints:
    """Find the collar bones by the tree: the first bone of each arm's own chain.

    Raises InputError where an arm has no bone between chest and upper arm.
    """
    skeleton, place = body.skeleton, {joint: k for k, joint in enumerate(body.joints)}
    left, right = (skeleton.chain(hand) for hand in skeleton.roles.hands)
    shared = [joint for joint in left if joint in right]
    own = [[joint for joint in chain if joint not in shared] for chain in (left, right)]
    if any(len(chain) < 3 for chain in own):
        raise InputError("the skeleton's arms have no collar bones")
    inner, outer = ((place[own[0][k]], place[own[1][k]]) for k in (0, 1))
    return CollarJoints(place[shared[-1]], inner, outer)


@dataclass(frozen=True)
class Collars:
    """Mean direction of each collar bone (left, right) in the chest's axes, its mean length (m) and its spread (m)."""

    directions: Float[ndarray, "2 3"]
    lengths: Float[ndarray, "2"]
    variation: Float[ndarray, "2"]

    def angles(self, other: "Collars") -> Float[ndarray, "2"]:
        """Angle (degrees) of each bone's mean direction to another's."""
        cosine = (self.directions * other.directions).sum(axis=-1)
        return np.degrees(np.arccos(np.clip(cosine, -1, 1)))


def collars_of(poses: Float[ndarray, "frames pose"], joints: CollarJoints) -> Collars:
    """Measure the collar bones of a motion, from the joints' predicted or recorded positions."""
    sides = zip(joints.inner, joints.outer, strict=True)
    bones = np.stack([seen_from(poses, inner, [outer], joints.chest)[:, 0] for inner, outer in sides], axis=1)
    lengths = np.linalg.norm(bones, axis=-1)
    means = (bones / np.maximum(lengths, 1e-9)[..., None]).mean(axis=0)
    return Collars(means / np.linalg.norm(means, axis=-1, keepdims=True), lengths.mean(axis=0), lengths.std(axis=0))


def most_unusual(collars: dict[str, Collars]) -> str:
    """The style whose collar bones point furthest from the mean over all styles."""
    mean = np.mean([one.directions for one in collars.values()], axis=0)
    mean = Collars(mean / np.linalg.norm(mean, axis=-1, keepdims=True), np.zeros(2), np.zeros(2))
    return max(collars, key=lambda style: float(collars[style].angles(mean).mean()))
