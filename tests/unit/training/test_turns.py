"""Training a PFNN with adapters: styles in turn, each with an adapter that only its own frames change ([M18] 6)."""

import tiny_training as tiny
import torch

from stylephase.training.losses import mean_absolute, shared_weights, style_weights

TURNS = {"styles_per_step": 1, "steps_per_code": 1, "in_turn": True}


def test_styles_follow_one_another_and_each_batch_changes_its_own_adapter_alone():
    run = tiny.trainer(model="pfnn-cp", shared_l1=0.01, style_l1=0.01, **TURNS)
    for turn in range(4):
        before = [[weight.clone() for weight in style_weights(run.network.synthesis, k)] for k in range(2)]
        run.round()
        changed = [
            any(not torch.equal(a, b) for a, b in zip(old, style_weights(run.network.synthesis, k), strict=True))
            for k, old in enumerate(before)
        ]
        assert changed == [turn % 2 == 0, turn % 2 == 1]


def test_the_l1_terms_are_means_over_what_is_shared_and_over_one_styles_adapter():
    run = tiny.trainer(model="pfnn-cp", shared_l1=2.0, style_l1=3.0, **TURNS)
    network = run.network.synthesis
    own, shared = (
        torch.cat([w.flatten() for w in some]) for some in (style_weights(network, 1), shared_weights(network))
    )
    adapters = sum(weight.numel() for weight in network.modulator.parameters())
    assert len(own) * 2 == adapters and len(shared) + adapters == sum(w.numel() for w in network.parameters())
    expected = 2 * shared.abs().mean() + 3 * own.abs().mean()
    assert torch.allclose(run.l1_terms(run.styles_of_round() + 1), expected)


def test_a_strong_weight_makes_weights_smaller():
    sizes = []
    for weight in (0.0, 100.0):
        run = tiny.trainer(model="pfnn-cp", style_l1=weight, steps=200, **TURNS)
        for _ in range(60):
            run.round()
        sizes.append(mean_absolute(style_weights(run.network.synthesis, 0)).item())
    assert sizes[1] < 0.9 * sizes[0]


def test_other_models_have_no_adapters_to_weigh():
    network = tiny.trainer(model="pfnn-film").network.synthesis
    assert style_weights(network, 0) == [] and mean_absolute([]) == 0
