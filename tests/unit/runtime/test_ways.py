"""The way that was taken, told as it is asked for."""

import numpy as np
import pytest

from stylephase.features.layout import FPS
from stylephase.runtime.plans import FollowPath, Steady
from stylephase.runtime.rollout import Rollout
from stylephase.runtime.ways import Way, way_of


def walked(aside: float, turn: float, seconds: float = 4.0, speed: float = 1.2) -> Rollout:
    """A root that goes at an angle (degrees, to the left) to where it faces, and turns (degrees a second)."""
    frames = int(seconds * FPS)
    angles = np.radians(turn) * np.arange(frames) / FPS
    way = angles + np.radians(aside)
    steps = speed / FPS * np.stack([np.sin(way), np.cos(way)], axis=-1)
    joints = np.zeros((frames, 1, 3, 3))
    parts = [joints, joints[..., None] + np.eye(3), np.cumsum(steps, axis=0)[:, None], angles[:, None]]
    return Rollout(*parts, np.zeros((frames, 1, 2)), np.zeros((frames, 1, 8)))


@pytest.mark.parametrize(("aside", "turn"), [(90.0, 0.0), (-32.0, 0.0), (0.0, -45.0), (180.0, 0.0), (40.0, 60.0)])
def test_angle_and_turning_are_those_of_the_way(aside, turn):
    found = way_of(walked(aside, turn), 0, Steady(np.ones(1)), [])
    assert abs(found.strafe) == pytest.approx(abs(aside), abs=1) and found.turn == pytest.approx(turn, abs=0.5)
    assert aside in (0.0, 180.0) or np.sign(found.strafe) == np.sign(aside)
    assert (found.off, found.arrived) == (None, None)


def test_of_a_path_the_farthest_from_it_and_the_end_are_told():
    plan = FollowPath(np.array([[0.0, 0.0], [0.0, 2.0]]), np.ones(1), stops=True)
    found = way_of(walked(0, 0), 0, plan, [0.1, 0.4, 0.2])
    assert (found.off, found.arrived) == (0.4, None)
    plan.arrived[:] = 120
    assert way_of(walked(0, 0), 0, plan, [0.1]).arrived == pytest.approx(2.0)


def test_a_walk_of_a_frame_or_two_has_a_way_too():
    for frames in (1, 2):
        found = way_of(walked(0, 0, seconds=frames / FPS), 0, Steady(np.ones(1)), [])
        assert isinstance(found, Way) and np.isfinite([found.strafe, found.turn]).all()
