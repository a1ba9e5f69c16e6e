"""Checks of a trainer: both networks learn, one that is not trained shows, and the loss is Eq. 5."""

import tiny_training as tiny

from stylephase.training.checks import changed_by_training, off_from_equation_5


def test_both_networks_change_and_one_that_is_not_trained_does_not():
    assert changed_by_training(tiny.trainer()) == {"synthesis": 1.0, "generator": 1.0}
    frozen = tiny.trainer()
    frozen.optimisers["generator"].step = lambda *_: None
    assert changed_by_training(frozen)["generator"] == 0.0


def test_the_loss_is_equation_5_and_another_weight_of_bones_is_not():
    assert off_from_equation_5(tiny.trainer()) < 1e-6
    other = tiny.trainer()
    other.scaling.y[1] *= 1.5
    assert off_from_equation_5(other) > 1e-4
