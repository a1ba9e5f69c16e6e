"""One's own motion, from a folder of BVH files to a character that walks and a BVH file of its walk (notebook 15)."""

import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from stylephase.data.catalogue import Catalogue, load_catalogue
from stylephase.data.registry import OWN
from stylephase.errors import InputError
from stylephase.evaluation.inspection import FEWSHOT, FINETUNE, Report, fitting_weights, inspect_files, keep_usable
from stylephase.evaluation.rollouts import Walk, codes_of, judge, start_of, walking_speed
from stylephase.evaluation.style import style_space
from stylephase.features.captures import captured_clip, captured_vectors, clip_vectors
from stylephase.features.layout import FPS
from stylephase.features.store import StyleVectors, VectorStore, for_gate
from stylephase.models.bundle import Bundle, load_bundle
from stylephase.motion.bvh import read_bvh, read_with_unit, write_bvh
from stylephase.motion.clip import Clip, forward_kinematics
from stylephase.motion.synthetic import SKELETON, find_style, walk
from stylephase.report.render.motion import Motion
from stylephase.report.walks import data_walk
from stylephase.runtime.pace import at_pace
from stylephase.runtime.plans import Steady
from stylephase.runtime.rollout import to_clip
from stylephase.runtime.speeds import speed_curves
from stylephase.runtime.walkers import NetworkWalker, drive
from stylephase.training.checkpoint import check_folder
from stylephase.training.fewshot import Lesson, add_styles
from stylephase.training.finetune import fine_tune
from stylephase.training.loop import Trainer, identity_of
from stylephase.training.presets import preset

# The walker's joints as Mixamo calls them.
_MIXAMO = {
    "Chest": "Spine",
    "Chest2": "Spine1",
    "Chest3": "Spine2",
    "Chest4": "Spine3",
    **{
        f"{side}{own}": f"{side}{other}"
        for side in ("Left", "Right")
        for own, other in {
            "Collar": "Shoulder",
            "Shoulder": "Arm",
            "Elbow": "ForeArm",
            "Wrist": "Hand",
            "Hip": "UpLeg",
            "Knee": "Leg",
            "Ankle": "Foot",
            "Toe": "ToeBase",
        }.items()
    },
}
# Of a walk so long (s) the last part is judged: being led to a speed takes some seconds.
_DRIVEN_SECONDS, _LED_SECONDS, _SHOWN_SECONDS = 12.0, 6.0, 3.0
# Styles of the walker and how its files count lengths (m); of other data so many takes of a style are written.
_WALKERS, _INCH, _EACH = ("Plain", "StoopedOver"), 0.0254, 6
# What fine-tuned and few-shot styles are called: weights may know the files by another name.
MINE = "mine"


def as_mixamo(clip: Clip) -> Clip:
    """A clip of the walker with Mixamo's names."""
    names = tuple(f"mixamorig:{_MIXAMO.get(name, name)}" for name in SKELETON.names)
    return replace(clip, skeleton=replace(clip.skeleton, names=names))


def write_walker(folder: Path) -> Path:
    """Takes of the walker as somebody's own files: Mixamo's names, inches, and two that are of no use."""
    for style in _WALKERS:
        for gait in ("FW", "BW"):
            clip, truth = walk(find_style(style), gait, seconds=12.0)
            whole = as_mixamo(clip.frames(*truth.cut))
            write_bvh(folder / style / f"{style}_{gait}.bvh", whole, metres_per_unit=_INCH)
    write_bvh(folder / _WALKERS[0] / "too_short.bvh", whole.frames(0, 40), metres_per_unit=_INCH)
    write_bvh(folder / _WALKERS[0] / "other_rig.bvh", walk(find_style(_WALKERS[0]), "FW", seconds=3.0)[0])
    return folder


def write_takes(catalogue: Catalogue, folder: Path, gaits: Sequence[str]) -> Path:
    """A few takes of every style as somebody's own files: cut, at their own rate and unit."""
    for style in catalogue.styles:
        for entry in [entry for entry in catalogue.of(style) if entry.gait in gaits][:_EACH]:
            clip, unit = read_with_unit(entry.path, metres_per_unit=catalogue.dataset.metres_per_unit)
            whole = clip.frames(entry.start, len(clip) if entry.stop is None else min(entry.stop, len(clip)))
            write_bvh(folder / style / entry.path.name, whole, metres_per_unit=unit)
    return folder


def inspected(folder: Path) -> Report:
    """The report on a folder of BVH files."""
    return inspect_files([(entry.path, entry.style) for entry in load_catalogue(f"{OWN}{folder}").entries])


@dataclass(frozen=True)
class Driven:
    """A character of one's own: how it was learned, the walks of its styles, and its motion as a file.

    `motions` are three seconds of the data and of the character. `round_trip` (mm) is the largest distance of a joint
    between the walk and the same read back from its BVH file.
    """

    how: str
    walks: Sequence[Walk]
    motions: Mapping[str, Motion]
    round_trip: float
    file: Path


def learn_and_drive(report: Report, work: Path, steps: int) -> Driven:
    """Learn from the usable files, walk at the speed of the data, and write the walk of the first style as BVH.

    Weights that know the skeleton learn the files as one style by fine-tuning, or each style from one clip of it; else
    a small network is trained anew, for so many steps. The walk is led and finished as a user's is. `work` is emptied
    first. Raises InputError where no file is of use.
    """
    if not report.usable:
        raise InputError("no file is of use; the table above says why", report.takes[0].file if report.takes else None)
    if inside := [take.file for take in report.takes if take.file.resolve().is_relative_to(work.resolve())]:
        raise InputError(f"lies in {work}, which is emptied to work in; name another folder", inside[0])
    shutil.rmtree(work, ignore_errors=True)
    usable = keep_usable(report, work / "usable")
    known = fitting_weights(report.skeleton) if report.skeleton else {}
    ways = [(_tuned, FINETUNE), (_few_shot, FEWSHOT)]
    able = [(way, path) for way, wanted in ways for path, command in known.items() if command == wanted]
    bundle, vectors, store, how = able[0][0](able[0][1], usable) if able else _trained(usable, work, steps)
    styles = [for_gate(style, bundle.layout) for style in vectors]
    start, codes = start_of(styles, bundle.body), codes_of(bundle, styles)
    wanted, names = np.array([walking_speed(style) for style in styles]), [style.style for style in styles]
    curves = speed_curves(bundle, names, start, grounded=True)
    gains = np.array([curves[name].gain(speed) for name, speed in zip(names, wanted, strict=True)])
    plan = at_pace(Steady(gains), wanted)
    run = drive(NetworkWalker(bundle), codes, start, int(_DRIVEN_SECONDS * FPS), plan)
    walks = judge(run, bundle, styles, gains, style_space(styles, bundle.layout), settle=int(_LED_SECONDS * FPS))
    name = styles[0].style
    motions = {"data": _middle(data_walk(store, store.catalogue.styles[0], f"{store.catalogue.styles[0]}, data"))}
    clip = to_clip(run, 0, bundle.body, name)
    pose = forward_kinematics(clip)
    motions["ours"] = _middle(Motion(clip.skeleton, pose.positions, run.contacts[:, 0] > 0.5, label=f"{name}, ours"))
    file = work / f"{name}.bvh"
    write_bvh(file, clip)
    off = np.linalg.norm(forward_kinematics(read_bvh(file, metres_per_unit=0.01)).positions - pose.positions, axis=-1)
    return Driven(how, walks, motions, 1000 * float(off.max()), file)


def _middle(motion: Motion) -> Motion:
    """Some seconds from its middle: pictures further apart than that may meet the same pose again and again."""
    start = max((len(motion) - int(_SHOWN_SECONDS * FPS)) // 2, 0)
    return motion.frames(start, min(start + int(_SHOWN_SECONDS * FPS), len(motion)))


# Weights, the styles to walk in, the vectors that they came from, and how it was learned.
_Learned = tuple[Bundle, list[StyleVectors], VectorStore, str]


def _tuned(weights: Path, folder: Path) -> _Learned:
    base, catalogue = load_bundle(weights), load_catalogue(f"{OWN}{folder}")
    phases, files = str(base.about["phases"]), [entry.path for entry in catalogue.entries]
    vectors = captured_vectors(files, MINE, base.body, phases, str(base.about["data"]))
    how = f"fine-tuned from data/pretrained/{weights.name}"
    return fine_tune(base, [vectors]).bundle, [vectors], VectorStore(catalogue, phases), how


def _few_shot(weights: Path, folder: Path) -> _Learned:
    """Each style from the first of its files; the others only say how it walks."""
    base, catalogue = load_bundle(weights), load_catalogue(f"{OWN}{folder}")
    data, phases, vectors, lessons = str(base.about["data"]), str(base.about["phases"]), [], []
    for style in catalogue.styles:
        files, name = [entry.path for entry in catalogue.of(style)], f"{MINE}-{style}"
        vectors.append(captured_vectors(files, name, base.body, phases, data))
        clip = captured_clip(files[0], base.body, data)
        lessons.append(Lesson(clip_vectors(clip, name, base.body, phases, data, symmetric=True)))
    how = f"each style from one clip, by data/pretrained/{weights.name}"
    return add_styles(base, lessons), vectors, VectorStore(catalogue, phases), how


def _trained(folder: Path, work: Path, steps: int) -> _Learned:
    how = replace(preset("quick"), steps=steps)
    store = VectorStore(load_catalogue(f"{OWN}{folder}"), how.phases)
    check_folder(work / "run", identity_of(store, "lpn-film", how, "quick", 0), resume=True)
    bundle = Trainer(store, "lpn-film", how, "quick", 0).run(work / "run", lambda steps: None)
    return (
        bundle,
        [store.load(style) for style in bundle.styles],
        store,
        f"trained anew, preset quick with {steps} steps",
    )
