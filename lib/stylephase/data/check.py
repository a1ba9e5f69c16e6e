"""Checking a data set: every file read, every fault listed."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from stylephase.data.catalogue import Catalogue, cut_frames, load_clip, usable
from stylephase.data.layouts import Entry, hash_content
from stylephase.errors import InputError

_FPS = 60.0


@dataclass(frozen=True)
class Findings:
    """What a check found. `frames` are those inside the cuts of the good files, at 60 fps; `faults` one line each."""

    files: int
    frames_by_style: dict[str, int]
    too_short: tuple[str, ...]
    content: str
    faults: tuple[str, ...]

    @property
    def frames(self) -> int:
        """Frames of all styles."""
        return sum(self.frames_by_style.values())

    @property
    def minutes(self) -> float:
        """Duration of all styles."""
        return self.frames / _FPS / 60.0


def check(catalogue: Catalogue, progress: Callable[[Iterable[Entry]], Iterable[Entry]] = iter) -> Findings:
    """Read every file of a catalogue and go on where one is bad; `progress` wraps the loop over the entries."""
    frames, short, faults, skeleton = dict.fromkeys(catalogue.styles, 0), [], [], None
    for entry in progress(catalogue.entries):
        try:
            clip = load_clip(entry, catalogue.dataset, fps=_FPS, skeleton=skeleton)
            start, stop = cut_frames(entry, catalogue.dataset, clip)
        except InputError as error:
            faults.append(str(error))
            continue
        skeleton = clip.skeleton
        frames[entry.style] += stop - start
        if not usable(stop - start):
            short.append(entry.path.name)
    content = hash_content(catalogue.entries)
    if catalogue.dataset.content not in (None, content):
        faults.append(f"the motion files have SHA-256 {content}, registered is {catalogue.dataset.content}")
    return Findings(len(catalogue.entries), frames, tuple(short), content, tuple(faults))
