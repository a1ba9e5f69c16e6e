"""How each foot is used: a hop is told from a walk without asking the phases ([M22] 5.1.1, Fig. 6)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stylephase.evaluation.stretches import Stretch
from stylephase.features.layout import FPS, Layout
from stylephase.phase.global_phase import touchdowns

# Height is that of the lowest tenth of the frames: where a foot stands, if it stands at all.
_LOW = 10


@dataclass(frozen=True)
class FootUse:
    """Of the right and the left foot.

    `contact` is the share of the time in contact, `rate` the touchdowns a second, `low` (m) the height of the toe where
    it is low.
    """

    contact: tuple[float, float]
    rate: tuple[float, float]
    low: tuple[float, float]

    @property
    def raised(self) -> float:
        """How much higher (m) the right toe is held than the left one, negative where the left one is."""
        return self.low[0] - self.low[1]


def foot_use(stretches: Sequence[Stretch], layout: Layout) -> FootUse:
    """Measure the use of both feet over some stretches of motion."""
    poses, contacts = (np.concatenate([getattr(one, part) for one in stretches]) for part in ("poses", "contacts"))
    toes = poses.reshape(len(poses), -1, 12)[:, list(layout.effectors[3:1:-1]), 1]
    low = np.percentile(toes, _LOW, axis=0)
    downs = [len(touchdowns(contacts[:, foot], FPS)) * FPS / len(contacts) for foot in range(2)]
    share = contacts.mean(axis=0)
    return FootUse((float(share[0]), float(share[1])), (downs[0], downs[1]), (float(low[0]), float(low[1])))
