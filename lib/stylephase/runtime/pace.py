"""Speeds in metres per second: wishes are made larger while a character is too slow, smaller while it is too fast.

Walking and running are two ways of going on, and some styles keep the one that they are in whatever is wished: who runs
goes on running when a walk, or nothing, is wished for; who stood shuffles on; and some go backwards when little is
wished for. Such a character is pulled back until it walks, or pushed until it goes ahead, the more the longer it stays.
Some walk beside the way that they face: their wishes are turned until they go the way that is wanted.
"""

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.features.layout import FPS
from stylephase.runtime.limits import JUMP
from stylephase.runtime.plans import OnPath, Plan
from stylephase.runtime.trajectory import Steering, on_ground, unit_ground

# The speed is told from the way of the last second, so that a step counts whole. A wish is changed by what is missing
# within about `_SECONDS`, and between the factors `_LEAST` and `_MOST` in all.
_WINDOW, _SECONDS, _LEAST, _MOST = int(FPS), 2.0, 0.6, 3.0
# After a new wish a character is left to itself for so long (s). A wish below this speed (m/s) is to stand.
_PATIENCE, _STANDS = 2.0, 0.05
# A wish that changes by less than this share is the same wish.
_SAME = 0.02
# Who is faster than this share of the wanted speed, and than this (m/s) unless it should stand, is pulled back by so
# many times what is too much, and who goes the wrong way is pushed; that is told from half a second. Who should stand
# is led back by so much a metre (1/s).
_TOO_FAST, _NO_WALK, _PULL, _PUSH, _SHORT, _HOME = 1.3, 1.3, 1.5, 1.5, int(FPS / 2), 2.0
# Who after that patience goes at less or more than these shares of the wanted speed is stuck: it is wished what is
# missing, or so many times what is too much, and that again for each second that it has been stuck, up to a bound
# (m/s). That wears off so many times as fast.
_SLOW, _FAST, _MISSING, _MUCH, _WEARS_OFF, _LOOSENS = 0.8, 1.1, 1.0, 1.5, 4.0, 3.0
# A way that turns by less than this (rad) is the same way. Who goes beside it is turned back within about so many
# seconds, by at most `_VEER` (rad), once it goes at this share of the wanted speed; each frame of another way leaves so
# much of it.
_SAME_WAY, _STRAIGHTENS, _VEER, _WALKS, _FORGETS = 0.05, 2.0, 0.6, 0.3, 0.9


class Pace:
    """Leads some characters to the speeds and ways that are wanted of them, from where they have been.

    Without `straightens` only to the speeds.
    """

    def __init__(self, characters: int, *, straightens: bool = True):
        self.straightens = straightens
        self.factors, self.wanted, self.waited = np.ones(characters), np.zeros(characters), np.zeros(characters)
        self.stuck = np.zeros(characters)
        self.stood, self.home = np.zeros(characters, dtype=bool), np.zeros((characters, 2))
        self.way, self.straight, self.veer = np.zeros((characters, 2)), np.zeros(characters), np.zeros(characters)
        self.track: Float[ndarray, "frames characters 2"] = np.full((0, characters, 2), np.nan)

    # Who has left the finite numbers is not led.
    @np.errstate(invalid="ignore", over="ignore")
    def lead(self, wish: Steering, wanted: Float[ndarray, " characters"], state: OnPath) -> Steering:
        """The wish for the next frame, whose velocities are a gain, such that speeds (m/s) are reached; once a frame.

        Who has jumped to another place begins anew.
        """
        self._see(state.path.root.positions)
        wanted = np.where(np.linalg.norm(wish.velocity, axis=1) > _STANDS, wanted, 0.0)
        self._learn(wish, wanted)
        moved = self._moved(_SHORT)
        fast = np.linalg.norm(moved, axis=1)
        much = np.maximum(fast - np.maximum(_TOO_FAST * wanted, np.where(wanted > 0, _NO_WALK, 0.0)), 0.0)
        back = _PULL * much[:, None] * unit_ground(moved, np.zeros_like(moved))
        # Who goes the wrong way is pushed.
        way = unit_ground(wish.velocity, np.zeros_like(moved))
        wrong = np.where(wanted > 0, np.maximum(-(moved * way).sum(axis=1), 0.0), 0.0)
        loosened = self._loosened(way, wanted)[:, None] * way
        led = np.nan_to_num(_PUSH * wrong[:, None] * way - back + loosened + self._home(wanted), posinf=0.0, neginf=0.0)
        velocity = self._straightened(wish.velocity, wanted) if self.straightens else wish.velocity
        return Steering(velocity * self.factors[:, None] + led, wish.facing)

    def _straightened(
        self, velocity: Float[ndarray, "characters 2"], wanted: Float[ndarray, " characters"]
    ) -> Float[ndarray, "characters 2"]:
        """Wishes turned by what characters have gone beside a way that has stayed the same."""
        way, moved = unit_ground(velocity, np.zeros_like(velocity)), self._moved(_WINDOW)
        turned = (way * self.way).sum(axis=1) < np.cos(_SAME_WAY)
        self.way = np.where(turned[:, None], way, self.way)
        self.straight = np.where(turned, 0.0, self.straight + 1 / FPS)
        ahead, aside = (moved * way).sum(axis=1), moved[:, 0] * way[:, 1] - moved[:, 1] * way[:, 0]
        walks = (self.straight > _PATIENCE) & (wanted > _STANDS) & (ahead > _WALKS * wanted)
        off = np.where(walks, np.arctan2(aside, ahead), 0.0)
        back = np.where(turned, self.veer * _FORGETS, self.veer - off / (FPS * _STRAIGHTENS))
        self.veer = np.clip(back, -_VEER, _VEER)
        return np.einsum("nij,nj->ni", on_ground(self.veer), velocity)

    def _home(self, wanted: Float[ndarray, " characters"]) -> Float[ndarray, "characters 2"]:
        """What leads those who should stand back to where they came to a stop."""
        standing = wanted == 0
        self.home = np.where((standing & self.stood)[:, None], self.home, self.track[-1])
        self.stood = standing
        return _HOME * (self.home - self.track[-1])

    def _loosened(
        self, way: Float[ndarray, "characters 2"], wanted: Float[ndarray, " characters"]
    ) -> Float[ndarray, " characters"]:
        """What is wished more (m/s) along the way of those who are stuck in another speed."""
        ahead = (self._moved(_WINDOW) * way).sum(axis=1)
        late = (self.waited > _PATIENCE) & (wanted > _STANDS) & (len(self.track) > _WINDOW)
        slow, fast = late & (ahead < _SLOW * wanted), late & (ahead > _FAST * wanted)
        self.stuck = np.where(slow | fast, self.stuck + 1 / FPS, np.maximum(self.stuck - _WEARS_OFF / FPS, 0.0))
        share = np.where(slow, _MISSING, np.where(fast, _MUCH, 0.0)) * (1 + self.stuck)
        return np.clip(share * (wanted - ahead), -_LOOSENS, _LOOSENS)

    def _see(self, places: Float[ndarray, "characters 2"]) -> None:
        if len(self.track):
            jumped = ~(np.linalg.norm(places - self.track[-1], axis=1) < JUMP)
            self.factors, self.waited = np.where(jumped, 1.0, self.factors), np.where(jumped, 0.0, self.waited)
            self.stuck, self.veer = np.where(jumped, 0.0, self.stuck), np.where(jumped, 0.0, self.veer)
            self.straight = np.where(jumped, 0.0, self.straight)
            self.track, self.stood = np.where(jumped[:, None], places, self.track), self.stood & ~jumped
        self.track = np.concatenate([self.track[-_WINDOW:], places[None]])

    def _moved(self, frames: int) -> Float[ndarray, "characters 2"]:
        """Mean velocity (m/s) over the last frames, as far as they are known."""
        frames = min(frames, len(self.track) - 1)
        return (self.track[-1] - self.track[-1 - frames]) * FPS / max(frames, 1)

    def _learn(self, wish: Steering, wanted: Float[ndarray, " characters"]) -> None:
        fresh = np.abs(wanted - self.wanted) > _SAME * np.maximum(wanted, self.wanted)
        self.waited = np.where(fresh, 0.0, self.waited + 1 / FPS)
        self.wanted = np.where(fresh, wanted, self.wanted)
        moved, way = self._moved(_WINDOW), unit_ground(wish.velocity, np.zeros_like(wish.velocity))
        speeds, ahead = np.linalg.norm(moved, axis=1), (moved * way).sum(axis=1)
        missing = np.log(np.maximum(wanted, _STANDS) / np.maximum(speeds, _STANDS))
        # Who goes the wrong way is pushed, and nothing is learned from it.
        led = (self.waited > _PATIENCE) & (wanted > _STANDS) & (ahead > -_STANDS) & (len(self.track) > _WINDOW)
        missing = np.where(led & np.isfinite(missing), np.clip(missing, -1, 1), 0.0)
        self.factors = np.clip(self.factors * np.exp(missing / (FPS * _SECONDS)), _LEAST, _MOST)


def at_pace(plan: Plan, wanted: Float[ndarray, " characters"], *, straightens: bool = True) -> Plan:
    """The same plan with characters led to speeds (m/s), and to its ways, while it wants them to go anywhere."""
    pace = Pace(len(wanted), straightens=straightens)
    return lambda frame, state: pace.lead(plan(frame, state), wanted, state)
