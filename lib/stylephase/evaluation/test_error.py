"""Test errors on seen styles and unseen frames ([M22] 5.2.2, Fig. 10), of a network and of naive predictors."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields

import numpy as np
import torch
from jaxtyping import Int
from numpy import ndarray

from stylephase.evaluation.predictors import (
    Predictor,
    fit_ridge,
    predict_hold,
    predict_mean,
    predict_network,
    untrained,
)
from stylephase.features.store import StyleVectors
from stylephase.models.bundle import Bundle
from stylephase.training.losses import BoneLengths, bone_lengths

# Test frames of a style, as many as the release takes ([M22] release 4.6), here spread evenly over all of them.
FRAMES = 1000
# Other styles whose codes are tried as wrong ones.
_WRONG_CODES = 5


@dataclass(frozen=True)
class Error:
    """Mean squared error over normalised outputs, and mean bone length error (m).

    `shared` is the squared error over the outputs that all models have, whatever their gate: models are compared by it.
    """

    mse: float
    bll: float
    shared: float


def test_rows(style: StyleVectors, part: str = "test") -> Int[ndarray, " rows"]:
    """The rows that a style is tested on: at most FRAMES of its part, evenly spread."""
    rows = style.rows(part)
    return rows[np.unique(np.linspace(0, len(rows) - 1, min(FRAMES, len(rows))).astype(int))] if len(rows) else rows


def distance_to_training(style: StyleVectors, part: str = "test") -> float:
    """Frames between a tested row and the nearest training row of its take; infinite where no take has both."""
    tested, trained, least = test_rows(style, part), style.rows("train"), np.inf
    for take in np.intersect1d(style.take[tested], style.take[trained]):
        one, other = tested[style.take[tested] == take], trained[style.take[trained] == take]
        least = min(least, float(np.abs(one[:, None] - other).min()))
    return least


def error_of(predictor: Predictor, style: StyleVectors, bundle: Bundle, lengths: BoneLengths, part: str) -> Error:
    """Error of a predictor on one style."""
    rows = test_rows(style, part)
    y, predicted = style.y[rows].astype(float), predictor(style.x[rows].astype(float), style.p[rows].astype(float))
    bones = [lengths(torch.from_numpy(values)) for values in (y, predicted)]
    squared = np.square((predicted - y) / bundle.normaliser.y_std).mean(axis=0)
    shared = squared[bundle.layout.y_shared].mean()
    return Error(float(squared.mean()), float((bones[0] - bones[1]).abs().mean()), float(shared))


def test_errors(bundle: Bundle, styles: Sequence[StyleVectors], *, part: str = "test") -> dict[str, dict[str, Error]]:
    """For each style with frames in the part, the error of the network and of every rival.

    `network` has the style's stored code, `dropout` the same with dropout on, `wrong code` the mean over some codes
    of other styles; then `mean`, `hold`, `ridge` and `untrained`.
    """
    n, layout, lengths = bundle.normaliser, bundle.layout, bone_lengths(bundle.body)
    blank = untrained(bundle)
    fixed = {"mean": predict_mean(n), "hold": predict_hold(layout, n), "ridge": fit_ridge(styles, n)}
    errors = {}
    for style in (style for style in styles if len(test_rows(style, part))):
        rivals = fixed | {
            "network": predict_network(bundle, style.style),
            "dropout": predict_network(bundle, style.style, dropout=True),
            "untrained": predict_network(blank, style.style),
        }
        errors[style.style] = {name: error_of(rival, style, bundle, lengths, part) for name, rival in rivals.items()}
        wrong = [predict_network(bundle, other) for other in other_styles(bundle.styles, style.style)]
        if wrong:
            errors[style.style]["wrong code"] = _mean([error_of(w, style, bundle, lengths, part) for w in wrong])
    return errors


def other_styles(styles: Sequence[str], style: str) -> list[str]:
    """Some other styles, spread evenly over the rest."""
    rest = [other for other in styles if other != style]
    return [rest[k] for k in np.unique(np.linspace(0, len(rest) - 1, min(_WRONG_CODES, len(rest))).astype(int))]


def _mean(errors: Sequence[Error]) -> Error:
    return Error(*(float(np.mean([getattr(error, part.name) for error in errors])) for part in fields(Error)))


def mean_over(errors: dict[str, dict[str, Error]], styles: Iterable[str]) -> dict[str, Error]:
    """Plain means over some styles, as the release reports ([M22] release 4.6)."""
    chosen = [errors[style] for style in styles if style in errors]
    names = [name for name in chosen[0] if all(name in one for one in chosen)] if chosen else []
    return {name: _mean([one[name] for one in chosen]) for name in names}
