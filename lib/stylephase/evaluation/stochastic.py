"""Movement that does not come back with the cycle: what a phase still explains of it ([M22] 6)."""

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from stylephase.evaluation.phases import explained
from stylephase.features.layout import FPS
from stylephase.motion.clip import forward_kinematics
from stylephase.motion.contacts import ContactRule
from stylephase.motion.synthetic import WalkStyle, walk
from stylephase.phase.local import PhaseVariant
from stylephase.phase.source import Movement, principal_source, sourcing
from stylephase.phase.take import movement_of, movement_phases

# Random movement is as slow as a swing of the arms: noise smoothed over so many frames.
_SMOOTH = 9.0
_HANDS = (0, 1)


def with_random_hands(movement: Movement, share: float, rng: np.random.Generator) -> Movement:
    """The movement with this share of the hands' variance replaced by smooth noise that has no beat."""
    hands = movement.places[:, _HANDS]
    middle, noise = hands.mean(axis=0), rng.normal(size=hands.shape)
    noise = gaussian_filter1d(noise, _SMOOTH, axis=0)
    noise *= hands.std(axis=0) / noise.std(axis=0)
    places = movement.places.copy()
    places[:, _HANDS] = middle + np.sqrt(1 - share) * (hands - middle) + np.sqrt(share) * noise
    return replace(movement, places=places)


def explained_of_hands(
    style: WalkStyle, rule: ContactRule, how: PhaseVariant, *, share: float = 0.0, seed: int = 0, seconds: float = 12.0
) -> float:
    """Share of the walker's hand movement that a sinusoid of the hands' own phases explains, mean of both hands."""
    clip, truth = walk(style, "FW", seconds=seconds, seed=seed)
    movement = movement_of(forward_kinematics(clip), clip.skeleton, FPS, rule)
    movement = with_random_hands(movement, share, np.random.default_rng(seed))
    take, inside = movement_phases(movement, sourcing([movement]), how), slice(truth.cut[0] + 30, truth.cut[1] - 30)
    sources = [principal_source(movement.places[inside, k], take.sourcing.directions[k]) for k in _HANDS]
    return float(np.mean([explained(s, take.local.phase[inside, k]) for k, s in zip(_HANDS, sources, strict=True)]))
