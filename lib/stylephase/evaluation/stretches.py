"""Unbroken stretches of walking, recorded and generated, in one form, so that both are measured alike."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray

from stylephase.evaluation.rollouts import SETTLE, codes_of, local_poses, start_of
from stylephase.features.body import Body
from stylephase.features.clips import walking_gaits
from stylephase.features.layout import FPS, Layout
from stylephase.features.store import StyleVectors
from stylephase.models.bundle import Bundle
from stylephase.phase.global_phase import global_phase
from stylephase.runtime.controller import State, start_state
from stylephase.runtime.plans import Steady
from stylephase.runtime.rollout import Rollout, roll_out

_CONTACT = 0.5


@dataclass(frozen=True)
class Stretch:
    """Some seconds of one character: poses as in x, the global phase (rad), and contacts (right, left)."""

    poses: Float[ndarray, "frames pose"]
    phase: Float[ndarray, " frames"]
    contacts: Bool[ndarray, "frames 2"]

    def __len__(self) -> int:
        return len(self.poses)

    @property
    def joints(self) -> Float[ndarray, "frames joints 4 3"]:
        """A copy of the poses by joint: position, forward, up, velocity."""
        return self.poses.reshape(len(self), -1, 4, 3).astype(float)

    def at(self, rows: slice | Int[ndarray, " chosen"]) -> "Stretch":
        """Some of its frames."""
        return Stretch(self.poses[rows], self.phase[rows], self.contacts[rows])


def recorded(style: StyleVectors, layout: Layout, shortest: float = 4.0) -> list[Stretch]:
    """The forward walks of a style that last at least so many seconds, take by take, whatever their part of the split.

    Where none does, the longest. Of all gaits where the data name no walk.
    """
    gaits = walking_gaits(style) or style.gaits
    takes = [np.flatnonzero(style.take == k) for k, gait in enumerate(style.gaits) if gait in gaits]
    long = [rows for rows in takes if len(rows) >= shortest * FPS] or [max(takes, key=len)]
    return [
        Stretch(style.x[rows][:, layout.x_pose], style.phase[rows], style.y[rows][:, -2:] > _CONTACT) for rows in long
    ]


def generated(run: Rollout, character: int, settle: int = SETTLE) -> Stretch | None:
    """A rollout's character after the settling frames, with the global phase of its contacts by the rule of recorded
    ones; None where it did not stay finite."""
    if not run.finite[character]:
        return None
    contacts = run.contacts[1:, character] > _CONTACT
    phase = global_phase(contacts, FPS)
    return Stretch(local_poses(run, character)[settle:], phase[settle:], contacts[settle:])


def free_walks(
    bundle: Bundle, styles: Sequence[StyleVectors], gains: Sequence[float], seconds: float = 20.0
) -> Rollout:
    """Every style walks straight on from a pose of its data, at its gain (m/s)."""
    plan = Steady(np.array(gains, dtype=float))
    return roll_out(bundle, codes_of(bundle, styles), start_of(styles, bundle.body), int(seconds * FPS), plan)


def walks_from(bundle: Bundle, style: StyleVectors, gain: float, starts: int, seconds: float = 20.0) -> Rollout:
    """One style walks straight on from several frames of its data, which differ in how hands and feet go together."""
    codes = bundle.code(style.style).expand(starts, -1)
    state = starts_of(style, bundle.body, starts)
    return roll_out(bundle, codes, state, int(seconds * FPS), Steady(np.full(starts, gain)))


def starts_of(style: StyleVectors, body: Body, count: int) -> State:
    """Characters of one style at frames spread evenly over its training rows of forward walks (or of all gaits)."""
    walks = walking_gaits(style) or style.gaits
    rows = style.rows("train")
    walking = rows[np.isin(np.array(style.gaits)[style.take[rows]], walks)]
    rows = walking if len(walking) else rows
    chosen = rows[((np.arange(count) + 0.5) * len(rows) / count).astype(int)]
    return start_state(style.x[chosen].astype(float), style.p[chosen].astype(float), body.layout)
