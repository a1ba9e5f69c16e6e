"""The released network walks in every style at once, as its own demonstration would let it ([M22] release 2.1)."""

from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Bool, Float
from numpy import ndarray

from stylephase.evaluation.motion import Bones, Steps, bones_of, correlation, steps_of
from stylephase.evaluation.rollouts import SETTLE
from stylephase.models.bundle import Bundle
from stylephase.runtime.calibration import speed_of
from stylephase.runtime.controller import RELEASE, start_state
from stylephase.runtime.plans import Steady
from stylephase.runtime.rollout import Tick, quiet, roll_out

# What the demonstration asks for (a gain, not m/s), and how long is watched.
GAIN, FRAMES = 6.0, 480
# A foot is down above the middle of its own contacts' range: dragged feet hardly leave theirs. Less than this is none.
_RANGE = 0.1
# Feet of a walk take turns, and a cycle takes longer than this (s): a tremble is no walk.
_APART, _SHORTEST = -0.3, 0.4


@dataclass(frozen=True)
class ReleaseWalk:
    """One style's walk: speed (m/s), steps, correlation of both feet's contacts, and how its bones hold."""

    style: str
    speed: float
    steps: Steps
    correlation: float
    bones: Bones
    finite: bool

    @property
    def walks(self) -> bool:
        """Whether its feet take turns, in cycles as long as a person's."""
        return self.finite and self.correlation < _APART and self.steps.cycle > _SHORTEST


def own_contacts(values: Float[ndarray, "frames 2"]) -> Bool[ndarray, "frames 2"]:
    """Where each foot is down, by the range of its own values; a foot whose values hardly change never is."""
    low, high = values.min(axis=0), values.max(axis=0)
    return (values > (low + high) / 2) & (high - low > _RANGE)


def release_walks(bundle: Bundle, *, frames: int = FRAMES, tick: Tick = quiet) -> list[ReleaseWalk]:
    """All styles of the bundle side by side, from the mean pose with phases at zero; the first seconds only settle."""
    codes = torch.stack(list(bundle.codes.values()))
    still = np.zeros((len(codes), bundle.layout.gate_inputs))
    start = start_state(np.tile(bundle.normaliser.x_mean, (len(codes), 1)), still, bundle.layout)
    run = roll_out(bundle, codes, start, frames, Steady(np.full(len(codes), GAIN)), RELEASE, tick)
    skeleton, joints, bones = bundle.body.skeleton, bundle.body.joints, bundle.body.bones
    true = np.array([np.linalg.norm(skeleton.offsets[joints[child]]) for _, child in bones])
    return [
        ReleaseWalk(
            style,
            speed_of(run.root_positions[SETTLE:, k]),
            steps_of(own_contacts(run.contacts[SETTLE:, k])),
            correlation(run.contacts[SETTLE:, k]),
            bones_of(run.positions[SETTLE:, k], bones, true),
            bool(run.finite[k]),
        )
        for k, style in enumerate(bundle.styles)
    ]
