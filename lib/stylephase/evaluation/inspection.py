"""What a BVH file of one's own is good for: joints, unit, gait, contacts, phases, and what stands in the way.

Nothing is assumed of the file but that somebody may walk in it. A fault makes a take useless here, a remark says what
will be worse for it.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from stylephase.data.catalogue import check_same_skeleton
from stylephase.data.registry import DATA, MIDDLE_CONTACT
from stylephase.errors import InputError
from stylephase.evaluation.motion import ALTERNATION, foot_skate, steps_of
from stylephase.evaluation.phases import antiphase, explained
from stylephase.features.body import body_from_json
from stylephase.features.captures import SLOWEST, UPRIGHT, above_the_feet, other_axis_up, too_short, too_slow
from stylephase.features.layout import FPS
from stylephase.models.bundle import description
from stylephase.models.zoo import PHASED_ADAPTERS, model
from stylephase.motion.bvh import read_bvh, read_with_unit, write_bvh
from stylephase.motion.clip import Clip, Pose, forward_kinematics, resample
from stylephase.motion.root import root_of
from stylephase.motion.skeleton import EFFECTOR_NAMES, Skeleton
from stylephase.phase.local import variant
from stylephase.phase.source import Movement, principal_source, sourcing
from stylephase.phase.take import TakePhases, movement_of, movement_phases

PRETRAINED = DATA / "pretrained"
# The commands by which weights learn a new style.
FINETUNE, FEWSHOT = "finetune", "fewshot"
UNITS = {1.0: "metre", 0.01: "centimetre", 0.001: "millimetre", 0.0254: "inch", 0.0254 / 0.45: "CMU's (2.54 cm / 0.45)"}
# Legs of an adult (m); a guess of the unit that gives others is doubtful.
_LEGS = (0.6, 1.25)
# Somebody who runs is often in the air, and faster than this (m/s).
_FLIGHT, _RUNNING = 0.1, 1.5
# No joint of a person goes faster than this (m/s).
_FASTEST = 20.0
# Remarks begin here: frames a second, steps, clarity, sliding feet (m/s), floor (m).
_COARSE, _FEW_STEPS, _CLEAR, _SLIDES, _FLOOR = 50.0, 6, 0.5, 0.15, 0.25
# A cycle takes two steps; of fewer nothing can be learned. Nobody's takes longer than this (s).
_LEAST_STEPS, _SLOW_CYCLE = 2, 3.0
_WINDOW, _OFTEN = 2.0, 0.05


@dataclass(frozen=True)
class Walk:
    """What goes on in a take.

    `gait` in words; `speed` (m/s) over half seconds; `turning` (degrees/s) and `towards`, the angle (degrees) from
    where the hips face to where they go, both positive to the left; `contacts` the share of the time that
    the right and the left foot stand, `skate` (m/s) their speed then; `steps`, the share of them that alternate, and
    `cycle` (s); `floor` (m) the height at which the feet rest; `still` and `fallen` the shares of the time in which
    the root does not get on, and in which nobody is upright.
    """

    gait: str
    speed: float
    turning: float
    towards: float
    contacts: tuple[float, float]
    skate: float
    steps: int
    alternation: float
    cycle: float
    floor: float
    still: float
    fallen: float


@dataclass(frozen=True)
class Inspection:
    """One file: what was found, remarks, and the faults that make it useless (none for a usable take).

    `unit` is the guessed unit of length, `legs` (m) what the legs measure by it; `effectors` name the joints taken for
    hands and feet, and `stretch` is the longest part of the file [start, stop) in which nothing jumps; the rest was
    measured in it. `clarity` is, for each effector, the share of its movement to and fro that a sinusoid of its phase
    explains (1: all of it), and `apart` (cycles) how far the feet are from half a cycle apart, in the median.
    """

    file: Path
    style: str
    frames: int = 0
    fps: float = 0.0
    joints: int = 0
    unit: str = ""
    legs: float = 0.0
    effectors: dict[str, str] | None = None
    stretch: tuple[int, int] = (0, 0)
    walk: Walk | None = None
    clarity: dict[str, float] | None = None
    apart: float | None = None
    remarks: tuple[str, ...] = ()
    faults: tuple[str, ...] = ()

    @property
    def usable(self) -> bool:
        """Whether one can learn from the take."""
        return not self.faults

    @property
    def seconds(self) -> float:
        """Duration (s)."""
        return self.frames / self.fps if self.fps else 0.0


@dataclass(frozen=True)
class Report:
    """Files of one folder: what was found of each, and the skeleton that most of them have."""

    takes: tuple[Inspection, ...]
    skeleton: Skeleton | None

    @property
    def usable(self) -> tuple[Inspection, ...]:
        """The takes that one can learn from."""
        return tuple(take for take in self.takes if take.usable)


def inspect_files(files: Iterable[tuple[Path, str]]) -> Report:
    """Inspect files of (path, style); those with another skeleton than most others are of no use beside them."""
    takes, skeletons = list[Inspection](), dict[Path, Skeleton]()
    for path, style in files:
        try:
            clip, unit = read_with_unit(path)
            takes.append(inspect_clip(clip, path, style, unit))
        except InputError as error:
            takes.append(Inspection(path, style, faults=(_without_path(error),)))
            continue
        skeletons[path] = clip.skeleton
    if not skeletons:
        return Report(tuple(takes), None)
    first = most_common_skeleton(skeletons)
    for k, take in enumerate(takes):
        if take.file in skeletons and (reason := _other_skeleton(take.file, skeletons, first)):
            takes[k] = Inspection(take.file, take.style, faults=(reason,))
    return Report(tuple(takes), skeletons[first])


def most_common_skeleton(skeletons: Mapping[Path, Skeleton]) -> Path:
    """The first file whose skeleton most files have; of skeletons that as many have, the one met first."""
    counts = dict[Path, int]()
    for path in skeletons:
        known = next((first for first in counts if _other_skeleton(path, skeletons, first) is None), path)
        counts[known] = counts.get(known, 0) + 1
    return max(counts, key=lambda first: counts[first])


def _other_skeleton(path: Path, skeletons: Mapping[Path, Skeleton], first: Path) -> str | None:
    """How the skeleton of a file differs from that of another file, or None."""
    try:
        check_same_skeleton(path, skeletons[path], skeletons[first], whose=first.name)
    except InputError as error:
        return error.reason
    return None


def keep_usable(report: Report, folder: Path) -> Path:
    """Write what is of use of a report's files into a folder of their own, in centimetres, by style.

    Each is cut to the stretch in which nothing jumps; of files with one name the further ones get a number. Raises
    InputError where the folder holds something, so that nobody's files are lost.
    """
    check_new_folder(folder)
    for take in report.usable:
        place, number = folder / take.style / take.file.name, 2
        while place.exists():
            place, number = place.with_name(f"{take.file.stem}-{number}{take.file.suffix}"), number + 1
        write_bvh(place, read_bvh(take.file).frames(*take.stretch))
    return folder


def check_new_folder(folder: Path) -> None:
    """Raise InputError where a folder to write into holds something already, or is a file."""
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InputError("is there and not empty; name another folder", folder)


def fitting_weights(skeleton: Skeleton, folder: Path = PRETRAINED) -> dict[Path, str]:
    """The trained weights in a folder of such that know a skeleton and can learn a new style, and by which command.

    By `finetune` with their style network, which weights that are only meant to walk come without, or by `fewshot`
    with an adapter.
    """
    found = {}
    for path in sorted(path.parent for path in folder.glob("*/model.json")):
        told = description(path)
        try:
            check_same_skeleton(path, skeleton, body_from_json(told["body"]).skeleton)
        except InputError:
            continue
        modulator = model(told["model"]).modulator
        if modulator == "film" and told.get("generator", True):
            found[path] = FINETUNE
        elif modulator in PHASED_ADAPTERS:
            found[path] = FEWSHOT
    return found


def inspect_clip(clip: Clip, path: Path, style: str, unit: float) -> Inspection:
    """Inspect one take that could be read, from a file with this unit of length (m)."""
    skeleton, stretch = clip.skeleton, unbroken(clip)
    at_60 = resample(clip.frames(*stretch), FPS)
    pose, legs = forward_kinematics(at_60), skeleton.length_to(skeleton.roles.toes[0])
    seen = Inspection(
        path,
        style,
        frames=len(clip),
        fps=clip.fps,
        joints=len(skeleton),
        unit=UNITS.get(unit, f"{unit:g} m"),
        legs=legs,
        stretch=stretch,
        effectors={
            name: skeleton.names[joint] for name, joint in zip(EFFECTOR_NAMES, skeleton.roles.effectors, strict=True)
        },
    )
    faults = tuple(
        fault
        for fault in (too_short(at_60), other_axis_up(pose, skeleton) or _low(pose, skeleton))
        if fault is not None
    )
    if faults:
        return replace(seen, faults=faults)
    movement = movement_of(pose, skeleton, FPS, MIDDLE_CONTACT)
    phases = movement_phases(movement, sourcing([movement]), variant("adaptive"))
    walk, apart = walk_of(pose, skeleton, phases), float(np.median(antiphase(phases.local.phase)))
    fault = too_slow(walk.speed) or _no_cycle(walk)
    seen = replace(seen, walk=walk, clarity=clarity_of(movement, phases), apart=apart, faults=(fault,) if fault else ())
    return replace(seen, remarks=tuple(_remarks(seen)))


def unbroken(clip: Clip) -> tuple[int, int]:
    """The longest part [start, stop) of a take in which no joint goes faster than anybody can."""
    steps = np.linalg.norm(np.diff(forward_kinematics(clip).positions, axis=0), axis=-1).max(axis=1)
    ends = [0, *(np.flatnonzero(steps * clip.fps > _FASTEST) + 1), len(clip)]
    start, stop = max(pairwise(ends), key=lambda part: part[1] - part[0])
    return int(start), int(stop)


def walk_of(pose: Pose, skeleton: Skeleton, phases: TakePhases) -> Walk:
    """What goes on in a take at 60 frames a second."""
    root, half = root_of(pose, skeleton), int(FPS / 2)
    moved = (root.positions[half:] - root.positions[:-half]) * FPS / half
    speeds = np.linalg.norm(moved, axis=1)
    speed = float(speeds.mean())
    facing = root.directions[half // 2 : half // 2 + len(moved)]
    ahead, left = (moved * facing).sum(axis=1).mean(), (moved * facing[:, ::-1] * [1, -1]).sum(axis=1).mean()
    toes = pose.positions[:, list(skeleton.roles.toe_sensors[::-1])]
    steps, contacts = steps_of(phases.contacts, phases.fps), phases.contacts
    towards = float(np.degrees(np.arctan2(left, ahead)))
    flight = float((~contacts.any(axis=1)).mean())
    return Walk(
        gait_of(speed, towards, flight),
        speed,
        float(np.degrees(root.angles[-1] - root.angles[0]) * FPS / max(len(root) - 1, 1)),
        towards,
        (float(contacts[:, 0].mean()), float(contacts[:, 1].mean())),
        foot_skate(toes, contacts),
        steps.count,
        steps.alternation,
        steps.cycle,
        float(np.percentile(toes[..., 1].min(axis=1), 3)),
        float((speeds < SLOWEST).mean()),
        float((above_the_feet(pose, skeleton)[:, 1] < UPRIGHT).mean()),
    )


def clarity_of(movement: Movement, phases: TakePhases) -> dict[str, float]:
    """For each effector the share of its movement along its main direction that a sinusoid of its phase explains.

    Taken in windows of two seconds, a few cycles; the median of them counts, so that a stop does not.
    """
    places = movement.places
    windows = np.array_split(np.arange(len(places)), max(1, round(len(places) / (_WINDOW * movement.fps))))
    clear = {}
    for k, name in enumerate(EFFECTOR_NAMES):
        source, phase = principal_source(places[:, k], phases.sourcing.directions[k]), phases.local.phase[:, k]
        clear[name] = float(np.median([explained(source[rows], phase[rows]) for rows in windows]))
    return clear


def gait_of(speed: float, towards: float, flight: float) -> str:
    """What is done at a speed (m/s), this far to the left of ahead (degrees), in the air for a share of the frames."""
    if speed <= SLOWEST:
        return "stands"
    verb = "runs" if flight > _FLIGHT and speed > _RUNNING else "walks"
    way = "ahead" if abs(towards) < 45 else "backwards" if abs(towards) > 135 else "sideways"
    return f"{verb} {way}"


def _low(pose: Pose, skeleton: Skeleton) -> str | None:
    """Why a take in which nobody stands upright is of no use, or None."""
    above, legs = float(np.median(above_the_feet(pose, skeleton)[:, 1])), skeleton.length_to(skeleton.roles.toes[0])
    if above > UPRIGHT:
        return None
    return f"the hips are {above * legs:.2f} m above the feet, with legs of {legs:.2f} m: nobody stands in it"


def _no_cycle(walk: Walk) -> str | None:
    """Why a take without a cycle of steps is of no use, or None."""
    if walk.steps >= _LEAST_STEPS:
        return None
    return f"{walk.steps} steps at {walk.speed:.2f} m/s: no whole cycle, or feet whose contacts cannot be told"


def _remarks(seen: Inspection) -> list[str]:
    walk, remarks = seen.walk, []
    assert walk is not None and seen.clarity is not None
    if not _LEGS[0] <= seen.legs <= _LEGS[1]:
        remarks.append(f"legs of {seen.legs:.2f} m: the unit may be another than the {seen.unit}")
    if seen.stretch != (0, seen.frames):
        start, stop = seen.stretch
        remarks.append(f"the body jumps: cut the file to frames {start} to {stop - 1} of {seen.frames}")
    if seen.fps < _COARSE:
        remarks.append(f"{seen.fps:g} frames a second: what moves faster than {seen.fps / 2:g} Hz is not in it")
    for share, what in ((walk.still, "nobody gets on"), (walk.fallen, "nobody is upright")):
        if share > _OFTEN:
            remarks.append(f"in {100 * share:.0f} % of the time {what}: cut that out")
    if abs(walk.floor) > _FLOOR:
        remarks.append(f"the feet rest {walk.floor:.2f} m from y = 0")
    if walk.cycle > _SLOW_CYCLE:
        remarks.append(f"a cycle takes {walk.cycle:.1f} s: is the Frame Time right?")
    if _LEAST_STEPS <= walk.steps < _FEW_STEPS:
        remarks.append(f"{walk.steps} steps: little to learn from")
    elif walk.steps >= _FEW_STEPS and walk.alternation < ALTERNATION:
        remarks.append(f"only {100 * walk.alternation:.0f} % of the steps follow one of the other foot")
    if walk.skate > _SLIDES:
        remarks.append(f"feet slide by {walk.skate:.2f} m/s while they stand")
    unclear = [name for name, share in seen.clarity.items() if share < _CLEAR]
    if unclear:
        remarks.append(f"no clear phase: {', '.join(unclear)}")
    return remarks


def _without_path(error: InputError) -> str:
    return error.reason if error.line is None else f"line {error.line}: {error.reason}"


HEADS = ("file", "style", "s", "fps", "gait", "m/s", "steps", "cycle s", "stands R, L", "clear phases", "verdict")


def rows_of(found: Sequence[Inspection]) -> list[tuple[str, ...]]:
    """A row for each file under `HEADS`."""
    return [_row(each) for each in found]


def _row(each: Inspection) -> tuple[str, ...]:
    walk, clarity = each.walk, each.clarity or {}
    told = (*each.faults, *each.remarks)
    verdict = ("usable" if each.usable else "unusable") + (f": {'; '.join(told)}" if told else "")
    head = (each.file.name, each.style, f"{each.seconds:.1f}", f"{each.fps:g}")
    if walk is None:
        return (*head, *[""] * (len(HEADS) - len(head) - 1), verdict)
    return (
        *head,
        walk.gait,
        f"{walk.speed:.2f}",
        str(walk.steps),
        f"{walk.cycle:.2f}",
        f"{walk.contacts[0]:.2f}, {walk.contacts[1]:.2f}",
        ", ".join(f"{share:.2f}" for share in clarity.values()),
        verdict,
    )
