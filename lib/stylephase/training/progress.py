"""What a training run tells of itself: validation error, and whether the style codes are alive."""

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from stylephase.features.store import StyleVectors
from stylephase.models.synthesis import StyledNetwork, Synthesis
from stylephase.models.zoo import style_codes
from stylephase.training.codes import clip_codes
from stylephase.training.losses import squared_error
from stylephase.training.sampler import Scaling

_FRAMES_PER_STYLE, _CLIPS_PER_STYLE = 96, 4


def validate(network: StyledNetwork, styles: list[StyleVectors], scaling: Scaling) -> dict[str, float | None]:
    """Squared error on validation frames with the right and with wrong style codes, and the spread of the codes.

    A dead generator is invisible in the error: it shows in `code_between`, the deviation of codes between styles,
    falling to that within a style, `code_within`; codes without a generator have no such spread. Short takes all
    train: without validation frames there is no error. Leaves the network in eval mode.
    """
    network.eval()
    codes, spread = style_codes(network, len(styles)), {"code_between": None, "code_within": None}
    if network.generator is not None:
        groups = [clip_codes(network.generator, style, scaling, most=_CLIPS_PER_STYLE) for style in styles]
        codes = torch.stack([group.mean(dim=0) for group in groups])
        within = torch.stack([(group - group.mean(dim=0)).square().mean() for group in groups]).mean().sqrt()
        between = codes.std(dim=0, unbiased=False).square().mean().sqrt()
        spread = {"code_between": float(between), "code_within": float(within)}
    right = _error(network.synthesis, styles, codes, scaling)
    wrong = _error(network.synthesis, styles, codes.roll(1, dims=0), scaling)
    return {
        "validation_mse": right,
        "wrong_code_factor": wrong / right if right and wrong else None,
        **spread,
    }


def _error(
    network: Synthesis, styles: list[StyleVectors], codes: Float[Tensor, "styles values"], scaling: Scaling
) -> float | None:
    """Mean over styles of the error on evenly spread validation frames; None where there are no such frames."""
    errors = []
    for style, code in zip(styles, codes, strict=True):
        rows = style.rows("validation")
        if not len(rows):
            continue
        rows = rows[np.unique(np.linspace(0, len(rows) - 1, _FRAMES_PER_STYLE).astype(int))]
        x, p, y = (scaling.scaled(kind, torch.from_numpy(getattr(style, kind)[rows])) for kind in "xpy")
        with torch.inference_mode():
            errors.append(squared_error(y, network(x, p, code.expand(len(rows), -1))).item())
    return float(np.mean(errors)) if errors else None
