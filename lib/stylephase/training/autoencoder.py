"""Training of the motion autoencoder: windows of all styles alike, squared error and small weights."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray
from torch import Tensor

from stylephase.errors import InputError
from stylephase.features.channels import CONTACTS, STEPS, Channels
from stylephase.models.autoencoder import AutoencoderSettings, MotionAutoencoder

# Unbroken stretches of motion by style.
Stretches = Mapping[str, Sequence[Channels]]


@dataclass(frozen=True)
class AutoencoderTraining:
    """`steps` of `windows` windows, each of so many `frames`; the rate falls linearly over the second half.

    `l1` weighs the mean absolute weight, as in the other networks of [M18]; with `mixed` products are in bf16.
    Differs: Holden et al. 2016 train for 25 rounds of a far larger collection; this is half a minute of one processor.
    """

    steps: int = 2000
    windows: int = 8
    frames: int = 120
    rate: float = 1e-3
    l1: float = 0.01
    mixed: bool = True


def scale_of(
    motion: Float[ndarray, "frames channels"],
) -> tuple[Float[ndarray, " channels"], Float[ndarray, " channels"]]:
    """Mean and deviation of each channel, one deviation for all joints together, one for the speed, one for turning.

    So a joint that moves much weighs much. Steps are not centred; contacts are 0 or 1, so half is their middle and
    their spread.
    """
    mean, std = motion.mean(axis=0), np.ones(motion.shape[1])
    joints, ground = slice(0, -(STEPS + CONTACTS)), slice(-(STEPS + CONTACTS), -(1 + CONTACTS))
    turning, contacts = slice(-(1 + CONTACTS), -CONTACTS), slice(-CONTACTS, None)
    mean[-(STEPS + CONTACTS) : -CONTACTS], mean[contacts] = 0.0, 0.5
    std[joints] = motion[:, joints].std()
    std[ground], std[turning], std[contacts] = motion[:, ground].std(), motion[:, turning].std(), 0.5
    return mean, np.where(std < 1e-6, 1.0, std)


def train_autoencoder(
    stretches: Stretches,
    how: AutoencoderTraining,
    settings: AutoencoderSettings | None = None,
    *,
    seed: int = 0,
    tick: Callable[[int], object] = lambda steps: None,
) -> tuple[MotionAutoencoder, list[float]]:
    """A trained autoencoder in eval mode, and the squared error (normalised, with dropout) of every step.

    Raises InputError where no stretch lasts a window, and where the training diverges.
    """
    known = [[part.table for part in some if len(part) >= how.frames] for some in stretches.values()]
    known = [some for some in known if some]
    if not known:
        raise InputError(f"no stretch of motion lasts {how.frames} frames")
    mean, std = (torch.from_numpy(v).float() for v in scale_of(np.concatenate([t for some in known for t in some])))
    rng, errors = np.random.default_rng(seed), []
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        network = MotionAutoencoder(mean, std, settings or AutoencoderSettings()).train()
        optimiser = torch.optim.Adam(network.parameters(), lr=how.rate, fused=True)
        for step in range(how.steps):
            optimiser.param_groups[0]["lr"] = how.rate * min(1.0, 2 * (1 - step / how.steps))
            motion = _windows(known, how, rng)
            with torch.autocast("cpu", dtype=torch.bfloat16, enabled=how.mixed):
                found = network(motion)
            error = (network.normalised(found.float()) - network.normalised(motion)).square().mean()
            optimiser.zero_grad(set_to_none=True)
            (error + how.l1 * network.filters.abs().mean()).backward()
            optimiser.step()
            errors.append(error.item())
            if not math.isfinite(errors[-1]):
                raise InputError(f"the autoencoder diverged at step {step}")
            tick(1)
    return network.eval(), errors


def _windows(
    known: list[list[ndarray]], how: AutoencoderTraining, rng: np.random.Generator
) -> Float[Tensor, "windows channels frames"]:
    """Windows of styles drawn alike; a style's stretches by how many windows they hold."""
    drawn = []
    for style in rng.integers(len(known), size=how.windows):
        starts = np.array([len(table) - how.frames + 1 for table in known[style]])
        table = known[style][int(rng.choice(len(starts), p=starts / starts.sum()))]
        start = int(rng.integers(len(table) - how.frames + 1))
        drawn.append(table[start : start + how.frames].T)
    return torch.from_numpy(np.stack(drawn)).float()
