"""Style codes of a trained generator: one per style, the mean over some of its training clips ([M22] 4.4)."""

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from stylephase.features.clips import clip_rows, walking_gaits
from stylephase.features.store import StyleVectors
from stylephase.models.generator import FilmGenerator
from stylephase.models.synthesis import StyledNetwork
from stylephase.models.zoo import style_codes
from stylephase.training.sampler import Scaling

# Clips that a stored code averages over. The paper allows one clip or an average; the release takes one.
CLIPS_PER_CODE = 8


def clip_codes(
    generator: FilmGenerator, style: StyleVectors, scaling: Scaling, *, part: str = "train", most: int = CLIPS_PER_CODE
) -> Float[Tensor, "clips values"]:
    """Codes of clips of a style, spread evenly over those of a part; walking ones where the style has them."""
    rows = clip_rows(style, part, gaits=walking_gaits(style))
    rows = rows if len(rows) else clip_rows(style, part)
    chosen = rows[np.unique(np.linspace(0, len(rows) - 1, min(most, len(rows))).astype(int))] if len(rows) else rows
    poses = torch.from_numpy(style.x[chosen][:, :, scaling.layout.x_pose])
    generator.eval()
    with torch.inference_mode():
        return generator(scaling.scaled("clip", poses))


def stored_codes(
    network: StyledNetwork, styles: list[StyleVectors], scaling: Scaling
) -> dict[str, Float[Tensor, " values"]]:
    """The code of each style: the generator's over its clips, or weights that are one for the style alone."""
    if network.generator is None:
        codes = style_codes(network, len(styles))
    else:
        codes = torch.stack([clip_codes(network.generator, style, scaling).mean(dim=0) for style in styles])
    return {style.style: code.clone() for style, code in zip(styles, codes, strict=True)}
