"""Principal directions on a character: the path goes through the hand, and arrow and plane are in the picture."""

import numpy as np
import pytest

from stylephase.data.registry import MIDDLE_CONTACT
from stylephase.motion.clip import forward_kinematics
from stylephase.motion.synthetic import find_style, steady, walk
from stylephase.phase.source import sourcing
from stylephase.phase.take import movement_of
from stylephase.report import palette
from stylephase.report.render import Motion
from stylephase.report.render.swings import swing_picture, swings

COLOURS = ["#00AA00", "#AA00AA"]


@pytest.fixture(scope="module")
def walking():
    clip, _ = walk(find_style("Plain"), "FW", plan=steady(2.0, forward=1.2, turn=0.5))
    return clip.skeleton, forward_kinematics(clip)


def directions_of(pose, skeleton):
    return sourcing([movement_of(pose, skeleton, 60.0, MIDDLE_CONTACT)]).directions[:2]


def test_a_path_goes_through_the_joint_in_its_frame_and_the_direction_points_ahead(walking):
    skeleton, pose = walking
    directions = directions_of(pose, skeleton)
    for frame in (0, 60):
        drawn = swings(pose, skeleton, skeleton.roles.hands, directions, COLOURS, frame=frame)
        for one, joint in zip(drawn, skeleton.roles.hands, strict=True):
            assert np.allclose(one.path[frame], pose.positions[frame, joint])
            assert one.direction @ pose.rotations[frame, 0, :, 2] > 0.5
            assert np.linalg.norm(one.direction) == pytest.approx(1)
            assert one.reach == pytest.approx(2 * ((one.path - one.middle) @ one.direction).std())


def test_path_arrow_and_plane_are_in_the_picture(walking):
    skeleton, pose = walking
    motion = Motion(skeleton, pose.positions, label="Plain")
    drawn = swings(pose, skeleton, skeleton.roles.hands, directions_of(pose, skeleton), COLOURS, frame=60)
    bare, full = (swing_picture(motion, chosen, frame=60, scale=90).astype(int) for chosen in ([], drawn))
    assert bare.shape == full.shape
    changed = np.abs(full - bare).sum(axis=2) > 60
    assert 0.005 < changed.mean() < 0.2
    # The marks are where the hands are: in the middle third of the picture's height.
    rows = np.flatnonzero(changed.any(axis=1))
    assert rows.min() > 0.2 * len(bare) and rows.max() < 0.75 * len(bare)
    highlight = np.abs(full - palette.rgb(palette.HIGHLIGHT)).sum(axis=2) < 120
    assert highlight.sum() > 30
