"""New styles by fine-tuning: the FiLM generator learns them while everything else stays as it is ([M22] 5.3.2)."""

import copy
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch

from stylephase.errors import InputError
from stylephase.features.store import StyleVectors, for_gate
from stylephase.models.bundle import Bundle
from stylephase.models.generator import FilmGenerator
from stylephase.models.synthesis import StyledNetwork
from stylephase.training.codes import stored_codes
from stylephase.training.losses import BoneLengths, bone_length_loss, bone_lengths, squared_error
from stylephase.training.sampler import Sampler, Scaling


@dataclass(frozen=True)
class FineTuning:
    """How a new style is learned.

    Each of `steps` shows the generator `clips` clips of the new style and the frozen network `frames` frames for each
    of their codes. Loss and optimiser are those of the training ([M22] 4.3, Eq. 5), the `rate` is the generator's in
    the preset `cpu`; it rises over `warm_up` steps and falls linearly over the second half. `bone_weight` and `mixed`
    are as in a preset.

    Differs: the paper does not say how long it fine-tunes, nor at which rate; this is a minute of one processor for a
    network of the paper's size.
    """

    steps: int = 120
    clips: int = 4
    frames: int = 64
    rate: float = 3e-4
    warm_up: int = 10
    bone_weight: float = 3.0
    mixed: bool = True


@dataclass(frozen=True)
class FineTuned:
    """Weights with codes for the new styles, and (squared error, bone length error in metres) of every step."""

    bundle: Bundle
    errors: list[tuple[float, float]]


def with_new_codes(bundle: Bundle, styles: Sequence[StyleVectors]) -> Bundle:
    """The same weights with a code for each new style, as the generator gives it without having learned the style.

    Raises InputError where the weights have no generator, or know one of the styles already.
    """
    _generator(bundle)
    if known := [style.style for style in styles if style.style in bundle.codes]:
        raise InputError(f"these weights know the style {known[0]!r} already; choose another name")
    made = stored_codes(bundle.network, _seen(bundle, styles), Scaling(bundle.normaliser, bundle.layout))
    return replace(bundle, codes=bundle.codes | made)


def fine_tune(
    bundle: Bundle,
    styles: Sequence[StyleVectors],
    how: FineTuning = FineTuning(),
    *,
    seed: int = 0,
    tick: Callable[[int], object] = lambda steps: None,
) -> FineTuned:
    """Learn one new style, or some together, from their training frames; the weights given are left as they are.

    Only the generator changes, and codes of earlier styles are kept as stored. Raises InputError where the weights
    have no generator or know one of the styles, and where the training diverges.
    """
    before = with_new_codes(bundle, styles)
    network, seen = copy.deepcopy(before.network), _seen(bundle, styles)
    network.synthesis.requires_grad_(False)
    scaling = Scaling(bundle.normaliser, bundle.layout)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        sampler = Sampler(seen, scaling, np.random.default_rng(seed))
        errors = _learn(network, sampler, bone_lengths(bundle.body), how, tick)
    network.synthesis.requires_grad_(True)
    codes = bundle.codes | stored_codes(network.eval(), seen, scaling)
    return FineTuned(replace(before, network=network, codes=codes), errors)


def _learn(
    network: StyledNetwork, sampler: Sampler, lengths: BoneLengths, how: FineTuning, tick: Callable[[int], object]
) -> list[tuple[float, float]]:
    """Train the generator with the rest frozen; dropout is on, so that the code is of use."""
    generator, scaling, errors = network.generator, sampler.scaling, []
    assert generator is not None
    network.train()
    optimiser = torch.optim.Adam(generator.parameters(), lr=how.rate, fused=True)
    for step in range(how.steps):
        optimiser.param_groups[0]["lr"] = how.rate * _factor(step, how)
        chosen = sampler.rng.choice(len(sampler.styles), size=how.clips, replace=how.clips > len(sampler.styles))
        batch = sampler.draw_frames(chosen, how.frames)
        with torch.autocast("cpu", dtype=torch.bfloat16, enabled=how.mixed):
            codes = generator(sampler.draw_clips(chosen)).repeat_interleave(how.frames, dim=0)
            predicted = network.synthesis(batch.x, batch.p, codes)
        mse, bll = squared_error(batch.y, predicted), bone_length_loss(batch.y, predicted, lengths, scaling)
        optimiser.zero_grad(set_to_none=True)
        (mse + how.bone_weight * bll).backward()
        optimiser.step()
        errors.append((mse.item(), bll.item()))
        if not all(map(math.isfinite, errors[-1])):
            raise InputError(f"fine-tuning diverged at step {step}: its numbers are no longer finite")
        tick(1)
    return errors


def _factor(step: int, how: FineTuning) -> float:
    """Factor of the rate: warm-up, a plateau, then a linear fall over the second half."""
    return min(1.0, (step + 1) / max(how.warm_up, 1), 2 * (1 - step / how.steps))


def _seen(bundle: Bundle, styles: Sequence[StyleVectors]) -> list[StyleVectors]:
    """The styles' vectors as the network's gate sees them."""
    return [for_gate(style, bundle.layout) for style in styles]


def _generator(bundle: Bundle) -> FilmGenerator:
    """The weights' generator; raises InputError where there is none."""
    generator = bundle.network.generator
    if generator is None:
        raise InputError(f"{bundle.model} has no style network to fine-tune; only FiLM models learn a style so")
    if generator.code.weight.is_meta:
        raise InputError("these weights come without their style network, which is what is fine-tuned")
    return generator
