"""Blends of the authors' released codes, among them the pair of [M22] Fig. 8, walked by the authors' own network."""

from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray
from torch import Tensor

from stylephase.evaluation.interpolation import (
    SHARES,
    Blend,
    Pair,
    blended_codes,
    blends_of,
    clearance,
    space_of_walks,
)
from stylephase.evaluation.release_walks import GAIN
from stylephase.evaluation.rollouts import SETTLE
from stylephase.features.layout import FPS
from stylephase.models.bundle import Bundle
from stylephase.models.released import UNUSABLE
from stylephase.runtime.controller import RELEASE, start_state
from stylephase.runtime.plans import Steady
from stylephase.runtime.rollout import Rollout, roll_out

# The pair of Fig. 8, and one whose hands have to get past the trunk.
FIG_8, PAST_THE_TRUNK = ("BentForward", "LeanBack"), ("ArmsFolded", "ArmsBehindBack")
_PURE_SECONDS, _BLEND_SECONDS = 13.0, 10.0


@dataclass(frozen=True)
class ReleaseBlends:
    """Pairs of styles, each pair's blend (None where a walk broke off), and the walks, eleven characters a pair."""

    pairs: list[Pair]
    blends: list[Blend | None]
    run: Rollout

    def characters(self, pair: Pair) -> range:
        """The characters of one pair, from the first style to the second."""
        first = self.pairs.index(pair) * len(SHARES)
        return range(first, first + len(SHARES))


def release_blends(bundle: Bundle, others: int = 20, *, seed: int = 0) -> ReleaseBlends:
    """The two pairs above and some that are drawn, in a style space of the pure walks of a third of all styles.

    The release's data are not at hand: the space tells how even a blend is, not how good its styles are.
    """
    names = [style for style in bundle.styles if style not in UNUSABLE]
    rng = np.random.default_rng(seed)
    drawn = [rng.choice(len(names), 2, replace=False) for _ in range(others)]
    pairs: list[Pair] = [FIG_8, PAST_THE_TRUNK, *((names[a], names[b]) for a, b in drawn)]
    known = names[::3]
    space = space_of_walks(_walk(bundle, torch.stack([bundle.code(name) for name in known]), _PURE_SECONDS), known)
    run = _walk(bundle, blended_codes(bundle, pairs), _BLEND_SECONDS)
    return ReleaseBlends(pairs, blends_of([run], bundle.body, space), run)


def hand_to_trunk(bundle: Bundle, found: ReleaseBlends, pair: Pair = PAST_THE_TRUNK) -> Float[ndarray, " shares"]:
    """Least distance (m) of a hand from the line of the trunk in each of a pair's walks."""
    return clearance(found.run, bundle.body)[SETTLE:, list(found.characters(pair))].min(axis=0)


def _walk(bundle: Bundle, codes: Float[Tensor, "characters values"], seconds: float) -> Rollout:
    """Straight walks from the mean pose, as the demonstration asks for them."""
    x = np.tile(bundle.normaliser.x_mean, (len(codes), 1))
    start = start_state(x, np.zeros((len(codes), bundle.layout.gate_inputs)), bundle.layout)
    return roll_out(bundle, codes, start, int(seconds * FPS), Steady(np.full(len(codes), GAIN)), RELEASE)
