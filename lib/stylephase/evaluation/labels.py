"""A global phase against one that was labelled by hand ([M18] 5.1).

Labels skip steps: they rest for seconds, or take seconds for what are several steps. Only those half cycles count that
a labeller has plainly walked through, of at most a second each. And a labeller has a habit of where in a step the foot
counts as down, so one offset for each take is free.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray
from scipy.ndimage import uniform_filter1d

from stylephase.data.catalogue import load_clip
from stylephase.data.labels import label_files, read_phase_labels
from stylephase.data.layouts import Entry
from stylephase.data.registry import Dataset
from stylephase.errors import InputError
from stylephase.motion.clip import forward_kinematics, velocities
from stylephase.phase.circular import distance, wrap

# A label's half cycle counts if it takes no longer than this (s).
LONGEST_HALF = 1.0
# A toe faster than this is swinging (m/s).
_SWINGS = 0.8
# An ankle falls faster than the first and has landed below the second (m/s), from speeds smoothed over so many frames,
# between so long before a label and so long after it (s).
_FALLS, _FALLEN, _SMOOTHED = 0.2, 0.1, 5
_BEFORE, _AFTER = 0.6, 0.1
# How much of a half cycle may be missing at its two ends, since a frame falls beside the touchdown (cycles).
_SLACK = 0.05


@dataclass(frozen=True)
class LabelScore:
    """How far a phase lies from labels (cycles), once shifted by `offset` (how late the labels are, in cycles)."""

    offset: float
    median: float
    ninth_decile: float
    frames: int


@dataclass(frozen=True)
class LabelledTake:
    """A take at its own frame rate with its labels (rad): `own`, and `copy`, those of its mirrored copy turned back.

    `toes` and `ankles` are places (m) in the world of the right and left foot.
    """

    name: str
    fps: float
    toes: Float[ndarray, "frames 2 3"]
    ankles: Float[ndarray, "frames 2 3"]
    own: Float[ndarray, " frames"]
    copy: Float[ndarray, " frames"]

    @property
    def speeds(self) -> Float[ndarray, "frames 2"]:
        """Speeds (m/s) of the right and left toe."""
        return np.linalg.norm(velocities(self.toes, self.fps), axis=-1)


def read_labelled(entry: Entry, dataset: Dataset) -> LabelledTake:
    """Read a take with its labels; a mirrored copy is half a cycle away. Raises InputError as reading either does."""
    clip = load_clip(entry, dataset, fps=dataset.fps or 60.0)
    own, copy = (read_phase_labels(path, len(clip)) for path in label_files(entry.path))
    positions, toes = forward_kinematics(clip).positions, clip.skeleton.roles.toes[::-1]
    sensors, ankles = clip.skeleton.roles.toe_sensors[::-1], [clip.skeleton.parents[toe] for toe in toes]
    turned = wrap(copy + np.pi, 2 * np.pi)
    return LabelledTake(entry.path.stem, clip.fps, positions[:, list(sensors)], positions[:, ankles], own, turned)


def labelled_halves(labels: Float[ndarray, " frames"], fps: float) -> list[tuple[int, int]]:
    """First frame and end of each half cycle of the labels (rad) that is whole and takes at most a second.

    A half cycle begins at a label of 0 or pi; there the labeller has set a foot down.
    """
    halves = np.floor(np.unwrap(labels) / np.pi + 1e-6).astype(int)
    moving = np.append(np.diff(np.unwrap(labels)) > 1e-9, False)
    marks = np.where(moving, halves, halves.min() - 1)
    edges = np.concatenate([[0], np.flatnonzero(np.diff(marks)) + 1, [len(labels)]])
    found = []
    for start, stop in pairwise(edges):
        steps = wrap(np.diff(labels[start : stop + 1]), 2 * np.pi)
        whole = abs(steps.sum() / (2 * np.pi) - 0.5) < _SLACK
        if moving[start] and whole and stop - start <= LONGEST_HALF * fps:
            found.append((int(start), int(stop)))
    return found


def footfalls(labels: Float[ndarray, " frames"], fps: float) -> list[tuple[int, int]]:
    """Frame and foot (0 right, 1 left) of the labelled contacts with which the half cycles that count begin."""
    return [(start, round(labels[start] / np.pi) % 2) for start, _ in labelled_halves(labels, fps)]


def label_delays(
    speeds: Float[ndarray, "frames 2"], falls: list[tuple[int, int]], fps: float, slower_than: float
) -> Float[ndarray, " falls"]:
    """Time (s) from a toe's first frame slower than a threshold (m/s) after its swing to its labelled contact.

    `speeds` (m/s) are of the right and left toe. NaN where the toe has not swung before, or is never as slow again.
    """
    delays = np.full(len(falls), np.nan)
    for number, (frame, foot) in enumerate(falls):
        swings = np.flatnonzero(speeds[: frame + 1, foot] > _SWINGS)
        slow = np.flatnonzero(speeds[:, foot] < slower_than)
        slow = slow[slow > swings[-1]] if len(swings) else slow[:0]
        if len(slow):
            delays[number] = (frame - slow[0]) / fps
    return delays


def landing_delays(
    heights: Float[ndarray, "frames 2"], falls: list[tuple[int, int]], fps: float
) -> Float[ndarray, " falls"]:
    """Time (s) from where a joint ends its fall to the floor to the labelled contact of its foot.

    `heights` (m) are those of a joint of the right and of the left foot: of the ankles, the fall ends at about the
    heel's strike. NaN where the joint has not fallen shortly before.
    """
    climbs = uniform_filter1d(np.gradient(heights, axis=0) * fps, _SMOOTHED, axis=0)
    delays = np.full(len(falls), np.nan)
    for number, (frame, foot) in enumerate(falls):
        begin, end = max(frame - round(_BEFORE * fps), 0), frame + round(_AFTER * fps)
        fastest = begin + int(climbs[begin:end, foot].argmin())
        slow = np.flatnonzero(climbs[fastest:, foot] > -_FALLEN)
        if climbs[fastest, foot] < -_FALLS and len(slow):
            delays[number] = (frame - fastest - slow[0]) / fps
    return delays


def stance_shares(contacts: Bool[ndarray, "frames 2"], falls: list[tuple[int, int]]) -> Float[ndarray, " falls"]:
    """Which share of the foot's stance has gone by at its labelled contact; contacts are (right, left).

    The stance is the one that begins nearest to the label; NaN where the foot never stands.
    """
    shares = np.full(len(falls), np.nan)
    for number, (frame, foot) in enumerate(falls):
        edges = np.diff(contacts[:, foot].astype(int), prepend=0, append=0)
        starts, stops = np.flatnonzero(edges > 0), np.flatnonzero(edges < 0)
        if len(starts):
            nearest = np.abs(starts - frame).argmin()
            shares[number] = (frame - starts[nearest]) / (stops[nearest] - starts[nearest])
    return shares


def scored_frames(labels: Float[ndarray, " frames"], fps: float) -> Bool[ndarray, " frames"]:
    """The frames inside the half cycles that count."""
    inside = np.zeros(len(labels), dtype=bool)
    for start, stop in labelled_halves(labels, fps):
        inside[start:stop] = True
    return inside


def score_phase(
    phase: Float[ndarray, " frames"], labels: Float[ndarray, " frames"], counted: Bool[ndarray, " frames"]
) -> LabelScore:
    """Distance of a phase from labels (both rad) over the frames that count, less the best offset.

    That offset is the circular mean of the differences. Raises InputError where no frame counts.
    """
    if not counted.any():
        raise InputError("no half cycle of the labels counts: each rests or takes longer than a second")
    late = (phase - labels)[counted] / (2 * np.pi)
    offset = float(np.angle(np.exp(2j * np.pi * late).mean()) / (2 * np.pi))
    median, most = np.percentile(distance(late, np.full_like(late, offset)), (50, 90))
    return LabelScore(offset, float(median), float(most), int(counted.sum()))


def steady_phase(phase: Float[ndarray, " frames"], counted: Bool[ndarray, " frames"]) -> Float[ndarray, " frames"]:
    """The null model: a phase (rad) of one rate throughout, that of the given phase over the frames that count."""
    steps = np.diff(np.unwrap(phase))
    rate = steps[counted[:-1] & counted[1:]].mean()
    return wrap(rate * np.arange(len(phase)), 2 * np.pi)
