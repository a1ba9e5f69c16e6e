"""Rollouts, mixtures of styles, and the way back to a clip and its files."""

import numpy as np
import pytest
import tiny_walker as tiny
import torch

from stylephase.errors import InputError
from stylephase.features.body import Body
from stylephase.features.vectors import vectors
from stylephase.motion.bvh import read_bvh
from stylephase.motion.clip import Clip, forward_kinematics
from stylephase.motion.rest import rest_axes
from stylephase.motion.root import root_of, turn
from stylephase.runtime.controller import start_state
from stylephase.runtime.export import write_motion
from stylephase.runtime.plans import Steady
from stylephase.runtime.rollout import Rollout, mixed_code, parse_mixture, roll_out, to_clip


class TestRollOut:
    def test_a_network_that_knows_the_take_makes_it_again(self):
        """On a curve: from the origin, facing ahead, the take as seen from its first frame."""
        take, first, frames = tiny.take("Plain", turn=0.6), 100, 60
        start = start_state(take.vectors.x[[first]], take.vectors.p[[first]], tiny.BODY.layout)
        bundle, ticks = tiny.knowing(take.vectors.y[first : first + frames]), []
        run = roll_out(bundle, tiny.codes(1), start, frames, Steady(np.array([1.1])), tick=ticks.append)
        root = root_of(take.pose, take.clip.skeleton)
        back = turn(-root.angles[first : first + 1])[0]
        origin = np.array([root.positions[first, 0], 0.0, root.positions[first, 1]])
        expected = (take.pose.positions[first + 1 : first + 1 + frames, list(tiny.BODY.joints)] - origin) @ back.T
        np.testing.assert_allclose(run.positions[:, 0], expected, atol=1e-6)
        angles = root.angles[first + 1 : first + 1 + frames] - root.angles[first]
        np.testing.assert_allclose(run.root_angles[:, 0], angles, atol=1e-6)
        assert len(run) == frames == sum(ticks) and run.finite.all()

    def test_who_leaves_the_finite_numbers_is_told_from_the_others(self):
        class Bomb(torch.nn.Module):
            def forward(self, x, p, code):
                return torch.where(code[:, :1] > 0, torch.nan, torch.zeros(len(x), tiny.BODY.layout.outputs))

        bundle, codes = tiny.bundle("Plain", network=Bomb()), torch.tensor([[-1.0], [1.0], [-1.0]]).expand(3, 32)
        run = roll_out(bundle, codes, tiny.start([0, 0, 0]), 5, Steady(np.ones(3)))
        np.testing.assert_array_equal(run.finite, [True, False, True])


class TestMixture:
    @pytest.mark.parametrize(
        ("text", "mixture"),
        [
            ("Old", {"Old": 1.0}),
            ("Very old", {"Very old": 1.0}),
            ("set1-not-old", {"set1-not-old": 1.0}),
            ("Old:0.3,Plain:0.7", {"Old": 0.3, "Plain": 0.7}),
            (" Old:1 , set1-not-old:2e-1", {"Old": 1.0, "set1-not-old": 0.2}),
            ("Old,Plain", {"Old": 1.0, "Plain": 1.0}),
            ("own:a:0.5", {"own:a": 0.5}),
        ],
    )
    def test_styles_and_weights(self, text, mixture):
        assert parse_mixture(text) == mixture

    @pytest.mark.parametrize(
        ("text", "says"),
        [
            ("", "a name is missing"),
            ("Old,,Plain", "a name is missing"),
            (":0.5", "a name is missing"),
            ("Old:", "expected NAME:weight with a number"),
            ("Old:much", "expected NAME:weight with a number"),
            ("Old:0.5,Old:0.5", "named twice"),
        ],
    )
    def test_what_is_no_mixture_is_one_line(self, text, says):
        with pytest.raises(InputError, match=says):
            parse_mixture(text)

    def test_weights_are_brought_to_sum_1(self):
        bundle = tiny.bundle()
        mixed = mixed_code(bundle, {"Old": 1.0, "Plain": 3.0})
        torch.testing.assert_close(mixed, 0.25 * bundle.code("Old") + 0.75 * bundle.code("Plain"))
        torch.testing.assert_close(mixed_code(bundle, {"Old": 7.0}), bundle.code("Old"))
        torch.testing.assert_close(mixed_code(bundle, {"Old": 1.0, "Plain": 0.0}), bundle.code("Old"))

    @pytest.mark.parametrize("weights", [(-1.0, 2.0), (float("nan"), 1.0), (float("inf"), 1.0), (0.0, 0.0)])
    def test_weights_that_are_none_are_refused(self, weights):
        with pytest.raises(InputError, match="style weights should be numbers not below zero, with one above"):
            mixed_code(tiny.bundle(), dict(zip(("Old", "Plain"), weights, strict=True)))

    def test_an_unknown_style_is_answered_with_those_spelt_alike(self):
        with pytest.raises(InputError, match=r"no style 'plane' in these weights; did you mean Plain\?"):
            mixed_code(tiny.bundle(), {"plane": 1.0})
        with pytest.raises(InputError, match="there are Plain, Old, Very old, set1-not-old"):
            mixed_code(tiny.bundle(), {"Q": 1.0})


def read_off(clip: Clip) -> tuple[Rollout, Body]:
    """A rollout as a network would make it that predicts the take's own vectors, each frame at the origin."""
    body = Body(clip.skeleton, rest_axes(clip.skeleton, [clip]))
    rng, frames = np.random.default_rng(0), len(clip)
    signals = rng.normal(size=(frames, 8)), rng.random((frames, 2)) < 0.5
    made = vectors(forward_kinematics(clip), clip.skeleton, body.rest, clip.fps, *signals)
    state = start_state(made.x, made.p, body.layout)
    root = state.path.root
    parts = (state.positions, state.rotations, root.positions, root.angles, state.contacts, state.phases)
    return Rollout(*(part[:, None] for part in parts)), body


@pytest.fixture(params=["limping", "odd frames", "real_take"])
def take(request: pytest.FixtureRequest, change) -> Clip:
    """The walker, the same with joint frames that lie in any way, and a real take with frames along the bones."""
    if request.param == "odd frames":
        return change.reframed(request.getfixturevalue("limping"))
    return request.getfixturevalue(request.param)


class TestToClip:
    def test_true_vectors_give_back_the_motion(self, take):
        """Rotations of all joints in the world to 1e-5, and since the bones are the take's own, all positions."""
        run, body = read_off(take)
        pose = forward_kinematics(take)
        root = root_of(pose, take.skeleton)
        back = turn(-root.angles[:-1])[:, None]
        origin = np.insert(root.positions[:-1], 1, 0.0, axis=1)[:, None]
        found = forward_kinematics(to_clip(run, 0, body, "again"))
        moving = ~np.array(take.skeleton.sites)
        np.testing.assert_allclose(found.rotations[:, moving], (back @ pose.rotations[:-1])[:, moving], atol=1e-5)
        expected = np.einsum("taij,tkj->tki", back, pose.positions[:-1] - origin)
        np.testing.assert_allclose(found.positions, expected, atol=1e-5)

    def test_name_rate_and_skeleton_are_the_bodys(self, limping):
        run, body = read_off(limping)
        clip = to_clip(run, 0, body, "again")
        assert (clip.name, clip.fps, len(clip)) == ("again", 60.0, len(run)) and clip.skeleton is body.skeleton

    def test_a_file_keeps_the_tree_and_the_joints_to_a_tenth_of_a_millimetre_and_a_hundredth_of_a_degree(
        self, take, tmp_path
    ):
        run, body = read_off(take)
        clip = to_clip(run, 0, body, "again")
        write_motion(tmp_path / "again.bvh", clip, np.zeros((len(clip), 2), dtype=bool))
        found = read_bvh(tmp_path / "again.bvh", metres_per_unit=0.01)
        assert found.skeleton.names == clip.skeleton.names and found.fps == pytest.approx(60.0, abs=1e-3)
        pose, again = forward_kinematics(clip), forward_kinematics(found)
        np.testing.assert_allclose(again.positions, pose.positions, atol=1e-4)
        assert found.skeleton.parents == clip.skeleton.parents
        traces = np.einsum("tjab,tjab->tj", pose.rotations, again.rotations)
        assert np.degrees(np.arccos(np.clip((traces - 1) / 2, -1, 1))).max() < 0.01

    def test_each_character_has_a_clip_of_its_own(self):
        bundle = tiny.bundle()
        run = roll_out(bundle, tiny.codes(2), tiny.start([0, 100]), 10, Steady(np.ones(2)))
        one, other = (to_clip(run, k, bundle.body, "") for k in range(2))
        np.testing.assert_array_equal(one.root_positions, run.positions[:, 0, 0])
        np.testing.assert_array_equal(other.root_positions, run.positions[:, 1, 0])
        assert np.abs(one.rotations - other.rotations).max() > 0.01


class TestExport:
    @pytest.fixture
    def clip(self, limping) -> Clip:
        return limping.frames(0, 20)

    @pytest.fixture
    def contacts(self) -> np.ndarray:
        return np.arange(40).reshape(20, 2) % 3 == 0

    def test_an_npz_holds_positions_rotations_contacts_and_the_tree(self, clip, contacts, tmp_path):
        write_motion(tmp_path / "a.npz", clip, contacts)
        with np.load(tmp_path / "a.npz", allow_pickle=False) as found:
            assert sorted(found) == ["contacts", "fps", "names", "parents", "positions", "rotations"]
            np.testing.assert_array_equal(found["positions"], forward_kinematics(clip).positions)
            np.testing.assert_array_equal(found["rotations"], clip.rotations)
            np.testing.assert_array_equal(found["contacts"], contacts)
            assert tuple(found["names"]) == clip.skeleton.names and tuple(found["parents"]) == clip.skeleton.parents
            assert found["fps"] == 60.0

    @pytest.mark.parametrize("name", ["a.fbx", "a", "bvh"])
    def test_another_suffix_is_refused(self, clip, contacts, tmp_path, name):
        with pytest.raises(InputError, match=r"expected a name that ends in \.bvh or \.npz"):
            write_motion(tmp_path / name, clip, contacts)
        assert list(tmp_path.iterdir()) == []

    @pytest.mark.parametrize("suffix", [".bvh", ".npz"])
    def test_a_folder_that_is_a_file_is_one_line(self, clip, contacts, tmp_path, suffix: str):
        (tmp_path / "in").write_text("the way")
        with pytest.raises(InputError, match="cannot write"):
            write_motion(tmp_path / "in" / f"a{suffix}", clip, contacts)
