"""A small controller for Holden's released PFNN, on flat ground: one frame after the other, as controller.py."""

from dataclasses import dataclass, replace

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray
from scipy.spatial.transform import Rotation

from stylephase.features.layout import FPS
from stylephase.models import holden
from stylephase.models.released_pfnn import ReleasedPfnn
from stylephase.motion.clip import Clip
from stylephase.motion.root import Root, to_local
from stylephase.motion.skeleton import Skeleton
from stylephase.runtime.plans import Plan
from stylephase.runtime.rollout import Tick, from_world, quiet
from stylephase.runtime.trajectory import Steering, Trajectory, on_ground, unit_ground

# Points of the path, one a frame: a second past, the root, and up to 59 frames to come.
_PAST, _LENGTH = 60, 120
_AT = np.array(holden.SAMPLES) + _PAST
_AHEAD = np.arange(1, _LENGTH - _PAST) / _PAST
# How the future bends towards what is wanted: the weight at share s of the second is 1 - (1 - s)^bias. With less for
# the places, slow walkers drift to the right; some degrees of that are left, whatever the bias.
_POSITION_BIAS, _DIRECTION_BIAS = 2.0, 2.0
# Weight of the predicted joint positions against the last ones carried on by their velocity.
_POSE_SHARE = 0.5
_POSE_PARTS = (holden.Y_POSITIONS, holden.Y_VELOCITIES)

# One of the network's gaits, or how much of each gait there is in each character.
Gait = str | Float[ndarray, "characters gaits"]


@dataclass(frozen=True)
class PfnnState:
    """Some characters between two frames.

    `places` and `facings` (x, z) are points of their paths, `local` and `velocities` (m a frame) the joints as seen
    from the last frame's root, `positions` (m) and `rotations` the joints in the world, `phase` (rad) the global phase,
    `contacts` the toes' (right, left).
    """

    places: Float[ndarray, "characters points 2"]
    facings: Float[ndarray, "characters points 2"]
    local: Float[ndarray, "characters joints 3"]
    velocities: Float[ndarray, "characters joints 3"]
    positions: Float[ndarray, "characters joints 3"]
    rotations: Float[ndarray, "characters joints 3 3"]
    phase: Float[ndarray, " characters"]
    contacts: Float[ndarray, "characters 2"]

    @property
    def path(self) -> Trajectory:
        """The characters' paths."""
        return Trajectory(self.places, self.facings)

    @property
    def root(self) -> Root:
        """The characters' root frames."""
        return self.path.root


def start_pfnn(released: ReleasedPfnn, characters: int) -> PfnnState:
    """Characters at the origin in the mean pose, facing +z, with the mean path behind and ahead."""
    points = np.arange(_LENGTH) - _PAST
    places = np.zeros((characters, _LENGTH, 2))
    depth = released.x_mean[holden.X_PLACES][len(holden.SAMPLES) :]
    places[:, :, 1] = np.interp(points, holden.SAMPLES, depth)
    facings = np.tile([0.0, 1.0], (characters, _LENGTH, 1))
    positions, velocities = (_joints(np.tile(released.y_mean[part], (characters, 1))) for part in _POSE_PARTS)
    rotations = _rotations(np.tile(released.y_mean[holden.Y_ROTATIONS], (characters, 1)))
    still = np.zeros(characters)
    return PfnnState(places, facings, positions, velocities, positions, rotations, still, np.zeros((characters, 2)))


def _joints(values: Float[ndarray, "characters values"]) -> Float[ndarray, "characters joints 3"]:
    return values.reshape(len(values), holden.JOINTS, 3)


def _rotations(values: Float[ndarray, "characters values"]) -> Float[ndarray, "characters joints 3 3"]:
    """Rotations of their logarithms, which the release keeps as half of the rotation vector."""
    return Rotation.from_rotvec(2 * values.reshape(-1, 3)).as_matrix().reshape(len(values), holden.JOINTS, 3, 3)


def gait_labels(gait: Gait) -> Float[ndarray, "characters gaits"]:
    """How much of each gait there is; a single row where it is the same for all."""
    return np.eye(len(holden.GAITS))[[holden.GAITS.index(gait)]] if isinstance(gait, str) else gait


def pfnn_input(state: PfnnState, gait: Gait = "walk") -> Float[ndarray, "characters inputs"]:
    """The network's input (m): path, gait, the last pose; the ground is flat."""
    inverse, root = on_ground(-state.root.angles), state.root
    x = np.zeros((len(state.phase), holden.INPUTS))
    places = np.einsum("nij,npj->nip", inverse, state.places[:, _AT] - root.positions[:, None])
    facings = np.einsum("nij,npj->nip", inverse, state.facings[:, _AT])
    x[:, holden.X_PLACES], x[:, holden.X_FACINGS] = (part.reshape(len(x), -1) for part in (places, facings))
    x[:, holden.X_GAITS] = np.repeat(gait_labels(gait), len(holden.SAMPLES), axis=1)
    x[:, holden.X_POSITIONS] = state.local.reshape(len(x), -1)
    x[:, holden.X_VELOCITIES] = state.velocities.reshape(len(x), -1)
    return x


def _predict(released: ReleasedPfnn, x: ndarray, phase: Float[ndarray, " characters"]) -> ndarray:
    scaled = torch.from_numpy((x - released.x_mean) / released.x_std).float()
    angle = torch.from_numpy(phase)[:, None].float()
    with torch.inference_mode():
        y = released.network(scaled, angle, torch.zeros(len(x), 0)).double().numpy()
    return y * released.y_std + released.y_mean


def step_pfnn(released: ReleasedPfnn, state: PfnnState, steering: Steering, gait: Gait = "walk") -> PfnnState:
    """The next frame: bend the path, predict, take the root's step, and lay the predicted future before it."""
    bent = _bent(state, steering)
    y, root = _predict(released, pfnn_input(bent, gait), state.phase), bent.root
    local, velocities = (_joints(y[:, part]) for part in _POSE_PARTS)
    origin = np.stack([root.positions[:, 0], np.zeros(len(y)), root.positions[:, 1]], axis=-1)[:, None]
    carried = state.positions + np.einsum("nij,npj->npi", root.matrices, velocities)
    predicted = np.einsum("nij,npj->npi", root.matrices, local) + origin
    positions = carried + _POSE_SHARE * (predicted - carried)
    phase = (state.phase + 2 * np.pi * y[:, holden.Y_PHASE]) % (2 * np.pi)
    contacts = y[:, holden.Y_CONTACTS][:, list(holden.TOE_CONTACTS)]
    rotations = root.matrices[:, None] @ _rotations(y[:, holden.Y_ROTATIONS])
    return PfnnState(*_advanced(bent, y), to_local(root, positions), velocities, positions, rotations, phase, contacts)


def _bent(state: PfnnState, steering: Steering) -> PfnnState:
    """The same with the future of the path bent towards what the user wants."""
    towards, turning = (1 - (1 - _AHEAD) ** bias for bias in (_POSITION_BIAS, _DIRECTION_BIAS))
    steps = np.diff(state.places[:, _PAST:], axis=1)
    steps = steps + towards[:, None] * (steering.velocity[:, None] / FPS - steps)
    ahead = state.facings[:, _PAST + 1 :]
    wanted = np.stack([np.sin(steering.facing), np.cos(steering.facing)], axis=-1)[:, None]
    places, facings = state.places.copy(), state.facings.copy()
    places[:, _PAST + 1 :] = places[:, _PAST, None] + np.cumsum(steps, axis=1)
    facings[:, _PAST + 1 :] = unit_ground(ahead + turning[:, None] * (wanted - ahead), ahead)
    return replace(state, places=places, facings=facings)


def _advanced(state: PfnnState, y: ndarray) -> tuple[ndarray, ndarray]:
    """The path one frame on: the past takes in the old root, root and future follow the network."""
    root = state.root
    place = root.positions + np.einsum("nij,nj->ni", on_ground(root.angles), y[:, holden.Y_STEP])
    angles = root.angles - y[:, holden.Y_TURN]
    turned, paths = on_ground(angles), []
    for part, old in ((holden.Y_PLACES, state.places), (holden.Y_FACINGS, state.facings)):
        samples = y[:, part].reshape(len(y), 2, -1).transpose(0, 2, 1)
        world = np.einsum("nij,npj->npi", turned, _filled(samples))
        world = world + place[:, None] if part is holden.Y_PLACES else unit_ground(world, world)
        paths += [np.concatenate([old[:, 1 : _PAST + 1], world], axis=1)]
    places, facings = paths
    places[:, _PAST] = place
    facings[:, _PAST] = np.stack([np.sin(angles), np.cos(angles)], axis=-1)
    return places, facings


def _filled(samples: Float[ndarray, "characters samples 2"]) -> Float[ndarray, "characters points 2"]:
    """Values at every future point: straight between the samples, and past the last one on in its direction."""
    points, at = np.arange(_LENGTH - _PAST), np.array(holden.FUTURE_SAMPLES)
    left = np.clip(np.searchsorted(at, points, side="right") - 1, 0, len(at) - 2)
    share = ((points - at[left]) / (at[left + 1] - at[left]))[:, None]
    return (1 - share) * samples[:, left] + share * samples[:, left + 1]


@dataclass(frozen=True)
class PfnnRollout:
    """Motion of some characters in the world: joints (m), root, phase (rad), contacts of toes (right, left)."""

    positions: Float[ndarray, "frames characters joints 3"]
    rotations: Float[ndarray, "frames characters joints 3 3"]
    root_positions: Float[ndarray, "frames characters 2"]
    root_angles: Float[ndarray, "frames characters"]
    phase: Float[ndarray, "frames characters"]
    contacts: Float[ndarray, "frames characters 2"]


def roll_out_pfnn(
    released: ReleasedPfnn, start: PfnnState, frames: int, plan: Plan, gait: str = "walk", tick: Tick = quiet
) -> PfnnRollout:
    """Run the controller for some frames under a plan."""
    state, states = start, []
    for frame in range(frames):
        state = step_pfnn(released, state, plan(frame, state), gait)
        tick(1)
        states.append(state)
    roots = [s.root for s in states]
    return PfnnRollout(
        np.stack([s.positions for s in states]),
        np.stack([s.rotations for s in states]),
        np.stack([root.positions for root in roots]),
        np.unwrap(np.stack([root.angles for root in roots]), axis=0),
        np.stack([s.phase for s in states]),
        np.stack([s.contacts for s in states]),
    )


def pfnn_clip(rollout: PfnnRollout, character: int, skeleton: Skeleton, name: str) -> Clip:
    """One character's motion as a clip of the skeleton that Holden's takes have: the hips' path and all rotations."""
    rotations = rollout.rotations[:, character]
    return from_world(skeleton, rotations, rollout.positions[:, character, holden.HIPS], name)
