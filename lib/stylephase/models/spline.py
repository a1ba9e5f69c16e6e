"""The phase function of a PFNN: how much each of four control points counts at a phase ([M18] 3.1, Eq. 1)."""

import torch
from jaxtyping import Float
from torch import Tensor

CONTROL_POINTS = 4


def catmull_rom(phase: Float[Tensor, " rows"]) -> Float[Tensor, "rows 4"]:
    """Coefficients of the control points at phases (rad): a cyclic cubic Catmull-Rom spline ([M18] Eq. 1).

    Weights at phase p are the sum of the control points times their coefficients. Control point k is met exactly at
    k quarters of the cycle. The coefficients of a phase sum to 1, and any phase will do: it wraps.
    """
    quarters = phase * (CONTROL_POINTS / (2 * torch.pi))
    start = torch.floor(quarters)
    d = (quarters - start)[:, None]
    before = d * (-0.5 + d * (1.0 - 0.5 * d))
    here = 1.0 + d * d * (-2.5 + 1.5 * d)
    after = d * (0.5 + d * (2.0 - 1.5 * d))
    beyond = d * d * (-0.5 + 0.5 * d)
    points = (start.long()[:, None] + torch.arange(-1, 3, device=phase.device)) % CONTROL_POINTS
    shares = torch.cat([before, here, after, beyond], dim=1)
    return torch.zeros_like(shares).scatter(1, points, shares)
