"""The skeleton: a tree of joints, and the roles that the field's methods need (hips, thighs, toes, hands).

Any skeleton will do: joint count, end effectors and mirror pairs come from names and tree, not from constants.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from stylephase.errors import InputError, hint

SIDES = ("left", "right")
# A bone that is no longer than this (m) has no direction, and counts for none.
MIN_BONE = 0.01
_SIDE_WORDS = {"left": "left", "right": "right", "l": "left", "r": "right"}
_HAND_WORDS = {"hand", "wrist"}
_TOE_WORDS = {"toe", "toes", "toebase", "ball"}
_FOOT_WORDS = {"foot", "ankle"}
# A side as the first letter: before a capital (`lToe`), or before a bone's name as CMU's own files spell it (`ltoes`).
_SIDE_LETTER = re.compile(
    r"^([lr])(?=[A-Z]|(?:hipjoint|femur|tibia|foot|toes|clavicle|humerus|radius|wrist|hand|fingers|thumb)$)"
)


@dataclass(frozen=True)
class Skeleton:
    """A tree of joints.

    `names[j]` is joint j's name, `parents[j]` its parent's index (-1 for joint 0, the hips; a parent comes before
    its children), `offsets[j]` (m) its place in the parent's frame, `sites[j]` whether it is an end site, which
    never rotates. `effectors` are the joints of LeftHand, RightHand, LeftFoot and RightFoot where their names do not
    tell.
    """

    names: tuple[str, ...]
    parents: tuple[int, ...]
    offsets: Float[ndarray, "joints 3"]
    sites: tuple[bool, ...]
    effectors: tuple[int, int, int, int] | None = None

    def __post_init__(self):
        if not len(self.names) == len(self.parents) == len(self.offsets) == len(self.sites):
            raise ValueError(f"expected one parent, offset and site flag for each of {len(self.names)} joints")
        if self.parents[0] != -1 or any(not 0 <= p < j for j, p in enumerate(self.parents) if j):
            raise ValueError("expected joint 0 as the only root and each parent before its children")

    def __len__(self) -> int:
        return len(self.names)

    def index(self, name: str) -> int:
        """Index of the joint called `name`; raises InputError with the names spelt alike, or else all."""
        if name not in self.names:
            raise InputError(f"no joint {name!r}; {hint(name, self.names)}")
        return self.names.index(name)

    def children(self, joint: int) -> list[int]:
        """Indices of the direct children of `joint`."""
        return [j for j, parent in enumerate(self.parents) if parent == joint]

    def chain(self, joint: int) -> list[int]:
        """Joints from the root down to `joint`, both included."""
        path = [joint]
        while self.parents[path[0]] >= 0:
            path.insert(0, self.parents[path[0]])
        return path

    def length_to(self, joint: int) -> float:
        """Length of the bones from the root to `joint`, one after the other."""
        return float(sum(np.linalg.norm(self.offsets[j]) for j in self.chain(joint)[1:]))

    @cached_property
    def roles(self) -> "Roles":
        """The joints that play a part in the methods, found by name and tree; raises InputError if one is missing."""
        if self.effectors is None:
            return find_roles(self)
        left_hand, right_hand, left_toe, right_toe = self.effectors
        return roles_from_effectors(self, hands=(left_hand, right_hand), toes=(left_toe, right_toe))

    @cached_property
    def mirrored(self) -> Int[ndarray, " joints"]:
        """For each joint the index of its partner on the other side (itself on the middle line)."""
        by_words = {_words(name): j for j, name in enumerate(self.names)}
        return np.array([by_words.get(_swapped(_words(name)), j) for j, name in enumerate(self.names)])


@dataclass(frozen=True)
class Roles:
    """Joint indices by role. Pairs are (left, right)."""

    hips: int
    thighs: tuple[int, int]
    toes: tuple[int, int]
    hands: tuple[int, int]
    toe_sensors: tuple[int, int]

    @property
    def effectors(self) -> tuple[int, int, int, int]:
        """LeftHand, RightHand, LeftFoot, RightFoot: the order of the local phases ([M22] 4.1.4)."""
        return (*self.hands, *self.toes)


EFFECTOR_NAMES = ("LeftHand", "RightHand", "LeftFoot", "RightFoot")


def with_effectors(skeleton: Skeleton, names: Sequence[str]) -> Skeleton:
    """The skeleton with its end effectors named, in the order of `EFFECTOR_NAMES`.

    Raises InputError: not four names, a name twice, no such joint, a foot that hangs on the other one.
    """
    if len(names) != len(EFFECTOR_NAMES) or len(set(names)) != len(names):
        raise InputError(f"expected four different joints for {', '.join(EFFECTOR_NAMES)}, found {', '.join(names)}")
    left_hand, right_hand, left_foot, right_foot = (skeleton.index(name) for name in names)
    if left_foot in skeleton.chain(right_foot) or right_foot in skeleton.chain(left_foot):
        raise InputError(f"{names[2]} and {names[3]} cannot be the two feet: one hangs on the other")
    return replace(skeleton, effectors=(left_hand, right_hand, left_foot, right_foot))


def _words(name: str) -> tuple[str, ...]:
    """Lower-case words of a joint name: `LeftToeBase`, `Toes_L`, `mixamorig:LeftToeBase` and `ltoes` all split."""
    name = _SIDE_LETTER.sub(r"\1_", name.split(":")[-1])
    parts: list[str] = re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+", name)
    return tuple(_SIDE_WORDS.get(part.lower(), part.lower()) for part in parts)


def _swapped(words: tuple[str, ...]) -> tuple[str, ...]:
    other = {"left": "right", "right": "left"}
    return tuple(other.get(word, word) for word in words)


def _find(skeleton: Skeleton, side: str, words: set[str]) -> list[int]:
    """The joints of `side` whose names have one of `words`, from the hips outwards, not counting end sites."""
    return [
        j
        for j, name in enumerate(skeleton.names)
        if not skeleton.sites[j] and side in _words(name) and words & set(_words(name))
    ]


def _toe(skeleton: Skeleton, side: str) -> int | None:
    """The first joint called toe, or else the last called foot or ankle: SMPL has both, and calls the toe a foot."""
    toes, feet = _find(skeleton, side, _TOE_WORDS), _find(skeleton, side, _FOOT_WORDS)
    return toes[0] if toes else feet[-1] if feet else None


def _last_hand(skeleton: Skeleton, side: str) -> int | None:
    """The outermost joint called hand or wrist that is no finger, or its end site if that lies further out."""
    finger = re.compile(r"thumb|index|middle|ring|pinky|finger", re.IGNORECASE)
    found = [j for j in _find(skeleton, side, _HAND_WORDS) if not finger.search(skeleton.names[j])]
    if not found:
        return None
    return _outer_site(skeleton, found[-1])


def _outer_site(skeleton: Skeleton, joint: int) -> int:
    """The end site of `joint` if it has one away from the joint, else the joint itself."""
    sites = [j for j in skeleton.children(joint) if skeleton.sites[j] and np.linalg.norm(skeleton.offsets[j]) > 1e-4]
    return sites[0] if len(sites) == 1 else joint


def _thigh(skeleton: Skeleton, toe: int, other_toe: int) -> int:
    """First joint of the toe's own chain that lies away from the hips: some skeletons have bones of no length there."""
    shared = set(skeleton.chain(other_toe))
    own = [j for j in skeleton.chain(toe) if j not in shared]
    return next((j for j in own if np.linalg.norm(skeleton.offsets[j]) > 1e-4), own[0])


def find_roles(skeleton: Skeleton) -> Roles:
    """Find the joints by role. Raises InputError that names the missing role and the joints there are."""
    toes, hands = [], []
    for side in SIDES:
        toe, hand = _toe(skeleton, side), _last_hand(skeleton, side)
        for role, joint in (("foot", toe), ("hand", hand)):
            if joint is None:
                raise InputError(
                    f"cannot tell which joint is the {side} {role}; name it so, or for phases name the end "
                    f"effectors with --effectors; this skeleton has {', '.join(skeleton.names)}"
                )
        toes.append(toe)
        hands.append(hand)
    return roles_from_effectors(skeleton, hands=(hands[0], hands[1]), toes=(toes[0], toes[1]))


def roles_from_effectors(skeleton: Skeleton, *, hands: tuple[int, int], toes: tuple[int, int]) -> Roles:
    """Roles where the end effectors are given (left, right)."""
    return Roles(
        hips=0,
        thighs=(_thigh(skeleton, toes[0], toes[1]), _thigh(skeleton, toes[1], toes[0])),
        toes=toes,
        hands=hands,
        toe_sensors=(_outer_site(skeleton, toes[0]), _outer_site(skeleton, toes[1])),
    )
