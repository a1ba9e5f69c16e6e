"""A controller whose path is given frame by frame, as [M18] 8.2 drives it along the path of another motion."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from torch import Tensor

from stylephase.features.layout import FPS
from stylephase.models.bundle import Bundle
from stylephase.motion.root import Root
from stylephase.runtime.controller import Controller, ControllerSettings, State
from stylephase.runtime.rollout import Rollout, as_rollout
from stylephase.runtime.trajectory import FUTURE, PAST, Steering, Trajectory

# With these the steering has no weight: the future is the path that is given.
_LED = ControllerSettings(path_share=0.0, position_bias=0.0, direction_bias=0.0)


def roll_out_led(
    bundle: Bundle, codes: Float[Tensor, "characters values"], start: State, paths: Sequence[Root]
) -> Rollout:
    """Each character walks along a path of its own, all of one length, at 60 frames a second.

    At every frame the coming second of the path is put in place of what the network foresaw, beginning where the
    character is and ending where the path is. Past its end a path goes on straight.
    """
    controller, states, state = Controller(bundle, codes, _LED), [], start
    nothing = Steering(np.zeros((len(paths), 2)), np.zeros(len(paths)))
    places = np.stack([_prolonged(root.positions) for root in paths])
    facings = np.stack([np.pad(root.angles, (0, FUTURE + 1), mode="edge") for root in paths])
    for frame in range(len(paths[0])):
        state = controller.step(replace(state, path=_led(state.path, places, facings, frame)), nothing)
        states.append(state)
    return as_rollout(states)


def _led(
    path: Trajectory,
    places: Float[ndarray, "characters frames 2"],
    facings: Float[ndarray, "characters frames"],
    frame: int,
) -> Trajectory:
    """The path with its future as given; the way that a character is off is made up for evenly over the second."""
    coming, share = slice(frame + 1, frame + 1 + FUTURE), np.arange(1, FUTURE + 1)[:, None] / FUTURE
    positions, directions = path.positions.copy(), path.directions.copy()
    off = path.positions[:, PAST, None] - places[:, frame, None]
    positions[:, PAST + 1 :] = places[:, coming] + (1 - share) * off
    directions[:, PAST + 1 :] = np.stack([np.sin(facings[:, coming]), np.cos(facings[:, coming])], axis=-1)
    return Trajectory(positions, directions)


def _prolonged(places: Float[ndarray, "frames 2"]) -> Float[ndarray, "longer 2"]:
    """The path with a second more, on its last half second's way."""
    back = min(int(FPS / 2), len(places) - 1)
    step = (places[-1] - places[-1 - back]) / back
    return np.concatenate([places, places[-1] + np.arange(1, FUTURE + 2)[:, None] * step])
