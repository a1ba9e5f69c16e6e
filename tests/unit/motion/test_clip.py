"""Forward kinematics, parts of a clip, resampling and velocities."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from stylephase.errors import InputError
from stylephase.motion.clip import Clip, forward_kinematics, resample, velocities


@pytest.fixture
def tumbling(skeletons, frozen) -> Clip:
    """A few frames at 30 per second in which every joint turns at random."""
    rng = np.random.default_rng(3)
    skeleton = skeletons["100style"]
    rotations = Rotation.random(7 * len(skeleton), rng=rng).as_quat(scalar_first=True).reshape(7, -1, 4)
    return Clip(skeleton, 30.0, frozen(rotations), frozen(rng.normal(size=(7, 3))), "tumbling")


def test_forward_kinematics_goes_down_each_chain(tumbling):
    """Against one joint at a time: each bone is turned by all that stands above it."""
    pose = forward_kinematics(tumbling)
    for joint in (0, 6, 12, 27):
        for frame in (0, 6):
            place, turned = tumbling.root_positions[frame], Rotation.identity()
            for j in tumbling.skeleton.chain(joint):
                place = place + turned.apply(tumbling.skeleton.offsets[j]) * (j > 0)
                turned = turned * Rotation.from_quat(tumbling.rotations[frame, j], scalar_first=True)
            np.testing.assert_allclose(pose.positions[frame, joint], place, atol=1e-12)
            np.testing.assert_allclose(pose.rotations[frame, joint], turned.as_matrix(), atol=1e-12)


def test_bones_keep_their_length(tumbling):
    positions, parents = forward_kinematics(tumbling).positions, list(tumbling.skeleton.parents[1:])
    lengths = np.linalg.norm(positions[:, 1:] - positions[:, parents], axis=-1)
    expected = np.linalg.norm(tumbling.skeleton.offsets[1:], axis=-1)
    np.testing.assert_allclose(lengths, np.broadcast_to(expected, lengths.shape), atol=1e-12)


def test_a_part_has_its_frames_and_no_others(tumbling):
    part = tumbling.frames(2, 5)
    assert len(part) == 3 and part.name == "tumbling"
    np.testing.assert_array_equal(part.rotations, tumbling.rotations[2:5])
    np.testing.assert_array_equal(part.root_positions, tumbling.root_positions[2:5])


@pytest.mark.parametrize(("start", "stop"), [(-1, 3), (3, 3), (5, 2), (0, 8)])
def test_a_part_outside_the_clip_is_refused(tumbling, start, stop):
    with pytest.raises(InputError, match=f"tumbling: frames {start} to {stop} do not lie in 0 to 7"):
        tumbling.frames(start, stop)


def test_from_30_to_60_keeps_the_given_frames_and_puts_one_between_each_two(tumbling):
    made = resample(tumbling, 60.0)
    assert made.fps == 60.0 and len(made) == 13
    same = np.abs((made.rotations[::2] * tumbling.rotations).sum(axis=-1))
    np.testing.assert_allclose(same, 1.0, atol=1e-12)
    np.testing.assert_allclose(made.root_positions[::2], tumbling.root_positions, atol=1e-12)
    half = (tumbling.root_positions[1:] + tumbling.root_positions[:-1]) / 2
    np.testing.assert_allclose(made.root_positions[1::2], half, atol=1e-12)


def test_between_two_frames_a_joint_turns_half_of_the_shorter_way(tumbling):
    """Slerp: half of the one rotation that leads from frame to frame, whatever the quaternions' signs."""
    flipped = replace(tumbling, rotations=tumbling.rotations * np.where(np.arange(7) % 2, -1.0, 1.0)[:, None, None])
    for clip in (tumbling, flipped):
        made = resample(clip, 60.0)
        for joint in (0, 9):
            keys = Rotation.from_quat(clip.rotations[:, joint], scalar_first=True)
            middle = keys[:-1] * Rotation.from_rotvec((keys[:-1].inv() * keys[1:]).as_rotvec() / 2)
            found = Rotation.from_quat(made.rotations[1::2, joint], scalar_first=True)
            np.testing.assert_allclose((middle.inv() * found).magnitude(), 0.0, atol=1e-7)


@settings(max_examples=10)
@given(st.sampled_from([24.0, 25.0, 29.97, 30.0, 50.0, 100.0, 120.0]), st.integers(2, 40))
def test_any_rate_keeps_first_frame_and_duration(skeletons, fps, frames):
    """Hips at constant speed go on at that speed, from the first frame to at most one new frame before the last."""
    skeleton = skeletons["bandai-namco"]
    still = np.tile([1.0, 0.0, 0.0, 0.0], (frames, len(skeleton), 1))
    path = np.outer(np.arange(frames) / fps, [0.3, 0.0, 1.2])
    made = resample(Clip(skeleton, fps, still, path), 60.0)
    np.testing.assert_allclose(made.root_positions, np.outer(np.arange(len(made)) / 60, [0.3, 0.0, 1.2]), atol=1e-9)
    assert 0 <= (frames - 1) / fps - (len(made) - 1) / 60 < 1 / 60 + 1e-9


def test_the_same_rate_and_a_single_frame_stay_as_they_are(tumbling):
    assert resample(tumbling, 30.01).rotations is tumbling.rotations
    assert len(resample(tumbling.frames(0, 1), 60.0)) == 1


def test_velocities_are_backward_differences_and_the_first_frame_takes_the_seconds(frozen):
    places = frozen(np.array([[0.0], [0.1], [0.3], [0.2]]))
    np.testing.assert_allclose(velocities(places, 60.0).ravel(), [6.0, 6.0, 12.0, -6.0])
    np.testing.assert_array_equal(velocities(places[:1], 60.0), [[0.0]])
