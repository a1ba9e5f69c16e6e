"""Feature-wise linear modulation of normalised hidden units ([M22] 4.2, Eq. 3)."""

import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn import functional


def film(
    h: Float[Tensor, "rows units"], scale: Float[Tensor, "rows units"], shift: Float[Tensor, "rows units"]
) -> Float[Tensor, "rows units"]:
    """Layer normalisation without weights of its own, then scale and shift, then ELU ([M22] Eq. 3).

    The scale is plain, not 1 + scale, and the deviation is the population's, as in the release's run time.
    The paper prints the features where the scale is meant.
    """
    normal = functional.layer_norm(h, h.shape[-1:], eps=1e-8)
    return functional.elu(torch.addcmul(shift, scale, normal))


def split_code(code: Float[Tensor, "rows values"]) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """Scale and shift of the first and of the second hidden layer ([M22] Eq. 2), in the release's order."""
    scale1, shift1, scale2, shift2 = torch.chunk(code, 4, dim=-1)
    return scale1, shift1, scale2, shift2


def film_in_training(
    h: Float[Tensor, "rows units"], scale: Float[Tensor, "rows units"], shift: Float[Tensor, "rows units"]
) -> Float[Tensor, "rows units"]:
    """The same with the deviation that the release trained with: the sample's, plus 1e-6 ([M22] release 2)."""
    deviation, mean = torch.std_mean(h, dim=-1, keepdim=True)
    return functional.elu(shift + scale * (h - mean) / (deviation + 1e-6))
