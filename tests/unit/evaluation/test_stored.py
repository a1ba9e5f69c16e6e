"""What a stored vector would miss: nothing of what is always the same, all of what has no mean."""

import numpy as np
import pytest

from stylephase.errors import InputError
from stylephase.evaluation import stored
from stylephase.models.bundle import load_bundle


def test_a_constant_is_not_missed_and_what_has_no_mean_is():
    wave = np.sin(np.linspace(0, 2 * np.pi, 60, endpoint=False))[:, None]
    assert stored.left_out(np.ones((60, 3))) == pytest.approx(0.0)
    assert stored.left_out(wave) == pytest.approx(1.0)
    assert 0.1 < stored.left_out(1.0 + wave) < 0.9


def test_weights_without_adapters_are_refused(root):
    with pytest.raises(InputError, match="no adapters"):
        stored.missed_by_a_stored_vector(load_bundle(root / "data/pretrained/bandai-namco"))
