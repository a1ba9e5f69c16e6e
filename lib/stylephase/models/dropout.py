"""Dropout that is cheap on a processor: one random byte decides for one unit."""

import torch
from jaxtyping import Float
from torch import Tensor


def dropout(h: Float[Tensor, "*shape"], rate: float, training: bool) -> Float[Tensor, "*shape"]:
    """Inverted dropout with the rate rounded to 1/256; the identity outside training.

    Own code because torch's draws a float per unit, which costs as much as the layer it guards on a processor.
    """
    threshold = round(rate * 256)
    if not training or threshold == 0:
        return h
    keep = torch.randint(0, 256, h.shape, dtype=torch.uint8, device=h.device) >= threshold
    return h * keep * (256 / (256 - threshold))
