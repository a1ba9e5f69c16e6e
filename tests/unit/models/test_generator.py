"""The FiLM generator: its convolution is torch's, its size the paper's, its output a style code."""

import pytest
import torch
from torch.nn import functional

from stylephase.models.film import split_code
from stylephase.models.generator import FilmGenerator, GeneratorSettings, TemporalConvolution

SMALL = GeneratorSettings(frames=16, filters=6, kernel=5, hidden=12, rate=0.5)


def clips(count: int = 3, frames: int = 16, inputs: int = 7, *, dtype=torch.float32) -> torch.Tensor:
    return torch.randn(count, frames, inputs, dtype=dtype, generator=torch.Generator().manual_seed(5))


def by_torch(convolution: TemporalConvolution, values: torch.Tensor) -> torch.Tensor:
    """The same by torch's own convolution, whose weight is (filters, inputs, kernel)."""
    weight = convolution.weight.view(convolution.kernel, values.shape[2], -1).permute(2, 1, 0)
    return functional.conv1d(values.transpose(1, 2), weight, convolution.bias, padding="same").transpose(1, 2)


# torch pads a copy of the input where `same` needs an uneven padding, and says so.
@pytest.mark.filterwarnings("ignore:Using padding='same' with even kernel lengths:UserWarning")
@pytest.mark.parametrize("kernel", [1, 2, 3, 4, 5, 25])
def test_the_convolution_is_torchs_forward_and_backward(kernel):
    torch.manual_seed(0)
    convolution = TemporalConvolution(7, 6, kernel).double()
    torch.nn.init.normal_(convolution.bias)
    values = clips(dtype=torch.float64).requires_grad_()
    ours, theirs = convolution(values), by_torch(convolution, values)
    torch.testing.assert_close(ours, theirs, atol=1e-10, rtol=0)
    wrt = (values, convolution.weight, convolution.bias)
    gradients = [torch.autograd.grad(out.sin().sum(), wrt) for out in (ours, theirs)]
    for one, other in zip(*gradients, strict=True):
        torch.testing.assert_close(one, other, atol=1e-10, rtol=0)


def test_the_convolution_learns_where_its_input_asks_for_no_gradient():
    """The first layer reads data; the same gradient of its weights must come out as with a gradient for the data."""
    torch.manual_seed(0)
    convolution = TemporalConvolution(7, 6, 4)
    without, with_gradient = clips(), clips().requires_grad_()
    found = [torch.autograd.grad(convolution(v).sin().sum(), convolution.weight)[0] for v in (without, with_gradient)]
    torch.testing.assert_close(*found)


def test_at_the_papers_size_it_has_39_214_592_parameters():
    """Pose of 300 values, kernel 25, 256 filters, dense layers of 2048, a code of 4 x 512."""
    convolutions = (25 * 300 * 256 + 256) + (25 * 256 * 256 + 256)
    dense = (240 // 4 * 256 * 2048 + 2048) + (2048 * 4 * 512 + 4 * 512)
    with torch.device("meta"):
        generator = FilmGenerator(300, 512, GeneratorSettings())
    assert sum(p.numel() for p in generator.parameters()) == convolutions + dense == 39_214_592


def test_it_is_the_papers_layers_in_a_row():
    torch.manual_seed(0)
    generator, values = FilmGenerator(7, 10, SMALL).eval(), clips()
    h = values.transpose(1, 2)
    for convolution in (generator.first, generator.second):
        h = functional.max_pool1d(functional.relu(by_torch(convolution, h.transpose(1, 2)).transpose(1, 2)), 2)
    flat = h.transpose(1, 2).flatten(1)
    expected = generator.code(functional.relu(generator.dense(flat)))
    torch.testing.assert_close(generator(values), expected, atol=1e-5, rtol=1e-5)


def test_a_neutral_start_gives_scales_near_one_and_shifts_near_nothing():
    torch.manual_seed(0)
    generator = FilmGenerator(7, 10, SMALL).eval()
    generator.start_neutral(spread=0.0)
    scale1, shift1, scale2, shift2 = split_code(generator(clips()))
    assert (scale1 == 1).all() and (scale2 == 1).all() and not shift1.any() and not shift2.any()


def test_a_neutral_start_lets_codes_differ_by_the_share_asked():
    def spread(share: float) -> float:
        torch.manual_seed(0)
        generator = FilmGenerator(7, 10, SMALL).eval()
        generator.start_neutral(share)
        return generator(clips()).detach().std(dim=0).mean().item()

    assert spread(0.3) == pytest.approx(0.3 * spread(1.0), rel=1e-4) and spread(0.3) > 0


def test_codes_depend_on_the_clip_and_not_on_its_neighbours_in_the_batch():
    torch.manual_seed(0)
    generator, values = FilmGenerator(7, 10, SMALL).eval(), clips()
    codes = generator(values)
    assert (codes[0] - codes[1]).abs().max() > 1e-3
    torch.testing.assert_close(generator(values[1:2]), codes[1:2])


def test_dropout_acts_in_training_only():
    torch.manual_seed(0)
    generator, values = FilmGenerator(7, 10, SMALL), clips()
    assert not torch.equal(generator.train()(values), generator(values))
    assert torch.equal(generator.eval()(values), generator(values))


def test_the_clamp_bounds_what_one_wild_value_does():
    torch.manual_seed(0)
    bounded = FilmGenerator(7, 10, GeneratorSettings(frames=16, filters=6, kernel=5, hidden=12, clamp=5.0)).eval()
    wild, wilder = clips(), clips()
    wild[0, 3, 2], wilder[0, 3, 2] = 50.0, 5000.0
    assert torch.equal(bounded(wild), bounded(wilder))


def test_with_the_leak_a_generator_learns_whose_filters_are_all_below_zero():
    """With plain rectifiers such a generator is dead: no gradient ever reaches its filters again."""

    def gradient(leak: float) -> float:
        torch.manual_seed(0)
        generator = FilmGenerator(7, 10, GeneratorSettings(frames=16, filters=6, kernel=5, hidden=12, leak=leak)).eval()
        torch.nn.init.constant_(generator.second.bias, -100.0)
        generator(clips()).sum().backward()
        assert generator.first.weight.grad is not None
        return float(generator.first.weight.grad.abs().max())

    assert gradient(0.0) == 0 and gradient(0.1) > 0


def test_mixed_precision_changes_codes_little_and_hands_back_float32():
    torch.manual_seed(0)
    generator, values = FilmGenerator(7, 10, SMALL).eval(), clips()
    exact = generator(values)
    with torch.autocast("cpu", dtype=torch.bfloat16):
        mixed = generator(values)
    assert mixed.dtype == torch.float32
    assert 0 < (mixed - exact).abs().max() < 0.05 * exact.abs().max()
