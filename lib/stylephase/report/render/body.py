"""A mannequin over any skeleton: which tapered shapes lie between which points, and how thick they are."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from stylephase.motion.skeleton import MIN_BONE
from stylephase.report import palette
from stylephase.report.render.anatomy import Anatomy
from stylephase.report.render.landmarks import HIPS, LEFT_FOOT, SHOULDERS, WAIST, added

Radii = tuple[tuple[float, float], tuple[float, float]]
# Half widths (across, deep) in metres at both ends, for a person of scale 1.
_RADII: dict[str, Radii] = {
    "belly": ((0.108, 0.082), (0.102, 0.076)),
    "ribs": ((0.135, 0.100), (0.085, 0.070)),
    "neck": ((0.050, 0.050), (0.047, 0.047)),
    "head": ((0.064, 0.076), (0.078, 0.094)),
    "collar": ((0.050, 0.050), (0.045, 0.045)),
    "upper arm": ((0.050, 0.050), (0.037, 0.037)),
    "forearm": ((0.037, 0.037), (0.026, 0.026)),
    "hand": ((0.024, 0.024), (0.034, 0.034)),
    "pelvis": ((0.078, 0.078), (0.078, 0.078)),
    "thigh": ((0.084, 0.084), (0.055, 0.055)),
    "shin": ((0.054, 0.054), (0.036, 0.036)),
    "heel": ((0.037, 0.037), (0.036, 0.036)),
    "instep": ((0.037, 0.046), (0.044, 0.030)),
    "sole": ((0.036, 0.036), (0.048, 0.028)),
    "toes": ((0.048, 0.028), (0.036, 0.022)),
    "other": ((0.014, 0.014), (0.012, 0.012)),
}
# Where the rib cage begins, as a share of the way from the hips to the base of the neck.
_RIBS = 0.55
_KNOB = 1.08
_FOOT = ("Heel", "Arch", "Ball", "Tip")
_COLOURS = {"left": palette.LEFT, "right": palette.RIGHT, "middle": palette.BODY}


class Part(NamedTuple):
    """A tapered shape from landmark `start` to landmark `stop`.

    `radii` (m) are half widths (across, deep) at both ends; the width follows the sideways vector number `axis`.
    """

    start: int
    stop: int
    radii: Radii
    axis: int
    colour: str


def body_parts(anatomy: Anatomy) -> list[Part]:
    """All shapes of the mannequin: trunk, head, each limb with its joints, and any other bone of the skeleton."""
    parts = _trunk_and_head(anatomy)
    for side in (0, 1):
        parts += [*_arm(anatomy, side), *_leg(anatomy, side)]
    parts += _other_bones(anatomy, {part.stop for part in parts})
    return [part._replace(radii=_scaled(part.radii, anatomy.scale)) for part in parts]


def _scaled(radii: Radii, factor: float) -> Radii:
    (a, b), (c, d) = radii
    return (a * factor, b * factor), (c * factor, d * factor)


def _part(start: int, stop: int, kind: str, colour: str = palette.BODY, axis: int = SHOULDERS) -> Part:
    return Part(start, stop, _RADII[kind], axis, colour)


def _knob(joint: int, kind: str, end: int, colour: str) -> Part:
    """The ball of a joint, a little thicker than that end of the limb."""
    radii = _scaled((_RADII[kind][end], _RADII[kind][end]), _KNOB)
    return Part(joint, joint, radii, HIPS, palette.darker(colour))


def _trunk_and_head(anatomy: Anatomy) -> list[Part]:
    """Pelvis, belly along the spine, rib cage up to the base of the neck, neck and head.

    The rib cage is one shape from about the middle of the trunk, whichever joint the arms hang on.
    """
    skeleton = anatomy.skeleton
    chain = [j for j in skeleton.chain(anatomy.head) if j == 0 or _length(anatomy, j) > MIN_BONE]
    base = next((k for k, j in enumerate(chain) if j > anatomy.chest and k > 0), len(chain) - 1)
    heights = np.cumsum([0.0] + [_length(anatomy, j) for j in chain[1 : base + 1]])
    ribs = int(np.argmin(np.abs(heights - _RIBS * heights[-1])))
    bones = list(pairwise(chain))
    (left, *_), (right, *_) = anatomy.legs
    return [
        _part(left, right, "pelvis"),
        *(_part(*bone, "belly", axis=WAIST) for bone in bones[:ribs]),
        _part(chain[ribs], chain[base], "ribs"),
        *(_part(*bone, "neck") for bone in bones[base:]),
        _part(added(anatomy, "Skull"), added(anatomy, "Crown"), "head"),
    ]


def _arm(anatomy: Anatomy, side: int) -> list[Part]:
    shoulder, elbow, wrist = anatomy.arms[side]
    colour = _COLOURS[anatomy.sides[wrist]]
    start = anatomy.skeleton.parents[shoulder]
    return [
        _part(start, shoulder, "collar"),
        _part(shoulder, elbow, "upper arm", colour),
        _part(elbow, wrist, "forearm", colour),
        _part(wrist, added(anatomy, f"{('Left', 'Right')[side]}Fist"), "hand", colour),
        _knob(elbow, "forearm", 0, colour),
        _knob(wrist, "forearm", 1, colour),
    ]


def _leg(anatomy: Anatomy, side: int) -> list[Part]:
    thigh, knee, ankle = anatomy.legs[side]
    colour, axis = _COLOURS[anatomy.sides[ankle]], LEFT_FOOT + side
    heel, arch, ball, tip = (added(anatomy, ("Left", "Right")[side] + name) for name in _FOOT)
    return [
        _part(thigh, knee, "thigh", colour),
        _part(knee, ankle, "shin", colour),
        _part(ankle, heel, "heel", colour, axis),
        _part(ankle, arch, "heel", colour, axis),
        _part(ankle, ball, "instep", colour, axis),
        _part(heel, ball, "sole", colour, axis),
        _part(ball, tip, "toes", colour, axis),
        _knob(knee, "shin", 0, colour),
        _knob(ankle, "shin", 1, colour),
    ]


def _length(anatomy: Anatomy, joint: int) -> float:
    return float(np.linalg.norm(anatomy.skeleton.offsets[joint]))


def _other_bones(anatomy: Anatomy, drawn: set[int]) -> list[Part]:
    """Bones with a length that no other shape stands for, such as fingers, a tail or a stick."""
    skeleton = anatomy.skeleton
    thighs = {leg[0] for leg in anatomy.legs}
    covered = drawn | thighs | {*skeleton.chain(anatomy.head), *skeleton.roles.hands, *anatomy.toes}
    ends = {anatomy.head, *anatomy.toes}
    return [
        _part(parent, joint, "other", _COLOURS[anatomy.sides[joint]])
        for joint, parent in enumerate(skeleton.parents)
        if _length(anatomy, joint) > MIN_BONE and joint not in covered and parent not in ends
    ]
