"""What a step of training changes: the weights that all styles share, and whose adapters ([M18] Fig. 5)."""

import numpy as np
import torch
from jaxtyping import Bool
from numpy import ndarray

from stylephase.training.loop import Trainer
from stylephase.training.losses import shared_weights, style_weights


def changed_by_step(trainer: Trainer, steps: int) -> Bool[ndarray, "steps parts"]:
    """For each of some rounds of a training, what changed: the shared weights, then the adapter of each style."""
    network = trainer.network.synthesis
    parts = [shared_weights(network), *(style_weights(network, style) for style in range(len(trainer.styles)))]
    changed = np.zeros((steps, len(parts)), dtype=bool)
    for step in range(steps):
        before = [[weight.detach().clone() for weight in part] for part in parts]
        trainer.round()
        for k, (part, old) in enumerate(zip(parts, before, strict=True)):
            changed[step, k] = any(not torch.equal(weight, was) for weight, was in zip(part, old, strict=True))
    return changed
