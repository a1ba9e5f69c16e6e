"""A data set as a list of takes with style, gait and cut, and each take as a clip at 60 frames a second."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from stylephase.data.archive import fetch
from stylephase.data.layouts import Entry, find_entries
from stylephase.data.registry import Dataset, dataset
from stylephase.errors import InputError, hint
from stylephase.motion.bvh import read_bvh
from stylephase.motion.clip import Clip, resample
from stylephase.motion.skeleton import Skeleton

# A frame is described by half a second and more on either side of it; a shorter take has no such frame.
SHORTEST_TAKE = 70
# Bones of one data set agree within this (m), and its frame rates within this share.
_SAME_BONE, _SAME_RATE = 0.001, 0.01


@dataclass(frozen=True)
class Catalogue:
    """The takes of one data set, sorted by style, gait and path."""

    dataset: Dataset
    entries: tuple[Entry, ...]

    @property
    def styles(self) -> tuple[str, ...]:
        """Names of the styles, sorted."""
        return tuple(sorted({entry.style for entry in self.entries}))

    @property
    def gaits(self) -> tuple[str, ...]:
        """Names of the gaits, sorted."""
        return tuple(sorted({entry.gait for entry in self.entries}))

    def of(self, style: str, gait: str | None = None) -> tuple[Entry, ...]:
        """The takes of one style, or of one style and gait. An unknown style raises InputError."""
        check_styles([style], self.styles)
        return tuple(e for e in self.entries if e.style == style and gait in (None, e.gait))

    def without_idle(self) -> "Catalogue":
        """The same without the takes of standing, as the release trains ([M22] release)."""
        return replace(self, entries=tuple(entry for entry in self.entries if not entry.idle))


def load_catalogue(name: str, styles: Sequence[str] | None = None) -> Catalogue:
    """The catalogue of the data set `name`, of all styles or those named, fetched at the first call.

    Raises InputError: unknown data set, unknown style (with those spelt alike), no BVH files, and whatever `fetch`
    raises.
    """
    chosen = dataset(name)
    catalogue = Catalogue(chosen, find_entries(chosen.layout, fetch(chosen)))
    if styles is None:
        return catalogue
    check_styles(styles, catalogue.styles)
    return replace(catalogue, entries=tuple(entry for entry in catalogue.entries if entry.style in styles))


def check_styles(asked: Iterable[str], known: Sequence[str]) -> None:
    """Raise InputError for the first style that is not known, with the ones spelt alike, or else all."""
    for style in asked:
        if style not in known:
            raise InputError(f"no style {style!r}; {hint(style, known)}")


def load_clip(entry: Entry, dataset: Dataset, *, fps: float = 60.0, skeleton: Skeleton | None = None) -> Clip:
    """The whole file of a take as a clip at `fps`; `cut_frames` says which of its frames count.

    With a `skeleton` given, the file's own must be the same, and the clip takes the one given. Raises InputError: what
    `read_bvh` raises, a frame rate other than the data set's, another skeleton.
    """
    clip = read_bvh(entry.path, metres_per_unit=dataset.metres_per_unit)
    if dataset.fps is not None and not np.isclose(clip.fps, dataset.fps, rtol=_SAME_RATE):
        raise InputError(f"expected {dataset.fps:g} frames a second, found {clip.fps:g}", entry.path)
    if skeleton is not None:
        check_same_skeleton(entry.path, clip.skeleton, skeleton)
        clip = replace(clip, skeleton=skeleton)
    return resample(clip, fps)


def cut_frames(entry: Entry, dataset: Dataset, clip: Clip) -> tuple[int, int]:
    """The cut [start, stop) of a take in frames of its resampled clip, no further than the clip's end.

    Raises InputError if nothing of the cut is left.
    """
    scale = 1.0 if dataset.fps is None else clip.fps / dataset.fps
    start = round(entry.start * scale)
    stop = len(clip) if entry.stop is None else min(round(entry.stop * scale), len(clip))
    if start >= stop:
        raise InputError(f"the cut starts at frame {start}, but the file has only {len(clip)} frames", entry.path)
    return start, stop


def load_clips(catalogue: Catalogue, *, fps: float = 60.0) -> Iterator[tuple[Entry, Clip]]:
    """Each take with the clip of its whole file, one after the other, all with the skeleton of the first.

    Raises InputError that names the file whose skeleton is another.
    """
    skeleton = None
    for entry in catalogue.entries:
        clip = load_clip(entry, catalogue.dataset, fps=fps, skeleton=skeleton)
        skeleton = clip.skeleton
        yield entry, clip


def check_same_skeleton(
    path: Path, skeleton: Skeleton, expected: Skeleton, *, whose: str = "the data set's first file"
) -> None:
    """Raise InputError unless joints, tree and bone lengths are those expected, which are `whose`.

    End sites may lie elsewhere: nothing moves them, and some files of one data set have them while others have not.
    """
    if skeleton.names != expected.names:
        raise InputError(f"its joints differ from those of {whose}: {_other_joint(skeleton, expected)}", path)
    if skeleton.parents != expected.parents:
        pairs = zip(skeleton.parents, expected.parents, strict=True)
        joint = skeleton.names[next(k for k, (own, other) in enumerate(pairs) if own != other)]
        raise InputError(f"its tree differs from that of {whose}: {joint} has another parent", path)
    apart = np.abs(skeleton.offsets - expected.offsets).max(axis=1) * ~np.array(expected.sites)
    if apart.max() > _SAME_BONE:
        joint = skeleton.names[int(apart.argmax())]
        raise InputError(f"joint {joint} lies {apart.max():.3f} m off its place in {whose}", path)


def _other_joint(skeleton: Skeleton, expected: Skeleton) -> str:
    """A joint that one skeleton has and the other has not, or that stands elsewhere."""
    for joint in expected.names:
        if joint not in skeleton.names:
            return f"it has no {joint}"
    for joint in skeleton.names:
        if joint not in expected.names:
            return f"{joint} is not among those"
    pairs = zip(skeleton.names, expected.names, strict=False)
    return next((f"{own} stands where {other} is there" for own, other in pairs if own != other), "one is named twice")


def usable(length: int) -> bool:
    """Whether a take of `length` frames at 60 fps is long enough to learn from."""
    return length >= SHORTEST_TAKE
