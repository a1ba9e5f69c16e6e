"""What a stored vector would miss of what an adapter adds: whether adapters have to be kept whole ([M22] 5.2.1)."""

from collections.abc import Callable

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray
from torch import Tensor, nn

from stylephase.errors import InputError
from stylephase.features.layout import FPS
from stylephase.models.bundle import Bundle
from stylephase.models.modulators import Adapters
from stylephase.runtime.calibration import warm_start
from stylephase.runtime.pace import at_pace
from stylephase.runtime.plans import Steady
from stylephase.runtime.rollout import roll_out


def missed_by_a_stored_vector(
    bundle: Bundle, *, seconds: float = 4.0, speed: float = 1.0, settle: float = 1.0
) -> Float[ndarray, " styles"]:
    """For each style the share of what its adapter adds that its own mean over a walk leaves out, 0 to 1.

    All styles walk straight on at a speed (m/s), all adapters run at every frame; the first `settle` seconds do not
    count. The share is of the squared values, over frames and units: 0 where the same is added in every frame, so that
    a vector could be stored in the adapter's place, 1 where the mean says nothing. Raises InputError for weights
    without adapters.
    """
    modulator = bundle.network.synthesis.modulator
    if not isinstance(modulator, Adapters):
        raise InputError(f"{bundle.model} has no adapters")
    added: list[list[ndarray]] = [[] for _ in modulator.adapters]
    hooks = [
        adapter.register_forward_hook(_keeping(kept)) for adapter, kept in zip(modulator.adapters, added, strict=True)
    ]
    try:
        codes, wanted = torch.stack([bundle.code(style) for style in bundle.styles]), np.full(len(bundle.styles), speed)
        start = warm_start(bundle, codes, wanted)
        for kept in added:
            kept.clear()
        roll_out(bundle, codes, start, int(seconds * FPS), at_pace(Steady(wanted), wanted))
    finally:
        for hook in hooks:
            hook.remove()
    return np.array([left_out(np.concatenate(kept[int(settle * FPS) :])) for kept in added])


def _keeping(kept: list[ndarray]) -> Callable[..., None]:
    """A hook that keeps what a module gives."""

    def keep(_module: nn.Module, _inputs: tuple[Tensor, ...], found: Tensor) -> None:
        kept.append(found.numpy().copy())

    return keep


def left_out(values: Float[ndarray, "frames units"]) -> float:
    """Share of the squares of values that lies about their mean over frames."""
    return float(np.square(values - values.mean(axis=0)).sum() / np.square(values).sum())
