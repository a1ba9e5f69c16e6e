"""The path: samples in and out, how it bends, how it moves on, and that the world has no preferred direction."""

from itertools import pairwise

import numpy as np
import pytest

from stylephase.features.layout import INPUT_SAMPLES, OUTPUT_SAMPLES
from stylephase.motion.root import Root
from stylephase.runtime.trajectory import (
    FUTURE,
    PAST,
    Steering,
    Trajectory,
    advance,
    from_samples,
    on_ground,
    samples_of,
    steer,
    unit_ground,
)

EXACT = 1e-12
RELEASED = {"position_bias": 0.75, "direction_bias": 1.25, "reach": 50 / 60}
POINTS = np.arange(-PAST, FUTURE + 1)
AT = PAST + np.array(OUTPUT_SAMPLES)


def heading(angle: float) -> np.ndarray:
    return np.array([np.sin(angle), np.cos(angle)])


def straight(speed: float, angle: float = 0.0, x: float = 0.0, z: float = 0.0) -> Trajectory:
    """One character that walks along its facing at a speed (m/s)."""
    ahead = heading(angle)
    positions = np.array([x, z]) + POINTS[:, None] / 60 * speed * ahead
    return Trajectory(positions[None], np.tile(ahead, (1, len(POINTS), 1)))


def wandering(rng: np.random.Generator, characters: int = 3) -> tuple[np.ndarray, Root]:
    """Samples as they stand in an input x, of paths that bend in any way, and roots to put them at."""
    samples = rng.normal(size=(characters, len(INPUT_SAMPLES), 4))
    samples[..., 2:] /= np.linalg.norm(samples[..., 2:], axis=-1, keepdims=True)
    samples[:, INPUT_SAMPLES.index(0)] = [0, 0, 0, 1]
    root = Root(rng.normal(size=(characters, 2)), rng.uniform(-3, 3, characters))
    return samples.reshape(characters, -1), root


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(1)


class TestSamples:
    def test_a_path_through_samples_has_these_samples(self, rng):
        samples, root = wandering(rng)
        np.testing.assert_allclose(samples_of(from_samples(samples, root)), samples, atol=1e-9)

    def test_the_path_runs_through_the_root_that_it_was_given(self, rng):
        samples, root = wandering(rng)
        found = from_samples(samples, root).root
        np.testing.assert_allclose(found.positions, root.positions, atol=EXACT)
        np.testing.assert_allclose(found.angles, root.angles, atol=EXACT)

    def test_between_samples_it_is_straight_with_unit_directions(self, rng):
        samples, root = wandering(rng, 1)
        path = from_samples(samples, root)
        for before, after in pairwise(INPUT_SAMPLES):
            steps = np.diff(path.positions[0, PAST + before : PAST + after + 1], axis=0)
            np.testing.assert_allclose(steps, np.broadcast_to(steps[0], steps.shape), atol=1e-9)
        np.testing.assert_allclose(np.linalg.norm(path.directions, axis=-1), 1.0, atol=EXACT)

    def test_a_path_to_the_left_of_the_facing_has_positive_x(self):
        """Facing +x, 2 m/s towards -z: that is to the right, so x is negative, as seen from the root."""
        positions = np.array([5.0, 7.0]) + POINTS[:, None] / 60 * np.array([0.0, -2.0])
        path = Trajectory(positions[None], np.tile([1.0, 0.0], (1, len(POINTS), 1)))
        last = samples_of(path).reshape(len(INPUT_SAMPLES), 4)[-1]
        np.testing.assert_allclose(last, [2.0, 0.0, 0.0, 1.0], atol=EXACT)


class TestSteer:
    def test_what_goes_on_as_it_was_stays_straight(self):
        path = straight(1.3, angle=0.8, x=2.0, z=-1.0)
        same = steer(path, Steering(1.3 * heading(0.8)[None], np.array([0.8])), **RELEASED)
        np.testing.assert_allclose(same.positions, path.positions, atol=EXACT)
        np.testing.assert_allclose(same.directions, path.directions, atol=EXACT)

    def test_the_user_weighs_the_more_the_further_ahead(self):
        """The release's numbers: 1 - (1 - w)^0.75 for steps and ^1.25 for facing, w up to 5/6 after one second."""
        ahead = np.arange(1, 61) / 72
        found = steer(straight(0.0), Steering(np.array([[6.0, 0.0]]), np.array([np.pi / 2])), **RELEASED)
        steps = np.diff(found.positions[0, PAST:], axis=0)
        np.testing.assert_allclose(steps[:, 0], (1 - (1 - ahead) ** 0.75) * 0.1, atol=EXACT)
        np.testing.assert_allclose(steps[:, 1], 0.0, atol=EXACT)
        share = 1 - (1 - ahead) ** 1.25
        expected = np.stack([share, 1 - share], axis=1) / np.hypot(share, 1 - share)[:, None]
        np.testing.assert_allclose(found.directions[0, PAST + 1 :], expected, atol=EXACT)

    def test_past_and_root_stay_and_nothing_given_is_changed(self, frozen):
        path = straight(1.0)
        given = Trajectory(frozen(path.positions), frozen(path.directions))
        found = steer(given, Steering(np.array([[3.0, 1.0]]), np.array([1.0])), **RELEASED)
        np.testing.assert_array_equal(found.positions[:, : PAST + 1], path.positions[:, : PAST + 1])
        np.testing.assert_array_equal(found.directions[:, : PAST + 1], path.directions[:, : PAST + 1])

    def test_facing_the_opposite_way_keeps_unit_directions(self):
        """Halfway between two opposite facings there is none."""
        found = steer(straight(1.0), Steering(np.array([[0.0, -1.0]]), np.array([np.pi])), **RELEASED)
        np.testing.assert_allclose(np.linalg.norm(found.directions, axis=-1), 1.0, atol=EXACT)


def predicted(rng: np.random.Generator, characters: int = 2) -> np.ndarray:
    samples = rng.normal(size=(characters, len(OUTPUT_SAMPLES), 4))
    samples[..., 2:] /= np.linalg.norm(samples[..., 2:], axis=-1, keepdims=True)
    return samples


class TestAdvance:
    @pytest.fixture
    def path(self, rng) -> Trajectory:
        return from_samples(*wandering(rng, 2))

    def test_the_whole_step_is_taken_at_share_1_and_the_samples_follow_the_network(self, rng, path):
        samples = predicted(rng)
        found = advance(path, samples, 1.0, 1.0)
        np.testing.assert_allclose(found.positions[:, AT], samples[..., :2], atol=EXACT)
        np.testing.assert_allclose(found.directions[:, AT], samples[..., 2:], atol=EXACT)

    def test_at_share_0_the_samples_stay_where_they_are(self, rng, path):
        found = advance(path, predicted(rng), 0.0, 0.0)
        np.testing.assert_allclose(found.positions[:, AT], path.positions[:, AT], atol=EXACT)
        np.testing.assert_allclose(found.directions[:, AT], path.directions[:, AT], atol=EXACT)

    def test_root_and_path_have_a_share_each(self, rng, path):
        samples = predicted(rng)
        found = advance(path, samples, 0.85, 0.5).positions[:, AT]
        present = path.positions[:, AT]
        np.testing.assert_allclose(found[:, 0], 0.15 * present[:, 0] + 0.85 * samples[:, 0, :2], atol=EXACT)
        np.testing.assert_allclose(found[:, 1:], 0.5 * present[:, 1:] + 0.5 * samples[:, 1:, :2], atol=EXACT)

    def test_the_past_shifts_by_one_and_takes_in_the_old_root(self, rng, path):
        found = advance(path, predicted(rng), 1.0, 0.85)
        np.testing.assert_array_equal(found.positions[:, :PAST], path.positions[:, 1 : PAST + 1])
        np.testing.assert_allclose(found.directions[:, :PAST], path.directions[:, 1 : PAST + 1], atol=EXACT)

    def test_directions_stay_unit_and_between_samples_the_path_is_straight(self, rng, path):
        found = advance(path, predicted(rng), 1.0, 0.85)
        np.testing.assert_allclose(np.linalg.norm(found.directions, axis=-1), 1.0, atol=EXACT)
        steps = np.diff(found.positions[0, PAST : PAST + 13], axis=0)
        np.testing.assert_allclose(steps, np.broadcast_to(steps[0], steps.shape), atol=EXACT)

    def test_a_straight_walk_that_is_predicted_goes_straight_on(self):
        """What the data say of a walk at 1.2 m/s: the next root and its samples lie one step on."""
        path = straight(1.2)
        samples = np.stack([path.positions[:, AT] + [0, 1.2 / 60], path.directions[:, AT]], axis=2).reshape(1, -1, 4)
        found = advance(path, samples, 1.0, 0.85)
        np.testing.assert_allclose(found.positions[:, :-60], straight(1.2, z=1.2 / 60).positions[:, :-60], atol=EXACT)
        np.testing.assert_allclose(np.diff(found.positions[0, PAST:], axis=0)[12:, 1], 1.2 / 60, atol=1e-3)


def test_a_world_that_is_turned_turns_the_path(rng):
    """Steering and moving on commute with turning and shifting everything."""
    samples, root = wandering(rng, 2)
    velocity, facing, forward = rng.normal(size=(2, 2)), rng.uniform(-3, 3, 2), predicted(rng)
    angle, shift = 1.1, np.array([4.0, -2.0])
    turn = on_ground(np.array([angle]))[0]

    def run(root: Root, velocity: np.ndarray, facing: np.ndarray, forward: np.ndarray) -> Trajectory:
        return advance(steer(from_samples(samples, root), Steering(velocity, facing), **RELEASED), forward, 0.9, 0.7)

    here = run(root, velocity, facing, forward)
    there_root = Root(root.positions @ turn.T + shift, root.angles + angle)
    moved = np.concatenate([forward[..., :2] @ turn.T + shift, forward[..., 2:] @ turn.T], axis=-1)
    there = run(there_root, velocity @ turn.T, facing + angle, moved)
    np.testing.assert_allclose(there.positions, here.positions @ turn.T + shift, atol=1e-9)
    np.testing.assert_allclose(there.directions, here.directions @ turn.T, atol=1e-9)


def test_a_vector_without_length_gives_the_other():
    vectors, otherwise = np.array([[3.0, 4.0], [0.0, 0.0]]), np.array([[1.0, 0.0], [0.0, 1.0]])
    np.testing.assert_allclose(unit_ground(vectors, otherwise), [[0.6, 0.8], [0.0, 1.0]])
