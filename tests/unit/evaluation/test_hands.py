"""Measures of hands, collar bones and feet on made-up motion with known answers."""

import numpy as np
import pytest
from tiny_training import BODY

from stylephase.errors import InputError
from stylephase.evaluation.collars import collar_joints, collars_of, most_unusual
from stylephase.evaluation.feet import foot_use
from stylephase.evaluation.hands import (
    half_ratios,
    hands_of,
    least_spread,
    spectrum,
    spread,
    stuck_below,
    tied,
    together,
)
from stylephase.evaluation.limbs import hand_paths, seen_from
from stylephase.evaluation.stretches import Stretch
from stylephase.motion.root import turn

LAYOUT, SECOND = BODY.layout, 60
CYCLE, OWN = 0.9, 1.4


def time(seconds: float = 16.0) -> np.ndarray:
    return np.arange(int(seconds * SECOND)) / SECOND


def still(frames: int) -> np.ndarray:
    """Poses (frames, joints, 4, 3) of a body that stands, each joint at a place of its own, axes as at rest."""
    poses = np.zeros((frames, LAYOUT.joints, 4, 3))
    poses[:, :, 0] = np.random.default_rng(1).uniform(0.1, 1.5, (LAYOUT.joints, 3))
    poses[..., 1, 2] = poses[..., 2, 1] = 1.0
    return poses


def swinging(frequency: float, amplitude: float = 0.2, seconds: float = 16.0) -> Stretch:
    """Both hands swing at a frequency (Hz), the feet keep a cycle of their own."""
    t = time(seconds)
    poses = still(len(t))
    poses[:, list(LAYOUT.effectors[:2]), 0, 2] += amplitude * np.sin(2 * np.pi * frequency * t)[:, None] * [1, -1]
    phase = np.mod(2 * np.pi * CYCLE * t, 2 * np.pi)
    return Stretch(poses.reshape(len(t), -1), phase, np.stack([phase < 3.5, phase > 3.0], axis=1))


def test_a_joint_is_seen_from_another_s_axes():
    """A body that turns as a whole looks the same from its hips."""
    poses = still(50)
    turned = np.einsum("tij,tnkj->tnki", turn(np.linspace(0, 3, 50)), poses)
    one, other = (seen_from(p.reshape(50, -1), 0, [3, 7]) for p in (poses, turned))
    np.testing.assert_allclose(one, other, atol=1e-12)
    np.testing.assert_allclose(one[:, 0], poses[:, 3, 0] - poses[:, 0, 0], atol=1e-12)


def test_spread_is_the_distance_from_the_mean_place():
    path = hand_paths(swinging(OWN, amplitude=0.2).poses, LAYOUT)
    np.testing.assert_allclose(spread(path), 0.2 / np.sqrt(2), rtol=0.02)


def test_a_posture_that_drifts_is_no_swing():
    path = hand_paths(swinging(OWN, amplitude=0.0, seconds=60).poses, LAYOUT)
    drifting = path + np.linspace(0, 0.3, len(path))[:, None, None]
    assert spread(drifting).max() < 0.02


@pytest.mark.parametrize(
    ("frequency", "low", "high"), [(CYCLE, 0.99, 1.01), (2 * CYCLE, 0.99, 1.01), (OWN, -0.1, 0.15)]
)
def test_hands_are_tied_where_they_swing_with_the_steps(frequency, low, high):
    stretch = swinging(frequency)
    assert low < tied([hand_paths(stretch.poses, LAYOUT)], [stretch.phase]) < high


def test_noise_is_tied_to_nothing():
    noise = np.random.default_rng(0).normal(size=(SECOND * 40, 2, 3))
    assert abs(tied([noise], [np.linspace(0, 200, len(noise))])) < 0.02


def test_the_spectrum_tells_the_hands_own_frequency():
    stretch = swinging(OWN)
    found = spectrum([hand_paths(stretch.poses, LAYOUT)])
    assert found.peak == pytest.approx(OWN, abs=0.02)
    assert found.share(OWN) > 0.95 and found.share(CYCLE) < 0.05


def test_stuck_hands_are_told_from_swinging_ones():
    data, stuck, with_steps = (
        hands_of([swinging(f, a)], LAYOUT, OWN) for f, a in ((OWN, 0.2), (OWN, 0.02), (CYCLE, 0.2))
    )
    np.testing.assert_allclose(data.against(data), 1.0)
    np.testing.assert_allclose(stuck.against(data), 0.1, rtol=0.01)
    assert with_steps.against(data).min() > 0.95 and with_steps.share < 0.1 < 0.9 < data.share
    assert data.tied < 0.15 and with_steps.tied > 0.95


def test_a_hand_in_another_place_is_off():
    data, moved = swinging(OWN), swinging(OWN)
    poses = moved.poses.reshape(len(moved), -1, 4, 3)
    poses[:, LAYOUT.effectors[0], 0] += [0.0, 0.0, 0.3]
    off = hands_of([moved], LAYOUT).off(hands_of([data], LAYOUT))
    np.testing.assert_allclose(off, [0.3, 0.0], atol=1e-9)


@pytest.mark.parametrize(("axis", "alike"), [(0, -1), (1, 1), (2, 1)])
def test_hands_that_mirror_each_other_are_told_from_those_that_swing_like_a_walkers(axis, alike):
    swing = 0.2 * np.sin(2 * np.pi * CYCLE * time())
    one, other = (np.stack([swing, side * swing], axis=1)[..., None] * np.eye(3)[axis] for side in (1, -1))
    assert (together([one]), together([other, other + 1.0])) == (pytest.approx(alike), pytest.approx(-alike))
    assert together([np.zeros((240, 2, 3))]) == 0


def test_halves_of_an_even_swing_agree_and_of_one_that_stops_do_not():
    even = hand_paths(swinging(OWN).poses, LAYOUT)
    stops = even.copy()
    stops[len(stops) // 2 :] = stops[0]
    assert half_ratios([even]).min() > 0.95 and half_ratios([stops]).max() < 0.05
    assert stuck_below(np.tile(half_ratios([even]), (9, 1))) == 0.5
    assert stuck_below(np.tile(half_ratios([stops]), (9, 1))) < 0.05
    np.testing.assert_allclose(least_spread([even, even / 2]), spread(even) / 2)


def test_no_motion_has_no_hands():
    with pytest.raises(InputError, match="no motion"):
        hands_of([], LAYOUT)


class TestCollars:
    JOINTS = collar_joints(BODY)

    def raised(self, degrees: float, stretch: float = 1.0) -> np.ndarray:
        """Collar bones of 15 cm that point outwards and up by an angle, as a share of their length."""
        poses, angle = still(30), np.radians(degrees)
        for inner, outer, side in zip(self.JOINTS.inner, self.JOINTS.outer, (1, -1), strict=True):
            way = np.array([side * np.cos(angle), np.sin(angle), 0.0])
            poses[:, outer, 0] = poses[:, inner, 0] + 0.15 * stretch * way
        return poses.reshape(30, -1)

    def test_they_are_the_collar_bones(self):
        names = [BODY.skeleton.names[BODY.joints[j]] for j in (*self.JOINTS.inner, *self.JOINTS.outer)]
        assert names == ["LeftCollar", "RightCollar", "LeftShoulder", "RightShoulder"]
        assert BODY.skeleton.names[BODY.joints[self.JOINTS.chest]] == "Chest4"

    def test_the_angle_between_two_postures_is_found(self):
        level, up = (collars_of(self.raised(angle), self.JOINTS) for angle in (0.0, 20.0))
        np.testing.assert_allclose(up.angles(level), 20.0, atol=1e-6)
        np.testing.assert_allclose(up.angles(up), 0.0, atol=1e-4)

    def test_a_bone_that_is_too_long_is_seen(self):
        found = collars_of(self.raised(0.0, stretch=1.2), self.JOINTS)
        np.testing.assert_allclose(found.lengths, 0.18, rtol=1e-6)

    def test_the_unusual_style_is_named(self):
        angles = {"Plain": 0.0, "Shrug": 25.0, "Same": 1.0, "Other": -1.0}
        assert most_unusual({style: collars_of(self.raised(a), self.JOINTS) for style, a in angles.items()}) == "Shrug"


def test_a_hop_is_told_from_a_walk():
    walk = swinging(OWN)
    hop = Stretch(walk.poses.copy(), walk.phase, walk.contacts & [True, False])
    hop.poses.reshape(len(hop), -1, 4, 3)[:, LAYOUT.effectors[2], 0, 1] += 5.0
    walked, hopped = (foot_use([motion], LAYOUT) for motion in (walk, hop))
    assert walked.rate == pytest.approx((CYCLE, CYCLE), abs=0.07)
    assert hopped.contact[1] == hopped.rate[1] == 0 and hopped.rate[0] == walked.rate[0]
    assert hopped.raised - walked.raised == pytest.approx(-5.0)
