"""What a frame of one character costs, and how far weights of fewer bits move its joints."""

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from torch import Tensor

from stylephase.evaluation.bench.rows import interleaved, threads
from stylephase.evaluation.rollouts import local_poses
from stylephase.features.body import Body
from stylephase.models.bundle import Bundle
from stylephase.runtime.controller import Controller, ControllerSettings, Predict, State, input_of
from stylephase.runtime.finishing import Finisher, Finishing
from stylephase.runtime.plans import Steady
from stylephase.runtime.rollout import Rollout, as_rollout
from stylephase.runtime.walkers import NetworkWalker


def frame_costs(
    bundle: Bundle,
    code: Float[Tensor, " values"],
    state: State,
    fast: Mapping[str, Predict],
    *,
    rounds: int = 10,
    each: int = 10,
) -> dict[str, float]:
    """Milliseconds of one character's frame on one thread: the controller, what finishing adds, and fast networks."""
    plain, finisher = Controller(bundle, code[None], ControllerSettings()), Finisher(bundle.body, Finishing())
    wish = Steady(np.ones(1))(0, state)
    after = plain.step(state, wish)
    rivals = {"frame": lambda: plain.step(state, wish), "finishing": lambda: finisher(state, after)}
    x, p = input_of(state), state.phases
    rivals |= {"network": lambda: plain.predict(x, p)}
    rivals |= {name: lambda f=f: f(x, p, code[None].numpy()) for name, f in fast.items()}
    with threads(1):
        found = interleaved(rivals, rounds=rounds, each=each)
    return {name: 1000 * seconds for name, seconds in found.items()}


def one_frame(
    bundle: Bundle,
    codes: Float[Tensor, "characters values"],
    start: State,
    gains: Float[ndarray, " characters"],
    *,
    fast: Predict | None = None,
) -> Rollout:
    """A single raw frame after the start, twice, since poses are seen with their velocities."""
    walker = NetworkWalker(bundle, fast=fast)
    after = walker.step(codes, start, Steady(gains)(0, start))
    return as_rollout([start, after])


def difference(run: Rollout, other: Rollout, body: Body) -> float:
    """Mean distance (mm) between the joints of two rollouts as seen from their roots, over all characters.

    Two walks fall out of step in time, so rollouts of a frame or a second are told apart by it.
    """
    size = len(body.joints)
    apart = [
        (local_poses(run, k) - local_poses(other, k)).reshape(-1, size, 12)[..., :3]
        for k in range(run.positions.shape[1])
    ]
    return float(1000 * np.linalg.norm(np.stack(apart), axis=-1).mean())
