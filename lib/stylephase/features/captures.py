"""Vectors of one style from BVH files named one by one, for weights that know their skeleton."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from stylephase.data.catalogue import SHORTEST_TAKE, Catalogue, check_same_skeleton, load_clip, usable
from stylephase.data.layouts import Entry
from stylephase.data.registry import OWN, dataset, datasets
from stylephase.errors import InputError
from stylephase.features.body import Body
from stylephase.features.layout import FPS
from stylephase.features.store import StyleVectors, style_vectors
from stylephase.motion.clip import Clip, forward_kinematics
from stylephase.motion.root import root_of

# The root of someone who walks gets on faster than this (m/s); the slowest takes of the data sets do at twice that.
_SLOWEST = 0.1


def captured_vectors(paths: Sequence[Path], style: str, body: Body, phases: str, data: str) -> StyleVectors:
    """Vectors of the takes in some files, all of one style, with contacts by the rule of the data set `data`.

    A file's frame rate and unit are its own. Raises InputError that names the file: it cannot be read, has another
    skeleton than `body`, is too short, or nobody walks in it.
    """
    known = datasets()[data] if data in datasets() else dataset(OWN)
    source = replace(known, fps=None, metres_per_unit=None, contact_free={})
    entries = tuple(Entry(path, style, "any") for path in paths)
    for entry in entries:
        clip = load_clip(entry, source, fps=FPS)
        check_same_skeleton(entry.path, clip.skeleton, body.skeleton, whose="the weights' skeleton")
        _check_walk(entry.path, replace(clip, skeleton=body.skeleton))
    return style_vectors(Catalogue(source, entries), style, body, phases)


def _check_walk(path: Path, clip: Clip) -> None:
    if not usable(len(clip)):
        raise InputError(f"lasts {len(clip)} frames at {FPS:g} a second; a take needs {SHORTEST_TAKE}", path)
    root, half = root_of(forward_kinematics(clip), clip.skeleton).positions, int(FPS / 2)
    speed = float(np.linalg.norm(root[half:] - root[:-half], axis=1).mean() * FPS / half)
    if not speed > _SLOWEST:
        raise InputError(f"nobody walks in it: it gets on by {speed:.2f} m/s; expected more than {_SLOWEST:g}", path)
