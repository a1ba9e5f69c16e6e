"""Speed without sway, a start without data, and the gain at which a character reaches a speed."""

from collections.abc import Callable

import numpy as np
import pytest
import tiny_walker as tiny

from stylephase.runtime import calibration
from stylephase.runtime.calibration import calibrate, speed_of, warm_start
from stylephase.runtime.controller import ControllerSettings
from stylephase.runtime.plans import Steady
from stylephase.runtime.rollout import Rollout

Speed = Callable[[np.ndarray], np.ndarray]


class TestSpeed:
    def test_of_a_straight_walk(self):
        path = np.arange(200)[:, None] / 60 * 1.3 * np.array([0.6, 0.8])
        assert speed_of(path) == pytest.approx(1.3)

    def test_sway_from_side_to_side_hardly_counts(self):
        """Hips sway by 3 cm once a second; the length of the path itself would be a tenth longer than its ground."""
        time = np.arange(600) / 60
        path = np.stack([0.06 * np.sin(2 * np.pi * time), 1.0 * time], axis=1)
        assert np.linalg.norm(np.diff(path, axis=0), axis=1).sum() / 10 > 1.02
        assert speed_of(path) == pytest.approx(1.0, abs=0.03)

    def test_standing_and_paths_of_a_moment_have_none(self):
        assert speed_of(np.ones((100, 2))) == 0.0
        assert speed_of(np.arange(40.0).reshape(20, 2)) == 0.0

    def test_a_path_into_infinity_has_no_finite_speed(self):
        path = np.arange(200.0).reshape(100, 2)
        path[50:] = np.inf
        assert not np.isfinite(speed_of(path))


@pytest.fixture
def walker(monkeypatch) -> Callable[[Speed], list[np.ndarray]]:
    """Replaces rollouts by walks whose speed is a function of the gain; gives the list of the gains tried."""

    def install(speed: Speed) -> list[np.ndarray]:
        tried = []

        def fake(bundle, codes, start, frames, plan: Steady, settings, tick) -> Rollout:
            tried.append(plan.speeds)
            assert len(codes) == len(plan.speeds) == len(start.positions)
            speeds, time = speed(plan.speeds), np.arange(frames)[:, None] / 60
            path = np.stack([0.02 * np.sin(7 * time) * np.ones(len(speeds)), (time + 0.1) * speeds], axis=-1)
            shape = (frames, len(speeds))
            rest = (np.zeros((*shape, 1, 3)), np.zeros((*shape, 1, 3, 3)), path)
            return Rollout(*rest, np.zeros(shape), np.zeros((*shape, 2)), np.zeros((*shape, 8)))

        monkeypatch.setattr(calibration, "roll_out", fake)
        return tried

    return install


class TestCalibrate:
    @pytest.mark.parametrize(
        "speed",
        [
            lambda gain: gain,
            lambda gain: 0.4 * gain,
            lambda gain: 1.2 * gain,
            lambda gain: 0.2 * gain**1.7,
            lambda gain: 2.0 * (1 - np.exp(-gain / 1.5)),
            lambda gain: 0.3 + 0.3 * gain,
        ],
    )
    def test_a_monotone_walker_comes_within_two_percent(self, walker, speed):
        walker(speed)
        targets = np.array([0.8, 1.1, 1.5])
        gains = calibrate(tiny.bundle(), tiny.codes(3), tiny.start([0, 50, 100]), targets)
        np.testing.assert_allclose(speed(gains), targets, rtol=0.02)

    def test_gains_that_lead_into_infinity_are_not_taken(self, walker):
        walker(lambda gain: np.where(gain < 1.5, 0.5 * gain, np.inf))
        gain = calibrate(tiny.bundle(), tiny.codes(1), tiny.start([0]), np.array([1.0]))
        assert 1.3 < gain[0] < 1.5

    def test_a_speed_out_of_reach_gives_the_nearest(self, walker):
        walker(lambda gain: np.minimum(0.5, 0.4 * gain))
        assert calibrate(tiny.bundle(), tiny.codes(1), tiny.start([0]), np.array([2.0]))[0] >= 1.25
        walker(lambda gain: 1 + gain)
        gain = calibrate(tiny.bundle(), tiny.codes(1), tiny.start([0]), np.array([0.5]))
        assert gain[0] == pytest.approx(0.3, abs=0.01)

    def test_when_all_is_infinite_there_is_still_a_gain(self, walker):
        walker(lambda gain: np.full(len(gain), np.nan))
        assert np.isfinite(calibrate(tiny.bundle(), tiny.codes(1), tiny.start([0]), np.array([1.0]))).all()

    def test_codes_and_starts_belong_to_their_gains(self, monkeypatch):
        """Each character is tried with all its gains side by side: code and start are repeated, not cycled."""
        seen = []

        def fake(bundle, codes, start, frames, plan, settings, tick) -> Rollout:
            seen.append((codes[:, 0].numpy(), start.positions[:, 0, 1], plan.speeds, settings))
            raise KeyboardInterrupt

        monkeypatch.setattr(calibration, "roll_out", fake)
        codes, start, how = tiny.codes(2), tiny.start([0, 100]), ControllerSettings(root_share=0.5)
        with pytest.raises(KeyboardInterrupt):
            calibrate(tiny.bundle(), codes, start, np.array([1.0, 10.0]), settings=how)
        each = len(seen[0][0]) // 2
        np.testing.assert_array_equal(seen[0][0], np.repeat(codes[:, 0].numpy(), each))
        np.testing.assert_array_equal(seen[0][1], np.repeat(start.positions[:, 0, 1], each))
        assert seen[0][2][:each].max() < 7 < seen[0][2][each + 1 :].max() and seen[0][3] is how


def test_a_warm_start_stands_at_the_origin_and_faces_ahead(monkeypatch):
    monkeypatch.setattr(calibration, "_WARM_UP_SECONDS", 0.5)
    state = warm_start(tiny.bundle(), tiny.codes(2), np.array([1.0, 1.5]))
    np.testing.assert_allclose(state.path.root.positions, 0.0, atol=1e-12)
    np.testing.assert_allclose(state.path.root.angles, 0.0, atol=1e-12)
    assert (state.positions[:, 0, 1] > 0.7).all() and (state.positions[:, 0, 1] < 1.2).all()
    assert np.abs(state.phases).max() > 0.01 and np.isfinite(state.velocities).all()
