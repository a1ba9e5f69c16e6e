"""New styles from more walks than one: so many cycles, and none of what is learned is tested on."""

import numpy as np
import pytest

from stylephase.data.catalogue import load_catalogue
from stylephase.errors import InputError
from stylephase.evaluation.new_clips import long_style
from stylephase.features.clips import WALKS
from stylephase.features.cycles import cycles_of
from stylephase.features.store import VectorStore


@pytest.fixture(scope="module")
def store() -> VectorStore:
    return VectorStore(load_catalogue("synthetic", ["Plain"]), "adaptive")


def test_as_many_cycles_as_asked_for_are_learned_from_walks_alone(store):
    found = long_style(store, "Plain", 3)
    takes = np.unique(found.clip.take).tolist()
    assert sum(len(cycles_of(found.clip, take)) for take in takes) >= 3
    assert all(gait in WALKS for gait in found.clip.gaits) and len(found.clip.gaits) == len(takes)
    for unseen in found.unseen.values():
        assert not any(np.array_equal(unseen.x[0], row) for row in found.clip.x)


def test_more_cycles_than_there_are_is_bad_input(store):
    with pytest.raises(InputError, match="fewer than the 9999 cycles"):
        long_style(store, "Plain", 9999)
