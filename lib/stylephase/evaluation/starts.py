"""Starts to keep with weights: a moment of each style's walk that the network itself walked to.

A walk that begins at the mean frame of the data may keep to a shuffle or a run. With data at hand it begins at a frame
of them; after some seconds all that the network sees is its own work, and that can be kept and passed on with the
weights, where frames of the data may not.
"""

from collections.abc import Sequence

import numpy as np
import torch

from stylephase.evaluation.rollouts import codes_of, start_of, walking_speed
from stylephase.features.layout import FPS
from stylephase.features.store import StyleVectors, VectorStore, for_gate
from stylephase.models.bundle import Bundle, Start
from stylephase.runtime.calibration import speed_of
from stylephase.runtime.controller import State, input_of, start_state
from stylephase.runtime.finishing import Finisher, Finishing
from stylephase.runtime.pace import Pace, at_pace
from stylephase.runtime.plans import Steady
from stylephase.runtime.rollout import Tick, quiet
from stylephase.runtime.speeds import speed_curves
from stylephase.runtime.walkers import NetworkWalker, drive

# Moments of the walk that may be kept (s): more than the second of the past that the network sees. From each the style
# must walk on for so long (s), and the one counts from which it comes nearest to its speed.
_MOMENTS, _ONWARDS = (4.0, 6.0, 8.0), 8.0


def walked_starts(bundle: Bundle, styles: Sequence[StyleVectors], tick: Tick = quiet) -> dict[str, Start]:
    """The start of each style, from the vectors of the data that the weights were trained on.

    A style that does not stay finite gets none.
    """
    styles = [for_gate(style, bundle.layout) for style in styles]
    names, codes, first = [s.style for s in styles], codes_of(bundle, styles), start_of(styles, bundle.body)
    wanted = np.array([walking_speed(style) for style in styles])
    curves = speed_curves(bundle, names, first, grounded=True, tick=tick)
    gains = np.array([curves[name].gain(speed) for name, speed in zip(names, wanted, strict=True)])
    kept = [_again(state, bundle) for state in _moments(bundle, codes, first, gains, wanted, tick)]
    off = [_off(bundle, codes, state, gains, wanted, tick) for state in kept]
    best = np.argmin(off, axis=0)
    return {
        name: Start(*(torch.from_numpy(part[k]).float() for part in (input_of(kept[b]), kept[b].phases)))
        for k, (name, b) in enumerate(zip(names, best, strict=True))
        if np.isfinite(off[b][k])
    }


def starts_from(bundle: Bundle, store: VectorStore, tick: Tick = quiet) -> dict[str, Start]:
    """The same for those styles of the weights of which the store has data."""
    return walked_starts(bundle, [store.load(style) for style in store.catalogue.styles], tick)


def _again(state: State, bundle: Bundle) -> State:
    """The same characters at the origin, facing +z."""
    return start_state(input_of(state), state.phases, bundle.layout)


def _moments(
    bundle: Bundle, codes: torch.Tensor, state: State, gains: np.ndarray, wanted: np.ndarray, tick: Tick
) -> list[State]:
    """The characters at each of the moments of a walk that is led to the wanted speeds, as a user's is."""
    walker, finisher, plan = NetworkWalker(bundle), Finisher(bundle.body, Finishing()), Steady(gains)
    pace, found = Pace(len(gains)), []
    for frame in range(int(_MOMENTS[-1] * FPS)):
        wish = pace.lead(plan(frame, state), wanted, state)
        state, _ = finisher(state, walker.step(codes, state, wish))
        if (frame + 1) / FPS in _MOMENTS:
            found.append(state)
        tick(1)
    return found


def _off(
    bundle: Bundle, codes: torch.Tensor, start: State, gains: np.ndarray, wanted: np.ndarray, tick: Tick
) -> np.ndarray:
    """How far each is off its speed, as a share of it, over the last half of walking on; infinite where not finite."""
    frames = int(_ONWARDS * FPS)
    run = drive(NetworkWalker(bundle), codes, start, frames, at_pace(Steady(gains), wanted), tick=tick)
    speeds = np.array([speed_of(run.root_positions[frames // 2 :, k]) for k in range(len(gains))])
    return np.where(run.finite & np.isfinite(speeds), np.abs(speeds / wanted - 1), np.inf)
