"""Clips carried over to another skeleton: onto the same one nothing changes, and errors are what they say."""

from dataclasses import replace

import numpy as np
import pytest
from tiny_walker import SKELETON, take

from stylephase.errors import InputError
from stylephase.evaluation.retargeting import carry
from stylephase.motion.clip import forward_kinematics

NAMES = {name: name for name, site in zip(SKELETON.names, SKELETON.sites, strict=True) if not site}
CLIPS = [take(style, 3.0).clip for style in ("Plain", "StoopedOver")]


def test_onto_the_same_skeleton_a_clip_stays_as_it_is():
    carried = carry(CLIPS, CLIPS, CLIPS, NAMES)
    for one, clip in zip(carried, CLIPS, strict=True):
        ours, theirs = (forward_kinematics(some).positions for some in (one.clip, clip))
        np.testing.assert_allclose(ours, theirs, atol=1e-6)
        assert one.off < 1e-4 and one.moves_off < 1e-4


def test_a_larger_body_walks_larger_and_its_proportions_are_no_error_of_movement():
    large = replace(SKELETON, offsets=1.3 * SKELETON.offsets)
    bigger = [replace(clip, skeleton=large, root_positions=1.3 * clip.root_positions) for clip in CLIPS]
    (one, _) = carry(CLIPS, CLIPS, bigger, NAMES)
    np.testing.assert_allclose(one.clip.root_positions, 1.3 * CLIPS[0].root_positions)
    assert one.off < 1e-4
    broad = replace(SKELETON, offsets=SKELETON.offsets * [1.0, 1.2, 1.0])
    (other, _) = carry(CLIPS, CLIPS, [replace(clip, skeleton=broad) for clip in CLIPS], NAMES)
    assert other.off > other.moves_off


def test_a_joint_without_one_to_follow_is_named():
    lacking = {name: name for name in NAMES if name != "Head"}
    with pytest.raises(InputError, match="no joint to follow for Head"):
        carry(CLIPS, CLIPS, CLIPS, lacking)
