"""The objective: squared error, bone length loss ([M22] Eq. 5) and L1 terms ([M18] Eq. 3)."""

from collections.abc import Iterable
from dataclasses import dataclass

import torch
from jaxtyping import Float
from torch import Tensor, nn

from stylephase.features.body import Body
from stylephase.models.modulators import Adapters
from stylephase.models.synthesis import Synthesis
from stylephase.training.sampler import Scaling


@dataclass(frozen=True)
class BoneLengths:
    """Lengths of the bones in an output y, given in metres."""

    pose: slice
    parents: tuple[int, ...]
    children: tuple[int, ...]

    def __call__(self, y: Float[Tensor, "rows outputs"]) -> Float[Tensor, "rows bones"]:
        """Distance (m) of each bone's two joints."""
        joints = y[:, self.pose].unflatten(1, (-1, 12))[..., :3]
        return torch.linalg.vector_norm(joints[:, list(self.parents)] - joints[:, list(self.children)], dim=-1)


def bone_lengths(body: Body) -> BoneLengths:
    """The lengths of a body's bones."""
    parents, children = zip(*body.bones, strict=True)
    return BoneLengths(body.layout.y_pose, parents, children)


def squared_error(y: Float[Tensor, "rows outputs"], predicted: Float[Tensor, "rows outputs"]) -> Float[Tensor, ""]:
    """Mean squared error over rows and outputs, normalised ([M22] Eq. 5a; a mean over outputs, as in the release)."""
    return torch.mean(torch.square(predicted - y))


def bone_length_loss(
    y: Float[Tensor, "rows outputs"], predicted: Float[Tensor, "rows outputs"], lengths: BoneLengths, scaling: Scaling
) -> Float[Tensor, ""]:
    """Mean difference of bone lengths in metres ([M22] Eq. 5b and 5c).

    Differs: the release divides by the number of joints, one more than there are bones.
    """
    return torch.mean(torch.abs(lengths(scaling.metric(predicted)) - lengths(scaling.metric(y))))


def mean_absolute(weights: Iterable[Tensor]) -> Float[Tensor, ""]:
    """Mean absolute value over all weights given ([M18] Eq. 3; a mean as in its release, where the paper has the norm).

    Zero where there are none.
    """
    flat = [weight.flatten() for weight in weights]
    return torch.cat(flat).abs().mean() if flat else torch.zeros(())


def shared_weights(network: Synthesis) -> list[nn.Parameter]:
    """What all styles share: the network without its modulator."""
    return [weight for name, weight in network.named_parameters() if not name.startswith("modulator.")]


def style_weights(network: Synthesis, style: int) -> list[nn.Parameter]:
    """The style's own adapter; none where styles enter in another way."""
    modulator = network.modulator
    return list(modulator.adapters[style].parameters()) if isinstance(modulator, Adapters) else []
