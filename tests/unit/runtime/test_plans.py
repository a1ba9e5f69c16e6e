"""Plans: what is wanted over time, that a path is followed to its end and beyond, and that bad files are named."""

from dataclasses import replace
from itertools import groupby

import numpy as np
import pytest
import tiny_walker as tiny

from stylephase.errors import InputError
from stylephase.runtime.controller import State
from stylephase.runtime.plans import FollowPath, Steady, TurnOnce, heading, read_path
from stylephase.runtime.trajectory import PAST

SPEEDS = np.array([1.0, 2.0])


@pytest.fixture(scope="module")
def state() -> State:
    return tiny.start([0, 0])


def at(state: State, *places: tuple[float, float]) -> State:
    """The characters at some places (x, z)."""
    shift = np.array(places)[:, None] - state.path.positions[:, PAST : PAST + 1]
    return replace(state, path=replace(state.path, positions=state.path.positions + shift))


class TestSteady:
    def test_it_goes_straight_at_each_characters_speed(self, state):
        wanted = Steady(SPEEDS)(500, state)
        np.testing.assert_allclose(wanted.velocity, [[0, 1], [0, 2]], atol=1e-12)
        np.testing.assert_array_equal(wanted.facing, [0, 0])

    def test_turning_left_turns_towards_positive_x(self, state):
        wanted = Steady(SPEEDS, turn=np.pi / 2)(60, state)
        np.testing.assert_allclose(wanted.velocity, [[1, 0], [2, 0]], atol=1e-12)
        np.testing.assert_allclose(wanted.facing, np.pi / 2)

    def test_a_side_step_keeps_the_facing(self, state):
        wanted = Steady(SPEEDS, strafe=np.pi / 2)(60, state)
        np.testing.assert_allclose(wanted.velocity, [[1, 0], [2, 0]], atol=1e-12)
        np.testing.assert_array_equal(wanted.facing, [0, 0])

    def test_it_stops_when_it_is_time(self, state):
        plan = Steady(SPEEDS, until=100.0)
        assert np.linalg.norm(plan(99, state).velocity[0]) == 1
        np.testing.assert_array_equal(plan(100, state).velocity, 0.0)


def test_turn_once_turns_at_its_frame(state):
    plan = TurnOnce(SPEEDS, -np.pi / 2, at=10)
    np.testing.assert_allclose(plan(9, state).velocity, [[0, 1], [0, 2]], atol=1e-12)
    np.testing.assert_allclose(plan(10, state).velocity, [[-1, 0], [-2, 0]], atol=1e-12)
    np.testing.assert_allclose(plan(10, state).facing, -np.pi / 2)


def walk(plan: FollowPath, state: State, seconds: float, sway: float = 0.0) -> np.ndarray:
    """Where two characters go that do at every frame as they are told, but sway from side to side."""
    places = np.zeros((2, 2))
    way = []
    for frame in range(int(seconds * 60)):
        wanted = plan(frame, at(state, *places))
        across = wanted.velocity[:, ::-1] * [1, -1] * sway * np.sin(frame / 5)
        places = places + (wanted.velocity + across) / 60
        way.append(places)
    return np.array(way)


class TestFollowPath:
    LINE = np.array([[0.0, 0.0], [0.0, 1.0], [0.0, 4.0]])

    def test_it_heads_for_a_point_ahead_and_faces_it(self, state):
        """Half a metre to the right of the path, 0.8 m ahead along it."""
        wanted = FollowPath(self.LINE, SPEEDS)(0, at(state, (-0.5, 1.0), (0.0, 0.3)))
        angle = np.arctan2(0.5, 0.8)
        np.testing.assert_allclose(wanted.facing, [angle, 0.0], atol=1e-12)
        np.testing.assert_allclose(wanted.velocity, SPEEDS[:, None] * heading(np.array([angle, 0.0])), atol=1e-12)

    def test_past_its_end_it_goes_straight_on(self, state):
        way = walk(FollowPath(self.LINE, SPEEDS), state, 8.0)
        np.testing.assert_allclose(way[-1], [[0, 8], [0, 16]], atol=1e-6)

    def test_it_stops_at_its_end_where_it_should_and_tells_when_it_came_there(self, state):
        plan = FollowPath(self.LINE, SPEEDS, stops=True)
        way = walk(plan, state, 8.0)
        np.testing.assert_allclose(way[-1], [[0, 4], [0, 4]], atol=0.31)
        assert 3.5 * 60 < plan.arrived[0] < 4 * 60 and plan.arrived[1] == pytest.approx(plan.arrived[0] / 2, abs=2)
        still = plan(500, at(state, (0.0, 4.0), (0.5, 4.1)))
        np.testing.assert_allclose(still.velocity, 0.0)
        np.testing.assert_allclose(still.facing, 0.0, atol=1e-12)
        assert plan.off == pytest.approx([0.0, 0.5])

    def test_a_corner_is_taken(self, state):
        corner = np.array([[0.0, 0.0], [0.0, 3.0], [3.0, 3.0]])
        way = walk(FollowPath(corner, SPEEDS), state, 6.0)
        np.testing.assert_allclose(way[-1, :, 1], 3.0, atol=0.05)
        assert (way[-1, :, 0] > 2).all()

    @pytest.mark.parametrize("sway", [0.0, 0.3])
    def test_a_closed_path_is_walked_all_round(self, state, sway):
        """It begins where it ends: the nearest point of it may be its last."""
        angle = np.linspace(0, 2 * np.pi, 60)
        circle = 2 * np.stack([1 - np.cos(angle), np.sin(angle)], axis=1)
        way = walk(FollowPath(circle, SPEEDS), state, 11.0, sway)[:, 0] - [2, 0]
        np.testing.assert_allclose(np.linalg.norm(way, axis=1), 2, atol=0.3)
        rounds = np.unwrap(np.arctan2(way[:, 1], way[:, 0]))
        assert abs(rounds[-1] - rounds[0]) > np.radians(300)

    def test_a_path_that_crosses_itself_is_walked_in_its_order(self, state):
        """A figure of eight: its quarters come one after the other, though two of them meet in the middle."""
        angle = np.linspace(0, 2 * np.pi, 200)
        eight = 3 * np.stack([np.sin(2 * angle) / 2, np.sin(angle)], axis=1)
        way = walk(FollowPath(eight, SPEEDS), state, 14.0)[:, 0]
        signs = [(x > 0, z > 0) for x, z in way if min(abs(x), abs(z)) > 0.5]
        assert [key for key, _ in groupby(signs)] == [(True, True), (False, True), (True, False), (False, False)]

    def test_from_aside_it_comes_to_the_path(self, state):
        way = walk(FollowPath(self.LINE + [2.0, 1.0], SPEEDS), state, 6.0)
        np.testing.assert_allclose(way[-1, :, 0], 2.0, atol=0.1)

    def test_frame_0_begins_anew(self, state):
        """One plan may drive two rollouts."""
        plan = FollowPath(self.LINE, SPEEDS)
        np.testing.assert_array_equal(walk(plan, state, 3.0), walk(plan, state, 3.0))

    def test_on_its_last_point_it_has_a_direction(self, state):
        plan = FollowPath(np.array([[0.0, 0.0], [0.0, 1.0]]), SPEEDS)
        wanted = plan(0, at(state, (0.0, 1.0), (0.0, 1.8)))
        np.testing.assert_allclose(wanted.facing, 0.0, atol=1e-12)


class TestReadPath:
    @pytest.mark.parametrize("text", ["0 0\n1 2\n", "\ufeff0,0\r\n1,2\r\n", " 0.0 , 0\n\n1\t2", "0 0\n0 0\n1 2"])
    def test_points_stand_one_a_line(self, tmp_path, text):
        file = tmp_path / "path.txt"
        file.write_bytes(text.encode())
        np.testing.assert_array_equal(read_path(file), [[0, 0], [1, 2]])

    @pytest.mark.parametrize(
        ("text", "says"),
        [
            ("0 0\n1 nan\n", ":2: expected two finite numbers, found '1 nan'"),
            ("0 0\n1 inf\n", ":2: expected two finite numbers, found '1 inf'"),
            ("0 0\n\n1\n", ":3: expected two finite numbers, found '1'"),
            ("0 0 0\n", ":1: expected two finite numbers, found '0 0 0'"),
            ("x z\n0 0\n", ":1: expected two numbers, found 'x z'"),
            ("", ": a path needs two different points, found 0"),
            ("1 1\n", ": a path needs two different points, found 1"),
            ("1 1\n1 1\n", ": a path needs two different points, found 1"),
        ],
    )
    def test_what_is_no_path_is_named_with_its_line(self, tmp_path, text, says):
        file = tmp_path / "path.txt"
        file.write_text(text)
        with pytest.raises(InputError) as caught:
            read_path(file)
        assert str(caught.value) == f"{file}{says}"

    def test_no_such_file_a_folder_and_bytes_that_are_no_text(self, tmp_path):
        (tmp_path / "bytes").write_bytes(b"\xff\xfe\x00\x01")
        for file in (tmp_path / "none", tmp_path, tmp_path / "bytes", tmp_path / "bytes" / "below"):
            with pytest.raises(InputError, match="no such text file"):
                read_path(file)
