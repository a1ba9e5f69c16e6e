"""Training of the motion autoencoder on the walker."""

import numpy as np
import pytest
from tiny_walker import BODY, style_vectors

from stylephase.errors import InputError
from stylephase.features.channels import Channels, channels_of
from stylephase.models.autoencoder import AutoencoderSettings
from stylephase.training.autoencoder import AutoencoderTraining, scale_of, train_autoencoder

HOW = AutoencoderTraining(steps=60, windows=4, frames=40, rate=3e-3, mixed=False)
SMALL = AutoencoderSettings(units=24, kernel=9)


@pytest.fixture(scope="module")
def walks() -> dict[str, list[Channels]]:
    return {name: [channels_of(style_vectors(name), np.arange(300), BODY.layout)] for name in ("Plain", "GiantStrides")}


def test_the_error_falls_and_a_seed_decides(walks):
    network, errors = train_autoencoder(walks, HOW, SMALL, seed=3)
    assert np.mean(errors[-10:]) < 0.3 * np.mean(errors[:3])
    assert not network.training
    assert train_autoencoder(walks, HOW, SMALL, seed=3)[1] == errors


def test_steps_are_not_centred_and_joints_share_a_deviation(walks):
    mean, std = scale_of(walks["Plain"][0].table)
    assert list(mean[-5:]) == [0, 0, 0, 0.5, 0.5]
    assert len(set(std[:-5])) == 1 and list(std[-2:]) == [0.5, 0.5]


def test_stretches_shorter_than_a_window_are_refused(walks):
    short = {"Plain": [walks["Plain"][0].at(slice(0, 30))]}
    with pytest.raises(InputError, match="lasts 40 frames"):
        train_autoencoder(short, HOW, SMALL)
