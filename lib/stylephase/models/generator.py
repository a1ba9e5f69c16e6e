"""The FiLM generator: from a clip of stylised motion to a style code ([M22] 4.2, 4.3)."""

from dataclasses import dataclass

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional

from stylephase.models.dropout import dropout


@dataclass(frozen=True)
class GeneratorSettings:
    """Sizes of the FiLM generator; defaults are the paper's ([M22] 4.3).

    `leak` is the slope of the rectifiers below zero (0 in the release), `normalise` puts a layer normalisation before
    the dense layers, `clamp` bounds the normalised input: with plain rectifiers every filter may die within minutes.
    """

    frames: int = 240
    filters: int = 256
    kernel: int = 25
    hidden: int = 2048
    rate: float = 0.3
    leak: float = 0.0
    normalise: bool = False
    clamp: float = float("inf")


class _Convolve(torch.autograd.Function):
    """Convolution along time as one matrix product, forward and backward; zeros stand past a clip's ends.

    Autograd's own way back through the windows scatters value by value and takes longer than all the rest.
    """

    @staticmethod
    def forward(ctx, clips: Tensor, weight: Tensor, kernel: int) -> Tensor:
        spread = _windows(clips, kernel, (kernel - 1) // 2)
        ctx.save_for_backward(spread, weight)
        ctx.kernel, ctx.inputs = kernel, clips.shape[2]
        return spread @ weight

    @staticmethod
    def backward(ctx, gradient: Tensor) -> tuple[Tensor | None, Tensor, None]:
        spread, weight = ctx.saved_tensors
        of_weight = spread.flatten(0, 1).t() @ gradient.flatten(0, 1)
        if not ctx.needs_input_grad[0]:
            return None, of_weight, None
        turned = weight.view(ctx.kernel, ctx.inputs, -1).flip(0).transpose(1, 2).reshape(-1, ctx.inputs)
        return _windows(gradient, ctx.kernel, ctx.kernel // 2) @ turned, of_weight, None


def _windows(clips: Tensor, kernel: int, before: int) -> Tensor:
    """For every frame the `kernel` frames around it, side by side: (clips, frames, kernel * inputs)."""
    padded = functional.pad(clips, (0, 0, before, kernel - 1 - before))
    return padded.unfold(1, kernel, 1).transpose(2, 3).flatten(2)


class TemporalConvolution(nn.Module):
    """A convolution along time that keeps the length. `weight` is (kernel * inputs, filters)."""

    def __init__(self, inputs: int, filters: int, kernel: int):
        super().__init__()
        self.kernel = kernel
        self.weight = nn.Parameter(torch.empty(kernel * inputs, filters))
        self.bias = nn.Parameter(torch.zeros(filters))
        bound = (6.0 / (kernel * (inputs + filters))) ** 0.5
        nn.init.uniform_(self.weight, -bound, bound)

    def forward(self, clips: Float[Tensor, "clips frames inputs"]) -> Float[Tensor, "clips frames filters"]:
        """Convolve each clip."""
        cast = torch.get_autocast_dtype("cpu") if torch.is_autocast_enabled("cpu") else clips.dtype
        return _Convolve.apply(clips.to(cast), self.weight.to(cast), self.kernel) + self.bias.to(cast)


class FilmGenerator(nn.Module):
    """Two convolutions with max pooling by two, then two dense layers; out comes the style code.

    A code is (scale 1, shift 1, scale 2, shift 2), each as wide as a hidden layer of the synthesis network.
    """

    def __init__(self, inputs: int, units: int, settings: GeneratorSettings):
        super().__init__()
        self.settings, self.units = settings, units
        flat = settings.frames // 4 * settings.filters
        self.first = TemporalConvolution(inputs, settings.filters, settings.kernel)
        self.second = TemporalConvolution(settings.filters, settings.filters, settings.kernel)
        self.dense = nn.Linear(flat, settings.hidden)
        self.code = nn.Linear(settings.hidden, 4 * units)
        for layer in (self.dense, self.code):
            nn.init.xavier_uniform_(layer.weight)
            nn.init.zeros_(layer.bias)

    def start_neutral(self, spread: float = 0.3) -> None:
        """Begin near scale 1 and shift 0, where modulation does nothing, with codes that differ little."""
        with torch.no_grad():
            self.code.weight.mul_(spread)
            self.code.bias.view(4, self.units)[0::2] = 1.0

    def forward(self, clips: Float[Tensor, "clips frames inputs"]) -> Float[Tensor, "clips values"]:
        """Style codes of normalised clips ([M22] Eq. 2)."""
        how = self.settings
        h = clips.clamp(-how.clamp, how.clamp)
        for convolution in (self.first, self.second):
            h = functional.leaky_relu(convolution(h), how.leak)
            h = torch.maximum(h[:, 0::2], h[:, 1::2])
        h = h.flatten(1).to(self.dense.weight.dtype)
        if how.normalise:
            h = functional.layer_norm(h, h.shape[-1:])
        with torch.autocast("cpu", enabled=False):
            h = functional.leaky_relu(self.dense(h), how.leak)
            return self.code(dropout(h, how.rate, self.training))
