"""Whether characters side by side are recognised by their style, and, dealt each other's codes, are not."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray
from torch import Tensor

from stylephase.evaluation.robustness import Endurance, endure, random_paths
from stylephase.evaluation.rollouts import SETTLE, local_poses, start_of
from stylephase.evaluation.style import StyleSpace, space_of, statistics
from stylephase.features.layout import FPS
from stylephase.features.store import StyleVectors
from stylephase.models.bundle import Bundle
from stylephase.models.released import BROKEN
from stylephase.runtime.controller import RELEASE, ControllerSettings, State
from stylephase.runtime.graph import FastNetwork, to_onnx
from stylephase.runtime.paths import FollowPaths
from stylephase.runtime.rollout import Rollout, roll_out
from stylephase.runtime.speeds import speed_curves
from stylephase.runtime.walkers import NetworkWalker
from stylephase.training.codes import clip_codes
from stylephase.training.sampler import Scaling

# Clips (frames) by which a crowd is told apart where there are no data.
_CLIP = int(1.5 * FPS)
_CROWD_SECONDS, _RECOGNISED_SECONDS = 8.0, 20.0
# Most are this share of the characters.
MOST = 0.8
# Where styles are dealt anew, at most this share is nearest to its own.
_FEW = 0.1
# Gain of the release's documented set-up ([M22] release 5.2).
_RELEASE_GAIN = 6.0


@dataclass(frozen=True)
class Recognised:
    """Of `count` characters, who are nearest to walks of their own style; `dealt` with each other's codes."""

    right: int
    dealt: int
    count: int

    @property
    def most(self) -> bool:
        """Whether most are, and few with each other's codes."""
        return self.right >= MOST * self.count and self.dealt <= _FEW * self.count


def recognised(
    bundle: Bundle,
    codes: Float[Tensor, "styles values"],
    start: State,
    gains: Float[ndarray, " styles"],
    space: StyleSpace,
) -> Recognised:
    """All styles on random ways of their own, each held against recorded walks of all styles."""
    run, anew = (crowd(bundle, given, start, gains, _RECOGNISED_SECONDS) for given in (codes, dealt_anew(codes)))
    return _recognised(run, anew, bundle.styles, space, set(bundle.styles))


def _recognised(run: Rollout, anew: Rollout, styles: Sequence[str], space: StyleSpace, counted: set[str]) -> Recognised:
    """Who is nearest to their own style in a walk, and in one with each other's codes; only some styles count."""
    right, dealt = (
        sum(a == b for a, b in zip(nearest_styles(each, space), styles, strict=True) if b in counted)
        for each in (run, anew)
    )
    return Recognised(right, dealt, len(counted))


@dataclass(frozen=True)
class Crowd(Recognised):
    """A crowd held against other walks of its own, and how it walks."""

    run: Rollout


def crowd_of(
    bundle: Bundle,
    start: State,
    *,
    gains: Float[ndarray, " characters"],
    how: ControllerSettings | None = None,
    uncounted: Sequence[str] = (),
) -> Crowd:
    """All styles side by side, each on random ways of its own; two other walks of each say what its style is like.

    Styles that are `uncounted` are shown, and count neither as recognised nor as not.
    """
    codes, counted = torch.stack([bundle.code(style) for style in bundle.styles]), set(bundle.styles) - set(uncounted)
    walked = partial(crowd, bundle, start=start, gains=gains, seconds=_CROWD_SECONDS, settings=how)
    space = crowd_space([walked(codes, seed=seed) for seed in (1, 2)], bundle.styles)
    run, anew = (walked(given, seed=0) for given in (codes, dealt_anew(codes)))
    seen = _recognised(run, anew, bundle.styles, space, counted)
    return Crowd(seen.right, seen.dealt, seen.count, run)


def released_crowd(bundle: Bundle) -> Crowd:
    """The same of the authors' weights, at their gain and settings; whose code is broken does not count."""
    codes = torch.stack([bundle.code(style) for style in bundle.styles])
    gains = np.full(len(codes), _RELEASE_GAIN)
    return crowd_of(bundle, NetworkWalker(bundle).start(codes), gains=gains, how=RELEASE, uncounted=BROKEN)


@dataclass(frozen=True)
class FromOneClip:
    """What became of each style from one clip of it, who was recognised, and whose network it was."""

    endured: Sequence[Endurance]
    recognised: Recognised
    weights: str


def endure_from_one_clip(
    bundle: Bundle,
    styles: Sequence[StyleVectors],
    speeds: Float[ndarray, " styles"],
    seconds: float,
    space: StyleSpace,
) -> FromOneClip:
    """Random input for some seconds, in each style with the code of one training clip, at the speeds of the data."""
    codes, start = one_clip_codes(bundle, styles), start_of(styles, bundle.body)
    curves = [curve for curve in speed_curves(bundle, bundle.styles, start, grounded=True).values()]
    gains = np.array([curve.gain(speed) for curve, speed in zip(curves, speeds, strict=True)])
    fast = FastNetwork(to_onnx(bundle))
    found = endure(bundle, bundle.styles, codes, start, gains, seconds, curves=curves, fast=fast)
    weights = f"{bundle.model}, preset {bundle.about.get('preset')}, {bundle.about.get('steps')} steps"
    return FromOneClip(found, recognised(bundle, codes, start, gains, space), weights)


def one_clip_codes(bundle: Bundle, styles: Sequence[StyleVectors]) -> Float[Tensor, "styles values"]:
    """The code of one training clip of each style, by weights that make codes."""
    generator = bundle.network.generator
    assert generator is not None and bundle.makes_codes
    scaling = Scaling(bundle.normaliser, bundle.body.layout)
    return torch.cat([clip_codes(generator, style, scaling, most=1) for style in styles])


def crowd(
    bundle: Bundle,
    codes: Float[Tensor, "characters values"],
    start: State,
    gains: Float[ndarray, " characters"],
    seconds: float,
    *,
    settings: ControllerSettings | None = None,
    seed: int = 0,
) -> Rollout:
    """Characters that each follow a random path of their own, side by side, raw, so that styles are the network's."""
    follow = FollowPaths(random_paths(len(codes), seconds, np.random.default_rng(seed)), gains)
    return roll_out(bundle, codes, start, int(seconds * FPS), follow, settings)


def nearest_styles(run: Rollout, space: StyleSpace, settle: int = SETTLE) -> list[str]:
    """The nearest style to each character's walk, among all of the space; empty for one that did not stay finite."""
    walks = [local_poses(run, k)[settle:] if run.finite[k] else None for k in range(len(run.finite))]
    return ["" if walk is None else space.nearest(walk) for walk in walks]


def crowd_space(runs: Sequence[Rollout], styles: Sequence[str], settle: int = SETTLE) -> StyleSpace:
    """The space of the styles of a crowd by its own walks, one character a style in each run, where no data are.

    Clips of a second and a half tell what varies within a style. A style that stays finite in no run has no place.
    """
    groups: dict[str, list[ndarray]] = {style: [] for style in styles}
    for run in runs:
        for k in np.flatnonzero(run.finite):
            poses = local_poses(run, int(k))[settle:]
            cuts = range(0, len(poses) - _CLIP + 1, _CLIP)
            groups[styles[int(k)]] += [statistics(poses[at : at + _CLIP]) for at in cuts]
    return space_of({style: np.array(group) for style, group in groups.items()})


def dealt_anew(codes: Float[Tensor, "characters values"]) -> Float[Tensor, "characters values"]:
    """Each character with the code of the next: the null of a crowd."""
    return torch.roll(codes, 1, dims=0)
