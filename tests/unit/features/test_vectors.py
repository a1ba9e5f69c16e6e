"""The vectors of a take: documented places, no trace of the world, and mirror images where the motion's are.

Where vectors are compared with vectors of the same motion, they agree to 1e-9 (m, m/s): all is in double precision.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from stylephase.features.layout import INPUT_SAMPLES, OUTPUT_SAMPLES, feature_joints, layout_of
from stylephase.features.vectors import Vectors, vectors
from stylephase.motion.clip import Clip, Pose, forward_kinematics
from stylephase.motion.rest import rest_axes
from stylephase.motion.root import Root, root_of, turn
from stylephase.motion.synthetic import SKELETON

EXACT = 1e-9
MIRROR = np.diag([-1.0, 1.0, 1.0])


def signals(frames: int) -> tuple[np.ndarray, np.ndarray]:
    """Phases and contacts as they might be, all different."""
    rng = np.random.default_rng(5)
    return rng.normal(size=(frames, 8)), rng.random((frames, 2)) < 0.5


def made(pose: Pose, clip: Clip, rest: np.ndarray) -> Vectors:
    return vectors(pose, clip.skeleton, rest, clip.fps, *signals(len(clip)))


@pytest.fixture(scope="module")
def pose(limping) -> Pose:
    return forward_kinematics(limping)


@pytest.fixture(scope="module")
def rest(limping) -> np.ndarray:
    return rest_axes(limping.skeleton, [limping])


@pytest.fixture(scope="module")
def whole(limping, pose, rest) -> Vectors:
    return made(pose, limping, rest)


def seen(root: Root, t: int, point: np.ndarray) -> tuple[float, float]:
    """A ground point (x, z) from root t, written out."""
    (x, z), angle = point - root.positions[t], root.angles[t]
    return x * np.cos(angle) - z * np.sin(angle), x * np.sin(angle) + z * np.cos(angle)


def beyond(path: np.ndarray, i: int) -> np.ndarray:
    """Element i of a path that goes on reflected about its end points."""
    last = len(path) - 1
    return 2 * path[0] - path[-i] if i < 0 else 2 * path[last] - path[2 * last - i] if i > last else path[i]


class TestPlaces:
    def test_there_is_a_row_for_each_frame_that_has_a_next(self, whole, limping):
        assert whole.x.shape == (len(limping) - 1, 348)
        assert whole.p.shape == (len(limping) - 1, 8)
        assert whole.y.shape == (len(limping) - 1, 342)

    def test_what_is_constant_by_construction_is(self, whole):
        """The present of the trajectory is the origin, facing ahead; the hips stand over it and face ahead."""
        np.testing.assert_allclose(whole.x[:, 24:28], np.tile([0, 0, 0, 1], (len(whole.x), 1)), atol=EXACT)
        np.testing.assert_allclose(whole.x[:, [48, 50, 51]], 0.0, atol=EXACT)

    @pytest.mark.parametrize("t", [0, 7, 90, -1])
    def test_the_trajectory_is_the_roots_path_every_sixth_and_fifth_of_a_second(self, whole, limping, pose, t):
        root, t = root_of(pose, limping.skeleton), t % len(whole.x)
        for parts, samples, ahead in ((whole.x, INPUT_SAMPLES, 0), (whole.y, OUTPUT_SAMPLES, 1)):
            expected = []
            for sample in samples:
                angle = beyond(root.angles, t + ahead + sample) - root.angles[t]
                expected += [*seen(root, t, beyond(root.positions, t + ahead + sample)), np.sin(angle), np.cos(angle)]
            np.testing.assert_allclose(parts[t, : 4 * len(samples)], expected, atol=EXACT)

    def test_a_walker_that_turns_left_has_its_path_on_the_left(self, skeletons):
        """On a circle of 2 m at half a radian a second: left is +x, ahead is +z."""
        skeleton, angles = skeletons["100style"], 0.5 * np.arange(200) / 60
        rotations = np.tile([1.0, 0.0, 0.0, 0.0], (200, len(skeleton), 1))
        rotations[:, 0] = Rotation.from_euler("y", angles[:, None]).as_quat(scalar_first=True)
        path = 2 * np.stack([1 - np.cos(angles), np.full(200, 0.5), np.sin(angles)], axis=1)
        clip = Clip(skeleton, 60.0, rotations, path)
        row = made(forward_kinematics(clip), clip, rest_axes(skeleton, [])).x[100, :48].reshape(12, 4)
        later = 0.5 * np.array(INPUT_SAMPLES) / 60
        expected = [2 * (1 - np.cos(later)), 2 * np.sin(later), np.sin(later), np.cos(later)]
        np.testing.assert_allclose(row.T, expected, atol=EXACT)
        assert row[-1, 0] > 0.2 and row[-1, 1] > 0.9

    @pytest.mark.parametrize("joint", ["Hips", "Head", "LeftWristSite", "RightToe"])
    def test_each_joint_has_position_forward_up_and_velocity(self, whole, limping, pose, joint):
        """Found again from the world's side; forward and up are the joint's own z and y, as it stands at zero."""
        skeleton, root = limping.skeleton, root_of(pose, limping.skeleton)
        j = skeleton.index(joint)
        start = 48 + 12 * feature_joints(skeleton).index(j)
        block = whole.x[:, start : start + 12].reshape(-1, 4, 3)
        world = np.einsum("tij,tkj->tki", root.matrices[:-1], block)
        world[:, 0] += np.insert(root.positions[:-1], 1, 0.0, axis=1)
        np.testing.assert_allclose(world[:, 0], pose.positions[:-1, j], atol=EXACT)
        np.testing.assert_allclose(world[:, 1], pose.rotations[:-1, j, :, 2], atol=EXACT)
        np.testing.assert_allclose(world[:, 2], pose.rotations[:-1, j, :, 1], atol=EXACT)
        steps = np.diff(pose.positions[:, j], axis=0)[:-1] * 60
        np.testing.assert_allclose(world[1:, 3], steps, atol=1e-7)
        np.testing.assert_allclose(world[0, 3], steps[0], atol=1e-7)

    def test_a_row_of_y_is_the_next_frame_seen_from_this_root(self, whole, limping, pose):
        """In the world it is what the next row of x says."""
        root = root_of(pose, limping.skeleton)
        to_next = turn(root.angles[:-2] - root.angles[1:-1])
        now, following = (part.reshape(len(part), 25, 4, 3) for part in (whole.y[:-1, 24:324], whole.x[1:, 48:]))
        shift = whole.y[:-1, [0, 1]]
        now = now.copy()
        now[:, :, 0, ::2] -= shift[:, None]
        np.testing.assert_allclose(np.einsum("tij,tkcj->tkci", to_next, now), following, atol=1e-7)

    def test_phases_updates_and_contacts_of_the_next_frame_follow(self, whole, limping):
        phases, contacts = signals(len(limping))
        np.testing.assert_array_equal(whole.p, phases[:-1])
        np.testing.assert_array_equal(whole.y[:, 324:332], phases[1:])
        np.testing.assert_allclose(whole.y[:, 332:340], phases[1:] - phases[:-1], atol=EXACT)
        np.testing.assert_array_equal(whole.y[:, 340:342], contacts[1:])


class TestWorld:
    @settings(max_examples=8)
    @given(st.floats(-10, 10), st.floats(-50, 50), st.floats(-50, 50))
    def test_moving_and_turning_the_whole_take_changes_nothing(self, limping, rest, whole, change, angle, x, z):
        clip = change.moved(limping, angle, x, z)
        other = made(forward_kinematics(clip), clip, rest)
        np.testing.assert_allclose(other.x, whole.x, atol=1e-8)
        np.testing.assert_allclose(other.y, whole.y, atol=1e-8)

    def test_nothing_that_was_given_is_changed(self, limping, pose, rest, whole, frozen):
        given = Pose(frozen(pose.positions), frozen(pose.rotations))
        phases, contacts = (frozen(part) for part in signals(len(limping)))
        again = vectors(given, limping.skeleton, frozen(rest), 60.0, phases, contacts)
        np.testing.assert_array_equal(again.x, whole.x)

    def test_a_take_shorter_than_the_windows_reach_has_finite_vectors(self, limping, rest):
        """At the ends of the shortest takes the path is reflected more than once."""
        short = limping.frames(0, 40)
        found = made(forward_kinematics(short), short, rest)
        assert len(found.x) == 39 and np.isfinite(found.x).all() and np.isfinite(found.y).all()


def image(values: np.ndarray, mirror: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    source, sign, _ = mirror
    return values[:, source] * sign


def assert_mirrored(clip: Clip, pose: Pose, other: Pose, rest: np.ndarray, *, atol: float) -> None:
    """The vectors of `other`, the mirror image of `pose`, are the mirrored vectors."""
    layout, (phases, contacts) = layout_of(clip.skeleton), signals(len(clip))
    whole = vectors(pose, clip.skeleton, rest, clip.fps, phases, contacts)
    turned = vectors(other, clip.skeleton, rest, clip.fps, image(phases, layout.mirror_p), contacts[:, ::-1])
    np.testing.assert_allclose(turned.x, image(whole.x, layout.mirror_x), atol=atol)
    np.testing.assert_array_equal(turned.p, image(whole.p, layout.mirror_p))
    np.testing.assert_allclose(turned.y, image(whole.y, layout.mirror_y), atol=atol)
    assert np.abs(turned.x - whole.x).max() > 0.1


def real_image(clip: Clip, pose: Pose) -> Pose:
    """The mirror image of a take on a skeleton whose joint frames are not known.

    For each joint the change of axes is, of all 24, the one that brings the image of its partner nearest to itself.
    """
    partner, root = clip.skeleton.mirrored, root_of(pose, clip.skeleton)
    level = np.einsum("tji,tkjl->tkil", root.matrices, pose.rotations)
    candidates = MIRROR @ Rotation.create_group("O").as_matrix()
    fit = np.einsum("tkij,cjl,tkil->kc", MIRROR @ level[:, partner], candidates, level)
    rotations = MIRROR @ pose.rotations[:, partner] @ candidates[fit.argmax(axis=1)]
    return Pose(pose.positions[:, partner] * [-1, 1, 1], rotations)


class TestMirror:
    """Mirroring the motion in the world and then making vectors is the same as mirroring the vectors."""

    def test_of_a_walker_whose_frames_stand_upright(self, limping, pose, rest, change):
        assert_mirrored(limping, pose, forward_kinematics(change.mirrored(limping)), rest, atol=EXACT)

    def test_of_a_walker_whose_frames_lie_in_any_way(self, limping, upright, change):
        """The rest pose comes from another style than the one that is mirrored."""
        odd = change.reframed(limping)
        rest = rest_axes(odd.skeleton, [change.reframed(upright)])
        other = forward_kinematics(change.reframed(change.mirrored(limping)))
        assert_mirrored(odd, forward_kinematics(odd), other, rest, atol=EXACT)

    def test_of_a_real_take_whose_frames_lie_along_the_bones(self, real_take):
        pose = forward_kinematics(real_take)
        other = real_image(real_take, pose)
        self.check_image(real_take, other)
        assert_mirrored(real_take, pose, other, rest_axes(real_take.skeleton, [real_take]), atol=EXACT)

    @staticmethod
    def check_image(clip: Clip, image: Pose) -> None:
        """The image is a pose of the same skeleton: its bones, turned as it says, end where it says, to 5 mm."""
        joints, parents = np.arange(1, len(clip.skeleton)), list(clip.skeleton.parents[1:])
        bones = np.einsum("tkij,kj->tki", image.rotations[:, parents], clip.skeleton.offsets[joints])
        np.testing.assert_allclose(image.positions[:, parents] + bones, image.positions[:, joints], atol=0.005)
        np.testing.assert_allclose(np.linalg.det(image.rotations), 1.0, atol=EXACT)


@pytest.fixture(params=["limping", "real_take"])
def take(request: pytest.FixtureRequest) -> Clip:
    return request.getfixturevalue(request.param)


def test_a_pose_can_be_drawn_from_its_vector(take):
    """Positions in x, turned and moved by the root, are the take's joints, to the rounding of single precision."""
    skeleton, pose = take.skeleton, forward_kinematics(take)
    found = made(pose, take, rest_axes(skeleton, [take]))
    layout, root = layout_of(skeleton), root_of(pose, skeleton)
    places = found.x.astype(np.float32)[:, layout.x_pose].reshape(len(found.x), layout.joints, 4, 3)[:, :, 0]
    world = (
        np.einsum("tij,tkj->tki", root.matrices[:-1], places) + np.insert(root.positions[:-1], 1, 0, axis=1)[:, None]
    )
    np.testing.assert_allclose(world, pose.positions[:-1, list(feature_joints(skeleton))], atol=1e-6)


def test_the_walker_has_the_joints_of_100style(skeletons):
    """So what is tested on it holds for the paper's data."""
    known = skeletons["100style"]
    assert (SKELETON.names, SKELETON.parents, SKELETON.sites) == (known.names, known.parents, known.sites)
