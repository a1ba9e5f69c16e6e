"""Style modulators: how the style of each row changes the synthesis network ([M22] 5, [M18] 6).

All are called alike, once for each hidden layer (0 and 1): with the layer's output `f` before its activation, its
input `h`, the gate and the style `code`; they give the layer's output after the activation. `values` is the width of
a code. Where a code holds weights over styles, one row per style of the training is a one-hot vector, and weights
between make mixtures.
"""

from collections.abc import Callable

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional

from stylephase.models.dropout import dropout
from stylephase.models.experts import ExpertLayer
from stylephase.models.film import film, split_code


class Modulator(nn.Module):
    """No modulation: the activation alone. The code has no values."""

    def __init__(self, values: int = 0):
        super().__init__()
        self.values = values

    def forward(
        self,
        layer: int,
        f: Float[Tensor, "rows units"],
        h: Float[Tensor, "rows inputs"],
        gate: Float[Tensor, "rows experts"],
        code: Float[Tensor, "rows values"],
    ) -> Float[Tensor, "rows units"]:
        """Hidden units of layer 0 or 1."""
        return functional.elu(f)


class Film(Modulator):
    """Layer normalisation, then a scale and a shift for each unit of both hidden layers ([M22] Eq. 2, 3).

    The code is (scale 1, shift 1, scale 2, shift 2), made by a FiLM generator; there are no parameters here.
    """

    def __init__(self, units: int):
        super().__init__(4 * units)

    def forward(self, layer: int, f: Tensor, h: Tensor, gate: Tensor, code: Tensor) -> Float[Tensor, "rows units"]:
        """Hidden units of layer 0 or 1."""
        return film(f, *split_code(code)[2 * layer : 2 * layer + 2])


class OneHot(Modulator):
    """More columns of the first layer: one for each style, in every expert ([M22] Table 2: styles x units x experts).

    The code is what those columns multiply: weights over styles.
    """

    def __init__(self, styles: int, experts: int, units: int):
        super().__init__(styles)
        self.columns = ExpertLayer(experts, styles, units, biased=False)

    def forward(self, layer: int, f: Tensor, h: Tensor, gate: Tensor, code: Tensor) -> Float[Tensor, "rows units"]:
        """Hidden units of layer 0 or 1."""
        return functional.elu(f + self.columns(code, gate) if layer == 0 else f)


class Adapters(Modulator):
    """A residual adapter for each style beside the second layer, W_res h + b_res ([M18] Eq. 2, 4).

    `make` makes one: an `ExpertLayer`, `DiagonalLayer` or `CpLayer`, whose control points the gate blends. Without
    `phased` the adapter is one `ExpertLayer` of a single expert, whatever the gate says ([M22] 5.2.2). `rate` is the
    dropout in front of the adapters ([M18] 7.2). The code holds weights over styles; all zero is the average motion.
    """

    def __init__(self, styles: int, make: Callable[[], nn.Module], *, phased: bool = True, rate: float = 0.0):
        super().__init__(styles)
        self.adapters = nn.ModuleList(make() for _ in range(styles))
        self.phased, self.rate = phased, rate

    def forward(self, layer: int, f: Tensor, h: Tensor, gate: Tensor, code: Tensor) -> Float[Tensor, "rows units"]:
        """Hidden units of layer 0 or 1."""
        return functional.elu(f + self.residual(h, gate, code) if layer == 1 else f)

    def residual(self, h: Tensor, gate: Tensor, code: Tensor) -> Float[Tensor, "rows units"]:
        """What the adapters add: each runs only over the rows that it has a weight in."""
        h, gate = dropout(h, self.rate, self.training), gate if self.phased else torch.ones_like(gate[:, :1])
        added = torch.zeros_like(h)
        for style in code.any(dim=0).nonzero()[:, 0].tolist():
            rows = code[:, style].nonzero()[:, 0]
            change = self.adapters[style](h[rows], gate[rows])
            added = added.index_add(0, rows, code[rows, style, None] * change)
        return added
