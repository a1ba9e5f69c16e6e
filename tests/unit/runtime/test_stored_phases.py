"""A PFNN at stored phases is the PFNN at those phases."""

import math

import pytest
import torch

from stylephase.models.pfnn import Pfnn
from stylephase.models.synthesis import NetworkSettings, for_one_style
from stylephase.models.zoo import MODELS, Widths, build_synthesis, model
from stylephase.runtime.phases import PHASES, StoredPfnn

STYLES = 3


@pytest.mark.parametrize("name", [name for name in MODELS if model(name).backbone == "pfnn"])
def test_at_a_stored_phase_it_gives_what_the_network_gives(name):
    torch.manual_seed(0)
    network = build_synthesis(name, Widths(10, 1, 7, 12), STYLES, NetworkSettings(units=8)).eval()
    assert isinstance(network, Pfnn)
    for bias in (layer.bias for layer in network.layers):
        torch.nn.init.normal_(bias)
    values = network.modulator.values
    code = (torch.eye(STYLES)[[2]] if values == STYLES else torch.randn(1, values)).expand(4, -1)
    x, stored = torch.randn(4, 10), StoredPfnn(network, style=2)
    for k in (0, 13, 49):
        phase = 2 * math.pi * k / PHASES
        exact = network(x, torch.full((4, 1), phase), code)
        # Between two phases the nearest is taken, and the last is followed by the first.
        torch.testing.assert_close(stored(x, phase + 0.4 * 2 * math.pi / PHASES, code), exact, atol=1e-5, rtol=1e-5)
        torch.testing.assert_close(stored(x, phase - 2 * math.pi, code), exact, atol=1e-5, rtol=1e-5)


def test_a_one_hot_network_of_one_style_gives_what_the_whole_gives_for_it():
    torch.manual_seed(0)
    network = build_synthesis("lpn-onehot", Widths(10, 8, 7, 12), STYLES, NetworkSettings(units=8)).eval()
    x, p = torch.randn(4, 10), torch.randn(4, 8)
    for style, code in enumerate(torch.eye(STYLES)):
        alone = for_one_style(network, style)
        torch.testing.assert_close(alone(x, p, code.expand(4, -1)), network(x, p, code.expand(4, -1)))
        assert sum(t.numel() for t in alone.parameters()) < sum(t.numel() for t in network.parameters())
    film = build_synthesis("lpn-film", Widths(10, 8, 7, 12), STYLES, NetworkSettings(units=8))
    assert for_one_style(film, 0) is film
