"""Which frames train, validate and test: whole files where a style and gait has many, else windows of each file."""

import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stylephase.data.catalogue import usable
from stylephase.data.layouts import Entry

TRAIN, VALIDATION, TEST = "train", "validation", "test"
PARTS = (TRAIN, VALIDATION, TEST)
# A style and gait with so many files is split by files, since frames of another take are the harder test.
MANY_FILES = 10
# Share of files or frames for the validation, and for the test ([M22] release 4.1).
SHARE = 0.1
# Frames next to a window that no part gets. A frame is described by its surroundings, up to a second either way, and
# its neighbours are nearly copies of it. Half a second keeps near copies out of the training; a whole second on each
# side would take more than a third of the short takes.
GUARD = 30
# A take shorter than one style clip (4 s) is not cut into windows: the guards would eat what is left to train on.
SHORTEST_CUT = 240


@dataclass(frozen=True)
class Segment:
    """Frames [start, stop) at 60 fps, counted from the beginning of the cut of entry number `entry`, for one part."""

    entry: int
    start: int
    stop: int
    part: str

    def __len__(self) -> int:
        return self.stop - self.start


def split(entries: Sequence[Entry], lengths: Sequence[int], *, seed: int) -> tuple[Segment, ...]:
    """Share out the takes to the parts. `lengths` are the frames of each take's cut at 60 fps.

    Per style and gait: with at least MANY_FILES usable takes, a tenth of the files is for the validation and a tenth
    for the test; with fewer, each file gives one window of a tenth to each. Transitions only train ([M22] release).
    Takes that are not usable get no segment. The draw for one style and gait does not depend on the others.

    Differs: the release places the two windows apart and without a guard, so that they may overlap; here they lie side
    by side, which leaves more to train on.
    """
    if len(entries) != len(lengths):
        raise ValueError(f"expected one length for each of {len(entries)} entries, got {len(lengths)}")
    groups: dict[tuple[str, str], list[int]] = {}
    for number, (entry, length) in enumerate(zip(entries, lengths, strict=True)):
        if usable(length):
            groups.setdefault((entry.style, entry.gait), []).append(number)
    segments = []
    for (style, gait), members in groups.items():
        generator = np.random.default_rng([seed, zlib.crc32(f"{style}/{gait}".encode())])
        if entries[members[0]].transition:
            segments += [Segment(number, 0, lengths[number], TRAIN) for number in members]
        elif len(members) >= MANY_FILES:
            segments += _by_file(members, lengths, generator)
        else:
            segments += [part for number in members for part in _by_window(number, lengths[number], generator)]
    return tuple(sorted(segments, key=lambda segment: (segment.entry, segment.start)))


def _by_file(members: Sequence[int], lengths: Sequence[int], generator: np.random.Generator) -> list[Segment]:
    """Whole files; at least one for the validation and one for the test."""
    share = round(SHARE * len(members))
    parts = [TEST] * share + [VALIDATION] * share + [TRAIN] * (len(members) - 2 * share)
    shuffled = generator.permutation(members).tolist()
    return [Segment(number, 0, lengths[number], part) for number, part in zip(shuffled, parts, strict=True)]


def _by_window(number: int, length: int, generator: np.random.Generator) -> list[Segment]:
    """Validation and test side by side somewhere in the file, a guard before and after them, the rest to train on."""
    if length < SHORTEST_CUT:
        return [Segment(number, 0, length, TRAIN)]
    window = int(SHARE * length)
    start = int(generator.integers(length - 2 * window + 1))
    middle, stop = start + window, start + 2 * window
    first, second = generator.permutation([VALIDATION, TEST]).tolist()
    pieces = [
        Segment(number, 0, start - GUARD, TRAIN),
        Segment(number, start, middle, first),
        Segment(number, middle, stop, second),
        Segment(number, stop + GUARD, length, TRAIN),
    ]
    return [piece for piece in pieces if piece.stop - piece.start > 0]


def frames_by_part(segments: Sequence[Segment], entries: Sequence[Entry]) -> dict[str, dict[str, int]]:
    """Frames at 60 fps for each style and part."""
    counts: dict[str, dict[str, int]] = {}
    for segment in segments:
        parts = counts.setdefault(entries[segment.entry].style, dict.fromkeys(PARTS, 0))
        parts[segment.part] += len(segment)
    return counts


def left_out(entries: Sequence[Entry], lengths: Sequence[int]) -> tuple[Entry, ...]:
    """The takes that are too short to be of use."""
    return tuple(entry for entry, length in zip(entries, lengths, strict=True) if not usable(length))
