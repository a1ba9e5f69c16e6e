"""New styles for few-shot learning: one short straight walk of each to learn from, all other takes to test on."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy import ndarray

from stylephase.data.catalogue import cut_frames, load_clip, usable
from stylephase.errors import InputError
from stylephase.features.captures import clip_vectors
from stylephase.features.clips import WALKS
from stylephase.features.cycles import Cycles, cycles_of
from stylephase.features.layout import FPS
from stylephase.features.store import StyleVectors, VectorStore
from stylephase.motion.clip import Clip, forward_kinematics
from stylephase.motion.root import root_of

# A clip to learn from lasts so long at the most (s): "a single clip of 1 to 5 s" ([M18] 7).
LONGEST = 5.0
# Straightness is looked for at so many places.
_STEP = 15
# Takes shorter than this (s) are too short to test on: the first second only settles.
_SHORTEST = 2.0


@dataclass(frozen=True)
class NewStyle:
    """A style to learn: its clip with vectors all of which train, and the takes that nobody learns from by gait.

    `moving` is the clip itself, `turned` how far it turns from its beginning to its end (degrees).
    """

    name: str
    moving: Clip
    clip: StyleVectors
    turned: float
    unseen: dict[str, StyleVectors]

    @property
    def cycles(self) -> Cycles:
        """Whole cycles of the clip."""
        return cycles_of(self.clip)

    @property
    def seconds(self) -> float:
        """Length of the clip."""
        return len(self.moving) / FPS


def new_style(store: VectorStore, name: str, seconds: float = LONGEST) -> NewStyle:
    """The straightest window of the first walk that is long enough, and the style's other takes.

    Where the style has a second walk, it is the take `walk, another take`. Raises InputError where it has none to learn
    from.
    """
    vectors, catalogue, body = store.load(name), store.catalogue, store.body
    entries = catalogue.of(name)
    clips = [load_clip(entry, catalogue.dataset, fps=FPS, skeleton=body.skeleton) for entry in entries]
    clips = [c.frames(*cut_frames(e, catalogue.dataset, c)) for c, e in zip(clips, entries, strict=True)]
    # The vectors are of the takes that are long enough, in this order.
    kept = [(entry, clip) for entry, clip in zip(entries, clips, strict=True) if usable(len(clip))]
    walks = [k for k, (entry, _) in enumerate(kept) if entry.gait in WALKS]
    for chosen in walks:
        moving, turned = straightest(kept[chosen][1], seconds)
        symmetric, gait = vectors.symmetric, kept[chosen][0].gait
        clip = clip_vectors(moving, name, body, store.phases, catalogue.dataset.name, symmetric=symmetric, gait=gait)
        if len(cycles_of(clip)):
            return NewStyle(name, moving, clip, turned, _unseen(vectors, [chosen]))
    raise InputError(f"style {name!r} has no walk with a whole cycle to learn from")


def long_style(store: VectorStore, name: str, cycles: int) -> NewStyle:
    """So many cycles of a style or a few more: its first walks one after the other, and its other takes.

    A single clip of a few seconds has a handful ([M18] Table 2 goes up to 25). Raises InputError where the style has
    fewer.
    """
    vectors, catalogue = store.load(name), store.catalogue
    walks = [k for k, gait in enumerate(vectors.gaits) if gait in WALKS]
    total = np.cumsum([len(cycles_of(vectors, take)) for take in walks])
    if not len(total) or total[-1] < cycles:
        raise InputError(f"style {name!r} has fewer than the {cycles} cycles of walking that are to be learned")
    learned = walks[: int(np.searchsorted(total, cycles)) + 1]
    rows = np.flatnonzero(np.isin(vectors.take, learned))
    entry = next(entry for entry in catalogue.of(name) if entry.gait in WALKS)
    moving = load_clip(entry, catalogue.dataset, fps=FPS, skeleton=store.body.skeleton)
    return NewStyle(name, moving, take_rows(vectors, rows), 0.0, _unseen(vectors, learned))


def straightest(clip: Clip, seconds: float) -> tuple[Clip, float]:
    """The window of a clip, of so many seconds at the most, that turns least, and how far it turns (degrees)."""
    angles = root_of(forward_kinematics(clip), clip.skeleton).angles
    frames = min(int(seconds * FPS), len(clip))
    starts = range(0, len(clip) - frames + 1, _STEP)
    spread = [np.ptp(angles[start : start + frames]) for start in starts]
    best = starts[int(np.argmin(spread))]
    turned = float(np.degrees(abs(angles[best + frames - 1] - angles[best])))
    return clip.frames(best, best + frames), turned


def _unseen(style: StyleVectors, learned: Sequence[int]) -> dict[str, StyleVectors]:
    """Takes other than those that are learned from, one of each gait."""
    found: dict[str, StyleVectors] = {}
    for k, gait in enumerate(style.gaits):
        rows = np.flatnonzero(style.take == k)
        name = "walk, another take" if gait in WALKS else gait
        if k not in learned and len(rows) >= _SHORTEST * FPS and name not in found:
            found[name] = take_rows(style, rows)
    return found


def take_rows(style: StyleVectors, rows: ndarray) -> StyleVectors:
    """Some rows of a style as vectors of their own, all of which train; their takes are numbered anew."""
    takes, take = np.unique(style.take[rows], return_inverse=True)
    kinds = ("x", "p", "y", "phase", "phase_update")
    arrays = {kind: getattr(style, kind)[rows] for kind in kinds}
    gaits, part = tuple(style.gaits[k] for k in takes), np.zeros(len(rows), dtype=int)
    return StyleVectors(style=style.style, symmetric=style.symmetric, gaits=gaits, take=take, part=part, **arrays)


def gaits_of(styles: Sequence[NewStyle]) -> list[str]:
    """Gaits of unseen takes that some style has, the most frequent first."""
    names = [gait for style in styles for gait in style.unseen]
    return sorted(dict.fromkeys(names), key=lambda gait: -names.count(gait))
