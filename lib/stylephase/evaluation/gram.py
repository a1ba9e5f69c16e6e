"""Style transfer by Gram matrices against a controller on the same path, style by style ([M18] 8.2).

Content are neutral takes, style one short clip; what is judged is judged by walks of the style that neither the
autoencoder nor the style clip had.
"""

import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray
from scipy.ndimage import gaussian_filter1d
from torch import Tensor

from stylephase.data.split import GUARD, PARTS
from stylephase.errors import InputError
from stylephase.evaluation.measures import WINDOW, Reference, measured
from stylephase.evaluation.rollouts import codes_of, start_of
from stylephase.evaluation.stretches import Stretch, generated
from stylephase.features.body import Body
from stylephase.features.channels import Channels, channels_of
from stylephase.features.clips import CLIP_FRAMES, walking_gaits
from stylephase.features.layout import FPS, Layout
from stylephase.features.store import StyleVectors, for_gate
from stylephase.models.autoencoder import MotionAutoencoder
from stylephase.models.bundle import Bundle, is_bundle
from stylephase.motion.root import Root
from stylephase.phase.global_phase import global_phase
from stylephase.runtime.calibration import speed_of
from stylephase.runtime.gram import Anatomy, GramSettings, transfer
from stylephase.runtime.led import roll_out_led
from stylephase.runtime.rollout import Rollout
from stylephase.runtime.trajectory import on_ground
from stylephase.training.fewshot import Lesson, add_styles

# Words for a style that is none.
_NEUTRAL = ("normal", "neutral", "plain")
_CONTACT = 0.5
# A controller walks straight on for so long before its path begins (s), since it starts from some frame of the data.
RUN_UP = 2.0
# A foot at this height (m) above where it rests slides no longer (Zhang et al. 2018).
_STANDS = 0.025
# Toes rest at this quantile of their heights.
_RESTS = 0.05


@dataclass(frozen=True)
class Material:
    """One style's share of the comparison, as rows of its vectors.

    `clip` is the style clip, `unseen` are walks to judge by, `known` stretches to train an autoencoder on.
    """

    style: StyleVectors
    clip: Int[ndarray, " rows"]
    unseen: tuple[Int[ndarray, "_"], ...]
    known: tuple[Int[ndarray, "_"], ...]

    @property
    def seconds(self) -> float:
        """How much of the style an autoencoder trains on (s)."""
        return sum(map(len, self.known)) / FPS


def material_of(style: StyleVectors, frames: int = CLIP_FRAMES) -> Material:
    """Share out a style's rows.

    Unseen are its forward walks that lie wholly in the test part of the split; without any, the last of several takes;
    of a single take the second half. The clip is the middle of the first walk left. Known is what trains of all other
    takes. Raises InputError where no walk is left that lasts a window of the measures.
    """
    takes = [np.flatnonzero(style.take == k) for k in range(len(style.gaits))]
    gaits = walking_gaits(style) or style.gaits
    walks = [rows for rows, gait in zip(takes, style.gaits, strict=True) if gait in gaits and len(rows) >= WINDOW]
    unseen = [rows for rows in walks if (style.part[rows] == PARTS.index("test"))[:-1].all()]
    if not unseen and len(walks) > 1:
        unseen = walks[-1:]
    elif not unseen and walks and len(walks[0]) >= 2 * (WINDOW + GUARD):
        unseen = [walks[0][len(walks[0]) // 2 + GUARD :]]
        walks = [walks[0][: len(walks[0]) // 2 - GUARD]]
    held = np.concatenate(unseen) if unseen else np.zeros(0, dtype=int)
    left = [rows for rows in walks if not np.isin(rows, held).any()]
    if not unseen or not left:
        raise InputError(f"style {style.style!r} has no two walks of {WINDOW / FPS:g} s, one to learn and one to judge")
    first = left[0]
    middle = max((len(first) - frames) // 2, 0)
    split_take = len(takes[style.take[held[0]]]) != len(unseen[0])
    spared = [k for k, rows in enumerate(takes) if np.isin(rows, held).any()]
    known = [_in_training(style, rows) for k, rows in enumerate(takes) if k not in spared]
    known += [[first]] if split_take else []
    return Material(style, first[middle : middle + frames], tuple(unseen), tuple(r for some in known for r in some))


def _in_training(style: StyleVectors, rows: Int[ndarray, " rows"]) -> list[Int[ndarray, " rows"]]:
    """The unbroken stretches of a take that train."""
    training = rows[style.part[rows] == PARTS.index("train")]
    return [part for part in np.split(training, np.flatnonzero(np.diff(training) > 1) + 1) if len(part)]


def materials_of(styles: Sequence[StyleVectors]) -> dict[str, Material]:
    """Material by style, of the styles that have enough walks for it."""
    found = {}
    for style in styles:
        try:
            found[style.style] = material_of(style)
        except InputError:
            continue
    return found


def known_stretches(materials: Iterable[Material], layout: Layout) -> dict[str, list[Channels]]:
    """What an autoencoder trains on, by style, with mirror images of symmetric styles."""
    found = {}
    for material in materials:
        own = [channels_of(material.style, rows, layout) for rows in material.known]
        images = [motion.mirrored(layout.mirrored) for motion in own] if material.style.symmetric else []
        found[material.style.style] = [*own, *images]
    return found


def known_walks(material: Material, layout: Layout, most: int = 12) -> list[Channels]:
    """Forward walks among what the autoencoder knows of a style, the longest first."""
    style, gaits = material.style, walking_gaits(material.style) or material.style.gaits
    walks = [rows for rows in material.known if style.gaits[style.take[rows[0]]] in gaits and len(rows) > 1]
    chosen = sorted(walks, key=len, reverse=True)[:most] or [material.clip]
    return [channels_of(style, rows, layout) for rows in chosen]


def neutral_style(materials: Sequence[Material]) -> str:
    """The neutral style of which there is most; raises InputError where there is none."""
    rows = {material.style.style: len(material.style.x) for material in materials}
    return max(neutral_styles(list(rows)), key=lambda style: rows[style])


def joints_apart(motion: Channels, other: Channels) -> float:
    """Mean distance (mm) of the joints of two motions, over the frames that both have."""
    frames = min(len(motion), len(other))
    return 1000 * float(np.linalg.norm(motion.positions[:frames] - other.positions[:frames], axis=-1).mean())


def standing(motion: Channels) -> Channels:
    """Its mean pose all the time."""
    return replace(motion, positions=np.broadcast_to(motion.positions.mean(axis=0), motion.positions.shape).copy())


def neutral_styles(styles: Sequence[str]) -> list[str]:
    """Names of styles that say they are none; raises InputError where there is none."""
    found = [style for style in styles if any(word in style.lower() for word in _NEUTRAL)]
    if not found:
        raise InputError(f"none of the styles is called {', '.join(_NEUTRAL)}: {', '.join(styles)}")
    return found


def contents_of(material: Material, layout: Layout, frames: int = 360, straight: int = 1) -> dict[str, Channels]:
    """Neutral clips by name: unseen forward walks, and one turn to each side from the test part where data have any.

    Each is the middle of its take, up to so many frames.
    """
    style, found = material.style, {}
    for k, rows in enumerate(material.unseen[:straight]):
        found[f"straight {k + 1}"] = rows
    test = style.part == PARTS.index("test")
    for side in ("left", "right"):
        takes = [np.flatnonzero(style.take == k) for k, gait in enumerate(style.gaits) if gait == f"walk-turn-{side}"]
        whole = [rows for rows in takes if test[rows][:-1].all()]
        if whole:
            found[f"turn {side}"] = max(whole, key=len)
    middles = {name: max((len(rows) - frames) // 2, 0) for name, rows in found.items()}
    chosen = {name: rows[middles[name] : middles[name] + frames] for name, rows in found.items()}
    return {name: channels_of(style, rows[: len(rows) // 2 * 2], layout) for name, rows in chosen.items()}


def recorded_stretch(style: StyleVectors, rows: Int[ndarray, " rows"], layout: Layout) -> Stretch:
    """Rows of one take as a stretch."""
    contacts = style.y[rows][:, layout.y_contacts] > _CONTACT
    return Stretch(style.x[rows][:, layout.x_pose], style.phase[rows], contacts)


def apart(reference: Reference, walks: Sequence[Stretch], others: Sequence[Stretch]) -> float:
    """How far the mean window of some walks lies from that of others, between the styles (deviations within one)."""
    return float(np.linalg.norm(reference.places(walks).mean(axis=0) - reference.places(others).mean(axis=0)))


def stretch_of(motion: Channels) -> Stretch:
    """A motion of channels as a stretch, its phase from its contacts."""
    contacts = motion.contacts > _CONTACT
    return Stretch(motion.poses, global_phase(contacts, FPS), contacts)


def lasting(root: Root, frames: int) -> Root:
    """A path with a straight run-up of so many frames, turned and moved so that this begins at the origin, facing +z.

    The path is smoothed over half a second, since it sways with the hips.
    """
    half = int(FPS / 2)
    # Reflected about its ends the path keeps its speed there; a filter that repeats the end would slow it down.
    longer = np.pad(root.positions, ((half, half), (0, 0)), mode="reflect", reflect_type="odd")
    places = gaussian_filter1d(longer, FPS / 4, axis=0, mode="nearest")[half:-half]
    facing = gaussian_filter1d(root.directions, FPS / 4, axis=0, mode="nearest")
    velocity = (places[half] - places[0]) / half
    before = places[0] + velocity * np.arange(-frames, 0)[:, None]
    facing = np.concatenate([np.repeat(facing[:1], frames, axis=0), facing])
    angles = np.unwrap(np.arctan2(facing[:, 0], facing[:, 1]))
    path = np.concatenate([before, places])
    return Root((path - path[0]) @ on_ground(angles[:1])[0], angles - angles[0])


@dataclass(frozen=True)
class Driven:
    """A controller's characters, one of each style, on paths of their own, and the frames of the run-up."""

    styles: tuple[str, ...]
    run: Rollout
    paths: tuple[Root, ...]
    run_up: int

    @property
    def walks(self) -> dict[str, Stretch]:
        """What was walked after the run-up, of those that stayed finite."""
        found = {style: generated(self.run, k, self.run_up - 1) for k, style in enumerate(self.styles)}
        return {style: walk for style, walk in found.items() if walk is not None}

    def way(self, style: str) -> tuple[Float[ndarray, "frames 2"], Float[ndarray, "frames 2"]]:
        """The path that was asked for and the one walked (x, z in metres)."""
        k, rest = self.styles.index(style), slice(self.run_up, None)
        return self.paths[k].positions[rest], self.run.root_positions[rest, k]

    def off(self, style: str) -> float:
        """Mean distance (m) of the character from where it should be at the same time."""
        asked, walked = self.way(style)
        return float(np.linalg.norm(asked - walked, axis=1).mean())

    def unled(self, style: str) -> float:
        """The same of somebody who goes straight on at the path's mean speed: what it is to follow nothing."""
        asked, _ = self.way(style)
        ahead = np.arange(len(asked))[:, None] / FPS * speed_of(asked) * np.array([0.0, 1.0])
        return float(np.linalg.norm(asked - asked[0] - ahead, axis=1).mean())


def driven(bundle: Bundle, styles: Sequence[StyleVectors], paths: Mapping[str, Root]) -> Driven:
    """Each style walks along a path of its own, all of one length, after a run-up."""
    run_up, seen = int(RUN_UP * FPS), [for_gate(style, bundle.layout) for style in styles]
    whole = [lasting(paths[style.style], run_up) for style in styles]
    run = roll_out_led(bundle, codes_of(bundle, seen), start_of(seen, bundle.body), whole)
    return Driven(tuple(style.style for style in styles), run, tuple(whole), run_up)


def sliding(body: Body, walks: Sequence[Stretch]) -> float:
    """Mean speed (m/s) of the toes over the ground, weighed by how near they are to it (Zhang et al. 2018).

    It asks no contacts, which every method tells in its own way. Heights count from where the toes of the same walk
    rest; a toe more than 25 mm above that counts not.
    """
    toes, found = list(body.layout.effectors[2:]), []
    for walk in walks:
        joints = walk.joints[:, toes]
        heights = joints[:, :, 0, 1]
        above = np.maximum(heights - np.quantile(heights, _RESTS, axis=0), 0)
        speeds = np.linalg.norm(joints[:, :, 3][..., [0, 2]], axis=-1)
        found.append((speeds * np.clip(2 - 2 ** (above / _STANDS), 0, 1)).mean(axis=1))
    return float(np.concatenate(found).mean())


def farthest(reference: Reference, neutral: str, styles: Sequence[str], share: float = 1 / 3) -> list[str]:
    """The share of styles whose recorded walks lie farthest from neutral ones: the problem styles of [M18] 8.1."""
    space = reference.space
    centre = {style: space.centres[space.styles.index(style)] for style in (neutral, *styles)}
    apart = {style: float(np.linalg.norm(centre[style] - centre[neutral])) for style in styles}
    return sorted(styles, key=lambda style: -apart[style])[: max(1, round(share * len(styles)))]


# What is told of each motion: its unit, larger being worse.
TOLD = {
    "distance": "deviations",
    "other style": "share of windows",
    "sliding": "m/s",
    "bones": "mm",
    "spectrum": "Hz",
}


def judged(
    reference: Reference, walks: Mapping[str, Sequence[Stretch]], unseen: Mapping[str, Sequence[Stretch]]
) -> dict[str, Float[ndarray, " styles"]]:
    """For the styles of `unseen` each measure of `TOLD`; NaN where a style has no walk."""
    styles = list(unseen)
    found = measured(reference, walks, styles, [name for name in TOLD if name not in ("distance", "sliding")])
    some = {style: list(walks.get(style, ())) for style in styles}
    nan = float("nan")
    far = [apart(reference, some[s], unseen[s]) if some[s] else nan for s in styles]
    slid = [sliding(reference.body, some[s]) if some[s] else nan for s in styles]
    return {name: found.get(name, np.array(far if name == "distance" else slid)) for name in TOLD}


def transfers(
    network: MotionAutoencoder,
    contents: Mapping[str, Channels],
    grams: Mapping[str, Float[Tensor, "units units"]],
    anatomy: Anatomy,
    settings: GramSettings,
    seed: int = 0,
) -> tuple[dict[str, dict[str, Channels]], float]:
    """Every content in every style, by content and style, and the processor's seconds for a second of motion."""
    begun = time.process_time()
    made = {
        name: {s: transfer(network, content, g, anatomy, settings, seed=seed) for s, g in grams.items()}
        for name, content in contents.items()
    }
    seconds = sum(len(motion) for some in made.values() for motion in some.values()) / FPS
    return made, (time.process_time() - begun) / seconds


def seconds_of_one(bundle: Bundle, style: StyleVectors, path: Root) -> float:
    """The processor's seconds for a second of one character on a path."""
    begun = time.process_time()
    run = driven(bundle, [style], {style.style: path}).run
    return (time.process_time() - begun) * FPS / len(run)


def weights_folder(named: Path | None, *others: Path) -> Path:
    """The first folder that holds trained weights: the one named, which must, or else of the others."""
    for folder in others if named is None else (named,):
        if is_bundle(folder):
            return folder
    raise InputError("holds no trained weights", named or others[0])


def learned_from_clips(base: Bundle, materials: Mapping[str, Material], seed: int = 0) -> Bundle:
    """The base with an adapter for every style that it does not know, learned from the style's clip and nothing else.

    So it saw what a transfer from one clip sees. Raises InputError where the base is no PFNN with adapters.
    """
    new = [clip_alone(material) for style, material in materials.items() if style not in base.codes]
    learned = [{"style": style.style, "frames": len(style.x)} for style in new]
    bundle = add_styles(base, [Lesson(style) for style in new], seed=seed)
    return replace(bundle, about=bundle.about | {"few_shot": [*base.about.get("few_shot", []), *learned]})


def clip_alone(material: Material) -> StyleVectors:
    """A style as if its clip were all there is of it."""
    style, rows = material.style, material.clip
    parts = {name: getattr(style, name)[rows] for name in ("x", "p", "y", "phase", "phase_update")}
    one = {name: np.zeros(len(rows), dtype=int) for name in ("take", "part")}
    return replace(style, gaits=(style.gaits[style.take[rows[0]]],), **parts, **one)


def few_shot_styles(bundle: Bundle) -> tuple[str, ...]:
    """The styles that the weights learned from a short clip each, as `stylephase fewshot` notes in them."""
    return tuple(learned["style"] for learned in bundle.about.get("few_shot", ()))
