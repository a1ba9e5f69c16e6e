"""The authors' released weights run through this network as they do through theirs."""

import tarfile
from pathlib import Path

import numpy as np
import pytest
import torch

from stylephase.errors import InputError
from stylephase.models.film import split_code
from stylephase.models.lpn import SynthesisNetwork
from stylephase.models.released import Released, load_released

_FOLDER = "local-phases/animation-demo/Unity/Assets/Demo/Parameters/LPN/"
_NEUTRAL, _DRUNK = 50, 23


@pytest.fixture(scope="module")
def folder(mirror, tmp_path_factory) -> Path:
    """The release's parameters, unpacked."""
    path = mirror / "local-phases-release.tar.xz"
    if not path.exists():
        pytest.skip("needs the release: local-phases-release.tar.xz is not in the mirror")
    top = tmp_path_factory.mktemp("release")
    with tarfile.open(path) as archive:
        members = [member for member in archive if member.name.startswith(_FOLDER)]
        archive.extractall(top, members, filter="data")
    return top / _FOLDER


@pytest.fixture(scope="module")
def released(folder) -> Released:
    """The release in float64, so that only its own float32 rounding is left."""
    found = load_released(folder)
    return Released(found.network.double(), found.normaliser, found.codes.double())


def inputs(width: int, phases: int) -> tuple[torch.Tensor, torch.Tensor]:
    """Normalised inputs made from waves, as in the recorded check."""
    x, p = 0.1 * np.sin(np.arange(width)), np.cos(np.arange(phases))
    return torch.from_numpy(x)[None], torch.from_numpy(p)[None]


def metric(released: Released, y: torch.Tensor) -> np.ndarray:
    return y.detach().numpy() * released.normaliser.y_std + released.normaliser.y_mean


def test_gates_and_outputs_are_those_recorded_from_an_independent_implementation(released):
    """The outputs were recorded with the training's layer normalisation, which the run time's follows closely."""
    (x, p), code = inputs(348, 8), released.codes[_NEUTRAL : _NEUTRAL + 1]
    gate = released.network.gating(p)[0].detach().numpy()
    np.testing.assert_allclose(
        gate, [0.11530, 0.12987, 0.10251, 0.14321, 0.21499, 0.06432, 0.10691, 0.12291], atol=1e-5
    )
    recorded = [-9.789e-05, 1.3102e-03, 2.5105e-03]
    np.testing.assert_allclose(metric(released, trained(released, x, p, code))[0, :3], recorded, atol=5e-8)
    np.testing.assert_allclose(metric(released, released.network(x, p, code))[0, :3], recorded, atol=5e-6)


def test_the_mean_input_gives_a_body(released):
    """Forward and up of every joint are nearly unit vectors at right angles, in every style but the broken one."""
    kept = [style for style in range(len(released.codes)) if style != _DRUNK]
    x, p = (torch.zeros(len(kept), width, dtype=torch.float64) for width in (348, 8))
    y = metric(released, released.network(x, p, released.codes[kept]))
    joints = y[:, 24:324].reshape(len(kept), 25, 4, 3)
    forward, up = joints[:, :, 1], joints[:, :, 2]
    assert np.linalg.norm(forward, axis=-1).mean() == pytest.approx(0.96, abs=0.02)
    assert np.linalg.norm(up, axis=-1).mean() == pytest.approx(0.96, abs=0.02)
    assert abs((forward * up).sum(axis=-1)).mean() < 0.05


def test_the_deviation_of_the_sample_or_of_the_population_matters_little(released):
    """The release trains with the one and runs with the other; outputs differ by less than 2e-3 in their own units."""
    x, p = (part.expand(3, -1) for part in inputs(348, 8))
    codes = released.codes[[_NEUTRAL, 80, 94]]
    difference = np.abs(
        metric(released, released.network(x, p, codes)) - metric(released, trained(released, x, p, codes))
    )
    assert 1e-5 < difference.max() < 2e-3


def trained(released: Released, x: torch.Tensor, p: torch.Tensor, codes: torch.Tensor) -> torch.Tensor:
    """The network as it was trained: normalised by the sample's deviation plus 1e-6."""
    network: SynthesisNetwork = released.network
    gate, (scale1, shift1, scale2, shift2), h = network.gating(p), split_code(codes), x
    for layer, scale, shift in zip(network.layers, (scale1, scale2), (shift1, shift2), strict=False):
        h = layer(h, gate)
        h = (h - h.mean(dim=1, keepdim=True)) / (h.std(dim=1, keepdim=True) + 1e-6)
        h = torch.nn.functional.elu(scale * h + shift)
    return network.layers[2](h, gate)


def test_it_has_the_papers_number_of_parameters_and_a_code_for_each_style(released):
    assert sum(p.numel() for p in released.network.parameters()) == 4_935_928
    assert released.codes.shape == (100, 2048) and not released.network.training


# Bad input, without the release


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"wc0_w\.bin: no such file"):
        load_released(tmp_path)


def test_a_file_of_another_size_is_named(tmp_path):
    (tmp_path / "wc0_w.bin").write_bytes(bytes(100))
    with pytest.raises(InputError, match=r"wc0_w\.bin: expected 1024 bytes, found 100"):
        load_released(tmp_path)
