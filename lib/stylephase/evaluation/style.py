"""Which real style a motion is nearest to, by statistics of pose and motion."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from sklearn.covariance import ledoit_wolf

from stylephase.features.clips import clip_rows, walking_gaits
from stylephase.features.layout import Layout
from stylephase.features.store import StyleVectors

# A deviation or variance below this is none.
_CONSTANT = 1e-6


def statistics(poses: Float[ndarray, "frames pose"]) -> Float[ndarray, " statistics"]:
    """Means and deviations over time of the joints' positions and of their velocities, seen from the root."""
    joints = poses.reshape(len(poses), -1, 12)
    positions, velocities = joints[..., :3].reshape(len(poses), -1), joints[..., 9:].reshape(len(poses), -1)
    return np.concatenate([positions.mean(0), positions.std(0), velocities.mean(0), velocities.std(0)]).astype(float)


@dataclass(frozen=True)
class StyleSpace:
    """Mean statistics of each style's walking, in coordinates in which a style's own clips vary alike every way.

    `scale` divides each statistic by its deviation over all clips, `whitening` then takes out what varies together
    within a style.
    """

    styles: tuple[str, ...]
    centres: Float[ndarray, "styles directions"]
    scale: Float[ndarray, " statistics"]
    whitening: Float[ndarray, "statistics directions"]

    def place(self, poses: Float[ndarray, "frames pose"]) -> Float[ndarray, " directions"]:
        """Where a motion lies, in deviations within a style."""
        return statistics(poses) / self.scale @ self.whitening

    def distances(self, poses: Float[ndarray, "frames pose"]) -> Float[ndarray, " styles"]:
        """Distance of a motion to each style, in deviations within a style."""
        return np.linalg.norm(self.centres - self.place(poses), axis=1)

    def nearest(self, poses: Float[ndarray, "frames pose"]) -> str:
        """The nearest style."""
        return self.styles[int(self.distances(poses).argmin())]


def windows_of(style: StyleVectors, part: str, layout: Layout) -> list[Float[ndarray, "frames pose"]]:
    """Poses of the walking style clips in a part of the split."""
    return [style.x[rows][:, layout.x_pose] for rows in clip_rows(style, part, gaits=walking_gaits(style))]


def style_space(styles: Sequence[StyleVectors], layout: Layout) -> StyleSpace:
    """The space of the training clips of some styles, those of symmetric styles mirrored too.

    The covariance within a style is pooled over styles and shrunk (Ledoit and Wolf 2004): there are fewer clips than
    statistics. This is linear discriminant analysis with equal chances.
    """
    return space_of({style.style: _statistics_of(style, layout) for style in styles})


def space_of(groups: Mapping[str, Float[ndarray, "_ statistics"]]) -> StyleSpace:
    """The same from statistics of each style's clips; a style without any has no place in it."""
    groups = {name: group for name, group in groups.items() if len(group)}
    scale = np.concatenate(list(groups.values())).std(axis=0)
    scale = np.where(scale < _CONSTANT, 1.0, scale)
    apart = np.concatenate([(group - group.mean(axis=0)) / scale for group in groups.values()])
    covariance, _ = ledoit_wolf(apart, assume_centered=True)
    values, vectors = np.linalg.eigh(covariance)
    whitening = vectors / np.sqrt(np.maximum(values, _CONSTANT))
    centres = np.array([group.mean(axis=0) for group in groups.values()]) / scale @ whitening
    return StyleSpace(tuple(groups), centres, scale, whitening)


def _statistics_of(style: StyleVectors, layout: Layout) -> Float[ndarray, "clips statistics"]:
    """Statistics of a style's training clips and, where it is symmetric, of their mirror images."""
    source, sign = (part[layout.x_pose] for part in layout.mirror_x[:2])
    windows = windows_of(style, "train", layout)
    images = [window[:, source - layout.x_pose.start] * sign for window in windows] if style.symmetric else []
    # Three numbers of position and of velocity have a mean and a deviation each: as many statistics as pose values.
    return np.array([statistics(window) for window in [*windows, *images]]).reshape(-1, layout.pose)


def recognised(space: StyleSpace, styles: Sequence[StyleVectors], layout: Layout, part: str) -> tuple[int, int]:
    """How many walking clips of a part are nearest to their own style, and of how many: what the measure is worth."""
    verdicts = [space.nearest(window) == s.style for s in styles for window in windows_of(s, part, layout)]
    return sum(verdicts), len(verdicts)
