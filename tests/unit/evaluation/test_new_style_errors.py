"""Errors on a style that weights learned afterwards, beside codes borrowed from the styles they know."""

from dataclasses import replace

import pytest
import tiny_walker as tiny

from stylephase.evaluation.new_styles import new_style_errors
from stylephase.evaluation.predictors import predict_mean, predict_network
from stylephase.evaluation.test_error import error_of
from stylephase.training.losses import bone_lengths


def test_borrowed_codes_are_chosen_by_the_validation_and_told_on_the_test():
    base, style = tiny.bundle("Plain", "Old", "Very old"), tiny.style_vectors("Sleepwalk", 16.0)
    taught = replace(base, codes=base.codes | {"Sleepwalk": base.codes["Old"]})
    rivals = {"mean": predict_mean(base.normaliser)}
    found = new_style_errors(base, {"after": taught}, style, rivals)
    lengths = bone_lengths(base.body)
    errors = {
        part: {name: error_of(predict_network(base, name), style, base, lengths, part).mse for name in base.styles}
        for part in ("validation", "test")
    }
    best = min(errors["validation"], key=errors["validation"].__getitem__)
    assert found["best known"] == errors["test"][best]
    assert found["wrong"] == pytest.approx(sum(errors["test"].values()) / 3)
    assert found["after"] == errors["test"]["Old"]
    assert found["mean"] == error_of(rivals["mean"], style, base, lengths, "test").mse
    assert list(found) == ["after", "best known", "wrong", "mean"]
