"""From a take to its phases: contacts, source functions, local phases and the global phase in one call."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from stylephase.motion.clip import Clip, Pose, forward_kinematics
from stylephase.motion.contacts import ContactRule, foot_contacts
from stylephase.motion.skeleton import Skeleton
from stylephase.phase.global_phase import global_phase
from stylephase.phase.local import (
    LocalPhases,
    PhaseVariant,
    effector_speeds,
    hand_directions,
    phases_of_sources,
    source_functions,
)


@dataclass(frozen=True)
class TakePhases:
    """Phases of one take, frame by frame at `fps`.

    `local` are those of LeftHand, RightHand, LeftFoot, RightFoot, `sources` the functions they were read from
    (z-scores), `contacts` those of the right and left foot, `directions` the principal directions of the left and
    right hand in the hips' frame (left, up, forward).
    """

    local: LocalPhases
    sources: Float[ndarray, "frames 4"]
    contacts: Bool[ndarray, "frames 2"]
    directions: Float[ndarray, "2 3"]
    fps: float

    @cached_property
    def global_phase(self) -> Float[ndarray, " frames"]:
        """The global phase (rad, [0, 2 pi)): 0 where the right foot comes down, pi where the left does ([M18] 5.1)."""
        return global_phase(self.contacts, self.fps)

    def arrays(self) -> dict[str, ndarray]:
        """What a file of phases holds: all but sources and directions, as plain arrays by name."""
        return {
            "vectors": self.local.vectors,
            "phase": self.local.phase,
            "magnitude": self.local.magnitude,
            "frequency": self.local.frequency,
            "contacts": self.contacts,
            "global_phase": self.global_phase,
            "fps": np.array(self.fps),
        }


def take_phases(clip: Clip, rule: ContactRule, how: PhaseVariant) -> TakePhases:
    """Phases of a clip at its own frame rate, with the principal directions of the clip alone ([M22] 4.1).

    Every result is finite, whatever moves. Raises InputError where the skeleton's hands, feet or hips cannot be told.
    """
    pose = forward_kinematics(clip)
    return pose_phases(pose, clip.skeleton, clip.fps, rule, hand_directions([pose], clip.skeleton), how)


def pose_phases(
    pose: Pose,
    skeleton: Skeleton,
    fps: float,
    rule: ContactRule,
    directions: Float[ndarray, "2 3"],
    how: PhaseVariant,
) -> TakePhases:
    """Phases of a take of which the poses are known, with given principal directions of the left and right hand."""
    contacts = foot_contacts(pose.positions[:, list(skeleton.roles.toe_sensors[::-1])], fps, rule)
    sources = source_functions(pose, skeleton, fps, contacts, directions, how)
    local = phases_of_sources(sources, effector_speeds(pose, skeleton, fps), fps, how)
    return TakePhases(local, sources, contacts, directions, fps)
