"""Style transfer by Gram matrices (Holden, Saito and Komura 2016, Sec. 7), the rival of [M18] 8.2.

The hidden units of a motion autoencoder are optimised until they go together as those of a style clip do, while they
stay near those of the content clip; then the motion is brought back to its path, its bones and its contacts.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray
from torch import Tensor

from stylephase.features.body import Body
from stylephase.features.channels import CONTACTS, STEPS, Channels, from_table
from stylephase.features.layout import FPS
from stylephase.models.autoencoder import MotionAutoencoder

_CONTACT = 0.5
# The optimisation starts from so much noise in every channel, normalised, as in Holden's demonstration.
_NOISE = 0.1


@dataclass(frozen=True)
class GramSettings:
    """How the hidden units are optimised.

    `style` and `content` weigh the two terms, each brought to 1 where the units are all zero; `steps` of Adam at `rate`
    transfer the style, `corrections` more at a rate of their own also ask for path (m/s), bones (m) and feet (m/s).

    Differs: Holden et al. correct without the style in view, and their demonstration takes steps as large as before;
    with units of our size that made the motion tremble and led it away from the style again.
    """

    style: float = 10.0
    content: float = 1.0
    steps: int = 250
    corrections: int = 100
    rate: float = 0.01
    correction_rate: float = 0.003
    path_weight: float = 1.0
    bone_weight: float = 300.0
    foot_weight: float = 1.0


@dataclass(frozen=True)
class Anatomy:
    """Bones as (parent, child) with their lengths (m), and toes (right, left), by place among the joints."""

    bones: tuple[tuple[int, int], ...]
    lengths: Float[ndarray, " bones"]
    toes: tuple[int, int]


def anatomy_of(body: Body) -> Anatomy:
    """Bones and toes of a body."""
    lengths = [float(np.linalg.norm(body.skeleton.offsets[body.joints[child]])) for _, child in body.bones]
    left, right = body.layout.effectors[2:]
    return Anatomy(body.bones, np.array(lengths), (right, left))


def gram(hidden: Float[Tensor, "units frames"]) -> Float[Tensor, "units units"]:
    """How hidden units go together: their products in the mean over time."""
    return hidden @ hidden.T / hidden.shape[1]


@torch.inference_mode()
def gram_of(network: MotionAutoencoder, clips: Sequence[Channels]) -> Float[Tensor, "units units"]:
    """The Gram matrix over all frames of some clips, each cut to an even number."""
    return gram(torch.cat([network.encode(_batch(clip))[0] for clip in clips], dim=1))


def transfer(
    network: MotionAutoencoder,
    content: Channels,
    wanted: Float[Tensor, "units units"],
    anatomy: Anatomy,
    settings: GramSettings,
    *,
    seed: int = 0,
) -> Channels:
    """The content in the style whose Gram matrix is wanted; an odd last frame is cut off.

    It starts from a motion that is noise, as in the paper. The content's path is kept, its speed brought to that of
    the stylised motion, and its contacts tell when feet stand.
    """
    network = network.requires_grad_(False)
    content = content.at(slice(0, len(content) // 2 * 2))
    generator = torch.Generator().manual_seed(seed)
    # No gradient of the weights is kept, so that inference tensors do not get into one.
    wanted = wanted.clone()
    with torch.no_grad():
        known = network.encode(_batch(content))
        noise = torch.empty(1, len(network.mean), len(content)).uniform_(-_NOISE, _NOISE, generator=generator)
        start = network.encode(noise * network.std + network.mean)
    sizes = wanted.square().mean(), known.square().mean()

    def unlike(hidden: Tensor) -> Tensor:
        style = (gram(hidden[0]) - wanted).square().mean() / sizes[0]
        return settings.style * style + settings.content * (hidden - known).square().mean() / sizes[1]

    hidden = _optimised(start, unlike, settings.steps, settings.rate)
    steps = _rescaled(content.steps, _motion(network, hidden).steps)
    off = _constraint(network, content, steps, anatomy, settings)
    hidden = _optimised(hidden, lambda h: unlike(h) + off(h), settings.corrections, settings.correction_rate)
    return replace(_motion(network, hidden), steps=steps, contacts=content.contacts)


def _optimised(
    start: Float[Tensor, "1 units frames"], cost: Callable[[Tensor], Tensor], steps: int, rate: float
) -> Float[Tensor, "1 units frames"]:
    hidden = start.clone().requires_grad_()
    optimiser = torch.optim.Adam([hidden], lr=rate)
    for _ in range(steps):
        optimiser.zero_grad(set_to_none=True)
        cost(hidden).backward()
        optimiser.step()
    return hidden.detach()


def _rescaled(steps: Float[ndarray, "frames 3"], stylised: Float[ndarray, "frames 3"]) -> Float[ndarray, "frames 3"]:
    """The content's steps, as fast in the mean as the stylised ones; how it turns stays."""
    before, after = (float(np.linalg.norm(some[:, :2], axis=1).mean()) for some in (steps, stylised))
    return steps * [after / max(before, 1e-6), after / max(before, 1e-6), 1.0]


def _constraint(
    network: MotionAutoencoder,
    content: Channels,
    steps: Float[ndarray, "frames 3"],
    anatomy: Anatomy,
    settings: GramSettings,
) -> Callable[[Float[Tensor, "1 units frames"]], Float[Tensor, ""]]:
    """What path, bones and feet are off by, as a function of the hidden units."""
    path = torch.from_numpy(steps).float()
    parents, children = (list(column) for column in zip(*anatomy.bones, strict=True))
    lengths, toes = torch.from_numpy(anatomy.lengths).float(), list(anatomy.toes)
    standing = content.contacts > _CONTACT
    held = torch.from_numpy(standing[:-1] & standing[1:]).float()[..., None]
    heights = content.positions[:, toes, 1][standing]
    floor = float(heights.min()) if len(heights) else float(content.positions[:, toes, 1].min())

    def off(hidden: Tensor) -> Tensor:
        table = network.decode(hidden)[0].T
        joints = table[:, : -(STEPS + CONTACTS)].unflatten(1, (-1, 3))
        walked = table[:, -(STEPS + CONTACTS) : -CONTACTS]
        bones = torch.linalg.vector_norm(joints[:, parents] - joints[:, children], dim=-1) - lengths
        slide = held * _world_step(joints[:, toes], path) * FPS
        sunk = torch.clamp(joints[:, toes, 1] - floor, max=0.0) * FPS
        feet = slide.square().mean() + sunk.square().mean()
        cost = settings.path_weight * (walked - path).square().mean() + settings.bone_weight * bones.square().mean()
        return cost + settings.foot_weight * feet

    return off


def _world_step(
    joints: Float[Tensor, "frames joints 3"], steps: Float[Tensor, "frames 3"]
) -> Float[Tensor, "steps joints 3"]:
    """How far (m) joints get in the world from each frame to the next, in the axes of the frame before."""
    sine, cosine = torch.sin(steps[:-1, 2] / FPS)[:, None], torch.cos(steps[:-1, 2] / FPS)[:, None]
    x, y, z = joints[1:].unbind(-1)
    ground = steps[:-1, None, :2] / FPS
    moved = torch.stack([cosine * x + sine * z + ground[..., 0], y, cosine * z - sine * x + ground[..., 1]], dim=-1)
    return moved - joints[:-1]


def _batch(motion: Channels) -> Float[Tensor, "1 channels frames"]:
    even = motion.table[: len(motion) // 2 * 2]
    return torch.from_numpy(even.T[None]).float()


@torch.no_grad()
def _motion(network: MotionAutoencoder, hidden: Float[Tensor, "1 units frames"]) -> Channels:
    return from_table(network.decode(hidden)[0].T.double().numpy())


def reconstructed(network: MotionAutoencoder, motion: Channels) -> Channels:
    """A motion through the autoencoder and back, an odd last frame cut off."""
    with torch.no_grad():
        return _motion(network, network.encode(_batch(motion)))
