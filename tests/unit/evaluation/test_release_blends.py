"""Blends of a bundle's own codes: pairs in order, walks for each, and hands that are followed."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import tiny_walker as tiny
import torch

from stylephase.evaluation import release_blends as blends_module
from stylephase.evaluation.release_blends import FIG_8, PAST_THE_TRUNK, ReleaseBlends, hand_to_trunk, release_blends
from stylephase.models.bundle import Bundle


@pytest.fixture(scope="module")
def bundle() -> Bundle:
    """Untrained weights with codes for the named pairs and some more styles."""
    rng = torch.Generator().manual_seed(1)
    names = [*FIG_8, *PAST_THE_TRUNK, "Drunk", "Neutral", "Zombie"]
    return replace(tiny.bundle(), codes={name: torch.randn(32, generator=rng) for name in names})


@pytest.fixture(scope="module")
def short() -> Iterator[None]:
    """Walks last as long as they must."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(blends_module, "_PURE_SECONDS", 9.0)
        patch.setattr(blends_module, "_BLEND_SECONDS", 3.2)
        yield


@pytest.fixture(scope="module")
def found(bundle, short) -> ReleaseBlends:
    return release_blends(bundle, 1)


def test_pairs_have_their_walks_in_order(bundle, found):
    assert found.pairs[:2] == [FIG_8, PAST_THE_TRUNK] and len(found.pairs) == len(found.blends) == 3
    assert not any("Drunk" in pair for pair in found.pairs)
    assert found.characters(PAST_THE_TRUNK) == range(11, 22) and found.run.positions.shape[1] == 33
    assert hand_to_trunk(bundle, found).shape == (11,) and (hand_to_trunk(bundle, found) >= 0).all()


def test_the_seed_draws_the_other_pairs(bundle, short, found):
    other = release_blends(bundle, 1, seed=3)
    assert found.pairs[:2] == other.pairs[:2] and found.pairs[2] != other.pairs[2]
    np.testing.assert_array_equal(found.run.positions[:, :22], other.run.positions[:, :22])
