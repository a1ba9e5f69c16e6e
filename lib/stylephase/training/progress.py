"""What a training run tells of itself: validation error, and whether the style codes are alive."""

from typing import TYPE_CHECKING

import numpy as np
import torch
from torch import Tensor

from stylephase.training.codes import clip_codes
from stylephase.training.losses import squared_error

if TYPE_CHECKING:
    from stylephase.training.loop import Trainer

_FRAMES_PER_STYLE, _CLIPS_PER_STYLE = 96, 4


def validate(trainer: "Trainer") -> dict[str, float]:
    """Squared error on validation frames with the right and with wrong style codes, and the spread of the codes.

    A dead generator is invisible in the error: it shows in `code_between`, the deviation of codes between styles,
    falling to that within a style, `code_within`.
    """
    trainer.network.eval()
    groups = [clip_codes(trainer.network.generator, s, trainer.scaling, most=_CLIPS_PER_STYLE) for s in trainer.styles]
    codes = torch.stack([group.mean(dim=0) for group in groups])
    within = torch.stack([(group - group.mean(dim=0)).square().mean() for group in groups]).mean().sqrt()
    right, wrong = _errors(trainer, codes), _errors(trainer, codes.roll(1, dims=0))
    return {
        "validation_mse": right,
        "wrong_code_factor": wrong / right,
        "code_between": float(codes.std(dim=0, unbiased=False).square().mean().sqrt()),
        "code_within": float(within),
    }


def _errors(trainer: "Trainer", codes: Tensor) -> float:
    """Mean over styles of the error on evenly spread validation frames."""
    errors = []
    for style, code in zip(trainer.styles, codes, strict=True):
        rows = style.rows("validation")
        if not len(rows):
            continue
        rows = rows[np.unique(np.linspace(0, len(rows) - 1, _FRAMES_PER_STYLE).astype(int))]
        x, p, y = (trainer.scaling.scaled(kind, torch.from_numpy(getattr(style, kind)[rows])) for kind in "xpy")
        with torch.inference_mode():
            errors.append(squared_error(y, trainer.network.synthesis(x, p, code.expand(len(rows), -1))).item())
    return float(np.mean(errors))
