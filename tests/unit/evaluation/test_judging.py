"""Rollouts judged, and all that is measured as plain values: what ends well, what does not, and what is refused."""

import json
from dataclasses import replace

import numpy as np
import pytest
import tiny_walker as tiny
import torch

from stylephase.data.split import PARTS
from stylephase.errors import InputError
from stylephase.evaluation import report, rollouts
from stylephase.evaluation.rollouts import judge, judge_rollouts, local_poses, start_of, walking_rows, walking_speed
from stylephase.evaluation.style import StyleSpace, style_space
from stylephase.features.body import Body
from stylephase.features.store import StyleVectors
from stylephase.models.bundle import Bundle
from stylephase.motion.root import root_of
from stylephase.runtime import calibration
from stylephase.runtime.rollout import Rollout

STYLES = ("DraggedLeft", "Plain")
# Little more than what settles.
SECONDS = 3.3


@pytest.fixture(scope="module")
def styles() -> list[StyleVectors]:
    return [tiny.style_vectors(style, 30.0) for style in STYLES]


@pytest.fixture(scope="module")
def space(styles) -> StyleSpace:
    return style_space(styles, tiny.BODY.layout)


@pytest.fixture(scope="module")
def data() -> Rollout:
    """The walker's own takes, as if a network had made them."""
    joints, columns = list(tiny.BODY.joints), []
    for style in STYLES:
        take = tiny.take(style, 30.0)
        root = root_of(take.pose, take.clip.skeleton)
        rotations = take.pose.rotations[:, joints] @ tiny.BODY.rest[joints]
        contacts = take.contacts.astype(float)
        columns.append((take.pose.positions[:, joints], rotations, root.positions, root.angles, contacts))
    parts = [np.stack(part, axis=1) for part in zip(*columns, strict=True)]
    return Rollout(*parts, np.zeros((*parts[0].shape[:2], 8)))


@pytest.fixture
def hasty(monkeypatch) -> None:
    """Calibrates, walks, turns and stops within a few frames."""
    monkeypatch.setattr(calibration, "_TRIAL_SECONDS", 1.1)
    monkeypatch.setattr(calibration, "_ROUNDS", 1)
    monkeypatch.setattr(rollouts, "_TRIAL_SECONDS", 1.0)
    monkeypatch.setattr(rollouts, "_CUE_SECONDS", 0.2)
    monkeypatch.setattr(report, "_SHORTEST", SECONDS)


class Broken(torch.nn.Module):
    """A network that says NaN to characters whose code begins below zero, and the mean frame to the others."""

    def forward(self, x, p, code):
        return torch.where(code[:, :1] < 0, torch.nan, torch.zeros(len(x), tiny.BODY.layout.outputs))


@pytest.fixture
def broken() -> Bundle:
    bundle = tiny.bundle(*STYLES, network=Broken())
    return replace(bundle, codes={"DraggedLeft": torch.ones(32), "Plain": -torch.ones(32)})


class TestRows:
    def test_speed_and_start_are_those_of_the_data(self, styles):
        assert walking_speed(styles[0]) == pytest.approx(tiny.SPEED, rel=0.02)
        state = start_of(styles, tiny.BODY)
        heights = [style.x[len(style.rows("train")) // 2, 49] for style in styles]
        np.testing.assert_allclose(state.positions[:, 0, 1], heights, atol=1e-6)

    def test_a_style_whose_walk_is_not_for_training_takes_what_there_is(self, styles):
        rows = len(styles[0].x)
        take = np.repeat([0, 1], [rows // 2, rows - rows // 2])
        part = np.where(take == 0, PARTS.index("test"), PARTS.index("train"))
        style = replace(styles[0], gaits=("FW", "FR"), take=take, part=part)
        np.testing.assert_array_equal(walking_rows(style), np.flatnonzero(take == 1))
        start_of([style], tiny.BODY)

    def test_poses_of_a_rollout_are_those_of_the_vectors(self, data, styles):
        """So that generated and real motion are measured alike."""
        found = local_poses(data, 1)
        expected = styles[1].x[1:, tiny.BODY.layout.x_pose]
        np.testing.assert_allclose(found[: len(expected)], expected, atol=2e-5)


class TestJudge:
    def test_real_motion_passes(self, data, styles, space):
        for k, walk in enumerate(judge(data, tiny.bundle(*STYLES), styles, np.ones(2), space)):
            assert walk.finite and walk.style == STYLES[k] == walk.nearest and walk.right_style
            assert walk.speed_ratio == pytest.approx(1, abs=0.05)
            assert max(walk.bones.worst, walk.bones.off, walk.bones.drift) < 1e-6
            assert walk.hips == pytest.approx(walk.data_hips, abs=0.005)
            assert walk.steps.alternate and walk.correlation < 0 and walk.skate < 0.2

    def test_the_wrong_style_is_noticed(self, data, styles, space):
        swapped = judge(data, tiny.bundle(*STYLES), styles[::-1], np.ones(2), space)
        assert [walk.nearest for walk in swapped] == list(STYLES)
        assert not any(walk.right_style for walk in swapped)

    @pytest.mark.filterwarnings("error")
    def test_a_rollout_that_left_the_finite_numbers_spoils_no_other(self, data, styles, space):
        positions = data.positions.copy()
        positions[900:, 1] = np.nan
        fine, lost = judge(replace(data, positions=positions), tiny.bundle(*STYLES), styles, np.ones(2), space)
        assert fine.finite and fine.right_style
        assert not lost.finite and not lost.right_style and not lost.steps.alternate and np.isnan(lost.speed_ratio)


class TestJudgeRollouts:
    def test_everybody_walks_turns_and_stops(self, hasty, styles, space):
        ticks = []
        judgement, straight = judge_rollouts(tiny.bundle(*STYLES), styles, space, seconds=SECONDS, tick=ticks.append)
        assert len(straight) == 198 and sum(ticks) == 66 + 198 + 3 * 60
        assert [walk.style for walk in judgement.walks] == list(STYLES)
        assert set(judgement.turns) == set(judgement.stops) == set(STYLES)
        json.dumps(judgement.to_json(), allow_nan=False)

    @pytest.mark.filterwarnings("error")
    def test_what_is_not_finite_becomes_plain_values_too(self, hasty, broken, styles, space):
        judgement, _ = judge_rollouts(broken, styles, space, seconds=SECONDS)
        found = json.loads(json.dumps(judgement.to_json(), allow_nan=False))
        fine, lost = found["walks"]
        assert fine["finite"] and not lost["finite"] and not lost["alternate"]
        assert lost["speed"] is lost["bones"]["worst"] is lost["speed_ratio"] is None
        assert found["turns"]["Plain"] == 180.0 and found["stops"]["Plain"] is None


@pytest.fixture
def store(styles) -> tiny.Store:
    return tiny.Store(*styles)


def quiet(frames: int) -> None:
    pass


class TestEvaluate:
    def test_without_rollouts_there_are_errors_groups_and_codes(self, store):
        found = report.evaluate_bundle(tiny.bundle(*STYLES), store, seconds=0.0, tick=quiet)
        assert list(found) == ["about", "parameters", "input_rate", "errors", "groups", "codes"]
        assert list(found["errors"]) == list(STYLES) and list(found["groups"]) == ["all"]
        assert found["codes"]["between"] > 0 and found["codes"]["within"] > 0
        mean = np.mean([found["errors"][style]["hold"]["mse"] for style in STYLES])
        assert found["groups"]["all"]["hold"]["mse"] == pytest.approx(mean)
        assert report.table(found).count("\n") == 8

    def test_with_rollouts_every_style_has_a_line(self, hasty, store):
        found = report.evaluate_bundle(tiny.bundle(*STYLES), store, seconds=SECONDS, tick=quiet)
        json.dumps(found, allow_nan=False)
        right, clips = found["recognised"]["right"], found["recognised"]["clips"]
        assert right == clips >= 2
        lines = report.table(found).splitlines()
        assert [line.split()[0] for line in lines[-2:]] == list(STYLES)

    def test_the_table_says_who_did_not_stay_finite(self, hasty, store, broken):
        found = report.evaluate_bundle(broken, store, seconds=SECONDS, tick=quiet)
        assert report.table(found).splitlines()[-1].split(maxsplit=1) == ["Plain", "did not stay finite"]

    @pytest.mark.parametrize("seconds", [-1.0, 0.5, 4.9, 1e5, float("inf"), float("nan")])
    def test_rollouts_too_short_or_too_long_are_refused_before_anything_is_done(self, seconds, store, monkeypatch):
        monkeypatch.setattr(report, "test_errors", None)
        with pytest.raises(InputError, match=r"^rollouts of \S+ s; expected 0 for none, or 5 to 3600$"):
            report.evaluate_bundle(tiny.bundle(), store, seconds=seconds, tick=quiet)

    def test_data_with_another_skeleton_are_refused(self, store, skeletons):
        store.known = Body(skeletons["cmu"], np.tile(np.eye(3), (len(skeletons["cmu"]), 1, 1)))
        with pytest.raises(InputError, match="the weights know another skeleton than made has"):
            report.evaluate_bundle(tiny.bundle(*STYLES), store, seconds=0.0, tick=quiet)


@pytest.mark.parametrize(
    ("styles", "groups"),
    [
        (("set1-old", "set2-old", "set1-sad"), {"set1": ["set1-old", "set1-sad"], "set2": ["set2-old"]}),
        (("set2-old", "set2-sad"), {"all": ["set2-old", "set2-sad"]}),
        (("Old", "set1-old", "set2-old"), {"all": ["Old", "set1-old", "set2-old"]}),
        (("Old",), {"all": ["Old"]}),
    ],
)
def test_styles_are_grouped_by_what_stands_before_a_hyphen(styles, groups):
    assert report.groups_of(styles) == groups


def test_the_settling_frames_are_fewer_than_the_shortest_rollouts():
    assert rollouts.SETTLE / 60 + 1 < report._SHORTEST
