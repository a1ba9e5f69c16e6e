"""The body as post-processing sees it: bones of fixed length, two legs, two arms."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.errors import InputError
from stylephase.features.body import Body
from stylephase.motion.skeleton import Skeleton

# Pairs of bones this near to the longest pair count as long as it.
_ALIKE = 0.9


@dataclass(frozen=True)
class Limb:
    """Two long bones from `start` over `middle` to `end`, and the joint further out that is to be somewhere.

    Places are those in the vectors. Where the limb has nothing beyond its end, `tip` is the end.
    """

    start: int
    middle: int
    end: int
    tip: int


@dataclass(frozen=True)
class Rig:
    """A body's joints in the order of the vectors: parents, and offsets (m) in the axes of the parent at rest.

    `legs` and `arms` are (right, left), as contacts are.
    """

    parents: tuple[int, ...]
    offsets: Float[ndarray, "joints 3"]
    legs: tuple[Limb, Limb]
    arms: tuple[Limb, Limb]

    @cached_property
    def limbs(self) -> tuple[list[int], list[int], list[int], list[int]]:
        """Starts, middles, ends and tips of both legs, then both arms."""
        limbs = (*self.legs, *self.arms)
        return [x.start for x in limbs], [x.middle for x in limbs], [x.end for x in limbs], [x.tip for x in limbs]

    def place(
        self, hips: Float[ndarray, "*batch 3"], rotations: Float[ndarray, "*batch joints 3 3"]
    ) -> Float[ndarray, "*batch joints 3"]:
        """Positions (m) of all joints, from the hips and the rotations against rest."""
        positions = np.empty(rotations.shape[:-1])
        positions[..., 0, :] = hips
        for joint, parent in list(enumerate(self.parents))[1:]:
            positions[..., joint, :] = positions[..., parent, :] + rotations[..., parent, :, :] @ self.offsets[joint]
        return positions


def rig_of(body: Body) -> Rig:
    """The rig of a body. Raises InputError where a leg or an arm has fewer than two bones."""
    skeleton, joints = body.skeleton, body.joints
    parents = tuple(joints.index(skeleton.parents[joint]) if joint else -1 for joint in joints)
    offsets = np.stack([body.rest[skeleton.parents[j]].T @ skeleton.offsets[j] if j else np.zeros(3) for j in joints])
    roles, place = skeleton.roles, joints.index
    legs, arms = (
        tuple(Limb(*(place(j) for j in (*_long_bones(skeleton, tip, other), tip))) for tip, other in (pair, pair[::-1]))
        for pair in (roles.toes[::-1], roles.hands[::-1])
    )
    return Rig(parents, offsets, (legs[0], legs[1]), (arms[0], arms[1]))


def _long_bones(skeleton: Skeleton, tip: int, other: int) -> tuple[int, int, int]:
    """The three joints of the two neighbouring bones that are longest together, on the limb's own way to its tip.

    Of pairs about as long, the outer one: a collar bone may be as long as a forearm.
    """
    shared = set(skeleton.chain(other))
    own = [joint for joint in skeleton.chain(tip) if joint not in shared]
    if len(own) < 3:
        raise InputError(f"the limb that ends in {skeleton.names[tip]} has no two bones")
    lengths = np.linalg.norm(skeleton.offsets[own[1:]], axis=1)
    together = lengths[:-1] + lengths[1:]
    k = int(np.flatnonzero(together >= _ALIKE * together.max())[-1])
    return own[k], own[k + 1], own[k + 2]
