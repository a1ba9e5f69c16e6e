"""Motion as an autoencoder sees it: joints about the character, its steps over the ground, and its contacts.

Holden, Saito and Komura 2016: positions of the joints, velocity of the root, contacts of the feet; no rotations.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from stylephase.features.layout import FPS, Layout
from stylephase.features.store import StyleVectors
from stylephase.motion.clip import velocities
from stylephase.motion.root import Root, rotate_to_local, turn

# Channels beside the joints: the root's velocity (x, z) and turning, and two contacts.
STEPS, CONTACTS = 3, 2
_POSITION, _VELOCITY = slice(0, 3), slice(9, 12)


@dataclass(frozen=True)
class Channels:
    """Some seconds of one character at 60 frames a second.

    `positions` (m) are the feature joints seen from the root, `steps` the root's velocity to the next frame as seen
    from this one (x and z in m/s, turning in rad/s), `contacts` those of right and left foot (0 to 1).
    """

    positions: Float[ndarray, "frames joints 3"]
    steps: Float[ndarray, "frames 3"]
    contacts: Float[ndarray, "frames 2"]

    def __len__(self) -> int:
        return len(self.positions)

    def at(self, rows: slice) -> "Channels":
        """Some of its frames."""
        return Channels(self.positions[rows], self.steps[rows], self.contacts[rows])

    @property
    def table(self) -> Float[ndarray, "frames channels"]:
        """All channels side by side: joints, steps, contacts."""
        return np.concatenate([self.positions.reshape(len(self), -1), self.steps, self.contacts], axis=1)

    @cached_property
    def root(self) -> Root:
        """The root's path, from the origin and facing +z."""
        angles = np.concatenate([[0.0], np.cumsum(self.steps[:-1, 2])]) / FPS
        ground = turn(angles)[:, ::2, ::2]
        walked = np.einsum("tij,tj->ti", ground[:-1], self.steps[:-1, :2]) / FPS
        return Root(np.concatenate([np.zeros((1, 2)), np.cumsum(walked, axis=0)]), angles)

    @property
    def world(self) -> Float[ndarray, "frames joints 3"]:
        """The joints in the world (m)."""
        turned = np.einsum("tij,tkj->tki", self.root.matrices, self.positions)
        turned[..., ::2] += self.root.positions[:, None]
        return turned

    @property
    def poses(self) -> Float[ndarray, "frames pose"]:
        """The frames as the pose part of x; axes of the joints are not known and stand as zeros."""
        parts = np.zeros((*self.positions.shape[:2], 12))
        parts[..., _POSITION] = self.positions
        parts[..., _VELOCITY] = rotate_to_local(self.root, velocities(self.world, FPS))
        return parts.reshape(len(self), -1)

    def mirrored(self, partners: tuple[int, ...]) -> "Channels":
        """The same with left and right exchanged; `partners` is the layout's list."""
        positions = self.positions[:, list(partners)] * [-1.0, 1.0, 1.0]
        return Channels(positions, self.steps * [-1.0, 1.0, -1.0], self.contacts[:, ::-1])


def from_table(table: Float[ndarray, "frames channels"]) -> Channels:
    """The inverse of `Channels.table`."""
    joints, steps, contacts = np.split(table, [-(STEPS + CONTACTS), -CONTACTS], axis=1)
    return Channels(joints.reshape(len(table), -1, 3), steps, contacts)


def channels_of(style: StyleVectors, rows: Int[ndarray, " rows"], layout: Layout) -> Channels:
    """Rows of a style that follow each other in one take; `layout` is that of local phases."""
    x, y = style.x[rows].astype(float), style.y[rows].astype(float)
    joints = x[:, layout.x_pose].reshape(len(rows), layout.joints, 12)
    ahead = y[:, layout.y_trajectory][:, :4]
    steps = np.concatenate([ahead[:, :2], np.arctan2(ahead[:, 2:3], ahead[:, 3:4])], axis=1) * FPS
    # y tells the contacts of the next frame.
    contacts = y[:, layout.y_contacts]
    return Channels(joints[..., _POSITION], steps, np.concatenate([contacts[:1], contacts[:-1]]))
