"""The way that the feet tell: a character moves as fast as its standing foot lets it.

A network gives the root's next step and where the joints lie about the root, each as a mean over its data, and the two
need not agree: a standing foot then slides along with the body. Its own velocity, which the network gives too, says
how little it should move. The character as a whole is moved back by the difference.
"""

from dataclasses import replace

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.features.layout import FPS
from stylephase.runtime.controller import State
from stylephase.runtime.rig import Rig
from stylephase.runtime.trajectory import Trajectory

_GROUND = [0, 2]
# The slide is followed within about so many frames, so that the body does not jerk when the feet change over.
_FRAMES = 4.0


def ground(
    rig: Rig, before: State, after: State, slide: Float[ndarray, "characters 2"] | None = None
) -> tuple[State, Float[ndarray, "characters 2"]]:
    """The state after a frame, moved by what its standing feet slid, and the slide (m/s) to go on with.

    Path and pose move alike, so the network does not notice. A foot counts as much as it is in contact; while none is,
    the last slide goes on.
    """
    toes = [leg.tip for leg in rig.legs]
    moved, meant = (after.positions - before.positions)[:, toes] * FPS, after.velocities[:, toes]
    weight = np.clip(after.contacts, 0, 1)[..., None] ** 2
    total = weight.sum(axis=1)
    found = (weight * (moved - meant)[..., _GROUND]).sum(axis=1) / np.maximum(total, 1e-6)
    known = np.zeros_like(found) if slide is None else slide
    known = known + np.minimum(total, 1) / _FRAMES * (found - known)
    return _shifted(after, -known / FPS), known


def _shifted(state: State, step: Float[ndarray, "characters 2"]) -> State:
    """Characters moved over the ground, each with its path."""
    path = Trajectory(state.path.positions + step[:, None], state.path.directions)
    positions = state.positions.copy()
    positions[..., _GROUND] += step[:, None]
    return replace(state, path=path, positions=positions)
