"""Keys, mixtures, speeds, paths and odd wishes of a played character."""

from dataclasses import replace

import numpy as np
import pytest
import tiny_walker as tiny
import torch
from hypothesis import given
from hypothesis import strategies as st

from stylephase.errors import InputError
from stylephase.motion.bvh import write_bvh
from stylephase.motion.clip import forward_kinematics
from stylephase.motion.root import Root, root_of
from stylephase.runtime import calibration, speeds
from stylephase.runtime.calibration import speed_of
from stylephase.runtime.controller import Controller, ControllerSettings, State, input_of
from stylephase.runtime.finishing import RAW
from stylephase.runtime.keyboard import RELEASE_KEYS, at_rest, steer_by_keys
from stylephase.runtime.limits import FASTEST, MOST_WISH, limited, teleported, within_limits
from stylephase.runtime.mixtures import CORNERS, around, barycentric, triangle_mixture
from stylephase.runtime.paths import SPACING, FollowPaths, Recorded, drawn_path, even_path, read_walk, record_of
from stylephase.runtime.plans import FollowPath, Steady
from stylephase.runtime.player import Player
from stylephase.runtime.rig import rig_of
from stylephase.runtime.rollout import roll_out
from stylephase.runtime.speeds import SpeedCurve, mixed_gain, mixed_speed, speed_curves
from stylephase.runtime.trajectory import Steering

PARENTS = list(rig_of(tiny.BODY).parents[1:])
LENGTHS = np.linalg.norm(rig_of(tiny.BODY).offsets[1:], axis=-1)
STRAIGHT = SpeedCurve(np.arange(0.25, 12.0, 0.25), np.arange(0.25, 12.0, 0.25))
NAN, INF = float("nan"), float("inf")


def held_for(keys: str, frames: int, state: State, settings=None) -> Steering:
    """The wish after the keys have been held for some frames by a character that does not turn."""
    wish = at_rest(state)
    for _ in range(frames):
        wish = steer_by_keys(set(keys.split()), wish, state, np.array([1.0]), settings)
    return wish


class TestKeys:
    @pytest.mark.parametrize(
        ("keys", "velocity"),
        [("w", (0, 1)), ("s", (0, -1)), ("a", (1, 0)), ("d", (-1, 0)), ("w a", (0.5**0.5, 0.5**0.5)), ("W", (0, 1))]
        + [("w shift", (0, 2)), ("w s", (0, 0)), ("shift", (0, 0)), ("x", (0, 0)), ("", (0, 0))],
    )
    def test_they_move_with_left_towards_positive_x(self, keys, velocity):
        np.testing.assert_allclose(held_for(keys, 60, tiny.start([0])).velocity, [velocity], atol=1e-6)

    def test_a_wish_comes_by_quarters_and_goes_when_the_keys_are_let_go(self):
        state = tiny.start([0])
        one = held_for("w", 1, state)
        np.testing.assert_allclose(one.velocity, [[0, 0.25]])
        np.testing.assert_allclose(steer_by_keys("", one, state, np.ones(1)).velocity, [[0, 0.1875]])
        np.testing.assert_array_equal(steer_by_keys("", one, state, np.ones(1), RELEASE_KEYS).velocity, one.velocity)

    def test_turning_asks_for_60_degrees_off_the_own_facing(self):
        state = tiny.turned(tiny.start([0]), 3.0, np.zeros(2))
        for keys, sign in (("q", 1), ("e", -1)):
            wish = held_for(keys, 60, state)
            off = wish.facing - (state.path.root.angles + sign * np.radians(60))
            np.testing.assert_allclose(np.sin(off), 0, atol=1e-6)
            assert abs(wish.facing[0] - state.path.root.angles[0]) < np.pi
        np.testing.assert_allclose(np.sin(held_for("q e", 60, state).facing - 3.0), 0, atol=1e-6)

    def test_without_a_turning_key_the_facing_wanted_stays_and_the_releases_follows_the_body(self):
        here, there = tiny.start([0]), tiny.turned(tiny.start([0]), 0.4, np.zeros(2))
        wish = held_for("w", 5, here)
        assert steer_by_keys("w", wish, there, np.ones(1)).facing == wish.facing
        assert steer_by_keys("w", wish, there, np.ones(1), RELEASE_KEYS).facing == pytest.approx(0.1, abs=1e-6)


class TestTriangle:
    @given(st.tuples(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6)))
    def test_weights_are_a_mixture_everywhere(self, point):
        weights = barycentric(point)
        assert (weights >= 0).all() and weights.sum() == pytest.approx(1)

    @given(st.lists(st.floats(0.01, 1), min_size=3, max_size=3))
    def test_inside_the_point_is_the_mean_of_the_corners(self, parts):
        weights = np.array(parts) / sum(parts)
        np.testing.assert_allclose(barycentric(weights @ CORNERS), weights, atol=1e-9)

    def test_outside_the_nearest_point_counts(self):
        np.testing.assert_allclose(barycentric((0.25, -1.0)), [0.75, 0.25, 0], atol=1e-9)
        np.testing.assert_allclose(barycentric((-5.0, -0.1)), [1, 0, 0], atol=1e-9)
        np.testing.assert_allclose(barycentric((0.5, 99.0)), [0, 0, 1], atol=1e-9)

    @pytest.mark.parametrize("point", [(NAN, 0.0), (INF, 0.0), (1.0,), (1.0, 2.0, 3.0)])
    def test_what_is_no_point_is_refused(self, point):
        with pytest.raises(InputError, match="two finite numbers"):
            barycentric(point)

    def test_round_the_triangle_are_the_corners_in_turn_and_the_middles_of_the_sides(self):
        corners = np.array([around(float(k)) for k in range(4)])
        np.testing.assert_allclose(corners, CORNERS[[0, 1, 2, 0]])
        np.testing.assert_allclose(around(1.5), (CORNERS[1] + CORNERS[2]) / 2)

    def test_one_style_at_two_corners_has_both_weights(self):
        mixture = triangle_mixture(("Old", "Plain", "Old"), CORNERS.mean(axis=0))
        assert mixture == {"Old": pytest.approx(2 / 3), "Plain": pytest.approx(1 / 3)}


class TestSpeeds:
    def test_a_gain_is_read_off_the_curve(self):
        curve = SpeedCurve(np.array([1.0, 2.0, 4.0]), np.array([0.5, 0.8, 1.2]))
        assert curve.gain(0.65) == pytest.approx(1.5) and curve.gain(1.0) == pytest.approx(3.0)
        assert curve.gain(0.1) == 1.0 and curve.gain(9.0) == 4.0
        assert curve.gain(0.0) == curve.gain(-1.0) == curve.gain(NAN) == 0.0

    def test_where_a_higher_gain_is_slower_the_least_gain_counts(self):
        assert SpeedCurve(np.array([1.0, 2.0, 3.0, 4.0]), np.array([1.0, 0.7, 0.9, 1.2])).gain(1.0) == 1.0

    def test_within_a_leap_the_nearer_gait_is_taken(self):
        curve = SpeedCurve(np.array([1.0, 3.0]), np.array([1.0, 3.0]))
        assert curve.gain(1.8) == 1.0 and curve.gain(2.2) == 3.0

    def test_the_speed_of_a_gain_is_the_wanted_one_where_the_style_has_it(self):
        curve = SpeedCurve(np.array([1.0, 2.0, 4.0]), np.array([0.5, 0.8, 1.2]))
        assert [curve.reached(speed) for speed in (0.65, 1.0, 9.0, 0.1, 0.0)] == pytest.approx([0.65, 1.0, 1.2, 0.5, 0])
        leap = SpeedCurve(np.array([1.0, 3.0]), np.array([1.0, 3.0]))
        assert (leap.reached(1.8), leap.reached(2.2)) == (1.0, 3.0)
        assert mixed_speed({"a": curve, "b": leap}, {"a": 1.0, "b": 3.0}, 0.8) == pytest.approx(0.95)

    def test_a_mixtures_gain_is_the_mean_whatever_the_weights_sum(self):
        curves = {"Old": SpeedCurve(np.array([1.0, 2.0]), np.array([0.5, 1.0])), "Plain": STRAIGHT}
        assert mixed_gain(curves, {"Old": 3.0, "Plain": 1.0}, 1.0) == pytest.approx(0.75 * 2 + 0.25 * 1)

    def test_a_curve_is_what_the_walker_does_and_a_speed_is_reached(self, monkeypatch):
        monkeypatch.setattr(speeds, "_SECONDS", 3.0)
        bundle, start = tiny.bundle(network=tiny.Obedient()), tiny.start([0, 0])
        curves = speed_curves(bundle, tiny.STYLES[:2], start)
        for style in tiny.STYLES[:2]:
            gains = np.array([curves[style].gain(1.1)])
            run = roll_out(bundle, bundle.code(style)[None], tiny.start([0]), 240, Steady(gains))
            assert speed_of(run.root_positions[120:, 0]) == pytest.approx(1.1, rel=0.1)

    def test_a_style_that_never_stays_finite_is_named(self, monkeypatch):
        monkeypatch.setattr(speeds, "_SECONDS", 0.2)
        bundle = tiny.bundle(
            "Plain", network=tiny.knowing(np.full((12, tiny.BODY.layout.outputs), NAN)).network.synthesis
        )
        with pytest.raises(InputError, match="style Plain does not stay finite"):
            speed_curves(bundle, ["Plain"], tiny.start([0]))


class TestPaths:
    def test_points_are_evenly_apart_and_the_ends_stay(self):
        path = even_path([[0, 0], [0, 0], [0, 3], [4, 3]])
        np.testing.assert_allclose(path[[0, -1]], [[0, 0], [4, 3]])
        assert np.linalg.norm(np.diff(path, axis=0), axis=1).max() <= SPACING + 1e-9

    @pytest.mark.parametrize(
        "points",
        [[], [[0, 0]], [[1, 1]] * 9, [[0, 0], [0, 0.1]], [[0, 0], [NAN, 1]], [[0, 0], [0, 1e9]], [[0, 0, 0]] * 2],
    )
    def test_what_is_no_path_is_refused(self, points):
        with pytest.raises(InputError, match="a path should be"):
            drawn_path(points)

    def test_a_trembling_line_becomes_smooth(self):
        way = np.linspace(0, 5, 60)
        line = np.stack([0.05 * (-1.0) ** np.arange(60), way], axis=1)
        assert np.abs(drawn_path(line)[2:-2, 0]).max() < 0.01

    def test_each_character_follows_its_own(self):
        """To the left and to the right of the start, at two speeds."""
        turns = [even_path([[0, 0], [0, 2], [side * 6, 2]]) for side in (1, -1)]
        plan = FollowPaths(turns, np.array([1.0, 2.0]))
        bundle = tiny.bundle(network=tiny.Obedient())
        run = roll_out(bundle, tiny.codes(2), tiny.start([0, 0]), 300, plan)
        np.testing.assert_allclose(run.root_positions[-1, :, 1], 2.0, atol=0.3)
        assert run.root_positions[-1, 0, 0] > 0.5 and run.root_positions[-1, 1, 0] < -2 and plan.off.max() < 0.3
        again = roll_out(bundle, tiny.codes(2), tiny.start([0, 0]), 300, plan)
        np.testing.assert_array_equal(again.root_positions, run.root_positions)

    def test_a_recorded_walk_is_walked_again(self):
        bundle, start = tiny.bundle(network=tiny.Obedient()), tiny.start([0])
        run = roll_out(bundle, tiny.codes(1), start, 300, Steady(np.array([1.2]), turn=0.5))
        walked = Root(run.root_positions[:, 0], run.root_angles[:, 0])
        again = roll_out(bundle, tiny.codes(1), start, 300, record_of([walked], np.ones(1)))
        apart = np.linalg.norm(again.root_positions - run.root_positions, axis=-1)
        assert apart.max() < 0.35 and np.linalg.norm(run.root_positions[-1]) > 2

    def test_a_file_of_a_walk_is_read_from_the_origin_on_whichever_way_it_went(self, tmp_path):
        clip = tiny.take(turn=0.4).clip
        write_bvh(tmp_path / "walk.bvh", clip)
        root = root_of(forward_kinematics(clip), clip.skeleton)
        found = read_walk(tmp_path / "walk.bvh")
        assert np.abs(found.positions[0]).max() < 1e-9 and abs(found.angles[0]) < 1e-9
        assert abs(speed_of(found.positions) - speed_of(root.positions)) < 1e-3
        np.testing.assert_allclose(np.diff(found.angles), np.diff(root.angles), atol=1e-4)
        # The way's angle to the facing is the same from any side.
        way = [np.diff(r.positions, axis=0) for r in (found, root)]
        ahead = [(w * r.directions[:-1]).sum(axis=1) for w, r in zip(way, (found, root), strict=True)]
        np.testing.assert_allclose(ahead[0], ahead[1], atol=1e-4)

    def test_past_its_end_a_recorded_walk_stands(self):
        plan = Recorded(np.zeros((5, 1, 2)), np.zeros((5, 1)), np.ones(1))
        np.testing.assert_allclose(plan(900, tiny.start([0])).velocity, 0, atol=1e-9)
        with pytest.raises(InputError, match="recorded walk"):
            Recorded(np.full((5, 1, 2), NAN), np.zeros((5, 1)), np.ones(1))

    @pytest.mark.parametrize("points", [np.zeros((3, 2)), np.array([[0.0, 0.0], [NAN, 1.0]])])
    def test_a_path_of_no_length_or_no_numbers_is_refused_by_the_plan(self, points):
        with pytest.raises(InputError, match="a path"):
            FollowPath(points, np.ones(1))


class TestLimits:
    def test_ordinary_wishes_pass_unchanged(self):
        wish = Steering(np.array([[0.0, 6.0]]), np.array([2.0]))
        same = limited(wish, tiny.start([0]))
        np.testing.assert_array_equal(same.velocity, wish.velocity)
        np.testing.assert_array_equal(same.facing, wish.facing)

    def test_what_is_no_number_counts_as_none_and_what_is_too_much_is_cut(self):
        state = tiny.turned(tiny.start([0, 0, 0]), 0.7, np.zeros(2))
        wish = Steering(np.array([[NAN, 1.0], [60.0, 80.0], [INF, 0.0]]), np.array([NAN, 0.1, INF]))
        found = limited(wish, state)
        np.testing.assert_allclose(found.velocity, [[0, 0], [0.6 * MOST_WISH, 0.8 * MOST_WISH], [0, 0]])
        np.testing.assert_allclose(found.facing, [0.7, 0.1, 0.7], atol=1e-9)

    @pytest.mark.parametrize("huge", [1e20, 1e200, 1.7e308])
    def test_a_huge_wish_keeps_its_direction_and_has_the_length_of_the_most(self, huge):
        wish = Steering(np.array([[0.6 * huge, -0.8 * huge], [0.0, huge]]), np.zeros(2))
        with np.errstate(all="raise"):
            found = limited(wish, tiny.start([0, 0]))
        np.testing.assert_allclose(found.velocity, MOST_WISH * np.array([[0.6, -0.8], [0.0, 1.0]]), atol=1e-9)

    @pytest.mark.parametrize("wish", [NAN, INF, -INF, 100.0, 1e30, 1e200])
    def test_an_absurd_wish_for_a_second_leaves_the_character_finite(self, wish):
        plan = within_limits(lambda frame, state: Steering(np.full((1, 2), wish), np.full(1, wish)))
        run = roll_out(tiny.bundle(network=tiny.Obedient()), tiny.codes(1), tiny.start([0]), 60, plan)
        assert run.finite.all() and np.abs(run.root_positions).max() < 1.1 * MOST_WISH

    def test_a_character_that_is_put_elsewhere_sees_what_it_saw(self):
        state = tiny.turned(tiny.start([0, 100]), 0.3, np.array([2.0, -1.0]))
        there = teleported(state, np.array([[900.0, 0.0], [0.0, -40.0]]), np.array([3.0, -2.0]))
        np.testing.assert_allclose(input_of(there), input_of(state), atol=1e-9)
        np.testing.assert_allclose(there.path.root.positions, [[900, 0], [0, -40]])
        np.testing.assert_allclose(there.path.root.angles, [3, -2])


class TestPlayer:
    @pytest.fixture(autouse=True)
    def hasty(self, monkeypatch) -> None:
        monkeypatch.setattr(calibration, "_WARM_UP_SECONDS", 0.1)

    def player(self, **given) -> Player:
        curves = dict.fromkeys(tiny.STYLES, STRAIGHT)
        return Player(tiny.bundle(network=tiny.Obedient()), tiny.STYLES[:3], curves=curves, **given)

    def test_keys_move_it_and_nothing_else_does(self):
        player = self.player()
        for keys, least, most in (((), 0.0, 0.2), (("w",), 0.4, 1.1)):
            before = player.state.path.root.positions
            player.hold(keys)
            for _ in range(60):
                player.step()
            assert least <= np.linalg.norm(player.state.path.root.positions - before) <= most

    @pytest.mark.parametrize(
        ("keys", "held"), [("shift", {"shift"}), ("W", {"w"}), ("", set()), (["w", "q"], {"w", "q"})]
    )
    def test_a_word_is_the_name_of_one_key(self, keys, held):
        """Not its letters: `s` of `shift` would walk backward."""
        player = self.player()
        player.hold(keys)
        assert player.held == held

    def test_a_new_mixture_comes_smoothly_and_whole(self):
        player = self.player()
        before = player.code
        player.mix((0.0, 0.0))
        player.step()
        target = player.walker.code({tiny.STYLES[0]: 1.0})
        torch.testing.assert_close(player.code, before + 0.1 * (target - before))
        for _ in range(150):
            player.step()
        torch.testing.assert_close(player.code, target, atol=1e-4, rtol=1e-4)

    def test_a_drawn_path_is_followed_to_its_end_and_a_key_ends_it(self):
        player = self.player(speed=1.5)
        player.follow([[0.0, 1.0], [1.0, 2.0]])
        for _ in range(240):
            player.step()
        assert np.linalg.norm(player.state.path.root.positions[0] - [1, 2]) < 1.5 and player.path is None
        player.follow([[3.0, 3.0], [5.0, 3.0]])
        player.hold({"s"})
        assert player.path is None

    @pytest.mark.parametrize(
        ("speed", "taken"), [(NAN, 0.0), (-1.0, 0.0), (INF, FASTEST), (100.0, FASTEST), (1.3, 1.3)]
    )
    def test_odd_speeds_have_a_defined_effect(self, speed, taken):
        player = self.player()
        player.speed = speed
        assert player.speed == taken
        player.hold({"w"})
        for _ in range(30):
            player.step()
        assert np.isfinite(player.state.positions).all()

    def test_what_cannot_be_is_refused_and_changes_nothing(self):
        player = self.player()
        asked = {"choose": ["Old", "Plain"], "mix": (NAN, 0.0), "follow": [[0.0, 0.0]]}
        for name, value in asked.items():
            with pytest.raises(InputError):
                getattr(player, name)(value)
        with pytest.raises(InputError, match="no style"):
            player.choose(["Old", "Plain", "Nobody"])
        del player.curves["Old"]
        with pytest.raises(InputError, match="have not been measured"):
            player.choose(["Old"] * 3)
        assert player.styles == tiny.STYLES[:3] and player.path is None
        np.testing.assert_allclose(player.weights, 1 / 3)

    @pytest.mark.parametrize(
        ("name", "value", "says"),
        [
            ("mix", "left", "a point of the triangle should be of numbers, not 'left'"),
            ("mix", None, "a point of the triangle should be of numbers, not None"),
            ("mix", [0.1, None], "should be of numbers"),
            ("follow", [[0.0, 1.0], [None, 2.0]], "a path should be of numbers"),
            ("mix", [[0, 1], [2]], "should be of numbers"),
            ("follow", "0 0 1 1", "a path should be of numbers, not '0 0 1 1'"),
            ("follow", {"x": 1}, "a path should be of numbers"),
            ("follow", [1.0, 2.0], "points of two finite numbers each"),
            ("hold", 5, "keys should be names of keys, not 5"),
            ("hold", [1, None], "keys should be names of keys"),
            ("choose", "Old", "three names of styles, not 'Old'"),
            ("choose", [1, 2, 3], "three names of styles"),
            ("choose", None, "three names of styles"),
        ],
    )
    def test_words_where_numbers_belong_are_refused_in_one_line(self, name, value, says):
        player = self.player()
        with pytest.raises(InputError, match=says) as refused:
            getattr(player, name)(value)
        assert "\n" not in str(refused.value) and player.held == frozenset() and player.path is None

    def test_a_speed_is_a_number(self):
        player = self.player()
        for odd in ("fast", [1, 2], {}, None):
            with pytest.raises(InputError, match="a speed should be"):
                player.speed = odd
        assert player.speed == 1.0

    def test_a_character_that_bursts_starts_anew(self, monkeypatch):
        player = self.player()
        step, burst = player.walker.step, {"at": 5}

        def bursting(codes, state: State, steering) -> State:
            after, burst["at"] = step(codes, state, steering), burst["at"] - 1
            return replace(after, positions=after.positions * NAN) if burst["at"] == 0 else after

        monkeypatch.setattr(player.walker, "step", bursting)
        for _ in range(8):
            assert np.isfinite(player.step().positions).all()
        assert player.frame == 3

    def test_frames_are_finished_unless_raw_is_asked_for(self):
        """Bones of the shown pose are the skeleton's, and the network goes on with its own pose."""
        for finishing, constant in ((None, True), (RAW, False)):
            player = self.player(finishing=finishing)
            player.code = player.code + 1
            shown = player.step()
            lengths = np.linalg.norm(shown.positions[0, 1:] - shown.positions[0, PARENTS], axis=-1)
            assert (np.abs(lengths - LENGTHS).max() < 1e-9) == constant
            assert (np.abs(shown.positions - player.state.positions).max() > 1e-3) == constant

    def test_shift_multiplies_the_speed_wanted_and_not_the_gain_of_walking(self):
        player = self.player(speed=1.0)
        player.curves = dict.fromkeys(tiny.STYLES, SpeedCurve(np.array([1.0, 2.0, 9.0]), np.array([0.5, 1.0, 2.0])))
        player.hold({"w", "shift"})
        for _ in range(60):
            player.step()
        assert np.linalg.norm(player.wish.velocity) == pytest.approx(9.0, rel=0.05)

    def test_styles_without_a_curve_are_measured(self, monkeypatch):
        monkeypatch.setattr(speeds, "_SECONDS", 1.5)
        player = Player(tiny.bundle(network=tiny.Obedient()), tiny.STYLES[:3])
        assert player.curves.keys() == set(tiny.STYLES[:3])


def test_a_controller_takes_a_new_code_between_two_frames():
    controller = Controller(tiny.bundle(), tiny.codes(1), ControllerSettings())
    state, wish = tiny.start([0]), Steering(np.zeros((1, 2)), np.zeros(1))
    before = controller.step(state, wish)
    controller.codes = tiny.codes(2)[1:]
    assert np.abs(controller.step(state, wish).positions - before.positions).max() > 1e-4
