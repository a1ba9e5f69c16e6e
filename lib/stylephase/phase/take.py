"""From a take to its phases: contacts, source functions, local phases and the global phase in one call."""

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from stylephase.motion.clip import Clip, Pose, forward_kinematics, velocities
from stylephase.motion.contacts import ContactRule, foot_contacts
from stylephase.motion.root import hips_frame
from stylephase.motion.skeleton import Skeleton
from stylephase.phase.global_phase import global_phase
from stylephase.phase.local import LocalPhases, PhaseVariant, local_phases
from stylephase.phase.source import Movement, Sourcing, sourcing


@dataclass(frozen=True)
class TakePhases:
    """Phases of one take, frame by frame at `fps`.

    `local` are those of LeftHand, RightHand, LeftFoot, RightFoot, `contacts` those of the right and left foot,
    `sourcing` says what the phases were read from.
    """

    local: LocalPhases
    contacts: Bool[ndarray, "frames 2"]
    sourcing: Sourcing
    fps: float

    @cached_property
    def global_phase(self) -> Float[ndarray, " frames"]:
        """The global phase (rad, [0, 2 pi)): 0 where the right foot comes down, pi where the left does ([M18] 5.1)."""
        return global_phase(self.contacts, self.fps)

    def arrays(self) -> dict[str, ndarray]:
        """What a file of phases holds, as plain arrays by name."""
        return {
            "vectors": self.local.vectors,
            "phase": self.local.phase,
            "magnitude": self.local.magnitude,
            "frequency": self.local.frequency,
            "contacts": self.contacts,
            "global_phase": self.global_phase,
            "fps": np.array(self.fps),
        }


def take_phases(
    clip: Clip,
    rule: ContactRule,
    how: PhaseVariant,
    *,
    sources: str = "hybrid",
    contact_free: Collection[str] = (),
) -> TakePhases:
    """Phases of a clip at its own frame rate, with source functions chosen for the clip alone ([M22] 4.1).

    Every result is finite, whatever moves. Raises InputError where the skeleton's hands, feet or hips cannot be told.
    """
    movement = movement_of(forward_kinematics(clip), clip.skeleton, clip.fps, rule)
    return movement_phases(movement, sourcing([movement], sources=sources, contact_free=contact_free), how)


def movement_of(pose: Pose, skeleton: Skeleton, fps: float, rule: ContactRule) -> Movement:
    """The movement of a take of which the poses are known."""
    contacts = foot_contacts(pose.positions[:, list(skeleton.roles.toe_sensors[::-1])], fps, rule)
    return Movement(hips_frame(pose, skeleton, skeleton.roles.effectors), contacts, fps)


def movement_phases(movement: Movement, chosen: Sourcing, how: PhaseVariant) -> TakePhases:
    """Phases of a movement, read from chosen source functions."""
    speeds = np.linalg.norm(velocities(movement.places, movement.fps), axis=-1)
    local = local_phases(chosen.functions(movement), speeds, movement.fps, how)
    return TakePhases(local, movement.contacts, chosen, movement.fps)
