"""Which real style a motion is nearest to, by statistics of pose and motion."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.features.clips import clip_rows
from stylephase.features.layout import Layout
from stylephase.features.store import StyleVectors

WALKS = ("walk", "FW")
# The spread within a style may not be taken for less than this share of the spread between styles.
_LEAST_SPREAD = 0.1


def walking_gaits(style: StyleVectors) -> tuple[str, ...] | None:
    """The style's forward walks, or None (all gaits) where the data do not name one."""
    return tuple(gait for gait in dict.fromkeys(style.gaits) if gait in WALKS) or None


def statistics(poses: Float[ndarray, "frames pose"]) -> Float[ndarray, " statistics"]:
    """Means and deviations over time of the joints' positions and of their velocities, seen from the root."""
    joints = poses.reshape(len(poses), -1, 12)
    positions, velocities = joints[..., :3].reshape(len(poses), -1), joints[..., 9:].reshape(len(poses), -1)
    return np.concatenate([positions.mean(0), positions.std(0), velocities.mean(0), velocities.std(0)]).astype(float)


@dataclass(frozen=True)
class StyleSpace:
    """Mean statistics of each style's walking, and their spread within a style, which scales distances."""

    styles: tuple[str, ...]
    centres: Float[ndarray, "styles statistics"]
    spread: Float[ndarray, " statistics"]

    def distances(self, poses: Float[ndarray, "frames pose"]) -> Float[ndarray, " styles"]:
        """Root mean square distance of a motion to each style, in units of the spread within a style."""
        return np.sqrt(np.square((self.centres - statistics(poses)) / self.spread).mean(axis=1))

    def nearest(self, poses: Float[ndarray, "frames pose"]) -> str:
        """The nearest style."""
        return self.styles[int(self.distances(poses).argmin())]


def windows_of(style: StyleVectors, part: str, layout: Layout) -> list[Float[ndarray, "frames pose"]]:
    """Poses of the walking style clips in a part of the split."""
    return [style.x[rows][:, layout.x_pose] for rows in clip_rows(style, part, gaits=walking_gaits(style))]


def style_space(styles: Sequence[StyleVectors], layout: Layout) -> StyleSpace:
    """The space of the training clips of some styles."""
    groups = [np.array([statistics(window) for window in windows_of(style, "train", layout)]) for style in styles]
    kept = [(style.style, group) for style, group in zip(styles, groups, strict=True) if len(group)]
    centres = np.array([group.mean(axis=0) for _, group in kept])
    within = np.sqrt(
        np.mean([group.var(axis=0) for _, group in kept if len(group) > 1] or [np.ones(centres.shape[1])], axis=0)
    )
    spread = np.maximum(within, _LEAST_SPREAD * centres.std(axis=0) + 1e-6)
    return StyleSpace(tuple(name for name, _ in kept), centres, spread)


def recognised(space: StyleSpace, styles: Sequence[StyleVectors], layout: Layout, part: str) -> tuple[int, int]:
    """How many walking clips of a part are nearest to their own style, and of how many: what the measure is worth."""
    verdicts = [space.nearest(window) == s.style for s in styles for window in windows_of(s, part, layout)]
    return sum(verdicts), len(verdicts)
