"""Two bones reach for a point without changing their lengths."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stylephase.runtime.inverse_kinematics import eased, two_bones

_MIRROR = np.array([-1.0, 1.0, 1.0])


@pytest.fixture(scope="module")
def limbs(frozen) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Start, middle and end joint of many bent limbs, in any direction."""
    random = np.random.default_rng(3)
    start = random.normal(size=(200, 3))
    upper, lower = random.normal(size=(2, 200, 3))
    upper *= 0.4 / np.linalg.norm(upper, axis=1, keepdims=True)
    lower *= 0.3 / np.linalg.norm(lower, axis=1, keepdims=True)
    return frozen(start), frozen(start + upper), frozen(start + upper + lower)


@pytest.fixture(scope="module")
def targets(limbs) -> np.ndarray:
    """For each limb a target that it can reach."""
    random = np.random.default_rng(4)
    towards = random.normal(size=(200, 3))
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    return limbs[0] + towards * random.uniform(0.11, 0.68, size=(200, 1))


def _bent(limbs) -> np.ndarray:
    """The limbs that are less than 99 % stretched."""
    return np.linalg.norm(limbs[2] - limbs[0], axis=1) < 0.99 * 0.7


def test_a_limb_on_its_target_does_not_move(limbs):
    found, still = two_bones(*limbs, limbs[2]), _bent(limbs)
    assert still.sum() > 150
    np.testing.assert_allclose(found.middle[still], limbs[1][still], atol=1e-7)
    np.testing.assert_allclose(found.end[still], limbs[2][still], atol=1e-12)
    for turn in (found.upper_turn, found.lower_turn):
        np.testing.assert_allclose(turn[still], np.broadcast_to(np.eye(3), turn[still].shape), atol=1e-6)


def test_a_target_within_reach_is_reached(limbs, targets):
    np.testing.assert_allclose(two_bones(*limbs, targets).end, targets, atol=1e-9)


@pytest.mark.parametrize("far", [0.05, 0.5, 0.695, 0.7, 1.0, 1e6])
def test_lengths_are_kept_wherever_the_target_is(limbs, targets, far):
    way = targets - limbs[0]
    found = two_bones(*limbs, limbs[0] + far * way / np.linalg.norm(way, axis=1, keepdims=True))
    np.testing.assert_allclose(np.linalg.norm(found.middle - limbs[0], axis=1), 0.4, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(found.end - found.middle, axis=1), 0.3, atol=1e-9)


def test_turned_bones_lie_where_the_joints_are(limbs, targets):
    found = two_bones(*limbs, targets)
    upper = (found.upper_turn @ (limbs[1] - limbs[0])[..., None])[..., 0]
    lower = (found.lower_turn @ (limbs[2] - limbs[1])[..., None])[..., 0]
    np.testing.assert_allclose(limbs[0] + upper, found.middle, atol=1e-9)
    np.testing.assert_allclose(found.middle + lower, found.end, atol=1e-9)
    for turn in (found.upper_turn, found.lower_turn):
        np.testing.assert_allclose(turn @ np.swapaxes(turn, -1, -2), np.broadcast_to(np.eye(3), turn.shape), atol=1e-9)
        np.testing.assert_allclose(np.linalg.det(turn), 1, atol=1e-9)


def test_a_nearer_target_on_the_same_line_keeps_the_plane_of_the_bend(limbs):
    normal = np.cross(limbs[1] - limbs[0], limbs[2] - limbs[0])
    found = two_bones(*limbs, limbs[0] + 0.8 * (limbs[2] - limbs[0]))
    assert np.abs(((found.middle - limbs[0]) * normal).sum(axis=1)).max() < 1e-9
    assert (np.cross(found.middle - limbs[0], found.end - limbs[0]) * normal).sum(axis=1).min() > 0


def test_the_pole_says_to_which_side_a_straight_limb_bends():
    start, middle, end, target = (
        np.zeros(3),
        np.array([0, -0.4, 0.0]),
        np.array([0, -0.8, 0.0]),
        np.array([0, -0.7, 0.0]),
    )
    front = two_bones(start, middle, end, target, np.array([0.0, 0.0, 1.0]))
    back = two_bones(start, middle, end, target, np.array([0.0, 0.0, -1.0]))
    assert front.middle[2] > 0.1 and back.middle[2] < -0.1
    np.testing.assert_allclose(front.end, target, atol=1e-9)


@pytest.mark.parametrize("target", [[0, 0.5, 0], [0, 0, 0], [0, 0.8, 0]])
def test_opposite_and_empty_directions_have_an_answer(target):
    """A target straight behind the limb, and one on its start."""
    found = two_bones(np.zeros(3), np.array([0, -0.4, 0.0]), np.array([0, -0.8, 0.0]), np.array(target, dtype=float))
    assert np.isfinite(found.end).all() and np.isfinite(found.upper_turn).all()
    assert np.linalg.norm(found.middle) == pytest.approx(0.4, abs=1e-9)


def test_mirrored_limbs_reach_as_in_a_mirror(limbs, targets):
    found = two_bones(*limbs, targets)
    image = two_bones(limbs[0] * _MIRROR, limbs[1] * _MIRROR, limbs[2] * _MIRROR, targets * _MIRROR)
    np.testing.assert_allclose(image.middle, found.middle * _MIRROR, atol=1e-9)
    np.testing.assert_allclose(image.upper_turn, found.upper_turn * np.outer(_MIRROR, _MIRROR), atol=1e-9)


@given(st.floats(0.0, 3.0), st.floats(1e-4, 0.1))
def test_the_reach_grows_steadily_and_stays_below_the_length(distance, more):
    near, far = (float(eased(np.array([d]), np.array([1.0]))[0]) for d in (distance, distance + more))
    assert near <= far <= min(1.0, far + 1) and far - near <= more + 1e-12 and far <= 1.0


def test_a_limb_that_is_pulled_straight_does_not_snap():
    """The angle of the middle joint changes little from one millimetre to the next; cut off at its length, it snaps."""
    pulled = np.stack([np.zeros(200), -np.linspace(0.75, 0.95, 200), np.zeros(200)], axis=1)
    start, middle, end = np.zeros((200, 3)), np.tile([0, -0.35, 0.19], (200, 1)), np.tile([0, -0.7, 0.0], (200, 1))
    straight = np.linalg.norm(middle[0]) + np.linalg.norm(end[0] - middle[0])
    bend = two_bones(start, middle, end, pulled).middle[:, 2]
    hard = np.sqrt(np.maximum(0.25 * straight**2 - 0.25 * np.minimum(-pulled[:, 1], straight) ** 2, 0))
    assert np.abs(np.diff(bend, 2)).max() < 0.25 * np.abs(np.diff(hard, 2)).max()
