"""The convolutional motion autoencoder of Holden, Saito and Komura 2016, the rival that [M18] 8.2 compares with.

One layer: convolution over time, ReLU, and the larger of each two frames; back by the same weights.
"""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional

from stylephase.files import read_json, write_json
from stylephase.models.bundle import load_tensors, save_tensors

_WEIGHTS, _DESCRIBED = "weights.safetensors", "autoencoder.json"


@dataclass(frozen=True)
class AutoencoderSettings:
    """Hidden units, frames that a filter sees, and dropout of the input in training."""

    units: int = 256
    kernel: int = 25
    dropout: float = 0.1


class MotionAutoencoder(nn.Module):
    """Channels over time to hidden units at half the frame rate, and back.

    It takes and gives channels in metres, m/s and rad/s; `mean` and `std` (channels) normalise inside.
    """

    mean: Tensor
    std: Tensor

    def __init__(
        self, mean: Float[Tensor, " channels"], std: Float[Tensor, " channels"], settings: AutoencoderSettings
    ):
        super().__init__()
        self.settings = settings
        self.register_buffer("mean", mean[:, None].clone())
        self.register_buffer("std", std[:, None].clone())
        self.filters = nn.Parameter(torch.empty(settings.units, len(mean), settings.kernel))
        self.bias, self.back_bias = nn.Parameter(torch.zeros(settings.units)), nn.Parameter(torch.zeros(len(mean)))
        nn.init.xavier_uniform_(self.filters)

    def normalised(self, motion: Float[Tensor, "clips channels frames"]) -> Float[Tensor, "clips channels frames"]:
        """Channels as the network learns them."""
        return (motion - self.mean) / self.std

    def encode(self, motion: Float[Tensor, "clips channels frames"]) -> Float[Tensor, "clips units half_frames"]:
        """Hidden units, of an even number of frames."""
        padding = self.settings.kernel // 2
        seen = functional.dropout(self.normalised(motion), self.settings.dropout, self.training)
        units = torch.relu(functional.conv1d(seen, self.filters, self.bias, padding=padding))
        return functional.max_pool1d(units, 2)

    def decode(self, hidden: Float[Tensor, "clips units half_frames"]) -> Float[Tensor, "clips channels frames"]:
        """Channels of hidden units.

        In training one of each two frames, by chance, takes the whole value and the other none; in use each takes half.
        """
        first = 0.5 if not self.training else (torch.rand_like(hidden) < 0.5).to(hidden.dtype)
        frames = torch.stack([first * hidden, (1 - first) * hidden], dim=-1).flatten(2)
        padding = self.settings.kernel // 2
        return functional.conv_transpose1d(frames, self.filters, self.back_bias, padding=padding) * self.std + self.mean

    def forward(self, motion: Float[Tensor, "clips channels frames"]) -> Float[Tensor, "clips channels frames"]:
        """There and back."""
        return self.decode(self.encode(motion))


def save_autoencoder(folder: Path, network: MotionAutoencoder, about: dict[str, Any]) -> None:
    """Write weights and what they are; the JSON comes last, so a folder with it is complete."""
    save_tensors(folder / _WEIGHTS, network.state_dict())
    write_json(folder / _DESCRIBED, {"settings": asdict(network.settings), "about": about})


def load_autoencoder(folder: Path) -> MotionAutoencoder:
    """Read a trained autoencoder, in eval mode. Raises InputError where a file is missing."""
    settings = AutoencoderSettings(**read_json(folder / _DESCRIBED)["settings"])
    tensors = load_tensors(folder / _WEIGHTS)
    network = MotionAutoencoder(tensors["mean"][:, 0], tensors["std"][:, 0], settings)
    network.load_state_dict(tensors)
    return network.eval()
