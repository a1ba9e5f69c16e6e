"""How well weights foresee a style that they learned afterwards, or never ([M22] 5.3.2)."""

from collections.abc import Mapping

import numpy as np

from stylephase.evaluation.predictors import Predictor, predict_network
from stylephase.evaluation.test_error import error_of
from stylephase.features.store import StyleVectors
from stylephase.models.bundle import Bundle
from stylephase.training.losses import bone_lengths


def new_style_errors(
    base: Bundle, tuned: Mapping[str, Bundle], style: StyleVectors, rivals: Mapping[str, Predictor]
) -> dict[str, float]:
    """Squared error of a step on a style's test frames, normalised by `base`, which does not know the style.

    Of each of the `tuned` weights with their code for it, of `base` with the known code that fits the style's
    validation frames best (`best known`) and with all known codes in the mean (`wrong`), and of `rivals`.
    """
    lengths, known = bone_lengths(base.body), {name: predict_network(base, name) for name in base.styles}

    def error(predictor: Predictor, part: str = "test") -> float:
        return error_of(predictor, style, base, lengths, part).mse

    fits = {name: error(predictor, "validation") for name, predictor in known.items()}
    borrowed = {name: error(predictor) for name, predictor in known.items()}
    errors = {label: error(predict_network(bundle, style.style)) for label, bundle in tuned.items()}
    errors |= {
        "best known": borrowed[min(fits, key=fits.__getitem__)],
        "wrong": float(np.mean(list(borrowed.values()))),
    }
    return errors | {label: error(rival) for label, rival in rivals.items()}


def against_holding(bundle: Bundle, base: Bundle, style: StyleVectors, hold: Predictor) -> float:
    """The squared error of a step by weights with their code for a style, over that of holding the pose.

    On test frames, normalised by `base`; 1 is no better than to stand still.
    """
    lengths, both = bone_lengths(base.body), (predict_network(bundle, style.style), hold)
    ours, standing = (error_of(predictor, style, base, lengths, "test").mse for predictor in both)
    return ours / standing
