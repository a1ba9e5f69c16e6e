"""Dropout by one byte for one unit drops as often as it says, and keeps the mean."""

import pytest
import torch

from stylephase.models.dropout import dropout


@pytest.mark.parametrize("rate", [0.1, 0.3, 0.5])
def test_it_drops_at_its_rate_and_scales_the_rest(rate):
    """A million units: the share dropped lies within five standard errors of the rate in steps of 1/256."""
    torch.manual_seed(0)
    units = 1_000_000
    out = dropout(torch.ones(units), rate, True)
    rounded = round(256 * rate) / 256
    dropped = float((out == 0).double().mean())
    assert abs(dropped - rounded) < 5 * (rounded * (1 - rounded) / units) ** 0.5
    torch.testing.assert_close(out[out > 0].unique(), torch.tensor([1 / (1 - rounded)]))


def test_it_keeps_the_mean_of_each_unit():
    torch.manual_seed(0)
    h = torch.tensor([-2.0, 0.5, 3.0]).expand(200_000, 3)
    torch.testing.assert_close(dropout(h, 0.3, True).mean(dim=0), h[0], atol=0.03, rtol=0)


def test_units_are_dropped_one_by_one():
    """Neither rows nor columns go together: shares over rows and over columns hardly vary."""
    torch.manual_seed(0)
    dropped = (dropout(torch.ones(2000, 2000), 0.5, True) == 0).double()
    for dim in (0, 1):
        assert dropped.mean(dim=dim).std() == pytest.approx(0.5 / 2000**0.5, rel=0.1)


def test_two_draws_differ_and_the_same_seed_repeats():
    def draw(seed: int) -> torch.Tensor:
        torch.manual_seed(seed)
        return dropout(torch.ones(100), 0.5, True)

    assert torch.equal(draw(1), draw(1)) and not torch.equal(draw(1), draw(2))


@pytest.mark.parametrize(("rate", "training"), [(0.3, False), (0.0, True), (0.001, True)])
def test_it_leaves_values_alone_outside_training_and_at_rates_that_round_to_nothing(rate, training):
    h = torch.randn(100, generator=torch.Generator().manual_seed(0))
    assert torch.equal(dropout(h, rate, training), h)


def test_a_dropped_unit_has_no_gradient():
    torch.manual_seed(0)
    h = torch.ones(1000, requires_grad=True)
    out = dropout(h, 0.3, True)
    out.sum().backward()
    assert torch.equal(h.grad, out.detach())
