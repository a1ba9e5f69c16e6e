"""A small trained model that was never trained, to write and read."""

import numpy as np
import pytest
import torch

from stylephase.features.body import Body
from stylephase.features.normaliser import Normaliser
from stylephase.models.bundle import Bundle, build_network
from stylephase.models.generator import GeneratorSettings
from stylephase.models.lpn import NetworkSettings
from stylephase.motion.synthetic import SKELETON

SMALL = NetworkSettings(experts=2, units=8, gating_units=4, generator=GeneratorSettings(filters=2, kernel=3, hidden=4))


@pytest.fixture(scope="session")
def bundle() -> Bundle:
    """Two styles on the walker's body, with random weights, statistics and codes."""
    torch.manual_seed(0)
    rng = np.random.default_rng(0)
    body = Body(SKELETON, np.tile(np.eye(3), (len(SKELETON), 1, 1)))
    widths = (body.layout.inputs, body.layout.gate_inputs, body.layout.outputs)
    normaliser = Normaliser(*(rng.uniform(0.5, 2.0, width) for width in np.repeat(widths, 2)))
    codes = {"Plain": torch.randn(32), "Very old": torch.randn(32)}
    about = {"data": "made", "preset": "small", "seed": 3}
    return Bundle("lpn-film", build_network("lpn-film", body, 2, SMALL).eval(), SMALL, body, normaliser, codes, about)
