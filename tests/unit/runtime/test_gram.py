"""Style transfer by Gram matrices, on an autoencoder that learned two styles of the walker."""

import numpy as np
import pytest
import torch
from tiny_walker import BODY, style_vectors

from stylephase.features.channels import Channels, channels_of
from stylephase.models.autoencoder import AutoencoderSettings, MotionAutoencoder
from stylephase.runtime.gram import GramSettings, anatomy_of, gram, gram_of, reconstructed, transfer
from stylephase.training.autoencoder import AutoencoderTraining, train_autoencoder

SETTINGS = GramSettings(steps=250, corrections=100)


def walk(style: str) -> Channels:
    return channels_of(style_vectors(style), np.arange(121), BODY.layout)


@pytest.fixture(scope="module")
def network() -> MotionAutoencoder:
    walks = {name: [channels_of(style_vectors(name), np.arange(500), BODY.layout)] for name in ("Plain", "StoopedOver")}
    how = AutoencoderTraining(steps=250, windows=4, frames=60, rate=3e-3, mixed=False)
    return train_autoencoder(walks, how, AutoencoderSettings(units=48, kernel=15))[0]


@pytest.fixture(scope="module")
def transferred(network) -> Channels:
    return transfer(network, walk("Plain"), gram_of(network, [walk("StoopedOver")]), anatomy_of(BODY), SETTINGS)


def test_a_gram_matrix_is_a_mean_of_products():
    hidden = torch.tensor([[1.0, 2.0], [0.0, 4.0]])
    torch.testing.assert_close(gram(hidden), torch.tensor([[2.5, 4.0], [4.0, 8.0]]))


def test_the_motion_goes_towards_the_style(network, transferred):
    """The null: the content itself, and the content through the autoencoder."""
    wanted = gram_of(network, [walk("StoopedOver")])

    def off(motion: Channels) -> float:
        return float((gram_of(network, [motion]) - wanted).square().mean())

    assert off(transferred) < 0.4 * off(walk("Plain"))
    old = reconstructed(network, walk("StoopedOver")).positions.mean(axis=0)
    distance = [np.linalg.norm(m.positions.mean(axis=0) - old) for m in (transferred, walk("Plain"))]
    assert distance[0] < 0.6 * distance[1]


def test_an_odd_frame_is_cut_off_and_contacts_are_the_content_s(transferred):
    assert len(transferred) == 120
    np.testing.assert_array_equal(transferred.contacts, walk("Plain").contacts[:120])


def test_the_path_is_the_content_s_at_another_speed(transferred):
    steps, content = transferred.steps, walk("Plain").steps[:120]
    np.testing.assert_allclose(steps[:, 2], content[:, 2])
    ratio = np.linalg.norm(steps[:, :2], axis=1).mean() / np.linalg.norm(content[:, :2], axis=1).mean()
    np.testing.assert_allclose(steps[:, :2], ratio * content[:, :2], atol=1e-9)
    assert ratio < 1


def test_corrections_bring_the_bones_nearer_to_their_length(network, transferred):
    anatomy = anatomy_of(BODY)
    loose = transfer(
        network, walk("Plain"), gram_of(network, [walk("StoopedOver")]), anatomy, GramSettings(steps=250, corrections=0)
    )
    parents, children = (list(column) for column in zip(*anatomy.bones, strict=True))

    def off(motion: Channels) -> float:
        lengths = np.linalg.norm(motion.positions[:, parents] - motion.positions[:, children], axis=-1)
        return float(np.abs(lengths - anatomy.lengths).mean())

    assert off(transferred) < 0.8 * off(loose)


def test_the_network_s_weights_stay(network):
    before = network.filters.clone()
    transfer(network, walk("Plain"), gram_of(network, [walk("Plain")]), anatomy_of(BODY), GramSettings(steps=2))
    torch.testing.assert_close(network.filters, before)
