"""A controller on a given path: what its network is told, and where it goes."""

import numpy as np
import pytest
from tiny_walker import BODY, bundle, style_vectors

from stylephase.evaluation.rollouts import codes_of, start_of
from stylephase.features.layout import INPUT_SAMPLES
from stylephase.motion.root import Root
from stylephase.runtime.controller import Controller
from stylephase.runtime.led import roll_out_led


@pytest.fixture
def seen(monkeypatch) -> list[np.ndarray]:
    """The inputs that the network was given."""
    inputs, predict = [], Controller.predict

    def noting(self, x, p):
        inputs.append(x.copy())
        return predict(self, x, p)

    monkeypatch.setattr(Controller, "predict", noting)
    return inputs


def test_the_network_is_told_the_coming_second_of_the_path(seen):
    weights, style = bundle("Plain"), style_vectors("Plain")
    angles = np.linspace(0, 1.5, 150)
    path = Root(np.cumsum(np.stack([np.sin(angles), np.cos(angles)], axis=1) / 50, axis=0), angles)
    run = roll_out_led(weights, codes_of(weights, [style]), start_of([style], BODY), [path])
    assert len(run) == 150
    ahead = INPUT_SAMPLES.index(60)
    # A second ahead of frame 40 the path is where it is at frame 100, whatever the character did until then.
    root = Root(run.root_positions[39:40, 0], run.root_angles[39:40, 0])
    told = seen[40][0, 4 * ahead : 4 * ahead + 4]
    place = root.positions[0] + root.matrices[0][::2, ::2] @ told[:2]
    np.testing.assert_allclose(place, path.positions[100], atol=1e-6)
    facing = root.angles[0] + np.arctan2(told[2], told[3])
    assert np.cos(facing - angles[100]) == pytest.approx(1.0, abs=1e-6)


def test_past_its_end_a_path_goes_on_straight(seen):
    weights, style = bundle("Plain"), style_vectors("Plain")
    path = Root(np.stack([np.zeros(70), np.arange(70) / 50], axis=1), np.zeros(70))
    roll_out_led(weights, codes_of(weights, [style]), start_of([style], BODY), [path])
    ahead = INPUT_SAMPLES.index(60)
    speeds = [np.linalg.norm(x[0, 4 * ahead : 4 * ahead + 2] - x[0, 4 * ahead - 4 : 4 * ahead - 2]) for x in seen[-3:]]
    assert np.isfinite(speeds).all() and min(speeds) > 0.1
