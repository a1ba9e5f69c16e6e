"""What may be asked of a character: odd wishes are made ordinary ones, and a character may be put elsewhere whole."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.runtime.controller import State
from stylephase.runtime.plans import OnPath, Plan
from stylephase.runtime.trajectory import Steering, Trajectory, on_ground

# No person runs faster (m/s); a wish, which is a speed times a gain, may be so much.
FASTEST, MOST_WISH = 10.0, 25.0
# Nobody walks so far in a frame (m): that is a jump to another place.
JUMP = 1.0


def limited(steering: Steering, state: OnPath) -> Steering:
    """The same wishes where they are ordinary ones.

    A velocity that is no number counts as none, one above `MOST_WISH` keeps its direction and has that length; a
    facing that is no number is the character's own.
    """
    velocity = np.where(np.isfinite(steering.velocity).all(axis=-1, keepdims=True), steering.velocity, 0.0)
    # Squares of huge numbers are infinite, so the length is told in units of the largest part.
    largest = np.maximum(np.abs(velocity).max(axis=-1, keepdims=True), 1.0)
    share = velocity / largest
    length = np.linalg.norm(share, axis=-1, keepdims=True)
    velocity = np.where(length > MOST_WISH / largest, share * (MOST_WISH / np.maximum(length, 1e-9)), velocity)
    facing = np.where(np.isfinite(steering.facing), steering.facing, state.path.root.angles)
    return Steering(velocity, facing)


def within_limits(plan: Plan) -> Plan:
    """A plan that only ever wants what is ordinary."""
    return lambda frame, state: limited(plan(frame, state), state)


def teleported(state: State, places: Float[ndarray, "characters 2"], facings: Float[ndarray, " characters"]) -> State:
    """The characters at other places (x, z) and facings (rad), each with its path, pose and velocities as they were.

    Nothing that the network sees changes, since it sees all from the root: a jump is no movement.
    """
    root = state.path.root
    turned = on_ground(facings - root.angles)
    world = np.tile(np.eye(3), (len(turned), 1, 1))
    world[:, ::2, ::2] = turned
    old, new = (np.insert(p, 1, 0.0, axis=1)[:, None] for p in (root.positions, places))
    ahead = np.einsum("nij,npj->npi", turned, state.path.positions - root.positions[:, None]) + places[:, None]
    path = Trajectory(ahead, np.einsum("nij,npj->npi", turned, state.path.directions))
    return replace(
        state,
        path=path,
        positions=np.einsum("nij,npj->npi", world, state.positions - old) + new,
        rotations=world[:, None] @ state.rotations,
        velocities=np.einsum("nij,npj->npi", world, state.velocities),
    )
