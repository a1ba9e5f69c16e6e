"""Every network of both papers behind one interface: a code for a mixture, a start, and one frame after the other."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol, runtime_checkable

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from stylephase.errors import InputError
from stylephase.features.body import Body
from stylephase.features.layout import FPS
from stylephase.models import holden
from stylephase.models.bundle import Bundle
from stylephase.models.released import load_weights
from stylephase.models.released_pfnn import PFNN_RELEASE, ReleasedPfnn, fetch_pfnn, holden_skeleton, load_pfnn
from stylephase.motion.rest import rest_axes
from stylephase.motion.skeleton import Skeleton
from stylephase.runtime.calibration import warm_start
from stylephase.runtime.controller import Controller, ControllerSettings, Predict, State, input_of, start_state
from stylephase.runtime.finishing import Finisher, Finishing
from stylephase.runtime.pfnn import PfnnState, start_pfnn, step_pfnn
from stylephase.runtime.plans import Plan
from stylephase.runtime.rollout import Rollout, Tick, as_rollout, mixed_code, quiet
from stylephase.runtime.speeds import SpeedCurve, speed_curves
from stylephase.runtime.trajectory import Steering

Codes = Float[Tensor, "characters values"]


@runtime_checkable
class Walker(Protocol):
    """A network that walks, whatever it is: characters with a style code each, driven by what is wanted of them."""

    @property
    def body(self) -> Body:
        """The body that walks."""
        ...

    @property
    def styles(self) -> tuple[str, ...]:
        """The styles that it knows."""
        ...

    def code(self, mixture: Mapping[str, float]) -> Float[Tensor, " values"]:
        """The code of a mixture of styles; raises InputError for an unknown style and weights that are no mixture."""
        ...

    def start(self, codes: Codes, speed: float | None = None) -> State:
        """Characters at the origin that face +z and have begun to walk, as nearly as may be at a speed (m/s).

        Without a speed each walks as its style does where that is known, else at about 1 m/s.
        """
        ...

    def curves(self, styles: Sequence[str], *, grounded: bool) -> dict[str, SpeedCurve]:
        """How fast each style walks at each gain."""
        ...

    def step(self, codes: Codes, state: State, steering: Steering) -> State:
        """The next frame."""
        ...


class NetworkWalker:
    """Any model of models/zoo.py, trained here or released; `fast` takes the network's place (graph.py)."""

    def __init__(self, bundle: Bundle, settings: ControllerSettings | None = None, fast: Predict | None = None):
        self.bundle, self.settings = bundle, settings or ControllerSettings()
        self.body, self.styles, self.layout = bundle.body, bundle.styles, bundle.layout
        self.controller = Controller(bundle, torch.empty(0, 0), self.settings, fast)

    def code(self, mixture: Mapping[str, float]) -> Float[Tensor, " values"]:
        """The weighted sum of the styles' codes."""
        return mixed_code(self.bundle, dict(mixture))

    def start(self, codes: Codes, speed: float | None = None) -> State:
        """The moment of its own walk that is kept with the weights, of a mixture that of the style it is nearest to.

        Where none is kept, and with a speed, some seconds after the mean frame of the data.
        """
        styles = nearest_codes(self.bundle, codes)
        unknown = [k for k, style in enumerate(styles) if speed is not None or style not in self.bundle.starts]
        x, p = (np.zeros((len(codes), width)) for width in (self.layout.inputs, self.layout.gate_inputs))
        if unknown:
            warm = warm_start(self.bundle, codes[unknown], np.full(len(unknown), 1.0 if speed is None else speed))
            x[unknown], p[unknown] = input_of(warm), warm.phases
        for k in set(range(len(codes))) - set(unknown):
            kept = self.bundle.starts[styles[k]]
            x[k], p[k] = kept.x.numpy(), kept.p.numpy()
        return start_state(x, p, self.layout)

    def curves(self, styles: Sequence[str], *, grounded: bool) -> dict[str, SpeedCurve]:
        """Measured, which takes about a second a style."""
        start = self.start(torch.stack([self.bundle.code(style) for style in styles]))
        return speed_curves(self.bundle, styles, start, settings=self.settings, grounded=grounded)

    def step(self, codes: Codes, state: State, steering: Steering) -> State:
        """One frame of the controller."""
        self.controller.codes = codes
        return self.controller.step(state, steering)


def nearest_codes(bundle: Bundle, codes: Codes) -> list[str]:
    """The style whose code is nearest to each of some codes: of a mixture, as a rule, the style of most weight."""
    known = torch.stack([bundle.code(style) for style in bundle.styles])
    return [bundle.styles[k] for k in torch.cdist(codes[None], known[None])[0].argmin(dim=1).tolist()]


@dataclass(frozen=True)
class HoldenState(State):
    """Characters of Holden's network, with all that it needs for the next frame."""

    inner: PfnnState


class HoldenWalker:
    """Holden's released PFNN of 2017; its styles are its gaits, and its speeds are as wished.

    Raises InputError where the skeleton of its takes is not at hand.
    """

    def __init__(self, released: ReleasedPfnn, skeleton: Skeleton | None = None):
        self.released, self.styles = released, holden.GAITS
        skeleton = skeleton or holden_skeleton()
        self.body = Body(skeleton, rest_axes(skeleton, []))

    def code(self, mixture: Mapping[str, float]) -> Float[Tensor, " values"]:
        """How much of each gait, of sum 1."""
        for gait in mixture:
            if gait not in self.styles:
                raise InputError(f"no gait {gait!r} in {PFNN_RELEASE}; there are {', '.join(self.styles)}")
        weights = torch.tensor([mixture.get(gait, 0.0) for gait in self.styles])
        if not torch.isfinite(weights.sum()) or (weights < 0).any() or not weights.sum() > 0:
            raise InputError("style weights should be numbers not below zero, with one above")
        return weights / weights.sum()

    def start(self, codes: Codes, speed: float | None = None) -> State:
        """The mean pose, whatever the speed."""
        return self._seen(start_pfnn(self.released, len(codes)))

    def curves(self, styles: Sequence[str], *, grounded: bool) -> dict[str, SpeedCurve]:
        """Every speed is its own gain."""
        same = np.linspace(0.1, 10.0, 100)
        return {style: SpeedCurve(same, same) for style in styles}

    def step(self, codes: Codes, state: State, steering: Steering) -> State:
        """One frame of Holden's controller, from the state that it made itself."""
        assert isinstance(state, HoldenState)
        inner = replace(state.inner, places=state.path.positions, positions=state.positions)
        return self._seen(step_pfnn(self.released, inner, steering, codes.double().numpy()))

    def _seen(self, inner: PfnnState) -> HoldenState:
        rest = self.body.rest[list(self.body.joints)]
        velocities = inner.velocities @ inner.root.matrices.transpose(0, 2, 1) * FPS
        rotations, phases = inner.rotations @ rest, inner.phase[:, None]
        return HoldenState(inner.path, inner.positions, rotations, velocities, phases, inner.contacts, inner)


def walker_of(
    weights: Bundle | ReleasedPfnn, settings: ControllerSettings | None = None, fast: Predict | None = None
) -> Walker:
    """The walker of any network; settings and `fast` are for those of this library."""
    return HoldenWalker(weights) if isinstance(weights, ReleasedPfnn) else NetworkWalker(weights, settings, fast)


def load_any(weights: str) -> Bundle | ReleasedPfnn:
    """A folder of trained weights, `release` or `pfnn-release`; raises as their readers do."""
    return load_pfnn(fetch_pfnn()) if weights == PFNN_RELEASE else load_weights(weights)


def drive(
    walker: Walker,
    codes: Codes,
    start: State,
    frames: int,
    plan: Plan,
    finishing: Finishing | None = None,
    tick: Tick = quiet,
) -> Rollout:
    """Walk for some frames under a plan; the frames are finished unless it says otherwise (finishing.py).

    What turns infinite stays so, for the caller to judge.
    """
    finisher, state, shown = Finisher(walker.body, finishing), start, []
    for frame in range(frames):
        before, state = state, walker.step(codes, state, plan(frame, state))
        state, seen = finisher(before, state)
        shown.append(seen)
        tick(1)
    return as_rollout(shown)
