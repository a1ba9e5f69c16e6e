"""Speeds in metres per second: the gain is turned up while a character is too slow, and down while it is too fast."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.features.layout import FPS
from stylephase.runtime.plans import OnPath, Plan
from stylephase.runtime.trajectory import Steering

# The speed is told from the way of the last second, so that a step counts whole. The gain follows what is missing
# within about `_SECONDS`, and is changed by no more than the factor `_MOST` in all.
_WINDOW, _SECONDS, _MOST = int(FPS), 2.0, 4.0
# After a new wish a character is left to itself for so long (s). A wish below this speed (m/s) is to stand.
_PATIENCE, _STANDS = 2.0, 0.05
# A wish that changes by less than this share is the same wish.
_SAME = 0.02
# Nobody walks so far in a frame (m): that is a jump to another place.
_JUMP = 1.0


class Pace:
    """Factors on the gains of some characters, from the speeds that are wanted of them and where they have been."""

    def __init__(self, characters: int):
        self.factors, self.wanted, self.waited = np.ones(characters), np.zeros(characters), np.zeros(characters)
        self.track: Float[ndarray, "frames characters 2"] = np.full((0, characters, 2), np.nan)

    def __call__(self, wanted: Float[ndarray, " characters"], state: OnPath) -> Float[ndarray, " characters"]:
        """The factors for the next frame, when speeds (m/s) are wanted; called once a frame.

        Who has jumped to another place begins anew.
        """
        places = state.path.root.positions
        if len(self.track):
            self._begin_anew(~(np.linalg.norm(places - self.track[-1], axis=1) < _JUMP), places)
        self.track = np.concatenate([self.track[-_WINDOW:], places[None]])
        fresh = np.abs(wanted - self.wanted) > _SAME * np.maximum(wanted, self.wanted)
        self.waited = np.where(fresh, 0.0, self.waited + 1 / FPS)
        self.wanted = np.where(fresh, wanted, self.wanted)
        led = (self.waited > _PATIENCE) & (wanted > _STANDS) & (len(self.track) > _WINDOW)
        speeds = np.linalg.norm(places - self.track[0], axis=1) * FPS / max(len(self.track) - 1, 1)
        missing = np.log(np.maximum(wanted, _STANDS) / np.maximum(speeds, _STANDS))
        led &= np.isfinite(missing)
        moved = self.factors * np.exp(np.where(led, np.clip(missing, -1, 1), 0.0) / (FPS * _SECONDS))
        self.factors = np.clip(moved, 1 / _MOST, _MOST)
        return self.factors

    def _begin_anew(self, who: ndarray, places: Float[ndarray, "characters 2"]) -> None:
        self.factors, self.waited = np.where(who, 1.0, self.factors), np.where(who, 0.0, self.waited)
        self.track = np.where(who[:, None], places, self.track)


def at_pace(plan: Plan, wanted: Float[ndarray, " characters"]) -> Plan:
    """The same plan with characters led to speeds (m/s); where it wants one to stand, that one is left alone."""
    pace = Pace(len(wanted))

    def paced(frame: int, state: OnPath) -> Steering:
        wish = plan(frame, state)
        moving = np.linalg.norm(wish.velocity, axis=1) > 0
        return Steering(wish.velocity * pace(wanted * moving, state)[:, None], wish.facing)

    return paced
