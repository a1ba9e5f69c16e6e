"""What a run tells of itself shows whether the style codes are alive."""

import pytest
import tiny_training as tiny
import torch

from stylephase.training.loop import Trainer
from stylephase.training.progress import validate


@pytest.fixture
def run() -> Trainer:
    return tiny.trainer()


def told(run: Trainer) -> dict[str, float | None]:
    return validate(run.network, run.styles, run.scaling)


def test_it_is_the_same_twice_and_needs_no_randomness(run):
    state = torch.get_rng_state()
    run.network.train()
    assert told(run) == told(run)
    assert torch.equal(torch.get_rng_state(), state) and not run.network.training


def test_a_dead_generator_shows_in_codes_that_do_not_differ(run):
    assert told(run)["code_between"] > 0
    torch.nn.init.zeros_(run.network.generator.code.weight)
    dead = told(run)
    assert dead["code_between"] == 0 and dead["wrong_code_factor"] == 1


def test_only_validation_frames_count(run):
    before = told(run)
    for style in run.styles:
        style.y[style.rows("train")] += 100
        style.y[style.rows("test")] -= 100
    assert told(run)["validation_mse"] == before["validation_mse"]
    for style in run.styles:
        style.y[style.rows("validation")] += 100
    assert told(run)["validation_mse"] > 10 * before["validation_mse"]
