"""Input x, phases p and output y of every frame of a take ([M22] 3.2)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from stylephase.features.layout import INPUT_SAMPLES, OUTPUT_SAMPLES, feature_joints
from stylephase.motion.clip import Pose, velocities
from stylephase.motion.root import Root, root_of, rotate_to_local, to_local, turn
from stylephase.motion.skeleton import Skeleton
from stylephase.phase.circular import wrap


@dataclass(frozen=True)
class Vectors:
    """Vectors of frames 0 ... T-2 of a take of T frames; row t of `y` describes frame t+1 as seen from root t.

    `phase` is the global phase (rad), `phase_update` its change to the next frame.
    """

    x: Float[ndarray, "rows inputs"]
    p: Float[ndarray, "rows 8"]
    y: Float[ndarray, "rows outputs"]
    phase: Float[ndarray, " rows"]
    phase_update: Float[ndarray, " rows"]


def vectors(
    pose: Pose,
    skeleton: Skeleton,
    rest: Float[ndarray, "joints 3 3"],
    fps: float,
    phases: Float[ndarray, "frames 8"],
    contacts: Bool[ndarray, "frames 2"],
    global_phase: Float[ndarray, " frames"] | None = None,
) -> Vectors:
    """Vectors of a take at 60 frames per second; `phases` are phase vectors, `contacts` right and left.

    The global phase (rad) is 0 throughout where it is left out.

    Beyond its ends the root's path goes on reflected about the end frame ([M22] release).
    """
    root = root_of(pose, skeleton)
    this, following = Root(root.positions[:-1], root.angles[:-1]), slice(1, None)
    body = _body(pose, skeleton, rest, fps)
    x = [_trajectory(root, INPUT_SAMPLES, 0)[:-1], _seen(this, [part[:-1] for part in body])]
    y = [
        _trajectory(root, OUTPUT_SAMPLES, 1)[:-1],
        _seen(this, [part[following] for part in body]),
        phases[1:],
        np.diff(phases, axis=0),
        contacts[1:].astype(float),
    ]
    global_phase = np.zeros(len(phases)) if global_phase is None else global_phase
    update = wrap(np.diff(global_phase) + np.pi, 2 * np.pi) - np.pi
    return Vectors(np.concatenate(x, axis=1), phases[:-1], np.concatenate(y, axis=1), global_phase[:-1], update)


def _body(pose: Pose, skeleton: Skeleton, rest: ndarray, fps: float) -> list[ndarray]:
    """World positions, forward and up vectors, and velocities of the feature joints."""
    joints = list(feature_joints(skeleton))
    turned = pose.rotations[:, joints] @ rest[joints]
    positions = pose.positions[:, joints]
    return [positions, turned[..., 2], turned[..., 1], velocities(positions, fps)]


def _seen(root: Root, body: list[ndarray]) -> Float[ndarray, "rows pose"]:
    """The body from the root, joint by joint: position, forward, up, velocity."""
    position, *directions = body
    parts = [to_local(root, position)] + [rotate_to_local(root, direction) for direction in directions]
    return np.concatenate(parts, axis=-1).reshape(len(root), -1)


def _trajectory(root: Root, samples: tuple[int, ...], ahead: int) -> Float[ndarray, "frames values"]:
    """Root positions and directions (x, z) at sample times after frame t + `ahead`, as seen from root t."""
    reach = max(max(samples) + ahead, -min(samples))
    path = np.concatenate([root.positions, root.angles[:, None]], axis=1)
    longer = np.pad(path, ((reach, reach), (0, 0)), mode="reflect", reflect_type="odd")
    at = np.arange(len(root))[:, None] + np.array(samples) + ahead + reach
    inverse = turn(-root.angles)[:, ::2, ::2]
    offsets = longer[at, :2] - root.positions[:, None]
    relative = longer[at, 2] - root.angles[:, None]
    places = np.einsum("tij,tkj->tki", inverse, offsets)
    facing = np.stack([np.sin(relative), np.cos(relative)], axis=-1)
    return np.concatenate([places, facing], axis=-1).reshape(len(root), -1)
