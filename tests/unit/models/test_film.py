"""Feature-wise linear modulation is Eq. 3 of [M22], with the code's parts in the release's order."""

import math

import torch
from torch.nn import functional

from stylephase.models.film import film, film_in_training, split_code


def rows(*shape: int) -> torch.Tensor:
    return torch.randn(*shape, dtype=torch.float64, generator=torch.Generator().manual_seed(3))


def test_without_modulation_it_is_layer_normalisation_and_elu():
    h = 5 + 3 * rows(6, 40)
    plain = functional.elu(functional.layer_norm(h, (40,)))
    torch.testing.assert_close(film(h, torch.ones_like(h), torch.zeros_like(h)), plain, atol=1e-4, rtol=0)


def test_it_is_equation_3_written_out():
    """By hand for every unit: (h - mean) / deviation of the row, times scale, plus shift, then ELU."""
    h, scale, shift = 2 + rows(3, 5), rows(3, 5) * 2 - 1, rows(3, 5) + 0.5
    for r in range(3):
        values = h[r].tolist()
        mean = sum(values) / 5
        deviation = math.sqrt(sum((value - mean) ** 2 for value in values) / 5)
        for u in range(5):
            z = float(scale[r, u]) * (values[u] - mean) / deviation + float(shift[r, u])
            expected = z if z > 0 else math.exp(z) - 1
            assert math.isclose(float(film(h, scale, shift)[r, u]), expected, rel_tol=1e-6, abs_tol=1e-6)


def test_a_scale_of_nothing_leaves_the_shift():
    """The scale is plain, not 1 + scale."""
    h, shift = rows(4, 8), rows(4, 8) + 3
    torch.testing.assert_close(film(h, torch.zeros_like(h), shift), functional.elu(shift))


def test_the_form_of_the_training_has_the_deviation_of_the_sample():
    """n - 1 for n, so normalised values are smaller by that root; the difference vanishes with width."""
    h, one, zero = 5 + 3 * rows(6, 40), torch.ones(6, 40).double(), torch.zeros(6, 40).double()
    smaller = film(h, (39 / 40) ** 0.5 * one, zero)
    torch.testing.assert_close(film_in_training(h, one, zero), smaller, atol=1e-5, rtol=0)


def test_equal_units_give_finite_values_and_gradients():
    h = torch.full((2, 8), 1.5, dtype=torch.float64, requires_grad=True)
    out = film(h, torch.ones(2, 8).double(), torch.zeros(2, 8).double())
    out.sum().backward()
    assert out.isfinite().all() and h.grad is not None and h.grad.isfinite().all()


def test_a_code_is_scale_1_shift_1_scale_2_shift_2():
    code = torch.arange(12.0).expand(2, 12)
    assert [part[1].tolist() for part in split_code(code)] == [[0, 1, 2], [3, 4, 5], [6, 7, 8], [9, 10, 11]]
