"""The check of the released network finds what it should find, on a small network in its place."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from stylephase.errors import InputError
from stylephase.evaluation.release import Golden, compare, made_golden, read_golden
from stylephase.features.normaliser import Normaliser
from stylephase.models.lpn import NetworkSettings, SynthesisNetwork
from stylephase.models.released import STYLES, Released, fetch_released

KEYS = {"x": "x", "p": "phases", "styles": "style", "gate": "gate"}


@pytest.fixture(scope="module")
def released() -> Released:
    """A network of the release's widths with few hidden units, biases and codes drawn at random."""
    torch.manual_seed(0)
    network = SynthesisNetwork(348, 8, 342, NetworkSettings(units=16, gating_units=32)).eval()
    for layer in network.layers:
        torch.nn.init.normal_(layer.bias)
    rng = np.random.default_rng(0)
    statistics = Normaliser(*(rng.uniform(0.5, 2.0, width) for width in (348, 348, 8, 8, 342, 342)))
    return Released(network, statistics, torch.randn(STYLES, 64))


def write(path, golden: Golden, **changes: np.ndarray):
    arrays = {key: getattr(golden, name) for name, key in KEYS.items()}
    arrays |= {"y_demo_ln": golden.y["demo"], "y_train_ln": golden.y["training"]}
    np.savez(path, **arrays | changes)
    return path


def test_our_network_agrees_with_the_plain_form(released):
    found = compare(released, made_golden(released))
    assert all(one.holds for one in found)
    assert len(found) == 2 * (1 + 2 * 8) and max(one.absolute for one in found) < 1e-4


def test_the_two_normalisations_are_told_apart(released):
    golden = made_golden(released)
    swapped = replace(golden, y={"demo": golden.y["training"], "training": golden.y["demo"]})
    assert not all(one.holds for one in compare(released, swapped))


@pytest.mark.parametrize(("column", "part"), [(2, "trajectory"), (24, "positions"), (330, "phases"), (341, "contacts")])
def test_an_error_is_found_in_its_part(released, column, part):
    golden = made_golden(released)
    golden.y["demo"][3, column] += 1e-3
    wrong = {one.part for one in compare(released, golden) if not one.holds}
    assert wrong == {part}


def test_recorded_values_come_back_from_their_file(released, tmp_path):
    golden = made_golden(released)
    found = read_golden(write(tmp_path / "golden.npz", golden))
    np.testing.assert_array_equal(found.y["training"], golden.y["training"])
    np.testing.assert_array_equal(found.styles, golden.styles)


def test_a_file_that_does_not_fit_is_refused(released, tmp_path):
    golden = made_golden(released)
    with pytest.raises(InputError, match=r"golden\.npz: x: expected numbers of shape \(6, 348\), found \(6, 347\)"):
        read_golden(write(tmp_path / "golden.npz", golden, x=golden.x[:, 1:]))
    with pytest.raises(InputError, match="style: expected numbers from 0 to 99"):
        read_golden(write(tmp_path / "golden.npz", golden, style=golden.styles + 50))
    np.savez(tmp_path / "few.npz", x=golden.x)
    with pytest.raises(InputError, match=r"few\.npz: lacks recorded values: phases"):
        read_golden(tmp_path / "few.npz")
    (tmp_path / "text.npz").write_text("x")
    with pytest.raises(InputError, match=r"text\.npz: not a file of NumPy arrays"):
        read_golden(tmp_path / "text.npz")
    with pytest.raises(InputError, match=r"none\.npz: no such file"):
        read_golden(tmp_path / "none.npz")


def test_the_release_itself_agrees(mirror, monkeypatch, cache):
    if not (mirror / "local-phases-release.tar.xz").exists():
        pytest.skip("needs the release: local-phases-release.tar.xz is not in the mirror")
    monkeypatch.setenv("STYLEPHASE_MIRROR", str(mirror))
    released = fetch_released()
    assert all(one.holds for one in compare(released, made_golden(released)))
