"""Feet that stay where they stand ([M22] release 5.4, with a state of its own for each foot).

The network says when a foot is in contact. From then on it rests where it came to a stop; afterwards it finds back to
the predicted foot. It is a step at a time, for any number of characters, so that a live character can have it too.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from stylephase.features.layout import FPS


@dataclass(frozen=True)
class LockSettings:
    """How feet are held.

    A foot is held while its contact is above `hold`, until it falls below `release`, or until the predicted foot is
    `stretch` (m) away. It stops within about `stopping` seconds and finds back within about `returning` seconds.
    """

    hold: float = 0.5
    release: float = 0.4
    stretch: float = 0.25
    stopping: float = 0.01
    returning: float = 0.15


@dataclass(frozen=True)
class Feet:
    """The feet (right, left) of some characters on the ground: places (m) as (x, z), and which are held.

    `predicted` is where the network last had them and `moving` how fast (m/s); `drift` is how much faster the feet are.
    """

    places: Float[ndarray, "characters 2 2"]
    drift: Float[ndarray, "characters 2 2"]
    held: Bool[ndarray, "characters 2"]
    predicted: Float[ndarray, "characters 2 2"]
    moving: Float[ndarray, "characters 2 2"]


def free_feet(predicted: Float[ndarray, "characters 2 2"]) -> Feet:
    """Feet that are where the network has them, at rest and not held."""
    still = np.zeros_like(predicted)
    return Feet(predicted, still, np.zeros(predicted.shape[:2], dtype=bool), predicted, still)


def step_feet(
    feet: Feet,
    predicted: Float[ndarray, "characters 2 2"],
    contacts: Float[ndarray, "characters 2"],
    settings: LockSettings,
) -> Feet:
    """The next frame: held feet come to rest, the others return to the predicted ones like a damped spring."""
    apart = np.linalg.norm(feet.places - predicted, axis=-1)
    threshold = np.where(feet.held, settings.release, settings.hold)
    held = (contacts > threshold) & (apart < settings.stretch)
    moving = (predicted - feet.predicted) * FPS
    stopping = (feet.drift + feet.moving) * np.exp(-1 / (FPS * settings.stopping))
    offset, drift = _returned(feet.places - feet.predicted, feet.drift, settings.returning)
    resting = held[..., None]
    places = np.where(resting, feet.places + stopping / FPS, predicted + offset)
    return Feet(places, np.where(resting, stopping - moving, drift), held, predicted, moving)


def _returned(offset: ndarray, drift: ndarray, seconds: float) -> tuple[ndarray, ndarray]:
    """A critically damped spring's offset (m) and its rate (m/s), one frame later."""
    rate = 2 / seconds
    pull, fade = drift + rate * offset, np.exp(-rate / FPS)
    return (offset + pull / FPS) * fade, (drift - rate * pull / FPS) * fade
