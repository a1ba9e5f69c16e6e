"""Starts that are kept with weights: they are the network's own work, and no frame of the data."""

from dataclasses import replace

import numpy as np
import pytest
import tiny_walker as tiny

from stylephase.evaluation import starts
from stylephase.evaluation.rollouts import walking_speed
from stylephase.evaluation.starts import starts_from, walked_starts
from stylephase.runtime import speeds
from stylephase.runtime.trajectory import PAST
from stylephase.runtime.walkers import NetworkWalker


@pytest.fixture(autouse=True)
def hasty(monkeypatch) -> None:
    monkeypatch.setattr(speeds, "_SECONDS", 1.5)
    monkeypatch.setattr(starts, "_MOMENTS", (1.5, 2.0))
    monkeypatch.setattr(starts, "_ONWARDS", 1.0)


def test_a_start_is_a_walk_of_the_network_at_the_speed_of_its_data():
    bundle, style = tiny.bundle(network=tiny.Obedient()), replace(tiny.style_vectors(), style="Plain")
    found = walked_starts(bundle, [style])
    assert list(found) == ["Plain"]
    apart = np.linalg.norm(style.x - found["Plain"].x.numpy(), axis=1)
    assert apart.min() > 0.01
    walker = NetworkWalker(replace(bundle, starts=found))
    past = walker.start(bundle.code("Plain")[None]).path.positions[0, : PAST + 1]
    assert past[-1] - past[0] == pytest.approx([0.0, walking_speed(style)], abs=0.35)


def test_the_store_says_which_styles_and_who_bursts_gets_none():
    store = tiny.Store(replace(tiny.style_vectors(), style="Old"))
    bundle = tiny.bundle(network=tiny.Obedient())
    assert list(starts_from(bundle, store)) == ["Old"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(starts, "_off", lambda *_: np.array([np.inf]))
        assert starts_from(bundle, store) == {}
