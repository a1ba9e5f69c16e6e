"""Metrics of motion on motion whose answers are known."""

import numpy as np
import pytest

from stylephase.evaluation.motion import Steps, bones_of, correlation, foot_skate, heading_error, steps_of

SECOND = 60


class TestBones:
    BONES = ((0, 1), (1, 2), (2, 3))
    TRUE = np.array([0.5, 0.3, 0.0])

    def chain(self, *lengths: np.ndarray, frames: int = 600) -> np.ndarray:
        """Joints in a row with bones of some lengths (frame by frame), turning and walking off."""
        angle = np.linspace(0, 5, frames)
        ahead = np.stack([np.sin(angle), np.cos(angle), np.zeros(frames)], axis=1)
        ends = np.cumsum([np.zeros(frames), *(np.broadcast_to(length, frames) for length in lengths)], axis=0)
        return ends.T[..., None] * ahead[:, None] + np.linspace(0, 9, frames)[:, None, None]

    def test_rigid_bones_do_not_vary(self):
        found = bones_of(self.chain(0.5, 0.3, 0.0), self.BONES, self.TRUE)
        np.testing.assert_allclose([found.median, found.worst, found.off, found.drift], 0, atol=1e-9)

    def test_variation_is_in_percent_of_the_length(self):
        """A bone that is half the time 10 % longer and half the time 10 % shorter than its mean varies by 10 %."""
        found = bones_of(self.chain(np.tile([0.45, 0.55], 300), 0.3, 0.0), self.BONES, self.TRUE)
        assert found.worst == pytest.approx(10.0) and found.median == pytest.approx(5.0)
        assert found.off == pytest.approx(0, abs=1e-9) and found.drift == pytest.approx(0, abs=1e-9)

    def test_a_bone_of_the_wrong_length_is_off(self):
        found = bones_of(self.chain(0.5, 0.32, 0.0), self.BONES, self.TRUE)
        assert found.off == pytest.approx(20.0) and found.worst == pytest.approx(0, abs=1e-9)

    def test_drift_is_between_the_first_and_the_last_second(self):
        growing = np.linspace(0.5, 0.6, 600)
        found = bones_of(self.chain(growing, 0.3, 0.0), self.BONES, self.TRUE)
        assert found.drift == pytest.approx(90.0, abs=1)

    def test_bones_of_no_length_count_not(self):
        """Else any noise on them would be an infinite share."""
        noise = np.random.default_rng(0).uniform(0, 1e-4, 600)
        found = bones_of(self.chain(0.5, 0.3, noise), self.BONES, self.TRUE)
        assert found.worst == pytest.approx(0, abs=1e-9)


def contacts(right: float, left: float, *, seconds: float = 10.0, cycle: float = 1.0, duty: float = 0.6) -> np.ndarray:
    """Contacts of feet that come down at these shares of a cycle; a foot at NaN never does."""
    time = np.arange(int(seconds * SECOND)) / SECOND / cycle
    feet = np.array([right, left])
    return ((time[:, None] - feet) % 1 < duty) & np.isfinite(feet)


class TestSteps:
    def test_walking_alternates(self):
        found = steps_of(contacts(0.25, 0.75))
        assert (found.count, found.alternation) == (20, 1.0) and found.alternate
        assert found.cycle == pytest.approx(1.0)

    def test_a_limp_alternates_too(self):
        found = steps_of(contacts(0.25, 0.55, cycle=1.3))
        assert found.alternate and found.cycle == pytest.approx(1.3, abs=0.02)

    def test_hopping_on_one_foot_does_not(self):
        found = steps_of(contacts(0.3, np.nan, cycle=0.6))
        assert found.count >= 16 and found.alternation == 0 and not found.alternate

    @pytest.mark.parametrize("apart", [0.0, 0.03])
    def test_jumping_with_both_feet_does_not(self, apart):
        """Both feet come down together, or nearly: listed one after the other, they would seem to alternate."""
        found = steps_of(contacts(0.3, 0.3 + apart, cycle=0.8))
        assert found.count >= 24 and found.alternation < 0.6 and not found.alternate

    def test_gliding_has_no_steps(self):
        for feet in (np.ones((600, 2), dtype=bool), np.zeros((600, 2), dtype=bool)):
            found = steps_of(feet)
            assert found == Steps(0, 0.0, 0.0) and not found.alternate

    def test_a_few_steps_are_too_few(self):
        assert steps_of(contacts(0.25, 0.75, seconds=4)).count == 8
        assert not steps_of(contacts(0.25, 0.75, seconds=4)).alternate

    def test_flicker_makes_no_steps(self):
        """A contact that breaks for a frame or two is one contact."""
        flicker = contacts(0.25, 0.75)
        flicker[::37] = False
        assert steps_of(flicker).count == pytest.approx(20, abs=1)


@pytest.mark.parametrize(
    ("angle", "target", "degrees"),
    [
        (0.5, 0.5, 0.0),
        (np.pi - 0.05, -np.pi + 0.05, np.degrees(0.1)),
        (-np.pi + 0.05, np.pi - 0.05, np.degrees(0.1)),
        (np.pi / 2 + 4 * np.pi, np.pi / 2, 0.0),
        (0.0, np.pi, 180.0),
        (np.pi / 2, -np.pi / 2, 180.0),
    ],
)
def test_a_heading_is_off_by_the_shorter_way_round(angle, target, degrees):
    assert heading_error(np.full(300, angle), target) == pytest.approx(degrees, abs=1e-6)


def test_a_heading_is_that_of_the_last_seconds_and_sway_averages_out():
    angles = np.concatenate([np.zeros(300), 1.0 + 0.2 * np.sin(2 * np.pi * np.arange(120) / 60)])
    assert heading_error(angles, 1.0) == pytest.approx(0, abs=0.1)


class TestFootSkate:
    def test_only_feet_in_contact_count(self):
        """The right foot slides at 0.3 m/s while in contact, the left swings at 2 m/s in the air."""
        time = np.arange(120)[:, None] / 60
        toes = np.stack([time * [0.3, 0.0, 0.0], time * [0.0, 0.0, 2.0]], axis=1)
        held = np.tile([True, False], (120, 1))
        assert foot_skate(toes, held) == pytest.approx(0.3)
        assert foot_skate(toes, held[:, ::-1].copy()) == pytest.approx(2.0)

    def test_up_and_down_is_no_skating(self):
        toes = np.zeros((120, 2, 3))
        toes[:, :, 1] = np.linspace(0, 1, 120)[:, None]
        assert foot_skate(toes, np.ones((120, 2), dtype=bool)) == 0.0

    def test_the_step_into_a_contact_is_not_counted(self):
        toes = np.zeros((10, 2, 3))
        toes[5:, 0, 2] = 1.0
        held = np.zeros((10, 2), dtype=bool)
        held[5:, 0] = True
        assert foot_skate(toes, held) == 0.0

    def test_without_contact_there_is_none(self):
        assert foot_skate(np.random.default_rng(0).normal(size=(60, 2, 3)), np.zeros((60, 2), dtype=bool)) == 0.0


class TestCorrelation:
    def test_it_is_that_of_numpy(self):
        values = np.random.default_rng(0).normal(size=(200, 2)) @ np.array([[1.0, -0.7], [0.0, 1.0]])
        assert correlation(values) == pytest.approx(np.corrcoef(values.T)[0, 1])

    def test_feet_that_take_turns_are_opposed(self):
        assert correlation(contacts(0.0, 0.5, duty=0.5).astype(float)) == pytest.approx(-1)

    def test_a_foot_that_stays_has_none(self):
        assert correlation(np.stack([np.full(50, 0.3), np.arange(50.0)], axis=1)) == 0.0
