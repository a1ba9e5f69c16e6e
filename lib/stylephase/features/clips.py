"""Style clips: windows of poses that show a style ([M22] 3.2: 240 frames x 300 values)."""

import numpy as np
from jaxtyping import Int
from numpy import ndarray

from stylephase.data.split import PARTS
from stylephase.features.layout import CLIP_FRAMES, CLIP_STRIDE
from stylephase.features.store import StyleVectors

# Names of forward walks in the data sets.
WALKS = ("walk", "FW")


def walking_gaits(style: StyleVectors) -> tuple[str, ...] | None:
    """The style's forward walks, or None (all gaits) where the data do not name one."""
    return tuple(gait for gait in dict.fromkeys(style.gaits) if gait in WALKS) or None


def clip_rows(
    style: StyleVectors, part: str, *, gaits: tuple[str, ...] | None = None, frames: int = CLIP_FRAMES
) -> Int[ndarray, "clips frames"]:
    """Row numbers of the style clips in a part of the split, every CLIP_STRIDE rows of each unbroken stretch.

    A stretch shorter than a clip gives one clip that repeats it; without that, a third of the short takes would show
    the generator nothing. `gaits` keeps only some gaits.
    """
    inside = style.part == PARTS.index(part)
    breaks = np.flatnonzero((np.diff(style.take) != 0) | (np.diff(inside.astype(int)) != 0)) + 1
    windows = []
    for stretch in np.split(np.arange(len(inside)), breaks):
        if not len(stretch) or not inside[stretch[0]]:
            continue
        if gaits is not None and style.gaits[style.take[stretch[0]]] not in gaits:
            continue
        if len(stretch) < frames:
            windows.append(np.resize(stretch, frames))
        else:
            starts = range(0, len(stretch) - frames + 1, CLIP_STRIDE)
            windows += [stretch[start : start + frames] for start in starts]
    return np.array(windows, dtype=int).reshape(-1, frames)
