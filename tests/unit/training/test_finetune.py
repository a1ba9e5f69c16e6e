"""Fine-tuning teaches the generator a new style and leaves everything else as it was, to the last bit."""

import copy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import tiny_training as tiny
import torch

from stylephase.errors import InputError
from stylephase.evaluation.predictors import predict_network
from stylephase.evaluation.test_error import error_of
from stylephase.features.store import StyleVectors
from stylephase.models.bundle import Bundle, load_tensors, save_bundle
from stylephase.training.finetune import FineTuned, FineTuning, fine_tune, with_new_codes
from stylephase.training.losses import bone_lengths

HOW = FineTuning(steps=60, clips=2, frames=8, rate=3e-3, warm_up=2, bone_weight=0.1, mixed=False)


@pytest.fixture(scope="module")
def base(tmp_path_factory) -> Bundle:
    """Weights that know two styles."""
    return tiny.trainer(steps=200, log_every=200).run(tmp_path_factory.mktemp("base"), tiny.ignore)


def style(name: str = "New", number: int = 3) -> StyleVectors:
    return tiny.vectors(name, number, 400)


@pytest.fixture(scope="module")
def tuned(base) -> FineTuned:
    return fine_tune(base, [style()], HOW)


def error(bundle: Bundle, vectors: StyleVectors) -> float:
    return error_of(predict_network(bundle, vectors.style), vectors, bundle, bone_lengths(bundle.body), "test").mse


def test_the_new_style_is_learned(base, tuned):
    """On frames that did not train, with everything but the generator frozen."""
    before, after = error(with_new_codes(base, [style()]), style()), error(tuned.bundle, style())
    assert after < 0.9 * before
    assert tuned.bundle.styles == ("Plain", "Sway", "New")
    assert len(tuned.errors) == HOW.steps and np.isfinite(tuned.errors).all()


def test_all_but_the_generator_stays_to_the_last_bit(base, tuned, tmp_path):
    """In the files: what differs is the generator, and what is new is one code."""
    for name, bundle in (("base", base), ("tuned", tuned.bundle)):
        save_bundle(tmp_path / name, bundle)
    before, after = (load_tensors(tmp_path / name / "weights.safetensors") for name in ("base", "tuned"))
    assert after.keys() - before.keys() == {"code.New"} and before.keys() <= after.keys()
    changed = {name for name in before if not torch.equal(before[name], after[name])}
    assert changed == {name for name in before if name.startswith("network.generator.")}


def test_old_styles_move_as_before_to_the_last_bit(base, tuned):
    old = tiny.vectors("Plain", 0, 300)
    x, p = old.x.astype(float), old.p.astype(float)
    before, after = (predict_network(bundle, "Plain")(x, p) for bundle in (base, tuned.bundle))
    np.testing.assert_array_equal(before, after)


def test_the_weights_given_are_not_touched(base):
    before = {name: tensor.clone() for name, tensor in tiny.weights(base).items()}
    fine_tune(base, [style()], replace(HOW, steps=2))
    assert tiny.same(before, tiny.weights(base))
    assert all(parameter.requires_grad for parameter in base.network.parameters())


def test_the_same_seed_gives_the_same_weights_and_another_seed_others(base, tuned):
    torch.manual_seed(5)
    again, other = (fine_tune(base, [style()], HOW, seed=seed).bundle for seed in (0, 1))
    assert tiny.same(tiny.weights(tuned.bundle), tiny.weights(again))
    assert not torch.equal(tuned.bundle.codes["New"], other.codes["New"])


def test_the_random_state_of_others_is_left_alone(base):
    torch.manual_seed(7)
    expected = torch.rand(3)
    torch.manual_seed(7)
    fine_tune(base, [style()], replace(HOW, steps=1))
    assert torch.equal(torch.rand(3), expected)


def test_a_style_learned_later_keeps_the_code_of_one_learned_before(base, tuned):
    both = fine_tune(tuned.bundle, [style("Newer", 4)], replace(HOW, steps=4)).bundle
    assert torch.equal(both.codes["New"], tuned.bundle.codes["New"])


def test_styles_may_be_learned_together(base):
    news = [style("New", 3), style("Newer", 6)]
    before, after = with_new_codes(base, news), fine_tune(base, news, HOW).bundle
    assert all(error(after, one) < error(before, one) for one in news)


@pytest.mark.parametrize("model", ["pfnn-film", "mann-film"])
def test_networks_with_other_gates_learn_too(model, tmp_path):
    other = tiny.trainer(model=model).run(tmp_path, tiny.ignore)
    assert fine_tune(other, [style()], replace(HOW, steps=2)).bundle.styles[-1] == "New"


def test_the_progress_told_adds_up_to_the_steps(base):
    ticks: list[int] = []
    fine_tune(base, [style()], replace(HOW, steps=3), tick=ticks.append)
    assert ticks == [1, 1, 1]


def test_a_style_that_is_known_is_refused(base):
    with pytest.raises(InputError, match="know the style 'Sway' already"):
        fine_tune(base, [style("Sway")], HOW)


@pytest.mark.parametrize("model", ["lpn-onehot", "pfnn-resad"])
def test_models_without_a_style_network_are_refused(model, tmp_path: Path):
    other = tiny.trainer(model=model, steps=2).run(tmp_path, tiny.ignore)
    with pytest.raises(InputError, match=f"{model} has no style network"):
        fine_tune(other, [style()], HOW)


def test_weights_that_came_without_their_generator_are_refused(base):
    bare = replace(base, network=copy.deepcopy(base.network))
    generator = bare.network.generator
    assert generator is not None
    generator.to("meta")
    with pytest.raises(InputError, match="without their style network"):
        fine_tune(bare, [style()], HOW)


def test_what_is_no_number_is_not_learned(base):
    broken = style()
    broken.y[:] = np.nan
    with pytest.raises(InputError, match="diverged at step 0"):
        fine_tune(base, [broken], HOW)
