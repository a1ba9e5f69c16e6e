"""The motion autoencoder: sizes, what depooling does, and weights that come back."""

import pytest
import torch

from stylephase.errors import InputError
from stylephase.models.autoencoder import (
    AutoencoderSettings,
    MotionAutoencoder,
    load_autoencoder,
    save_autoencoder,
)


@pytest.fixture
def network() -> MotionAutoencoder:
    torch.manual_seed(0)
    return MotionAutoencoder(torch.arange(7.0), torch.full((7,), 2.0), AutoencoderSettings(5, 9)).eval()


def test_half_the_frames_are_encoded_and_all_come_back(network):
    motion = torch.randn(3, 7, 20)
    assert network.encode(motion).shape == (3, 5, 10)
    assert (network.encode(motion) >= 0).all()
    assert network(motion).shape == motion.shape


def test_in_use_both_frames_of_a_pair_take_half_and_in_training_one_takes_all(network):
    hidden = torch.rand(1, 5, 6)
    used = network.decode(hidden)
    torch.manual_seed(1)
    trained = torch.stack([network.train().decode(hidden) for _ in range(4000)])
    assert (trained[0] - trained[1]).abs().max() > 1e-3
    assert (trained.mean(dim=0) - used).abs().max() < 0.1


def test_the_mean_of_the_data_is_what_no_unit_decodes_to(network):
    torch.testing.assert_close(network.decode(torch.zeros(1, 5, 2)), torch.arange(7.0)[None, :, None].expand(1, 7, 4))


def test_saved_weights_come_back(network, tmp_path):
    save_autoencoder(tmp_path, network, {"data": "made"})
    motion = torch.randn(1, 7, 8)
    torch.testing.assert_close(load_autoencoder(tmp_path)(motion), network(motion))


def test_a_folder_without_weights_is_refused(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        load_autoencoder(tmp_path)
