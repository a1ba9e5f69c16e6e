"""A character moves as its standing foot lets it."""

from dataclasses import replace

import numpy as np
import pytest

from stylephase.evaluation.bench.frames import made_bundle
from stylephase.models.bundle import Bundle
from stylephase.models.lpn import NetworkSettings
from stylephase.runtime.controller import State, input_of, start_state
from stylephase.runtime.grounding import ground
from stylephase.runtime.rig import Rig, rig_of


@pytest.fixture(scope="module")
def bundle() -> Bundle:
    return made_bundle(NetworkSettings(experts=2, units=8, gating_units=4))


@pytest.fixture(scope="module")
def rig(bundle) -> Rig:
    return rig_of(bundle.body)


def _standing(bundle: Bundle, contacts: list[float]) -> State:
    """Two characters that hold still, with these contacts."""
    x = np.tile(bundle.normaliser.x_mean, (2, 1))
    state = start_state(x, np.zeros((2, 8)), bundle.body.layout)
    return replace(state, contacts=np.tile(contacts, (2, 1)), velocities=0 * state.velocities)


def _slid(state: State, metres: float) -> State:
    return replace(state, positions=state.positions + np.array([metres, 0.0, 0.0]))


def test_a_body_that_slides_over_a_standing_foot_is_held_back(bundle, rig):
    state, slide, ways = _standing(bundle, [1.0, 0.0]), None, []
    for _ in range(60):
        after, slide = ground(rig, state, _slid(state, 0.005), slide)
        ways.append(after.positions[0, 0, 0] - state.positions[0, 0, 0])
        state = after
    assert ways[0] > 0.003 and abs(ways[-1]) < 1e-6
    np.testing.assert_allclose(slide, [[0.3, 0.0]] * 2, atol=1e-4)


def test_a_foot_that_is_meant_to_move_may(bundle, rig):
    state = _standing(bundle, [1.0, 1.0])
    after = replace(_slid(state, 0.005), velocities=state.velocities + np.array([0.3, 0.0, 0.0]))
    moved, slide = ground(rig, state, after)
    np.testing.assert_allclose(moved.positions, after.positions, atol=1e-12)
    np.testing.assert_allclose(slide, 0, atol=1e-9)


def test_without_a_foot_on_the_ground_the_last_slide_goes_on(bundle, rig):
    state, known = _standing(bundle, [0.0, 0.0]), np.array([[0.3, 0.0], [0.0, 0.6]])
    moved, slide = ground(rig, state, _slid(state, 0.005), known)
    np.testing.assert_array_equal(slide, known)
    np.testing.assert_allclose((moved.positions - state.positions)[:, 0], [[0, 0, 0], [0.005, 0, -0.01]], atol=1e-12)


def test_the_network_sees_no_difference(bundle, rig):
    """Path and pose move together, and heights stay."""
    state = _standing(bundle, [1.0, 0.5])
    after = _slid(state, 0.02)
    moved, _ = ground(rig, state, after)
    assert np.abs(moved.positions - after.positions)[..., [0, 2]].max() > 1e-3
    np.testing.assert_array_equal(moved.positions[..., 1], after.positions[..., 1])
    np.testing.assert_allclose(input_of(moved), input_of(after), atol=1e-9)
