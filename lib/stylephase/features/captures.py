"""Vectors of one style from BVH files named one by one, for weights that know their skeleton."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.data.catalogue import SHORTEST_TAKE, Catalogue, check_same_skeleton, load_clip, usable
from stylephase.data.layouts import Entry
from stylephase.data.registry import OWN, Dataset, dataset, datasets
from stylephase.errors import InputError
from stylephase.features.body import Body
from stylephase.features.layout import FPS
from stylephase.features.store import StyleVectors, style_vectors
from stylephase.features.vectors import vectors
from stylephase.motion.clip import Clip, Pose, forward_kinematics
from stylephase.motion.contacts import ContactRule
from stylephase.motion.root import root_of
from stylephase.motion.skeleton import Skeleton
from stylephase.phase.local import variant
from stylephase.phase.source import sourcing
from stylephase.phase.take import movement_of, movement_phases

# The root of someone who walks gets on faster than this (m/s); the slowest takes of the data sets do at twice that.
SLOWEST = 0.1
# Hips are above the feet by this share of the leg, along the axis that is up.
UPRIGHT = 0.5
_AXES = "xyz"


def captured_vectors(paths: Sequence[Path], style: str, body: Body, phases: str, data: str) -> StyleVectors:
    """Vectors of the takes in some files, all of one style, with contacts by the rule of the data set `data`.

    A file's frame rate and unit are its own. Raises InputError that names the file: it cannot be read, has another
    skeleton than `body`, is too short or lies on its side, or nobody walks in it.
    """
    entries = tuple(Entry(path, style, "any") for path in paths)
    for entry in entries:
        captured_clip(entry.path, body, data)
    return style_vectors(Catalogue(_source(data), entries), style, body, phases)


def captured_clip(path: Path, body: Body, data: str) -> Clip:
    """One file as a clip of a known body at 60 frames a second. Raises InputError as `captured_vectors`."""
    clip = load_clip(Entry(path, "", "any"), _source(data), fps=FPS)
    check_same_skeleton(path, clip.skeleton, body.skeleton, whose="the weights' skeleton")
    clip = replace(clip, skeleton=body.skeleton)
    _check_walk(path, clip)
    return clip


def check_upright(catalogue: Catalogue) -> None:
    """Raise InputError for a data set of one's own whose up axis is not y, by the first take of each style."""
    for style in catalogue.styles:
        entry = catalogue.of(style)[0]
        clip = load_clip(entry, catalogue.dataset, fps=FPS)
        if reason := other_axis_up(forward_kinematics(clip), clip.skeleton):
            raise InputError(reason, entry.path)


def clip_vectors(
    clip: Clip,
    style: str,
    body: Body,
    phases: str,
    data: str,
    *,
    symmetric: bool,
    gait: str = "any",
    rule: ContactRule | None = None,
) -> StyleVectors:
    """Vectors of one clip at 60 frames a second, all of them to train on, with contacts by the rule of `data`.

    A `rule` takes the place of that.
    """
    pose = forward_kinematics(clip)
    movement = movement_of(pose, body.skeleton, FPS, rule or _source(data).contact)
    take = movement_phases(movement, sourcing([movement]), variant(phases))
    made = vectors(pose, body.skeleton, body.rest, FPS, take.local.vectors, take.contacts, take.global_phase)
    arrays = {kind: value.astype(np.float32) for kind, value in vars(made).items()}
    whole = np.zeros(len(made.x), dtype=int)
    return StyleVectors(style=style, symmetric=symmetric, gaits=(gait,), take=whole, part=whole, **arrays)


def _source(data: str) -> Dataset:
    """The data set called so, or else the user's own; a file's frame rate and unit are its own."""
    known = datasets()[data] if data in datasets() else dataset(OWN)
    return replace(known, fps=None, metres_per_unit=None, contact_free={})


def _check_walk(path: Path, clip: Clip) -> None:
    pose = forward_kinematics(clip)
    reason = too_short(clip) or other_axis_up(pose, clip.skeleton)
    if reason is None:
        root, half = root_of(pose, clip.skeleton).positions, int(FPS / 2)
        reason = too_slow(float(np.linalg.norm(root[half:] - root[:-half], axis=1).mean() * FPS / half))
    if reason is not None:
        raise InputError(reason, path)


def above_the_feet(pose: Pose, skeleton: Skeleton) -> Float[ndarray, "frames 3"]:
    """The hips seen from between the toes, in lengths of a leg."""
    toes = pose.positions[:, list(skeleton.roles.toes)].mean(axis=1)
    return (pose.positions[:, 0] - toes) / skeleton.length_to(skeleton.roles.toes[0])


def other_axis_up(pose: Pose, skeleton: Skeleton) -> str | None:
    """Why a take with another axis up is of no use, or None; who crouches or runs may be low over the feet."""
    above = np.median(above_the_feet(pose, skeleton), axis=0)
    axis = int(np.abs(above).argmax())
    if axis == 1 or abs(above[axis]) <= UPRIGHT:
        return None
    return f"its up axis seems to be {'' if above[axis] > 0 else '-'}{_AXES[axis]}; export it with y up"


def too_short(clip: Clip) -> str | None:
    """Why a clip at 60 frames a second is too short to learn from, or None."""
    return None if usable(len(clip)) else f"lasts {len(clip)} frames at {FPS:g} a second; a take needs {SHORTEST_TAKE}"


def too_slow(speed: float) -> str | None:
    """Why a take that gets on at this speed (m/s) is no walk, or None."""
    if speed > SLOWEST:
        return None
    return f"nobody walks in it: it gets on by {speed:.2f} m/s; expected more than {SLOWEST:g}"
