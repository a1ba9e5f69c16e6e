"""The last touch on what a network gives: constant bones, feet that stay put, hands where they were predicted."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.motion.rotations import unit
from stylephase.runtime.foot_lock import Feet, LockSettings, free_feet, step_feet
from stylephase.runtime.inverse_kinematics import two_bones
from stylephase.runtime.rig import Rig
from stylephase.runtime.rollout import Rollout

_GROUND = [0, 2]
# A knee or elbow less bent than this (m from the line of its limb) is led to bend to the front or back.
_BEND = 0.02
# Knees bend to the front, elbows to the back: both legs, then both arms.
_FRONT = np.array([1.0, 1.0, -1.0, -1.0])[:, None]


def finish_frame(
    rig: Rig,
    feet: Feet | None,
    positions: Float[ndarray, "characters joints 3"],
    rotations: Float[ndarray, "characters joints 3 3"],
    contacts: Float[ndarray, "characters 2"],
    settings: LockSettings | None = None,
) -> tuple[Float[ndarray, "characters joints 3"], Float[ndarray, "characters joints 3 3"], Feet]:
    """One frame of some characters: its positions (m) and rotations with the rig's bones, and the feet to go on with.

    `feet` are those of the frame before, None at the first frame.
    """
    predicted = positions[:, [leg.tip for leg in rig.legs]][..., _GROUND]
    feet = free_feet(predicted) if feet is None else step_feet(feet, predicted, contacts, settings or LockSettings())
    return *pose_with(rig, positions, rotations, feet.places), feet


def finish(run: Rollout, rig: Rig, settings: LockSettings | None = None) -> Rollout:
    """A whole rollout with constant bones and held feet, as frame by frame."""
    toes, feet, places = run.positions[:, :, [leg.tip for leg in rig.legs]][..., _GROUND], None, []
    for predicted, contacts in zip(toes, run.contacts, strict=True):
        now = settings or LockSettings()
        feet = free_feet(predicted) if feet is None else step_feet(feet, predicted, contacts, now)
        places.append(feet.places)
    positions, rotations = pose_with(rig, run.positions, run.rotations, np.stack(places))
    return replace(run, positions=positions, rotations=rotations)


def pose_with(
    rig: Rig,
    positions: Float[ndarray, "*batch joints 3"],
    rotations: Float[ndarray, "*batch joints 3 3"],
    toes: Float[ndarray, "*batch 2 2"],
) -> tuple[Float[ndarray, "*batch joints 3"], Float[ndarray, "*batch joints 3 3"]]:
    """Positions (m) and rotations of a predicted pose with the rig's bones.

    The hips and all rotations are as predicted, but for the long bones of legs and arms: these bring each toe above its
    given place on the ground (x, z) at its predicted height, and each hand to its predicted place. Feet and hands keep
    their predicted rotations.
    """
    placed = rig.place(positions[..., 0, :], rotations)
    start, middle, end, tip = (placed[..., joints, :] for joints in rig.limbs)
    target = positions[..., rig.limbs[3], :]
    target[..., :2, _GROUND] = toes
    pole = _bend(start, middle, end, rotations[..., rig.limbs[0], :, :][..., 2])
    found = two_bones(start, middle, end, target - (tip - end), pole)
    turned = rotations.copy()
    turned[..., rig.limbs[0], :, :] = found.upper_turn @ turned[..., rig.limbs[0], :, :]
    turned[..., rig.limbs[1], :, :] = found.lower_turn @ turned[..., rig.limbs[1], :, :]
    return rig.place(positions[..., 0, :], turned), turned


def _bend(start: ndarray, middle: ndarray, end: ndarray, front: ndarray) -> Float[ndarray, "*batch 4 3"]:
    """The side to which each limb bends: its own, or as it straightens more and more a leg's front or an arm's back.

    These are told by `front`, that of the upper bone at rest. A straight limb has no side, and a noisy one changes it.
    """
    along = unit(end - start)
    sides = middle - start, _FRONT * front
    own, known = (side - (side * along).sum(-1, keepdims=True) * along for side in sides)
    return own + np.maximum(_BEND - (own * known).sum(-1, keepdims=True), 0) * known
