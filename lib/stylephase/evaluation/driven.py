"""A network led along recorded paths: the path is the record's, pose and phase are the network's own ([M18] 8.2).

So a style that was learned from one straight walk is held against real motion of that style on other paths.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray
from torch import Tensor, nn

from stylephase.features.layout import FPS, Layout
from stylephase.features.normaliser import Normaliser
from stylephase.features.store import StyleVectors
from stylephase.runtime.axes import from_axes

# Frames that only settle, and the most that are looked at after them.
SETTLE, MOST = 60, 180
# As in the controller, the predicted places against the last ones carried on by their velocity.
_POSE_SHARE = 0.5
# Harmonics of a cycle's mean pose, and phases around the circle at which two are compared.
_HARMONICS, _GRID = 3, 24


@dataclass(frozen=True)
class Driven:
    """Places of the joints (m) seen from the root, and the phase (rad), frame by frame after settling."""

    places: Float[ndarray, "frames joints 3"]
    phase: Float[ndarray, " frames"]
    poses: Float[ndarray, "frames pose"]

    @property
    def finite(self) -> bool:
        """Whether all numbers are finite."""
        return bool(np.isfinite(self.poses).all() and np.isfinite(self.phase).all())


def recorded_part(take: StyleVectors, layout: Layout) -> Driven:
    """The part of a recorded take that `drive` gives of a network."""
    rows = slice(SETTLE, SETTLE + MOST)
    poses = take.x[rows, layout.x_pose].astype(float)
    return Driven(poses.reshape(len(poses), -1, 4, 3)[:, :, 0], take.phase[rows].astype(float), poses)


@np.errstate(over="ignore", invalid="ignore")
def drive(
    network: nn.Module,
    layout: Layout,
    normaliser: Normaliser,
    codes: Float[Tensor, "takes values"],
    takes: Sequence[StyleVectors],
) -> list[Driven]:
    """Lead one character along each take, from its first pose on, all side by side. What turns infinite stays so."""
    longest = min(max(len(take.x) for take in takes), SETTLE + MOST)
    paths = np.stack([_padded(take.x[:, layout.x_trajectory], longest) for take in takes])
    steps = np.stack([_padded(take.y[:, :4], longest) for take in takes])
    pose = np.stack([take.x[0, layout.x_pose] for take in takes]).astype(float)
    phase = np.array([[take.phase[0]] for take in takes], dtype=float)
    poses, phases = [], []
    for frame in range(longest):
        poses.append(pose)
        phases.append(phase[:, 0])
        y = _predict(network, normaliser, np.concatenate([paths[:, frame], pose], axis=1), phase, codes)
        pose = _next_pose(pose, y[:, layout.y_pose], steps[:, frame])
        phase = (phase + y[:, layout.y_phase_updates]) % (2 * np.pi)
    found = []
    for k, take in enumerate(takes):
        rows = slice(SETTLE, min(len(take.x), SETTLE + MOST))
        own = np.stack([each[k] for each in poses])[rows]
        found.append(Driven(own.reshape(len(own), -1, 4, 3)[:, :, 0], np.array([p[k] for p in phases])[rows], own))
    return found


def _padded(rows: ndarray, length: int) -> ndarray:
    """So many rows; a shorter take stays at its last."""
    return rows[np.minimum(np.arange(length), len(rows) - 1)].astype(float)


def _predict(network: nn.Module, n: Normaliser, x: ndarray, p: ndarray, codes: Tensor) -> ndarray:
    scaled = ((x - n.x_mean) / n.x_std, (p - n.p_mean) / n.p_std)
    with torch.inference_mode():
        y = network(*(torch.from_numpy(v).float() for v in scaled), codes).double().numpy()
    return y * n.y_std + n.y_mean


def _next_pose(pose: ndarray, predicted: ndarray, step: Float[ndarray, "takes 4"]) -> Float[ndarray, "takes pose"]:
    """The next pose seen from the next root, of one that is predicted as seen from this root.

    As in the controller the predicted axes are made rotations: fed back as they are they grow, and break characters
    that walk well there.
    """
    now, then = (values.reshape(len(values), -1, 4, 3) for values in (pose, predicted.copy()))
    rotations = from_axes(then[:, :, 1], then[:, :, 2])
    then[:, :, 1], then[:, :, 2] = rotations[..., 2], rotations[..., 1]
    carried = now[:, :, 0] + then[:, :, 3] / FPS
    then[:, :, 0] = carried + _POSE_SHARE * (then[:, :, 0] - carried)
    then[:, :, 0, ::2] -= step[:, None, :2]
    # The next root's forward axis is the facing (x, z) of the record, its left axis that turned by a right angle.
    forward = np.stack([step[:, 2], 0 * step[:, 2], step[:, 3]], axis=1)
    left = np.stack([step[:, 3], 0 * step[:, 2], -step[:, 2]], axis=1)
    axes = np.stack([left, np.broadcast_to([0.0, 1.0, 0.0], left.shape), forward], axis=1)
    return np.einsum("tij,tklj->tkli", axes, then).reshape(len(pose), -1)


def cycle_of(motion: Driven) -> Float[ndarray, "grid joints 3"]:
    """The mean pose over a cycle: harmonics of the phase fitted to every coordinate, at phases around the circle."""
    count = min(_HARMONICS, max((len(motion.phase) - 1) // 8, 0))
    fitted = np.linalg.lstsq(_harmonics(motion.phase, count), motion.places.reshape(len(motion.phase), -1), rcond=1e-3)[
        0
    ]
    grid = np.linspace(0, 2 * np.pi, _GRID, endpoint=False)
    return (_harmonics(grid, count) @ fitted).reshape(_GRID, -1, 3)


def _harmonics(phase: ndarray, count: int) -> ndarray:
    parts = [np.ones_like(phase)]
    for k in range(1, count + 1):
        parts += [np.cos(k * phase), np.sin(k * phase)]
    return np.stack(parts, axis=1)


def apart(ours: Float[ndarray, "grid joints 3"], real: Float[ndarray, "grid joints 3"]) -> float:
    """Mean distance (cm) of the joints over a cycle, after the shift of phase at which it is least."""
    shifts = [np.linalg.norm(np.roll(ours, shift, axis=0) - real, axis=-1).mean() for shift in range(len(ours))]
    return 100 * float(min(shifts))
