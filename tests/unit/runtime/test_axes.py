"""The functions for one frame give what those for whole takes give, to rounding."""

import numpy as np
import pytest

from stylephase.motion import rotations
from stylephase.motion.root import Root, rotate_to_local
from stylephase.runtime.axes import from_axes, root_axes
from stylephase.runtime.trajectory import on_ground, to_world

EXACT = 1e-14


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(4)


def test_axes_make_the_same_rotations(rng):
    forward, up = rng.normal(size=(2, 3, 25, 3))
    forward[0, 0] = up[1, 1] = 0
    np.testing.assert_allclose(from_axes(forward, up), rotations.from_axes(forward, up), atol=EXACT)


def test_axes_of_a_root_lead_to_the_world_and_back(rng):
    root, vectors = Root(np.zeros((4, 2)), rng.uniform(-4, 4, 4)), rng.normal(size=(4, 7, 3))
    np.testing.assert_allclose(root_axes(root), np.swapaxes(root.matrices, 1, 2), atol=EXACT)
    np.testing.assert_allclose(rotate_to_local(root, vectors @ root_axes(root)), vectors, atol=EXACT)


def test_samples_in_the_world_are_turned_and_only_places_are_moved(rng):
    root, samples = Root(rng.normal(size=(4, 2)), rng.uniform(-4, 4, 4)), rng.normal(size=(4, 6, 4))
    turned = [np.einsum("nij,npj->npi", on_ground(root.angles), part) for part in np.split(samples, 2, axis=-1)]
    expected = np.concatenate([turned[0] + root.positions[:, None], turned[1]], axis=-1)
    np.testing.assert_allclose(to_world(samples, root), expected, atol=EXACT)
