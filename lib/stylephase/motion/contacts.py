"""Foot contacts by speed and height ([M22] 4.1.2)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from stylephase.motion.clip import velocities

# The floor of a take is where its lowest sensor comes to rest: this percentile of its heights.
_FLOOR_PERCENTILE = 3.0
# Votes of the majority filter on each side, in seconds: 5 frames of 60 ([M22] release; not in the paper).
_VOTE_SECONDS = 5 / 60


@dataclass(frozen=True)
class ContactRule:
    """A foot is in contact while its sensor is slower than `speed` (m/s) and less than `height` (m) above the floor.

    The defaults are the paper's ([M22] 4.1.2).
    """

    speed: float = 0.15
    height: float = 0.01


def foot_contacts(
    sensors: Float[ndarray, "frames feet 3"], fps: float, rule: ContactRule
) -> Bool[ndarray, "frames feet"]:
    """Contacts of foot sensors given in the world (m), in the same order.

    Differs: [M22] measures height from y = 0; here from the take's own floor, since sensors rest at another height
    on every skeleton. And a sensor must be slow on the way to its frame and on the way from it, so that a contact
    begins and ends alike; the release looks only back, and ends each contact late.
    """
    towards = np.linalg.norm(velocities(sensors, fps), axis=-1)
    speed = np.maximum(towards, np.concatenate([towards[1:], towards[-1:]]))
    return slow_and_low(speed, sensors[..., 1], fps, rule)


def slow_and_low(
    speeds: Float[ndarray, "frames feet"], heights: Float[ndarray, "frames feet"], fps: float, rule: ContactRule
) -> Bool[ndarray, "frames feet"]:
    """Contacts of feet with these speeds (m/s) and heights (m), against the take's own floor, after the vote."""
    floor = np.percentile(heights.min(axis=1), _FLOOR_PERCENTILE)
    return majority((speeds < rule.speed) & (heights < floor + rule.height), round(_VOTE_SECONDS * fps))


def majority(raw: Bool[ndarray, "frames feet"], reach: int) -> Bool[ndarray, "frames feet"]:
    """Majority vote over `reach` frames on either side, fewer at the ends; a tie keeps the raw value."""
    padded = np.concatenate([np.zeros((1, raw.shape[1])), np.cumsum(raw, axis=0)])
    frames = np.arange(len(raw))
    start, stop = np.maximum(frames - reach, 0), np.minimum(frames + reach + 1, len(raw))
    votes, size = padded[stop] - padded[start], (stop - start)[:, None]
    return np.where(2 * votes == size, raw, 2 * votes > size)
