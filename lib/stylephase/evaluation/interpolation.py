"""Interpolation between styles: how far a blend has come, how evenly it gets there, and what that costs.

([M22] 4.4, 5.1.2, Fig. 8.) Codes are blended, characters walk, and the statistics of each walk are projected on the
line between the walks of the two pure styles.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray
from torch import Tensor

from stylephase.evaluation.motion import foot_skate
from stylephase.evaluation.rollouts import SETTLE, local_poses, start_of
from stylephase.evaluation.style import StyleSpace, space_of, statistics
from stylephase.features.body import Body
from stylephase.features.layout import CLIP_FRAMES, CLIP_STRIDE, FPS
from stylephase.features.store import StyleVectors
from stylephase.models.bundle import Bundle
from stylephase.runtime.controller import State
from stylephase.runtime.plans import Steady
from stylephase.runtime.rollout import Rollout, roll_out

# The share of the second style goes from 0 to 1 in tenths.
SHARES = np.linspace(0.0, 1.0, 11)
_CONTACT = 0.5
_DRAWS = 2000

Pair = tuple[str, str]


@dataclass(frozen=True)
class Blend:
    """One blend: for each share of the second style, how far `along` the walk has come from the first (0) to it (1).

    `aside` is the walk's distance from the line between the pure ones, over their distance `apart` (in deviations
    within a style); `skate` the feet's slide (m/s).
    """

    shares: Float[ndarray, " shares"]
    along: Float[ndarray, " shares"]
    aside: Float[ndarray, " shares"]
    skate: Float[ndarray, " shares"]
    apart: float

    @property
    def off_line(self) -> float:
        """Root mean square of how far `along` is from the share: 0 if linear, 0.3 for a switch half-way."""
        return float(np.sqrt(np.mean(np.square(self.along - self.shares))))

    @property
    def largest_step(self) -> float:
        """The largest change between neighbouring shares: 0.1 if even in tenths, 1 for a switch."""
        return float(np.abs(np.diff(self.along)).max())

    @property
    def even(self) -> bool:
        """Whether it passes evenly: no step of more than two tenths, and hardly ever back."""
        return self.largest_step <= 0.2 and self.monotonicity >= 0.95

    @property
    def monotonicity(self) -> float:
        """What is gained in all over the way that is made: 1 if it never turns back."""
        way = np.abs(np.diff(self.along)).sum()
        return float((self.along[-1] - self.along[0]) / way) if way > 0 else 0.0

    @property
    def halfway(self) -> float:
        """The share at which half the way is first made: 0.5 if linear, near 1 where the first style is kept."""
        k = int(np.argmax(self.along >= 0.5))
        if self.along[k] < 0.5:
            return 1.0
        if k == 0:
            return 0.0
        before, after = self.along[k - 1 : k + 1]
        return float(np.interp(0.5, [before, after], self.shares[k - 1 : k + 1]))

    def reversed(self) -> "Blend":
        """The same from the second style to the first."""
        turned = {"along": 1 - self.along[::-1], "aside": self.aside[::-1], "skate": self.skate[::-1]}
        return replace(self, shares=1 - self.shares[::-1], **turned)

    @property
    def more_skate(self) -> float:
        """Mean slide (m/s) of what lies between, beyond that of the pure styles mixed by their shares."""
        mixed = (1 - self.shares) * self.skate[0] + self.shares * self.skate[-1]
        return float((self.skate - mixed)[1:-1].mean())


def blend_of(
    places: Float[ndarray, "shares directions"], skate: Float[ndarray, " shares"], shares: Float[ndarray, " shares"]
) -> Blend:
    """The blend whose walks lie at some places of the style space, the pure styles first and last."""
    way = places[-1] - places[0]
    apart = float(np.linalg.norm(way))
    along = (places - places[0]) @ way / apart**2
    aside = np.linalg.norm(places - places[0] - along[:, None] * way, axis=1) / apart
    return Blend(shares, along, aside, skate, apart)


def blended_codes(
    bundle: Bundle, pairs: Sequence[Pair], shares: Float[ndarray, " shares"] = SHARES
) -> Float[Tensor, "characters values"]:
    """Codes on the straight line from the first to the second style of each pair, pair after pair ([M22] 4.4)."""
    share = torch.from_numpy(shares).float()[:, None]
    return torch.cat([(1 - share) * bundle.code(first) + share * bundle.code(last) for first, last in pairs])


def blended_gains(
    gains: Mapping[str, float], pairs: Sequence[Pair], shares: Float[ndarray, " shares"] = SHARES
) -> Float[ndarray, " characters"]:
    """The steering's gains (m/s), mixed as the codes are."""
    return np.concatenate([(1 - shares) * gains[first] + shares * gains[last] for first, last in pairs])


def starts(
    styles: Mapping[str, StyleVectors], pairs: Sequence[Pair], body: Body, *, last: bool, count: int = len(SHARES)
) -> State:
    """Each pair's characters in a pose of the first style's data, or of the last one's."""
    return start_of([styles[pair[last]] for pair in pairs], body).repeated(count)


def walked_blends(
    bundle: Bundle,
    gains: Mapping[str, float],
    styles: Mapping[str, StyleVectors],
    pairs: Sequence[Pair],
    *,
    seconds: float = 10.0,
) -> list[Rollout]:
    """Walks straight on along the blend of each pair, begun in a pose of the first style's data, then of the last's."""
    codes, plan = blended_codes(bundle, pairs), Steady(blended_gains(gains, pairs))
    begun = [starts(styles, pairs, bundle.body, last=last) for last in (False, True)]
    return [roll_out(bundle, codes, start, int(seconds * FPS), plan) for start in begun]


def blends_of(
    runs: Sequence[Rollout],
    body: Body,
    space: StyleSpace,
    *,
    shares: Float[ndarray, " shares"] = SHARES,
    settle: int = SETTLE,
) -> list[Blend | None]:
    """The blend of each pair, its walks' places averaged over some runs that began otherwise; None if one broke off."""
    found = [walks_of(run, body, space, settle) for run in runs]
    places, skates = (np.mean(part, axis=0) for part in zip(*found, strict=True))
    blends = []
    for start in range(0, len(places), len(shares)):
        part = slice(start, start + len(shares))
        finite = np.isfinite(places[part]).all()
        blends.append(blend_of(places[part], skates[part], shares) if finite else None)
    return blends


def walks_of(
    run: Rollout, body: Body, space: StyleSpace, settle: int = SETTLE
) -> tuple[Float[ndarray, "characters directions"], Float[ndarray, " characters"]]:
    """Place in the style space and slide of the feet (m/s) of each character; NaN where it did not stay finite."""
    toes = [body.joints.index(toe) for toe in body.skeleton.roles.toes[::-1]]
    places, skates = np.full((len(run.finite), space.centres.shape[1]), np.nan), np.full(len(run.finite), np.nan)
    for k in np.flatnonzero(run.finite).tolist():
        places[k] = space.place(local_poses(run, k)[settle:])
        skates[k] = foot_skate(run.positions[settle:, k][:, toes], run.contacts[settle:, k] > _CONTACT)
    return places, skates


def space_of_walks(run: Rollout, names: Sequence[str], settle: int = SETTLE) -> StyleSpace:
    """A style space of generated walks, for weights whose data are not at hand; windows as long as a style clip."""
    groups = {}
    for k, name in enumerate(names):
        poses = local_poses(run, k)[settle:]
        windows = [poses[at : at + CLIP_FRAMES] for at in range(0, len(poses) - CLIP_FRAMES + 1, CLIP_STRIDE)]
        groups[name] = np.array([statistics(window) for window in windows])
    return space_of(groups)


def disagreement(one: Sequence[Blend], other: Sequence[Blend]) -> float:
    """Mean difference of `along` between blends of the same pairs that began otherwise: does the start decide?"""
    return float(np.mean([np.abs(a.along - b.along).mean() for a, b in zip(one, other, strict=True)]))


def triangle(steps: int = 4) -> Float[ndarray, "points 3"]:
    """Shares of three styles at the points of a triangular grid ([M22] 4.4)."""
    return np.array([(a, b, steps - a - b) for a in range(steps + 1) for b in range(steps + 1 - a)]) / steps


def barycentric(
    places: Float[ndarray, "points directions"], corners: Float[ndarray, "3 directions"]
) -> Float[ndarray, "points 3"]:
    """Shares of three corners, which sum to one, of the point in their plane that is nearest to each place."""
    edges = corners[:2] - corners[2]
    first = np.linalg.lstsq(edges.T, (places - corners[2]).T, rcond=None)[0].T
    return np.concatenate([first, 1 - first.sum(axis=1, keepdims=True)], axis=1)


def mean_over_pairs(
    values: Float[ndarray, " pairs"], pairs: Sequence[Pair], *, seed: int = 0
) -> tuple[float, float, float]:
    """Mean of a value over pairs of styles, and 95 % of what other styles would have given.

    Styles are drawn anew, not pairs, since pairs share styles: a pair counts as often as both of its styles are drawn.
    """
    names = sorted({style for pair in pairs for style in pair})
    first, last = (np.array([names.index(pair[end]) for pair in pairs]) for end in (0, 1))
    rng = np.random.default_rng(seed)
    counts = rng.multinomial(len(names), np.full(len(names), 1 / len(names)), size=_DRAWS)
    weights = counts[:, first] * counts[:, last]
    weights = weights[weights.sum(axis=1) > 0]
    means = weights @ values / weights.sum(axis=1)
    low, high = np.percentile(means, (2.5, 97.5))
    return float(np.mean(values)), float(low), float(high)


def clearance(run: Rollout, body: Body) -> Float[ndarray, "frames characters"]:
    """Least distance (m) of a hand from the line of the trunk, hips to chest; less than half a body's depth cuts in."""
    skeleton = body.skeleton
    chains = [skeleton.chain(hand) for hand in skeleton.roles.hands]
    chest = [joint for joint in chains[0] if joint in chains[1]][-1]
    hips, top, *hands = (body.joints.index(j) for j in (skeleton.roles.hips, chest, *skeleton.roles.hands))
    foot, axis = run.positions[:, :, hips], run.positions[:, :, top] - run.positions[:, :, hips]
    return np.min([_off_segment(run.positions[:, :, hand] - foot, axis) for hand in hands], axis=0)


def _off_segment(points: Float[ndarray, "*batch 3"], axis: Float[ndarray, "*batch 3"]) -> Float[ndarray, "*batch"]:
    """Distance of points from the segment that begins at the origin."""
    share = np.clip((points * axis).sum(axis=-1) / np.square(axis).sum(axis=-1), 0, 1)
    return np.linalg.norm(points - share[..., None] * axis, axis=-1)
