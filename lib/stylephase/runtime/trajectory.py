"""The path that the character follows: the past second, the root, and the second to come ([M22] release 5.1, 5.2)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.features.layout import FPS, INPUT_SAMPLES, OUTPUT_SAMPLES
from stylephase.motion.root import Root

# Points of the path: one per frame, 60 past, the root, 60 to come.
# Differs: the release has 50 points to come, which stand for the same second.
PAST = -min(INPUT_SAMPLES)
FUTURE = max(INPUT_SAMPLES)
_AHEAD = np.arange(1, FUTURE + 1) / FUTURE


@dataclass(frozen=True)
class Steering:
    """What the user wants of each character, in the world: a velocity (m/s, times a gain) and a facing (rad)."""

    velocity: Float[ndarray, "characters 2"]
    facing: Float[ndarray, " characters"]


@dataclass(frozen=True)
class Trajectory:
    """Positions and unit directions on the ground (x, z) of the points of each character's path."""

    positions: Float[ndarray, "characters points 2"]
    directions: Float[ndarray, "characters points 2"]

    @property
    def root(self) -> Root:
        """The characters' root frames."""
        facing = self.directions[:, PAST]
        return Root(self.positions[:, PAST], np.arctan2(facing[:, 0], facing[:, 1]))


def on_ground(angles: Float[ndarray, " characters"]) -> Float[ndarray, "characters 2 2"]:
    """Rotations of ground vectors (x, z) from root to world."""
    sine, cosine = np.sin(angles), np.cos(angles)
    return np.stack([cosine, sine, -sine, cosine], axis=-1).reshape(len(angles), 2, 2)


def unit_ground(
    vectors: Float[ndarray, "*batch 2"], otherwise: Float[ndarray, "*batch 2"]
) -> Float[ndarray, "*batch 2"]:
    """Vectors of length 1; where there is no length, `otherwise`."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.where(length > 1e-6, vectors / np.maximum(length, 1e-6), otherwise)


def from_samples(samples: Float[ndarray, "characters values"], root: Root) -> Trajectory:
    """A path through the trajectory part of an input x, placed at `root`; between the samples it is straight."""
    values = samples.reshape(len(samples), len(INPUT_SAMPLES), 4)
    points = np.arange(-PAST, FUTURE + 1)
    filled = np.stack(
        [[np.interp(points, INPUT_SAMPLES, column) for column in character.T] for character in values]
    ).transpose(0, 2, 1)
    turned = on_ground(root.angles)
    positions = np.einsum("nij,npj->npi", turned, filled[..., :2]) + root.positions[:, None]
    directions = np.einsum("nij,npj->npi", turned, filled[..., 2:])
    return Trajectory(positions, unit_ground(directions, directions))


def samples_of(path: Trajectory) -> Float[ndarray, "characters values"]:
    """The trajectory part of the input x: samples of the path as seen from the root."""
    root, at = path.root, np.array(INPUT_SAMPLES) + PAST
    inverse = on_ground(-root.angles)
    positions = np.einsum("nij,npj->npi", inverse, path.positions[:, at] - root.positions[:, None])
    directions = np.einsum("nij,npj->npi", inverse, path.directions[:, at])
    return np.concatenate([positions, directions], axis=-1).reshape(len(positions), -1)


def steer(
    path: Trajectory, steering: Steering, *, position_bias: float, direction_bias: float, reach: float
) -> Trajectory:
    """Bend the future towards what the user wants, the more the further ahead ([M22] release 5.2).

    The user's weight at a point that lies the share s of the second ahead is 1 - (1 - `reach` s)^bias.
    """
    towards, turning = (1 - (1 - reach * _AHEAD) ** bias for bias in (position_bias, direction_bias))
    steps = np.diff(path.positions[:, PAST:], axis=1)
    steps = steps + towards[:, None] * (steering.velocity[:, None] / FPS - steps)
    positions, directions = path.positions.copy(), path.directions.copy()
    positions[:, PAST + 1 :] = positions[:, PAST : PAST + 1] + np.cumsum(steps, axis=1)
    wanted = np.stack([np.sin(steering.facing), np.cos(steering.facing)], axis=-1)[:, None]
    ahead = directions[:, PAST + 1 :]
    directions[:, PAST + 1 :] = unit_ground(ahead + turning[:, None] * (wanted - ahead), ahead)
    return Trajectory(positions, directions)


def advance(
    path: Trajectory, predicted: Float[ndarray, "characters samples 4"], root_share: float, share: float
) -> Trajectory:
    """Move one frame on: the past takes in the old root, root and future follow the network's samples (world).

    `root_share` is the share of the predicted root step that is taken, `share` the weight of the network against the
    present path in the samples to come; between the samples the path is straight ([M22] release 5.3).
    """
    at = np.array(OUTPUT_SAMPLES)
    weight = np.where(at == 0, root_share, share)[:, None]
    present = path.positions[:, PAST + at], path.directions[:, PAST + at]
    places = present[0] + weight * (predicted[..., :2] - present[0])
    facing = unit_ground(present[1] + weight * (predicted[..., 2:] - present[1]), present[1])
    positions = np.concatenate([path.positions[:, 1 : PAST + 1], _between(places)], axis=1)
    directions = np.concatenate([path.directions[:, 1 : PAST + 1], _between(facing)], axis=1)
    return Trajectory(positions, unit_ground(directions, path.directions))


def _between(samples: Float[ndarray, "characters samples 2"]) -> Float[ndarray, "characters points 2"]:
    """Values at every future point, linear between the samples."""
    points = np.arange(FUTURE + 1)
    right = np.clip(np.searchsorted(OUTPUT_SAMPLES, points), 1, len(OUTPUT_SAMPLES) - 1)
    at = np.array(OUTPUT_SAMPLES)
    share = ((points - at[right - 1]) / (at[right] - at[right - 1]))[:, None]
    return (1 - share) * samples[:, right - 1] + share * samples[:, right]
