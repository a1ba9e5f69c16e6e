"""The rest pose: joint orientations mean the same on all skeletons, and mirroring is a sign change."""

from dataclasses import replace

import numpy as np
import pytest

from stylephase.motion.clip import Clip, forward_kinematics
from stylephase.motion.rest import rest_axes, stands_at_zero
from stylephase.motion.root import hips_axes, root_of, turn

MIRROR = np.diag([-1.0, 1.0, 1.0])


@pytest.mark.parametrize(
    ("origin", "stands"),
    [("100style", True), ("cmu", True), ("mixamo", True), ("poser", True), ("bandai-namco", False)],
)
def test_a_skeleton_stands_at_zero_where_its_legs_hang_down(skeletons, origin, stands):
    assert stands_at_zero(skeletons[origin]) == stands


@pytest.mark.parametrize("origin", ["100style", "cmu"])
def test_a_skeleton_that_stands_at_zero_has_that_rest_pose_whatever_the_motion(skeletons, origin):
    rest = rest_axes(skeletons[origin], [])
    np.testing.assert_array_equal(rest, np.broadcast_to(np.eye(3), rest.shape))


def test_axes_are_rotations_and_those_of_the_hips_are_the_facing(upright, change):
    odd = change.reframed(upright)
    assert not stands_at_zero(odd.skeleton)
    rest = rest_axes(odd.skeleton, [odd])
    np.testing.assert_allclose(rest @ np.swapaxes(rest, 1, 2), np.broadcast_to(np.eye(3), rest.shape), atol=1e-9)
    np.testing.assert_allclose(np.linalg.det(rest), 1.0, atol=1e-9)
    np.testing.assert_array_equal(rest[0], hips_axes(odd.skeleton))


def test_a_body_at_rest_has_no_orientation_of_its_own(upright, change):
    """A symmetric pose, held and turned in the world: measured against it, every joint faces as the root does."""
    hips_first = np.tile([1.0, 0.0, 0.0, 0.0], (60, len(upright.skeleton), 1))
    held = change.moved(replace(upright, rotations=hips_first, root_positions=np.zeros((60, 3))), 2.0, 3.0, -1.0)
    odd = change.reframed(held)
    pose = forward_kinematics(odd)
    found = pose.rotations @ rest_axes(odd.skeleton, [odd])
    expected = turn(root_of(pose, odd.skeleton).angles)[:, None]
    np.testing.assert_allclose(found, np.broadcast_to(expected, found.shape), atol=1e-9)


def asymmetry(rest: np.ndarray, clip: Clip, frames: np.ndarray) -> np.ndarray:
    """How far (largest element) each joint's axes are from the mirror image of its partner's, frames being known."""
    partner = clip.skeleton.mirrored
    image = np.swapaxes(frames[partner], 1, 2) @ MIRROR @ frames @ rest
    return np.abs(image - rest[partner] @ MIRROR).max(axis=(1, 2))


def test_the_rest_pose_is_its_own_mirror_image(limping, upright, change):
    """Also where it is the mean of a walk that drags a leg: with axes that lie in any way, opposite ways among them."""
    frames = change.odd_frames(upright.skeleton)
    odd = [change.reframed(clip) for clip in (upright, limping)]
    rest = rest_axes(odd[0].skeleton, odd)
    assert asymmetry(rest, odd[0], frames).max() < 1e-9
    # The mean pose itself is lopsided.
    pose = forward_kinematics(limping)
    mean = np.einsum("tji,tkjl->kil", root_of(pose, limping.skeleton).matrices, pose.rotations) / len(limping)
    assert np.abs(MIRROR @ mean[limping.skeleton.mirrored] @ MIRROR - mean).max() > 0.3


def test_the_mean_is_over_all_frames_of_all_clips(upright, change):
    """Turning or moving a take, or cutting it in two, does not change the rest pose."""
    odd = change.reframed(upright)
    whole = rest_axes(odd.skeleton, [odd])
    parts = [change.moved(odd.frames(0, 50), 1.0, 4.0, 2.0), odd.frames(50, len(odd))]
    np.testing.assert_allclose(rest_axes(odd.skeleton, parts), whole, atol=1e-9)


def test_a_pose_without_any_symmetry_stays_as_it_is(upright, change):
    """An arm half-way ahead and one at the side are no mirror images: made so, the pose would be that of neither."""
    rotations = np.tile([1.0, 0.0, 0.0, 0.0], (10, len(upright.skeleton), 1))
    shoulder = upright.skeleton.index("LeftShoulder")
    rotations[:, shoulder] = [np.cos(np.pi / 8), 0.0, -np.sin(np.pi / 8), 0.0]
    odd = change.reframed(replace(upright, rotations=rotations, root_positions=np.zeros((10, 3))))
    rest = rest_axes(odd.skeleton, [odd])
    np.testing.assert_allclose(rest[shoulder].T, forward_kinematics(odd).rotations[0, shoulder], atol=1e-9)
    off = asymmetry(rest, odd, change.odd_frames(upright.skeleton))
    assert off[shoulder] > 0.3 and off[upright.skeleton.index("LeftKnee")] < 1e-9


def test_on_a_real_skeleton_partners_carry_mirrored_bones(real_take):
    """Its limbs run along +x on the left and -x on the right; at rest each bone is its partner's mirror image."""
    skeleton = real_take.skeleton
    assert not stands_at_zero(skeleton)
    rest, partner = rest_axes(skeleton, [real_take]), skeleton.mirrored
    bones = np.stack([rest[p].T @ skeleton.offsets[j] for j, p in enumerate(skeleton.parents) if p >= 0])
    np.testing.assert_allclose(bones[partner[1:] - 1], bones * [-1, 1, 1], atol=0.005)
    assert bones[skeleton.index("LowerLeg_L") - 1, 1] < -0.35 and bones[skeleton.index("UpperArm_L") - 1, 0] > 0.04
