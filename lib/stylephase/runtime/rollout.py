"""Rollouts: a controller run for some seconds under given steering, and the motion that comes out."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Bool, Float
from numpy import ndarray
from torch import Tensor

from stylephase.errors import InputError
from stylephase.features.body import Body
from stylephase.features.layout import FPS
from stylephase.models.bundle import Bundle
from stylephase.motion.clip import Clip
from stylephase.motion.rotations import from_matrix
from stylephase.motion.skeleton import Skeleton
from stylephase.runtime.controller import Controller, ControllerSettings, State
from stylephase.runtime.grounding import ground
from stylephase.runtime.plans import Plan
from stylephase.runtime.rig import rig_of

# Called with the number of frames done.
Tick = Callable[[int], object]


def quiet(frames: int) -> None:
    """Tell nobody of progress."""


@dataclass(frozen=True)
class Rollout:
    """Motion of some characters in the world: joints (m), orientations against rest, root, contacts, phases."""

    positions: Float[ndarray, "frames characters joints 3"]
    rotations: Float[ndarray, "frames characters joints 3 3"]
    root_positions: Float[ndarray, "frames characters 2"]
    root_angles: Float[ndarray, "frames characters"]
    contacts: Float[ndarray, "frames characters 2"]
    phases: Float[ndarray, "frames characters gate_inputs"]

    def __len__(self) -> int:
        return len(self.positions)

    @property
    def finite(self) -> Bool[ndarray, " characters"]:
        """Whether all numbers of a character stayed finite."""
        parts = (self.positions, self.rotations, self.root_positions, self.root_angles)
        return np.all([np.isfinite(part).all(axis=(0, *range(2, part.ndim))) for part in parts], axis=0)


def roll_out(
    bundle: Bundle,
    codes: Float[Tensor, "characters values"],
    start: State,
    frames: int,
    plan: Plan,
    settings: ControllerSettings | None = None,
    tick: Tick = quiet,
    *,
    grounded: bool = False,
) -> Rollout:
    """Run the controller for some frames under a plan. What turns infinite stays so, for the caller to judge.

    With `grounded` each character moves as its standing foot lets it (grounding.py).
    """
    controller = Controller(bundle, codes, settings or ControllerSettings())
    state, states, slide, rig = start, [], None, rig_of(bundle.body) if grounded else None
    for frame in range(frames):
        before, state = state, controller.step(state, plan(frame, state))
        if rig is not None:
            state, slide = ground(rig, before, state, slide)
        states.append(state)
        tick(1)
    return as_rollout(states)


def as_rollout(states: Sequence[State]) -> Rollout:
    """States one after the other as a rollout."""
    roots = [s.path.root for s in states]
    return Rollout(
        np.stack([s.positions for s in states]),
        np.stack([s.rotations for s in states]),
        np.stack([root.positions for root in roots]),
        np.unwrap(np.stack([root.angles for root in roots]), axis=0),
        np.stack([s.contacts for s in states]),
        np.stack([s.phases for s in states]),
    )


def parse_mixture(text: str) -> dict[str, float]:
    """Styles and weights of `NAME` or `NAME:weight,NAME:weight,...`; raises InputError."""
    mixture: dict[str, float] = {}
    for part in text.split(","):
        name, colon, weight = part.strip().rpartition(":")
        try:
            value = float(weight) if colon else 1.0
        except ValueError as error:
            raise InputError(f"style {part!r}: expected NAME:weight with a number") from error
        name = name if colon else weight
        if not name or name in mixture:
            raise InputError(f"style {part!r}: a name is missing or named twice")
        mixture[name] = value
    return mixture


def mixed_code(bundle: Bundle, mixture: dict[str, float]) -> Float[Tensor, " values"]:
    """The weighted sum of style codes, its weights brought to sum 1 ([M22] 4.4).

    Raises InputError for weights that are no mixture, and for a style that the bundle does not know.
    """
    weights = np.array(list(mixture.values()))
    with np.errstate(over="ignore"):
        whole = weights.sum()
    if not len(weights) or not np.isfinite(whole) or (weights < 0).any() or not whole > 0:
        raise InputError("style weights should be numbers not below zero, with one above")
    codes = torch.stack([bundle.code(style) for style in mixture])
    return torch.from_numpy(weights / whole).float() @ codes


def to_clip(rollout: Rollout, character: int, body: Body, name: str) -> Clip:
    """One character's motion as a clip of the body's skeleton: the hips' path and all rotations, constant bones.

    The network's positions of the other joints are left aside. End sites turn with their parents.
    """
    skeleton, place = body.skeleton, {joint: k for k, joint in enumerate(body.joints)}
    moving = [joint for joint in range(len(skeleton)) if not skeleton.sites[joint]]
    rest = np.swapaxes(body.rest[moving], -1, -2)
    world = rollout.rotations[:, character, [place[joint] for joint in moving]] @ rest
    return from_world(skeleton, world, rollout.positions[:, character, place[0]], name)


def from_world(
    skeleton: Skeleton, rotations: Float[ndarray, "frames moving 3 3"], hips: Float[ndarray, "frames 3"], name: str
) -> Clip:
    """A clip from the hips' path and the rotations in the world of all joints but end sites, in the skeleton's order.

    End sites turn with their parents.
    """
    world, place = np.empty((len(hips), len(skeleton), 3, 3)), iter(range(rotations.shape[1]))
    for joint, parent in enumerate(skeleton.parents):
        world[:, joint] = world[:, parent] if skeleton.sites[joint] else rotations[:, next(place)]
    parents = list(skeleton.parents[1:])
    local = np.concatenate([world[:, :1], np.swapaxes(world[:, parents], -1, -2) @ world[:, 1:]], axis=1)
    return Clip(skeleton, FPS, from_matrix(local), hips, name)
