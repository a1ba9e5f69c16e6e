"""Steering by keys: from the keys that are held and what was wanted a frame ago to what is wanted now.

W, S, A and D move ahead, back, left and right of the wanted facing, Q and E turn it left and right, Shift doubles the
speed ([M22] release 5.2).
"""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.runtime.plans import OnPath, heading
from stylephase.runtime.trajectory import Steering, unit_ground

# Ahead and left of the wanted facing.
_MOVES = {"w": (1, 0), "s": (-1, 0), "a": (0, 1), "d": (0, -1)}
_TURNS = {"q": 1, "e": -1}
RUN = "shift"
KEYS = frozenset({*_MOVES, *_TURNS, RUN})


@dataclass(frozen=True)
class KeySettings:
    """How keys become wishes.

    Each frame the wish moves by the share `blend` towards what the keys say; a key that turns asks for a facing
    `turn` (rad) off the character's own, and Shift multiplies the speed by `run`. With `coasts` the wish stays as it
    is when all keys are let go, else its speed falls to zero. With `follows_root` the facing wanted while no key turns
    is the character's own, else the last one wanted.
    """

    blend: float = 0.25
    turn: float = float(np.radians(60))
    run: float = 2.0
    coasts: bool = False
    follows_root: bool = False


# In the release a character walks on when the keys are let go, and its own sway may turn it off its way.
RELEASE_KEYS = KeySettings(coasts=True, follows_root=True)


def at_rest(state: OnPath) -> Steering:
    """The wish of characters that nobody has steered yet: stand and face as they do."""
    return Steering(np.zeros_like(state.path.root.positions), state.path.root.angles.copy())


def steer_by_keys(
    held: Collection[str],
    last: Steering,
    state: OnPath,
    speeds: Float[ndarray, " characters"],
    settings: KeySettings | None = None,
) -> Steering:
    """What is wanted of all characters alike, each at its own speed (m/s, times a gain).

    `held` are names of `KEYS` in any case; other keys mean nothing, and opposite ones cancel.
    """
    how, keys = settings or KeySettings(), {key.lower() for key in held} & KEYS
    turning = sum(sign for key, sign in _TURNS.items() if key in keys)
    facing = _facing(turning, last, state, how, any_key=bool(keys))
    if not keys and how.coasts:
        return last
    ahead, left = (sum(_MOVES[key][axis] for key in keys & _MOVES.keys()) for axis in (0, 1))
    forward, side = heading(facing), heading(facing + np.pi / 2)
    way = unit_ground(ahead * forward + left * side, np.zeros_like(forward))
    wanted = way * speeds[:, None] * (how.run if RUN in keys else 1.0)
    return Steering(last.velocity + how.blend * (wanted - last.velocity), facing)


def _facing(
    turning: int, last: Steering, state: OnPath, how: KeySettings, *, any_key: bool
) -> Float[ndarray, " characters"]:
    """The facing wanted: a share of the way from the last one to the one that the keys ask for, the short way round."""
    if not turning and not (how.follows_root and any_key):
        return last.facing
    wanted = state.path.root.angles + turning * how.turn
    off = np.arctan2(np.sin(wanted - last.facing), np.cos(wanted - last.facing))
    return last.facing + how.blend * off
