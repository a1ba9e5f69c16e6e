"""Random steering asks for what a gait allows, for each character its own, and always the same."""

import numpy as np
import pytest

from stylephase.runtime.controller import State
from stylephase.runtime.random_steering import Gait, RandomSteering
from stylephase.runtime.trajectory import Trajectory

_FRAMES, _NAMES = 3000, ("Neutral", "Old", "Zombie")


def _facing_x() -> State:
    """A character at the origin that faces +x."""
    path = Trajectory(np.zeros((1, 121, 2)), np.tile([1.0, 0.0], (1, 121, 1)))
    joint, phases = np.zeros((1, 1, 3)), np.zeros((1, 8))
    return State(path, joint, np.eye(3)[None, None], joint, phases, np.zeros((1, 2)))


@pytest.fixture(scope="module")
def mixed() -> RandomSteering:
    return RandomSteering(Gait("TR2", 1.0, (2.0, 5.0), (0.0, np.pi / 2), turn=0.8, stops=0.2), _NAMES, _FRAMES)


def test_speeds_and_turns_stay_within_the_gait(mixed):
    speed = np.linalg.norm(mixed.velocities, axis=-1)
    assert speed.max() <= 5.0 + 1e-9 and (speed[200:] < 1e-9).mean() > 0.02
    assert 0.5 < np.abs(mixed.turns).max() <= 0.8 and (np.abs(mixed.turns) < 1e-9).mean() > 0.2


def test_wishes_change_smoothly(mixed):
    """A stop from the highest speed takes 0.4 s."""
    assert np.linalg.norm(np.diff(mixed.velocities, axis=0), axis=-1).max() < 2 * 5.0 / 24 + 1e-9
    assert np.abs(np.diff(mixed.turns, axis=0)).max() < 2 * 0.8 / 24 + 1e-9


def test_a_character_is_steered_alike_whoever_walks_beside_it(mixed):
    alone = RandomSteering(Gait("TR2", 1.0, (2.0, 5.0), (0.0, np.pi / 2), turn=0.8, stops=0.2), ("Old",), _FRAMES)
    np.testing.assert_array_equal(alone.velocities[:, 0], mixed.velocities[:, 1])
    assert np.abs(mixed.velocities[:, 0] - mixed.velocities[:, 1]).max() > 1


def test_another_seed_or_gait_is_another_walk(mixed):
    gait = Gait("TR2", 1.0, (2.0, 5.0), (0.0, np.pi / 2), turn=0.8, stops=0.2)
    seeded = RandomSteering(gait, _NAMES, _FRAMES, seed=1)
    named = RandomSteering(Gait(**(vars(gait) | {"name": "TR1"})), _NAMES, _FRAMES)
    for other in (seeded, named):
        assert np.abs(other.velocities - mixed.velocities).max() > 1


@pytest.mark.parametrize(("way", "expected"), [(0.0, [1, 0]), (np.pi, [-1, 0]), (np.pi / 2, [0, -1])])
def test_the_way_is_told_from_the_facing(way, expected):
    """One who faces +x: ahead is +x, back -x, left -z."""
    plan = RandomSteering(Gait("FW", 1.0, (3.0, 3.0), (way,), turn=0.0), ("Old",), 10)
    wanted = plan(5, _facing_x())
    np.testing.assert_allclose(wanted.velocity[0] / 3.0, expected, atol=1e-9)
    np.testing.assert_allclose(wanted.facing, [np.pi / 2])
