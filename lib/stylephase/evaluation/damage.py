"""Known damage to recorded walks, in degrees from none to much, by which measures of walking are tried out."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy import ndarray
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d

from stylephase.evaluation.measures import Reference
from stylephase.evaluation.stretches import Stretch
from stylephase.features.layout import FPS

# Joints of an arm from the hand upwards.
_ARM = 3


@dataclass(frozen=True)
class Means:
    """What damages need besides a walk: the joints of both arms, a walk of another style, and a source of chance."""

    arms: list[int]
    stranger: Stretch
    rng: np.random.Generator


# A walk and how much damage (in the damage's unit) to the damaged walk.
Damage = Callable[[Stretch, float, Means], Stretch]


def damaged(
    name: str, reference: Reference, style: str, walks: Sequence[Stretch], much: float, seed: int
) -> list[Stretch]:
    """Walks of a style with so much of a damage; what is left to chance follows from the seed."""
    rng = np.random.default_rng(seed)
    others = [other for other in reference.walks if other != style]
    stranger = max(reference.walks[others[int(rng.integers(len(others)))]], key=len)
    damage, means = DAMAGES[name][0], Means(_arms(reference), stranger, rng)
    return [damage(walk, much, means) for walk in walks]


def smoothing(walk: Stretch, much: float, means: Means) -> Stretch:
    """A Gaussian filter over time, `much` its deviation in frames."""
    return _with(walk, gaussian_filter1d(walk.poses, much, axis=0) if much else walk.poses)


def jitter(walk: Stretch, much: float, means: Means) -> Stretch:
    """Noise on every joint, `much` its deviation in metres, from frame to frame independent."""
    parts = walk.joints
    noise = means.rng.normal(size=parts[:, :, 0].shape) * much
    parts[:, :, 0] += noise
    parts[1:, :, 3] += np.diff(noise, axis=0) * FPS
    return _with(walk, parts)


def stuck_arms(walk: Stretch, much: float, means: Means) -> Stretch:
    """Arms that swing less: their joints come nearer to where they are in the mean by the share `much`."""
    parts = walk.joints
    parts[:, means.arms] += much * (parts[:, means.arms].mean(axis=0) - parts[:, means.arms])
    return _with(walk, parts)


def wrong_style(walk: Stretch, much: float, means: Means) -> Stretch:
    """The last share `much` of the walk replaced by one of another style."""
    kept, order = _kept(walk, much), np.arange(len(walk) - _kept(walk, much)) % len(means.stranger)
    pairs = ((getattr(walk, name), getattr(means.stranger, name)) for name in ("poses", "phase", "contacts"))
    return Stretch(*(np.concatenate([own[:kept], other[order]]) for own, other in pairs))


def tempo(walk: Stretch, much: float, means: Means) -> Stretch:
    """The same movement faster by the share `much`."""
    at = np.arange(0, len(walk) - 1, 1 + much)
    # A spline, since straight lines between frames would have a jerk of their own.
    parts = CubicSpline(np.arange(len(walk)), walk.poses)(at).reshape(len(at), -1, 4, 3)
    parts[:, :, 3] *= 1 + much
    near = at.astype(int)
    return Stretch(parts.reshape(len(at), -1), walk.phase[near], walk.contacts[near])


def looping(walk: Stretch, much: float, means: Means) -> Stretch:
    """The last share `much` of the walk gives way to its first cycle, again and again."""
    turned = np.maximum.accumulate(np.unwrap(walk.phase) - walk.phase[0])
    cycle, kept = max(int(np.searchsorted(turned, 2 * np.pi)), 2), _kept(walk, much)
    order = np.concatenate([np.arange(kept), np.arange(len(walk) - kept) % min(cycle, len(walk))])
    return walk.at(order)


def sliding(walk: Stretch, much: float, means: Means) -> Stretch:
    """The whole character is carried forward by `much` m/s more than its feet walk."""
    parts = walk.joints
    parts[:, :, 3, 2] += much
    return _with(walk, parts)


def sinking(walk: Stretch, much: float, means: Means) -> Stretch:
    """The whole character is `much` metres too low."""
    parts = walk.joints
    parts[:, :, 0, 1] -= much
    return _with(walk, parts)


def _with(walk: Stretch, poses: ndarray) -> Stretch:
    return Stretch(poses.reshape(len(walk), -1), walk.phase, walk.contacts)


def _kept(walk: Stretch, much: float) -> int:
    return round((1 - much) * len(walk))


def _arms(reference: Reference) -> list[int]:
    """Joints of both arms, from the hands upwards."""
    parents, joints = {child: parent for parent, child in reference.body.bones}, []
    for joint in reference.body.layout.effectors[:2]:
        for _ in range(_ARM):
            joints.append(joint)
            joint = parents[joint]
    return joints


# Each damage with its degrees and their unit. The first degree is none.
DAMAGES: dict[str, tuple[Damage, tuple[float, ...], str]] = {
    "smoothing": (smoothing, (0.0, 1.0, 2.0, 4.0, 8.0), "frames"),
    "jitter": (jitter, (0.0, 0.001, 0.002, 0.004, 0.008), "m"),
    "stuck arms": (stuck_arms, (0.0, 0.25, 0.5, 0.75, 1.0), "share"),
    "wrong style": (wrong_style, (0.0, 0.25, 0.5, 0.75, 1.0), "share"),
    "tempo": (tempo, (0.0, 0.1, 0.2, 0.35, 0.5), "share"),
    "looping": (looping, (0.0, 0.25, 0.5, 0.75, 1.0), "share"),
    "sliding": (sliding, (0.0, 0.1, 0.2, 0.4, 0.8), "m/s"),
    "sinking": (sinking, (0.0, 0.01, 0.02, 0.04, 0.08), "m"),
}
