"""The phase function: four control points, blended by a cyclic cubic Catmull-Rom spline ([M18] 3.1, Eq. 1).

A layer whose weights are that blend is an `ExpertLayer` of four experts whose gate is not learned but this spline.
"""

import math

import torch
from jaxtyping import Float
from torch import Tensor, nn

POINTS = 4


def catmull_rom(phase: Float[Tensor, "*rows"]) -> Float[Tensor, "*rows 4"]:
    """Coefficients of the four control points at a phase in rad ([M18] Eq. 1a to 1c); they add to 1.

    Point j (from 0) has the whole weight at phase j pi/2. The phase may be any number: the spline is cyclic.
    """
    quarters = phase * (POINTS / (2 * math.pi))
    passed = torch.floor(quarters)
    d = quarters - passed
    d2, d3 = d * d, d * d * d
    # Of the points k_0 to k_3 around the phase, which lies between k_1 and k_2.
    around = [d2 - d / 2 - d3 / 2, 1 - 2.5 * d2 + 1.5 * d3, d / 2 + 2 * d2 - 1.5 * d3, d3 / 2 - d2 / 2]
    points = torch.arange(POINTS, device=phase.device)
    return torch.stack(around, dim=-1).gather(-1, (points - passed.long()[..., None] + 1) % POINTS)


class SplineGate(nn.Module):
    """A gate without parameters: from the global phase (rad) to the coefficients of the control points."""

    def forward(self, phase: Float[Tensor, "rows 1"]) -> Float[Tensor, "rows 4"]:
        """Blending coefficients, which add to one; some are below zero."""
        return catmull_rom(phase[:, 0])
