"""A new style from one clip: its adapter learns, all else stays to the last bit ([M18] 7)."""

from dataclasses import replace

import numpy as np
import pytest
import tiny_adapters as tiny
import torch
from tiny_walker import of_model

from stylephase.errors import InputError
from stylephase.models.bundle import load_bundle, save_bundle
from stylephase.training.fewshot import (
    ADAPTERS,
    FewShot,
    Lesson,
    Schedule,
    add_styles,
    begun,
    fine_tune_whole,
    learn,
    lesson_rows,
    train_alone,
    with_styles,
)
from stylephase.training.sampler import Scaling

CLIP = tiny.clip_of("StoopedOver")


def outputs(bundle, style: str, seed: int = 0) -> torch.Tensor:
    layout = bundle.layout
    generator = torch.Generator().manual_seed(seed)
    x, p = torch.randn(5, layout.inputs, generator=generator), 6 * torch.rand(5, 1, generator=generator)
    with torch.inference_mode():
        return bundle.network.synthesis(x, p, bundle.code(style).expand(5, -1))


def error_of(bundle, style) -> float:
    """Squared error on the clip, normalised."""
    rows = lesson_rows(tiny.for_gate(style, bundle.layout), Scaling(bundle.normaliser, bundle.layout), None)
    code = bundle.code(style.style).expand(len(rows["x"]), -1)
    with torch.inference_mode():
        return float((bundle.network.synthesis(rows["x"], rows["p"], code) - rows["y"]).square().mean())


@pytest.mark.parametrize("kind", ADAPTERS)
def test_an_adapter_of_each_form_learns_its_clip(kind):
    lesson = Lesson(CLIP, FewShot(kind, factors=6, dropout=0.0))
    before = with_styles(tiny.base(), [CLIP.style], [begun(lesson.how, 24)], [lesson.how.form])
    after = add_styles(tiny.base(), [lesson], replace(tiny.QUICK, steps=150))
    assert error_of(after, CLIP) < 0.98 * error_of(before, CLIP)


def test_earlier_styles_stay_bit_identical_one_after_the_other():
    bundle, kept = tiny.base(), {style: outputs(tiny.base(), style) for style in tiny.STYLES}
    for kind, name in (("cp", "StoopedOver"), ("full", "DraggedLeft"), ("diagonal", "KneesUp")):
        bundle = add_styles(bundle, [Lesson(tiny.clip_of(name), FewShot(kind, factors=3))], tiny.QUICK)
        assert bundle.styles[-1] == name
        for style, before in kept.items():
            assert torch.equal(outputs(bundle, style), before), f"{style} after {name}"
        kept[name] = outputs(bundle, name)
    assert len(kept) == 5 and bundle.settings.adapters == ("cp", "cp", "cp:3", "full", "diag")


def test_shared_weights_and_the_weights_given_are_not_touched():
    base = tiny.base()
    before = {name: tensor.clone() for name, tensor in base.network.state_dict().items()}
    after = add_styles(base, [Lesson(CLIP)], tiny.QUICK).network.state_dict()
    assert all(torch.equal(tensor, base.network.state_dict()[name]) for name, tensor in before.items())
    assert all(torch.equal(tensor, after[name]) for name, tensor in before.items())
    assert all(tensor.requires_grad for tensor in base.network.parameters())


def test_weights_with_adapters_of_several_forms_come_back_as_they_were(tmp_path):
    lessons = [Lesson(CLIP, FewShot("full")), Lesson(tiny.clip_of("KneesUp"), FewShot("cp", 5))]
    bundle = add_styles(tiny.base(), lessons, tiny.QUICK)
    save_bundle(tmp_path / "run", bundle)
    found = load_bundle(tmp_path / "run")
    assert found.styles == (*tiny.STYLES, "StoopedOver", "KneesUp") and found.settings == bundle.settings
    assert all(torch.equal(outputs(found, style), outputs(bundle, style)) for style in bundle.styles)


def test_an_adapter_that_says_nothing_is_the_average_motion_and_gets_a_gradient():
    for kind in ADAPTERS:
        how = FewShot(kind, factors=2)
        bundle = with_styles(tiny.base(), ["New"], [begun(how, 24)], [how.form])
        average = replace(bundle, codes={"average": torch.zeros(3)})
        assert torch.equal(outputs(bundle, "New"), outputs(average, "average"))
        (one,) = learn(tiny.base(), [Lesson(CLIP, how)], replace(tiny.QUICK, steps=3))
        assert max(float(weight.detach().abs().max()) for weight in one.parameters()) > 0
        drawn = begun(replace(how, silent=False), 24)
        assert all(float(w.detach().abs().max()) > 0 for name, w in drawn.named_parameters() if name != "bias")


def test_asymmetric_clips_are_not_mirrored_and_cycles_are_whole():
    layout = tiny.base().layout
    scaling = Scaling(tiny.base().normaliser, layout)
    both, one = (tiny.for_gate(tiny.clip_of("StoopedOver", symmetric=s), layout) for s in (True, False))
    mirrored, plain = (lesson_rows(clip, scaling, None) for clip in (both, one))
    assert len(mirrored["x"]) == 2 * len(plain["x"])
    assert torch.equal(mirrored["x"][: len(plain["x"])], plain["x"])
    source, sign, _ = layout.mirror_x
    image = scaling.x[0] + mirrored["x"][len(plain["x"]) :] * scaling.x[1]
    raw = scaling.x[0] + plain["x"] * scaling.x[1]
    torch.testing.assert_close(image, raw[:, source] * torch.from_numpy(sign).float(), atol=1e-4, rtol=0)
    assert len(lesson_rows(one, scaling, 1)["x"]) < len(plain["x"])
    phase = plain["p"][:, 0] * scaling.p[1] + scaling.p[0]
    assert np.isclose(float(phase[0]) % (2 * np.pi), 0, atol=0.3) or np.isclose(float(phase[0]), np.pi, atol=0.3)


def test_the_normaliser_is_the_bases():
    assert add_styles(tiny.base(), [Lesson(CLIP)], tiny.QUICK).normaliser is tiny.base().normaliser


def test_dropout_and_l1_hold_an_adapter_back():
    hows = (FewShot(dropout=0.0, l1=0.0), FewShot(dropout=0.9, l1=0.0), FewShot(dropout=0.0, l1=1000.0))
    free, dropped, weighed = learn(tiny.base(), [Lesson(CLIP, how) for how in hows], tiny.QUICK)

    def size(one) -> float:
        return float(torch.cat([weight.detach().flatten() for weight in one.parameters()]).abs().mean())

    assert size(weighed) < 0.9 * size(free) and size(dropped) != size(free)


def test_the_same_seed_gives_the_same_adapter():
    one, two, other = (learn(tiny.base(), [Lesson(CLIP)], tiny.QUICK, seed=seed)[0] for seed in (0, 0, 1))
    assert torch.equal(one.a, two.a) and not torch.equal(one.a, other.a)


def test_rivals_learn_with_all_their_weights():
    alone = train_alone(tiny.base(), CLIP, replace(tiny.QUICK, steps=150))
    assert alone.styles == (CLIP.style,) and alone.model == "pfnn" and error_of(alone, CLIP) < 1
    normal = tiny.base(styles=("Plain",))
    tuned = fine_tune_whole(normal, CLIP, replace(tiny.QUICK, steps=150))
    weight = "synthesis.layers.0.weight"
    assert not torch.equal(tuned.network.state_dict()[weight], normal.network.state_dict()[weight])
    before = replace(normal, codes={CLIP.style: normal.code("Plain")})
    assert error_of(tuned, CLIP) < error_of(before, CLIP)


def test_what_cannot_be_learned_is_one_line():
    standing = replace(CLIP, y=np.zeros_like(CLIP.y))
    with pytest.raises(InputError, match="no walking cycle in the clip of StoopedOver"):
        learn(tiny.base(), [Lesson(standing)], tiny.QUICK)
    with pytest.raises(InputError, match="know the style 'Plain' already"):
        add_styles(tiny.base(), [Lesson(replace(CLIP, style="Plain"))], Schedule(steps=1))
    with pytest.raises(InputError, match="pfnn-film has no residual adapters"):
        learn(of_model("pfnn-film"), [Lesson(CLIP)], tiny.QUICK)
    with pytest.raises(InputError, match="no adapter 'big'; there are cp, diagonal, full"):
        begun(FewShot("big"), 24)
