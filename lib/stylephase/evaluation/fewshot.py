"""Few-shot learning put to the test: new styles from one short walk each, on real takes that nobody learned from."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import torch
from jaxtyping import Bool, Float
from numpy import ndarray
from torch import Tensor

from stylephase.evaluation.circles import Courses, walk_courses
from stylephase.evaluation.comparison import interval_of
from stylephase.evaluation.driven import SETTLE, Driven, apart, cycle_of, drive, recorded_part
from stylephase.evaluation.measures import Reference, fast_share, other_style
from stylephase.evaluation.new_clips import NewStyle, gaits_of, long_style, new_style
from stylephase.evaluation.rollouts import start_of, walking_speed
from stylephase.evaluation.stretches import Stretch, generated, recorded
from stylephase.features.clips import WALKS
from stylephase.features.normaliser import normaliser_of
from stylephase.features.store import StyleVectors, VectorStore, for_gate
from stylephase.models.bundle import Bundle
from stylephase.runtime.controller import State
from stylephase.training.fewshot import FewShot, Lesson, Schedule, add_styles

# Gaits of unseen takes that are walks on other ways, those that turn, and those that are runs; of the rest nobody was
# shown the like.
WALKING = ("walk, another take", "walk-left", "walk-right", "SW", "BW")
TURNING = ("walk-turn-left", "walk-turn-right")
RUNNING = ("run", "dash", "FR", "SR", "BR")
# Frames that an unseen take needs beyond those that settle, and recorded walks of a base style that are looked at.
_FEWEST, _WALKS = 40, 6
_DRAWS = 4000

Cycle = Float[ndarray, "grid joints 3"]


@dataclass(frozen=True)
class Study:
    """New styles, and a base with adapters to learn them onto; `neutral` is the base's neutral style."""

    store: VectorStore
    base: Bundle
    styles: tuple[NewStyle, ...]
    neutral: str

    @property
    def names(self) -> list[str]:
        """Names of the new styles."""
        return [style.name for style in self.styles]

    @cached_property
    def clips(self) -> list[StyleVectors]:
        """The clips as the base's gate sees them."""
        return [for_gate(style.clip, self.base.layout) for style in self.styles]

    @cached_property
    def takes(self) -> dict[tuple[str, str], StyleVectors]:
        """Unseen takes by style and gait."""
        return {
            (style.name, gait): for_gate(style.unseen[gait], self.base.layout)
            for gait in gaits_of(self.styles)
            for style in self.styles
            if gait in style.unseen and len(style.unseen[gait].x) > SETTLE + _FEWEST
        }

    @cached_property
    def real(self) -> dict[tuple[str, str], Cycle]:
        """The mean cycle of each unseen take."""
        return {key: cycle_of(recorded_part(take, self.base.layout)) for key, take in self.takes.items()}

    @cached_property
    def gaits(self) -> list[str]:
        """Gaits that some style has an unseen take of."""
        return list(dict.fromkeys(gait for _, gait in self.takes))

    @cached_property
    def clip_cycles(self) -> dict[str, Cycle]:
        """The mean cycle of each clip."""
        return {clip.style: cycle_of(whole_of(clip, self.base)) for clip in self.clips}

    @cached_property
    def base_cycles(self) -> dict[str, Cycle]:
        """The mean cycle of one recorded walk of each base style."""
        return {
            name: cycle_of(whole_of(for_gate(first_take(self.store.load(name)), self.base.layout), self.base))
            for name in self.base.styles
        }

    @cached_property
    def distance(self) -> Float[ndarray, " styles"]:
        """How far (cm) each clip is from the nearest base style."""
        known = list(self.base_cycles.values())
        return np.array([min(apart(self.clip_cycles[name], base) for base in known) for name in self.names])

    @cached_property
    def start(self) -> State:
        """Each style at a frame of its clip."""
        return start_of(self.clips, self.base.body)

    @cached_property
    def speeds(self) -> Float[ndarray, " styles"]:
        """Walking speed (m/s) of each clip."""
        return np.array([walking_speed(clip) for clip in self.clips])

    @cached_property
    def hips(self) -> Float[ndarray, " styles"]:
        """Mean height of the hips (m) in each clip."""
        return np.array([clip.x[:, self.base.layout.x_pose.start + 1].mean() for clip in self.clips])

    @cached_property
    def reference(self) -> Reference:
        """Recorded walks of new and base styles, for the recogniser of notebook 14."""
        layout = self.base.layout
        known = [*self.names, *self.base.styles]
        return Reference(self.base.body, {name: recorded(self.store.load(name), layout)[:_WALKS] for name in known})


def study_of(store: VectorStore, base: Bundle, names: Sequence[str], neutral: str) -> Study:
    """The new styles with a clip of each; those without a walk to learn from are an error."""
    return Study(store, base, tuple(new_style(store, name) for name in names), neutral)


def long_study(store: VectorStore, base: Bundle, names: Sequence[str], cycles: int) -> Study:
    """Styles that a base of one style does not know, with so many cycles of each to learn from."""
    (neutral,) = base.styles
    return Study(store, base, tuple(long_style(store, name, cycles) for name in names), neutral)


def first_take(style: StyleVectors, gaits: Sequence[str] = WALKS) -> StyleVectors:
    """The first take of a style that is of some gaits (walks, unless told otherwise), or its first where none is."""
    take = next((k for k, gait in enumerate(style.gaits) if gait in gaits), 0)
    rows = style.take == take
    kinds = {name: getattr(style, name)[rows] for name in ("x", "p", "y", "phase", "phase_update", "take", "part")}
    return replace(style, **kinds)


def whole_of(style: StyleVectors, base: Bundle) -> Driven:
    """All frames of recorded vectors as a motion to compare."""
    poses = style.x[:, base.layout.x_pose].astype(float)
    return Driven(poses.reshape(len(poses), -1, 4, 3)[:, :, 0], style.phase.astype(float), poses)


@dataclass(frozen=True)
class Found:
    """How one way to learn fared: by gait, for each style the pose error (cm), and whether the nearest real take is its
    own; NaN where a style has no such take. `seconds` of processor time were spent to learn all styles."""

    label: str
    errors: Mapping[str, Float[ndarray, " styles"]]
    right: Mapping[str, Float[ndarray, " styles"]]
    cycles: Mapping[tuple[str, str], Cycle | None]
    seconds: float = 0.0

    def over(self, gaits: Sequence[str], what: str = "errors") -> Float[ndarray, " styles"]:
        """Mean over some gaits for each style; NaN for a style without a take of any."""
        none = np.full_like(next(iter(self.errors.values())), np.nan)
        rows = np.stack([getattr(self, what).get(gait, none) for gait in gaits])
        known = ~np.isnan(rows)
        return np.where(
            known.any(axis=0), np.where(known, rows, 0).sum(axis=0) / np.maximum(known.sum(axis=0), 1), np.nan
        )

    @property
    def walking(self) -> Float[ndarray, " styles"]:
        """Pose error (cm) of each style over unseen walks."""
        return self.over(WALKING)

    @property
    def running(self) -> Float[ndarray, " styles"]:
        """The same over runs."""
        return self.over(RUNNING)

    @property
    def recognised(self) -> Float[ndarray, " styles"]:
        """Share of a style's unseen walks whose nearest real take is its own."""
        return self.over(WALKING, "right")


def found_of(study: Study, label: str, cycles: Mapping[tuple[str, str], Cycle | None], seconds: float = 0.0) -> Found:
    """Errors and verdicts of mean cycles that were made for each unseen take; None for what did not stay finite."""
    errors, right = ({gait: np.full(len(study.names), np.nan) for gait in study.gaits} for _ in range(2))
    for (name, gait), ours in cycles.items():
        k, rivals = study.names.index(name), {s: real for (s, g), real in study.real.items() if g == gait}
        off = (
            {s: apart(ours, real) for s, real in rivals.items()} if ours is not None else dict.fromkeys(rivals, np.inf)
        )
        errors[gait][k] = off[name]
        right[gait][k] = float(np.isfinite(off[name]) and min(off, key=lambda s: off[s]) == name)
    return Found(label, errors, right, cycles, seconds)


def led_along(
    study: Study,
    label: str,
    bundle: Bundle,
    code: Callable[[str], Tensor],
    *,
    seconds: float = 0.0,
) -> Found:
    """Lead each style's character along its unseen takes."""
    keys = list(study.takes)
    codes, network = torch.stack([code(name) for name, _ in keys]), bundle.network.synthesis.eval()
    moved = drive(network, bundle.layout, bundle.normaliser, codes, [study.takes[key] for key in keys])
    cycles = {key: cycle_of(motion) if motion.finite else None for key, motion in zip(keys, moved, strict=True)}
    return found_of(study, label, cycles, seconds)


def clip_again(study: Study) -> Found:
    """What repeating the clip's own cycle would come to, whatever the way: no network at all."""
    return found_of(study, "the clip again", {(name, gait): study.clip_cycles[name] for name, gait in study.takes})


@dataclass(frozen=True)
class Learned:
    """Weights that know all new styles, learned one way, and how they fared."""

    bundle: Bundle
    found: Found


def learned(
    study: Study,
    label: str,
    how: FewShot,
    schedule: Schedule,
    *,
    cycles: int | None = None,
    base: Bundle | None = None,
) -> Learned:
    """Learn all new styles side by side, one adapter each, and lead them along their unseen takes."""
    before = time.process_time()
    lessons = [Lesson(style.clip, how, cycles) for style in study.styles]
    bundle = add_styles(base or study.base, lessons, schedule)
    return Learned(bundle, led_along(study, label, bundle, bundle.code, seconds=time.process_time() - before))


def led_each(study: Study, label: str, bundles: Mapping[str, Bundle], seconds: float = 0.0) -> Found:
    """The same where each style has weights of its own, with statistics of its own."""
    cycles: dict[tuple[str, str], Cycle | None] = {}
    for name, bundle in bundles.items():
        keys = [key for key in study.takes if key[0] == name]
        codes, takes = bundle.code(name).expand(len(keys), -1), [study.takes[key] for key in keys]
        moved = drive(bundle.network.synthesis.eval(), bundle.layout, bundle.normaliser, codes, takes)
        cycles |= {key: cycle_of(motion) if motion.finite else None for key, motion in zip(keys, moved, strict=True)}
    return found_of(study, label, cycles, seconds)


def by_own_statistics(study: Study, how: FewShot, schedule: Schedule) -> dict[str, Bundle]:
    """Each clip learned with its own means and deviations, which [M18] 5.2 advises against."""
    bundles = {}
    for clip, style in zip(study.clips, study.styles, strict=True):
        own = replace(study.base, normaliser=normaliser_of([clip], study.base.layout))
        bundles[style.name] = add_styles(own, [Lesson(style.clip, how)], schedule)
    return bundles


def detail_kept(study: Study, bundles: Mapping[str, Bundle]) -> Float[ndarray, " styles"]:
    """Of each style led along the clip that it learned: its share of fast movement over the clip's ([M18] 9.3)."""
    kept = []
    for clip, style in zip(study.clips, study.styles, strict=True):
        bundle = bundles[style.name]
        (moved,) = drive(
            bundle.network.synthesis.eval(), bundle.layout, bundle.normaliser, bundle.code(style.name)[None], [clip]
        )
        real = recorded_part(clip, bundle.layout)
        ours, theirs = ([_stretch(motion)] for motion in (moved, real))
        kept.append(fast_share(ours) / fast_share(theirs) if moved.finite else np.nan)
    return np.array(kept)


def _stretch(motion: Driven) -> Stretch:
    """A motion that was led, to be measured as walks are; of its contacts nothing is known."""
    return Stretch(motion.poses, motion.phase, np.zeros((len(motion.poses), 2), dtype=bool))


def recognised_by_statistics(study: Study) -> float:
    """Share of unseen walks whose mean pose, normalised as the base is, lies nearest to that of their style's clip.

    Normalised by statistics of their own all means are zero, so that chance would be left: one in the styles.
    """
    pose, n = study.base.layout.x_pose, study.base.normaliser

    def mean(style: StyleVectors) -> Float[ndarray, " pose"]:
        return ((style.x[:, pose] - n.x_mean[pose]) / n.x_std[pose]).mean(axis=0)

    clips = np.stack([mean(clip) for clip in study.clips])
    walks = [(name, mean(take)) for (name, gait), take in study.takes.items() if gait in WALKING]
    near = [study.names[int(np.linalg.norm(clips - at, axis=1).argmin())] == name for name, at in walks]
    return float(np.mean(near))


def rivals(
    study: Study, train: Callable[[Bundle, StyleVectors, Schedule], Bundle], base: Bundle, schedule: Schedule
) -> dict[str, Bundle]:
    """A network of its own for each new style."""
    return {style.name: train(base, style.clip, schedule) for style in study.styles}


def courses_of(
    study: Study, bundle: Bundle, code: Callable[[str], Tensor], *, factor: float = 1.0, **options
) -> Courses:
    """All new styles straight on and round circles of both hands, with one network, at so many times their speed."""
    codes = torch.stack([code(name) for name in study.names])
    return walk_courses(bundle, study.names, codes, study.start, factor * study.speeds, study.hips, **options)


def rival_courses(study: Study, bundles: Mapping[str, Bundle], **options) -> dict[str, Courses]:
    """The same where each style has a network of its own."""
    found = {}
    for k, (name, clip) in enumerate(zip(study.names, study.clips, strict=True)):
        bundle, start = bundles[name], start_of([clip], study.base.body)
        speeds, hips = study.speeds[k : k + 1], study.hips[k : k + 1]
        found[name] = walk_courses(bundle, [name], bundle.code(name)[None], start, speeds, hips, **options)
    return found


def recognised_straight(study: Study, courses: Sequence[Courses]) -> Float[ndarray, " styles"]:
    """For each style the share of windows of its free straight walk that lie nearest to it among all recorded styles.

    A walk that did not stay finite has none.
    """
    walks = {name: straight_walk(courses, name) for name in study.names}
    return np.array([1 - other_style(study.reference, s, [w]) if w is not None else 0.0 for s, w in walks.items()])


def straight_walk(courses: Sequence[Courses], style: str) -> Stretch | None:
    """The free straight walk of a style after settling; None where it did not stay finite."""
    one = next(c for c in courses if any(course.style == style for course in c.courses))
    return generated(one.run, one.of(style, 0.0, "straight"))


def held(courses: Sequence[Courses], radius: float, hand: str) -> Bool[ndarray, " styles"]:
    """Which styles hold on a course, over one network or several."""
    return np.concatenate([one.held(radius, hand) for one in courses])


@dataclass(frozen=True)
class Middle:
    """The median over styles with an interval of 95 % when styles are drawn again."""

    value: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.value:.1f} [{self.low:.1f}, {self.high:.1f}]"

    @property
    def interval(self) -> list[float]:
        """Value, low and high as a plain list; empty where nothing was known."""
        parts = [round(part, 3) for part in (self.value, self.low, self.high)]
        return parts if np.isfinite(parts).all() else []


def middle(values: Float[ndarray, " styles"], seed: int = 0) -> Middle:
    """Median and interval of a value of each style; what is infinite counts as very large."""
    kept = np.minimum(values[~np.isnan(values)], 1e3)
    if not len(kept):
        return Middle(float("nan"), float("nan"), float("nan"))
    picks = np.random.default_rng(seed).integers(len(kept), size=(_DRAWS, len(kept)))
    return Middle(float(np.median(kept)), *interval_of(np.median(kept[picks], axis=1)))


def share(values: Bool[ndarray, " styles"] | Float[ndarray, " styles"], seed: int = 0) -> Middle:
    """Mean and interval of a share of each style."""
    kept = np.asarray(values, dtype=float)
    kept = kept[np.isfinite(kept)]
    if not len(kept):
        return Middle(float("nan"), float("nan"), float("nan"))
    picks = np.random.default_rng(seed).integers(len(kept), size=(_DRAWS, len(kept)))
    return Middle(float(kept.mean()), *interval_of(kept[picks].mean(axis=1)))


def swing(cycle: Cycle) -> float:
    """How much joints move over a mean cycle (cm): the deviation of their places, averaged."""
    return 100 * float(np.sqrt(np.square(cycle - cycle.mean(axis=0)).sum(axis=-1).mean()))


def swings_kept(study: Study, found: Found) -> Float[ndarray, " styles"]:
    """Movement of each style's joints on unseen walks against the recorded takes' (ratio): below 1 it is smoothed."""
    kept = {name: [] for name in study.names}
    for (name, gait), ours in found.cycles.items():
        if gait in WALKING and ours is not None:
            kept[name].append(swing(ours) / swing(study.real[name, gait]))
    return np.array([np.mean(values) if values else np.nan for values in kept.values()])


def nearer_to_neutral(found: Found, neutral: Found, study: Study, gaits: Sequence[str]) -> Float[ndarray, " styles"]:
    """Share of a style's takes of some gaits that come out nearer to what the neutral style makes of them than to the
    recorded take; what did not stay finite is left out. NaN for a style without such a take."""
    near = {name: [] for name in study.names}
    for key, ours in found.cycles.items():
        other = neutral.cycles[key]
        if key[1] in gaits and ours is not None and other is not None:
            near[key[0]].append(apart(ours, other) < apart(ours, study.real[key]))
    return np.array([np.mean(values) if values else np.nan for values in near.values()])


def with_the_clips_posture(study: Study, neutral: Found) -> Found:
    """An idea of ours for gaits that the clip does not show: the neutral motion there, with the mean posture moved as
    far as the clip's is from the neutral style's walk."""
    usual = study.base_cycles[study.neutral].mean(axis=0)
    moved = {
        key: None if cycle is None else cycle + study.clip_cycles[key[0]].mean(axis=0) - usual
        for key, cycle in neutral.cycles.items()
    }
    return found_of(study, "neutral, posture moved", moved)


def change_from(found: Found, average: Found, study: Study) -> Float[ndarray, " styles"]:
    """How far (cm) each style's unseen walks are from what the average motion makes of them: what was learned at all.

    NaN for a style of which nothing stayed finite.
    """
    far = {name: [] for name in study.names}
    for key, ours in found.cycles.items():
        other = average.cycles[key]
        if key[1] in WALKING and ours is not None and other is not None:
            far[key[0]].append(apart(ours, other))
    return np.array([np.mean(values) if values else np.nan for values in far.values()])


def by_take(found: Sequence[Found], most: float = 100.0) -> Float[ndarray, "styles ways takes"]:
    """Errors (cm) on unseen walks of several ways to learn, up to `most`; NaN where a style has no such take."""
    gaits = [gait for gait in WALKING if gait in found[0].errors]
    return np.stack([np.stack([np.minimum(one.errors[gait], most) for gait in gaits], axis=1) for one in found], axis=1)


def real_jolts(study: Study, turning: Sequence[str]) -> float:
    """The strongest jolt of recorded turns against recorded walks, as their ratio in the median base style; 1 where
    nobody is recorded turning."""
    ratios = []
    for name in study.base.styles:
        style = study.store.load(name)
        if set(turning) & set(style.gaits):
            both = (first_take(style, gaits) for gaits in (turning, WALKS))
            turn, walk = (whole_of(for_gate(take, study.base.layout), study.base).places for take in both)
            ratios.append(snap(turn) / snap(walk))
    return float(np.median(ratios)) if ratios else 1.0


def snap(positions: Float[ndarray, "frames joints 3"]) -> float:
    """The strongest jolt of a motion: the largest mean acceleration (m/s2) of the joints, seen from the root, over a
    tenth of a second."""
    bend = np.linalg.norm(np.diff(positions, 2, axis=0), axis=-1).mean(axis=1) * 3600
    window = np.ones(6) / 6
    return float(np.convolve(bend, window, mode="valid").max()) if len(bend) >= 6 else 0.0
