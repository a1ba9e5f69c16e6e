"""Holden's released PFNN, as control points of our layers."""

import shutil

import numpy as np
import pytest
import torch

from stylephase.errors import InputError
from stylephase.models import holden
from stylephase.models.released_pfnn import ReleasedPfnn, fetch_pfnn, load_pfnn, mirrored, spline_error


@pytest.fixture(scope="module")
def folder(mirror, tmp_path_factory):
    """The released arrays, unpacked."""
    if not (mirror / "pfnn-release.npz").exists():
        pytest.skip("needs the release: pfnn-release.npz is not in the mirror")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("STYLEPHASE_MIRROR", str(mirror))
        patch.setenv("STYLEPHASE_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield fetch_pfnn()


def test_our_spline_gives_the_weights_that_the_release_stores(folder):
    assert spline_error(load_pfnn(folder), folder) < 3e-6


def test_a_wrong_spline_would_be_seen(folder):
    released = load_pfnn(folder)
    with torch.no_grad():
        released.network.layers[2].weight.copy_(released.network.layers[2].weight.roll(1, 0))
    assert spline_error(released, folder) > 1e-2


def test_the_statistics_are_a_person_in_metres(folder):
    mean = load_pfnn(folder).y_mean
    joints = mean[holden.Y_POSITIONS].reshape(holden.JOINTS, 3)
    assert joints[holden.HIPS] == pytest.approx([0, 0.93, 0], abs=0.01)
    left, right = joints[list(holden.TOES)]
    assert left[0] == pytest.approx(0.10, abs=0.01) and right[0] == pytest.approx(-0.10, abs=0.01)
    assert mean[holden.Y_STEP][1] * 60 == pytest.approx(0.74, abs=0.01)
    heels_and_toes = mean[holden.Y_CONTACTS]
    assert (heels_and_toes[1::2] > heels_and_toes[0::2]).all()


def test_the_mirrored_network_mirrors_what_it_gives(folder):
    """With half a cycle between, as left and right are half a cycle apart."""
    released = load_pfnn(folder)
    turned, x = mirrored(released), np.random.default_rng(0).normal(size=(4, holden.INPUTS))
    x = released.x_mean + released.x_std * x
    (x_at, x_signs), (y_at, y_signs) = holden.x_mirror(), holden.y_mirror()
    expected = y_signs * outputs(released, x_signs * x[:, x_at], 1.0 + np.pi)[:, y_at]
    np.testing.assert_allclose(outputs(turned, x, 1.0), expected, atol=1e-4)
    assert np.abs(outputs(released, x, 1.0) - expected).max() > 0.1


def outputs(released: ReleasedPfnn, x: np.ndarray, phase: float) -> np.ndarray:
    scaled = torch.from_numpy((x - released.x_mean) / released.x_std).float()
    with torch.inference_mode():
        y = released.network(scaled, torch.full((len(x), 1), phase), torch.zeros(len(x), 0)).double().numpy()
    return y * released.y_std + released.y_mean


def test_arrays_that_are_missing_or_do_not_fit_are_named(folder, tmp_path):
    with pytest.raises(InputError, match=r"W0\.npy: no such file"):
        load_pfnn(tmp_path)
    shutil.copytree(folder, tmp_path / "copy")
    np.save(tmp_path / "copy/b1.npy", np.zeros((4, 511), np.float32))
    with pytest.raises(InputError, match=r"b1\.npy: expected an array of shape \(4, 512\), found \(4, 511\)"):
        load_pfnn(tmp_path / "copy")
