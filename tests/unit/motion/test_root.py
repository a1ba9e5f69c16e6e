"""The root frame: hips on the ground, facing as the hips face, whatever way a file's joint frames lie."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from stylephase.errors import InputError
from stylephase.motion.clip import Clip, forward_kinematics
from stylephase.motion.root import Root, hips_axes, hips_frame, root_of, rotate_to_local, snap, to_local, turn

UPRIGHT = np.eye(3)
ALONG_THE_SPINE = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


@pytest.mark.parametrize(
    ("origin", "axes"),
    [("100style", UPRIGHT), ("cmu", UPRIGHT), ("mixamo", UPRIGHT), ("poser", UPRIGHT),
     ("bandai-namco", ALONG_THE_SPINE)],
)  # fmt: skip
def test_the_hips_axes_are_read_off_the_skeleton(skeletons, origin, axes):
    """Left runs across the thighs, up along the spine: in one of these files up is the hips' x axis."""
    np.testing.assert_array_equal(hips_axes(skeletons[origin]), axes)


def test_axes_a_few_degrees_off_are_taken_for_the_files_own_and_others_are_kept():
    small, large = (Rotation.from_euler("y", angle, degrees=True).as_matrix() for angle in (4.0, 20.0))
    np.testing.assert_array_equal(snap(small), np.eye(3))
    np.testing.assert_array_equal(snap(large), large)


def test_thighs_along_the_spine_are_refused(skeletons):
    skeleton = skeletons["100style"]
    offsets = skeleton.offsets.copy()
    offsets[[18, 23]] = [[0.0, -0.1, 0.0], [0.0, 0.1, 0.0]]
    with pytest.raises(InputError, match="cannot tell the hips' axes"):
        hips_axes(replace(skeleton, offsets=offsets))


def standing(skeleton, hips: Rotation, places: np.ndarray) -> Clip:
    """A clip in which only the hips move; `hips` turns a character that stands at its zero pose, facing +z."""
    rotations = np.tile([1.0, 0.0, 0.0, 0.0], (len(places), len(skeleton), 1))
    upright = Rotation.from_matrix(hips_axes(skeleton)).inv()
    rotations[:, 0] = (hips * upright).as_quat(scalar_first=True)
    return Clip(skeleton, 60.0, rotations, places)


@pytest.mark.parametrize("origin", ["100style", "bandai-namco", "cmu"])
def test_facing_is_the_hips_heading_without_their_tilt(skeletons, origin, frozen):
    """Two whole turns to the left: the angle goes on beyond a half turn, and pitch does not change it."""
    angles = np.linspace(0.0, 4 * np.pi, 60)
    pitch = 0.3 * np.sin(np.arange(60))
    tilted = Rotation.from_euler("YX", np.stack([angles, pitch], axis=1))
    places = np.random.default_rng(0).normal(size=(60, 3))
    root = root_of(forward_kinematics(standing(skeletons[origin], tilted, frozen(places))), skeletons[origin])
    np.testing.assert_allclose(root.angles, angles, atol=1e-9)
    np.testing.assert_array_equal(root.positions, places[:, [0, 2]])
    np.testing.assert_allclose(root.directions[0], [0.0, 1.0], atol=1e-9)


def test_a_positive_angle_turns_to_the_left_which_is_plus_x():
    root = Root(np.zeros((1, 2)), np.array([np.pi / 2]))
    np.testing.assert_allclose(root.directions, [[1.0, 0.0]], atol=1e-12)
    np.testing.assert_allclose(turn(root.angles)[0] @ [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], atol=1e-12)


def test_root_and_hips_frame_do_not_depend_on_how_joint_frames_lie(limping, change):
    """The same walk with each joint's axes laid another way; the hips' z axis is not even level then."""
    odd = change.reframed(limping)
    assert abs(hips_axes(odd.skeleton)[2, 2]) < 0.1
    pose, other = forward_kinematics(limping), forward_kinematics(odd)
    root, hands = root_of(pose, limping.skeleton), limping.skeleton.roles.hands
    np.testing.assert_allclose(root_of(other, odd.skeleton).angles, root.angles, atol=1e-9)
    np.testing.assert_allclose(
        hips_frame(other, odd.skeleton, hands), hips_frame(pose, limping.skeleton, hands), atol=1e-9
    )


def test_local_points_come_back_by_the_root_matrices(limping, frozen):
    """Left, up and forward of the root are the columns of its matrices; heights stay as they are."""
    pose = forward_kinematics(limping)
    root = root_of(pose, limping.skeleton)
    local = to_local(root, frozen(pose.positions))
    origin = np.insert(root.positions, 1, 0.0, axis=1)
    back = np.einsum("tij,tkj->tki", root.matrices, local) + origin[:, None]
    np.testing.assert_allclose(back, pose.positions, atol=1e-12)
    np.testing.assert_array_equal(local[..., 1], pose.positions[..., 1])
    np.testing.assert_allclose(local[:, 0, [0, 2]], 0.0, atol=1e-12)
    across = pose.positions[:, 1:2] - pose.positions[:, :1]
    np.testing.assert_allclose(rotate_to_local(root, across), local[:, 1:2] - local[:, :1], atol=1e-12)


@pytest.mark.parametrize("origin", ["100style", "bandai-namco"])
def test_a_hand_that_is_fixed_to_the_hips_rests_in_their_frame(skeletons, origin):
    """All three rotations and the translation are taken out, and the left hand lies to the left."""
    skeleton = skeletons[origin]
    hips = Rotation.random(20, rng=np.random.default_rng(1))
    pose = forward_kinematics(standing(skeleton, hips, np.random.default_rng(2).normal(size=(20, 3))))
    places = hips_frame(pose, skeleton, skeleton.roles.hands)
    np.testing.assert_allclose(places, np.broadcast_to(places[0], places.shape), atol=1e-12)
    if origin == "100style":
        assert places[0, 0, 0] > 0.5 > 0 > places[0, 1, 0]
