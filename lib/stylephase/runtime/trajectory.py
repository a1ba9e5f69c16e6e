"""The path that the character follows: the past second, the root, and the second to come ([M22] release 5.1, 5.2)."""

from collections.abc import Sequence
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
# Where the samples of input and output lie on the path, and which of the output is the root.
_IN, _OUT = np.array(INPUT_SAMPLES) + PAST, np.array(OUTPUT_SAMPLES) + PAST
_AT_ROOT = (_OUT == PAST)[:, None]


def _between(samples: Sequence[int], first: int) -> Float[ndarray, "points samples"]:
    """Weights of the samples at every point from `first` on: linear between two neighbours."""
    points = np.arange(first, FUTURE + 1)
    return np.stack([np.interp(points, samples, one) for one in np.eye(len(samples))], axis=1)


_PATH, _FUTURE = _between(INPUT_SAMPLES, -PAST), _between(OUTPUT_SAMPLES, 0)


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
    turns = np.empty((len(angles), 2, 2))
    turns[:, 0, 0] = turns[:, 1, 1] = np.cos(angles)
    turns[:, 0, 1] = np.sin(angles)
    turns[:, 1, 0] = -turns[:, 0, 1]
    return turns


def unit_ground(
    vectors: Float[ndarray, "*batch 2"], otherwise: Float[ndarray, "*batch 2"]
) -> Float[ndarray, "*batch 2"]:
    """Vectors of length 1; where there is no length, `otherwise`."""
    length = np.hypot(vectors[..., 0], vectors[..., 1])[..., None]
    return np.divide(vectors, length, out=otherwise.copy(), where=length > 1e-6)


def to_world(samples: Float[ndarray, "characters samples 4"], root: Root) -> Float[ndarray, "characters samples 4"]:
    """Samples (place, direction) that are seen from the root, in the world."""
    turned = _turned(samples, on_ground(-root.angles))
    turned[..., :2] += root.positions[:, None]
    return turned


def _turned(samples: Float[ndarray, "characters samples 4"], turns: ndarray) -> Float[ndarray, "characters samples 4"]:
    """Places and directions times a matrix of each character."""
    return (samples.reshape(len(samples), -1, 2) @ turns).reshape(samples.shape)


def from_samples(samples: Float[ndarray, "characters values"], root: Root) -> Trajectory:
    """A path through the trajectory part of an input x, placed at `root`; between the samples it is straight."""
    path = to_world(_PATH @ samples.reshape(len(samples), len(INPUT_SAMPLES), 4), root)
    directions = path[..., 2:]
    return Trajectory(path[..., :2], unit_ground(directions, directions))


def samples_of(path: Trajectory) -> Float[ndarray, "characters values"]:
    """The trajectory part of the input x: samples of the path as seen from the root."""
    root = path.root
    samples = np.concatenate([path.positions[:, _IN], path.directions[:, _IN]], axis=-1)
    samples[..., :2] -= root.positions[:, None]
    return _turned(samples, on_ground(root.angles)).reshape(len(samples), -1)


def steer(
    path: Trajectory, steering: Steering, *, position_bias: float, direction_bias: float, reach: float
) -> Trajectory:
    """Bend the future towards what the user wants, the more the further ahead ([M22] release 5.2).

    The user's weight at a point that lies the share s of the second ahead is 1 - (1 - `reach` s)^bias.
    """
    towards, turning = (1 - (1 - reach * _AHEAD) ** bias for bias in (position_bias, direction_bias))
    positions, directions = path.positions.copy(), path.directions.copy()
    steps = positions[:, PAST + 1 :] - positions[:, PAST:-1]
    steps += towards[:, None] * (steering.velocity[:, None] / FPS - steps)
    positions[:, PAST + 1 :] = positions[:, PAST, None] + steps.cumsum(axis=1)
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
    samples = np.concatenate([path.positions[:, _OUT], path.directions[:, _OUT]], axis=-1)
    present = samples[..., 2:].copy()
    samples += np.where(_AT_ROOT, root_share, share) * (predicted - samples)
    samples[..., 2:] = unit_ground(samples[..., 2:], present)
    future = _FUTURE @ samples
    positions = np.concatenate([path.positions[:, 1 : PAST + 1], future[..., :2]], axis=1)
    directions = np.concatenate([path.directions[:, 1 : PAST + 1], future[..., 2:]], axis=1)
    return Trajectory(positions, unit_ground(directions, path.directions))
