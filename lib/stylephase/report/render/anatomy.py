"""Which joint of a skeleton is which part of a body: what the drawing needs beyond the roles of the methods."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from stylephase.errors import InputError
from stylephase.motion.skeleton import Skeleton

Side = Literal["left", "right", "middle"]
# Legs from hip to ankle (m) of the person for whom the thicknesses are given.
_LEG_LENGTH = 0.83


@dataclass(frozen=True)
class Anatomy:
    """Joint indices by part of the body; pairs are (left, right).

    `arms` run from shoulder over elbow to wrist, `legs` from thigh to ankle. `scale` is the legs' length against that
    of the person for whom the thicknesses are given.
    """

    skeleton: Skeleton
    chest: int
    head: int
    arms: tuple[list[int], list[int]]
    legs: tuple[list[int], list[int]]
    toes: tuple[int, int]
    sides: tuple[Side, ...]
    scale: float


def find_anatomy(skeleton: Skeleton) -> Anatomy:
    """The parts of the body, from names and tree. Raises InputError where hands or feet cannot be told."""
    roles = skeleton.roles
    branches = [[_branch(skeleton, *pair), _branch(skeleton, *pair[::-1])] for pair in (roles.hands, roles.toes)]
    chest = skeleton.parents[branches[0][0]]
    legs = (_leg(skeleton, roles.thighs[0], roles.toes[0]), _leg(skeleton, roles.thighs[1], roles.toes[1]))
    lengths = [np.linalg.norm(skeleton.offsets[joint]) for leg in legs for joint in leg[1:]]
    return Anatomy(
        skeleton=skeleton,
        chest=chest,
        head=_head(skeleton, chest, {branch for pair in branches for branch in pair}),
        arms=(_arm(skeleton, roles.hands[0]), _arm(skeleton, roles.hands[1])),
        legs=legs,
        toes=roles.toes,
        sides=_sides(skeleton, branches),
        scale=float(sum(lengths)) / 2 / _LEG_LENGTH,
    )


def _branch(skeleton: Skeleton, joint: int, other: int) -> int:
    """The first joint of the chain to `joint` that does not lead to `other`."""
    shared = skeleton.chain(other)
    return next(j for j in skeleton.chain(joint) if j not in shared)


def _arm(skeleton: Skeleton, hand: int) -> list[int]:
    """Shoulder, elbow and wrist: a hand that is an end site hangs on the wrist, any other is the wrist."""
    wrist = skeleton.parents[hand] if skeleton.sites[hand] else hand
    return _three(skeleton, skeleton.chain(wrist)[-3:], "shoulder, elbow and wrist")


def _leg(skeleton: Skeleton, thigh: int, toe: int) -> list[int]:
    """Thigh, knee and ankle. A leg of three joints has no toe of its own: its last joint is the ankle."""
    chain = skeleton.chain(toe)
    leg = chain[chain.index(thigh) :]
    leg = leg[:-1] if len(leg) > 3 else leg
    return _three(skeleton, [leg[0], *leg[1:][-2:]], "thigh, knee and ankle")


def _three(skeleton: Skeleton, joints: list[int], meaning: str) -> list[int]:
    if len(joints) != 3:
        raise InputError(f"expected {meaning}, found {', '.join(skeleton.names[j] for j in joints)}")
    return joints


def _head(skeleton: Skeleton, chest: int, branches: set[int]) -> int:
    """The joint called head, or the last on the middle line from the chest upwards."""
    middle = [
        j
        for j in range(chest, len(skeleton))
        if chest in skeleton.chain(j) and not branches & set(skeleton.chain(j)) and not skeleton.sites[j]
    ]
    return next((j for j in middle if "head" in skeleton.names[j].lower()), middle[-1])


def _sides(skeleton: Skeleton, branches: list[list[int]]) -> tuple[Side, ...]:
    left, right = ({pair[side] for pair in branches} for side in (0, 1))
    chains = [set(skeleton.chain(j)) for j in range(len(skeleton))]
    return tuple("left" if chain & left else "right" if chain & right else "middle" for chain in chains)
