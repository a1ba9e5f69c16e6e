"""What a frame costs is told part by part, and poses are compared in millimetres."""

from dataclasses import replace

import numpy as np
import pytest
import tiny_walker as tiny

from stylephase.evaluation.bench.character import difference, frame_costs
from stylephase.runtime.plans import Steady
from stylephase.runtime.rollout import roll_out


def test_the_difference_of_two_rollouts_is_in_millimetres_and_blind_to_where_they_are():
    run = roll_out(tiny.bundle(network=tiny.Obedient()), tiny.codes(1), tiny.start([0]), 60, Steady(np.ones(1)))
    assert difference(run, replace(run, positions=run.positions + [0.0, 0.003, 0.0]), tiny.BODY) == pytest.approx(3.0)
    away = replace(run, positions=run.positions + [4.0, 0, 1.0], root_positions=run.root_positions + [4.0, 1.0])
    assert difference(run, away, tiny.BODY) == pytest.approx(0, abs=1e-6)


def test_costs_are_told_of_each_part():
    bundle = tiny.bundle()
    fast = {"fast": lambda x, p, code: np.zeros((1, bundle.layout.outputs))}
    found = frame_costs(bundle, bundle.code("Plain"), tiny.start([0]), fast, rounds=2, each=2)
    assert set(found) == {"frame", "finishing", "network", "fast"} and min(found.values()) >= 0
    assert found["fast"] < found["network"] < found["frame"]
