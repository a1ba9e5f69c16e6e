"""Predictors of the next frame, naive and trained, and the test that all of them take."""

import sys
from dataclasses import astuple, replace

import numpy as np
import pytest
import tiny_walker as tiny
import torch

import stylephase.evaluation.test_error  # noqa: F401, a function in it begins as a test does
from stylephase.data.split import PARTS
from stylephase.evaluation.predictors import (
    fit_ridge,
    predict_hold,
    predict_mean,
    predict_network,
    untrained,
)
from stylephase.features.normaliser import Normaliser
from stylephase.features.store import StyleVectors
from stylephase.models.bundle import Bundle
from stylephase.training.losses import bone_lengths

module = sys.modules["stylephase.evaluation.test_error"]
LAYOUT = tiny.BODY.layout
STYLES = ("Plain", "Giant")


@pytest.fixture(scope="module")
def rows() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    made = tiny.take().vectors
    return made.x[100:110], made.p[100:110], made.y[100:110]


@pytest.fixture(scope="module")
def styles() -> list[StyleVectors]:
    return [replace(tiny.style_vectors(), style=style) for style in STYLES]


@pytest.fixture
def bundle() -> Bundle:
    return tiny.bundle(*STYLES)


class TestNaive:
    def test_the_mean_is_always_the_mean(self, rows):
        predicted = predict_mean(tiny.statistics())(*rows[:2])
        np.testing.assert_array_equal(predicted, np.tile(tiny.statistics().y_mean, (10, 1)))

    def test_hold_is_the_frame_itself(self, rows):
        """Pose and phases as they are, the trajectory's samples from the present on, nothing changes."""
        x, p, _ = rows
        y = predict_hold(LAYOUT, tiny.statistics())(x, p)
        np.testing.assert_array_equal(y[:, LAYOUT.y_pose], x[:, LAYOUT.x_pose])
        np.testing.assert_array_equal(y[:, LAYOUT.y_trajectory], x[:, 24:48])
        np.testing.assert_array_equal(y[:, LAYOUT.y_phases], p)
        np.testing.assert_array_equal(y[:, LAYOUT.y_phase_updates], 0.0)
        np.testing.assert_array_equal(y[:, LAYOUT.y_contacts], np.tile(tiny.statistics().y_mean[-2:], (10, 1)))

    def test_hold_is_near_the_truth_and_the_mean_is_not(self, rows):
        """Pose and phases are in their places: a frame later they are nearly the same."""
        x, p, y = rows
        n, moving = tiny.statistics(), slice(LAYOUT.y_pose.start, LAYOUT.y_phases.stop)
        rivals = (predict_hold(LAYOUT, n), predict_mean(n))
        hold, mean = (np.square((rival(x, p) - y) / n.y_std)[:, moving].mean() for rival in rivals)
        assert hold < 0.3 * mean


class TestRidge:
    def made(self, rng: np.random.Generator, offset: float) -> tuple[list[StyleVectors], Normaliser, np.ndarray]:
        """Styles whose y is a linear map of x and p, and statistics that do not centre them."""
        x, p = rng.normal(2.0, 3.0, size=(4000, 6)), rng.normal(size=(4000, 8))
        planted = rng.normal(size=(14, 5))
        y = np.concatenate([x, p], axis=1) @ planted + offset
        part = np.full(4000, PARTS.index("train"))
        part[3000:] = PARTS.index("test")
        made = StyleVectors("made", False, ("FW",), x, p, y, *np.zeros((2, 4000)), np.zeros(4000, dtype=int), part)
        x_mean, widths = x.mean(0) + 0.5, (6, 8, 5)
        ones = [np.ones(w) for w in widths]
        return [made], Normaliser(x_mean, x.std(0), p.mean(0), ones[1], y.mean(0) - 0.3, y.std(0)), planted

    def test_a_planted_linear_map_is_found(self):
        """With a constant, since the statistics need not centre the rows that it is fitted on."""
        (style,), normaliser, planted = self.made(np.random.default_rng(0), offset=7.0)
        ridge = fit_ridge([style], normaliser)
        rows = style.rows("test")
        predicted = ridge(style.x[rows], style.p[rows])
        assert np.sqrt(np.square(predicted - style.y[rows]).mean(0)).max() < 0.01
        step = np.eye(6)[2:3]
        slope = ridge(style.x[:1] + step, style.p[:1]) - ridge(style.x[:1], style.p[:1])
        np.testing.assert_allclose(slope[0], planted[2], atol=0.01)

    def test_it_learns_from_the_training_rows_alone(self):
        (style,), normaliser, _ = self.made(np.random.default_rng(0), offset=7.0)
        spoilt = replace(style, y=np.where(style.part[:, None] == PARTS.index("test"), 1e6, style.y))
        np.testing.assert_array_equal(fit_ridge([spoilt], normaliser).weights, fit_ridge([style], normaliser).weights)


class TestNetwork:
    def test_the_code_is_that_of_the_style(self, bundle, rows):
        one, other = (predict_network(bundle, style)(*rows[:2]) for style in STYLES)
        assert np.abs(one - other).max() > 1e-3

    def test_it_is_in_eval_mode_whatever_came_before(self, bundle, rows):
        """Also after a call with dropout, and after training."""
        bundle.network.train()
        plain, dropping = predict_network(bundle, "Plain"), predict_network(bundle, "Plain", dropout=True)
        first = plain(*rows[:2])
        dropped = dropping(*rows[:2])
        assert not bundle.network.synthesis.training
        np.testing.assert_array_equal(plain(*rows[:2]), first)
        assert np.abs(dropped - first).max() > 1e-3

    def test_dropout_is_the_same_in_every_call_and_leaves_the_worlds_chance_alone(self, bundle, rows):
        dropping, before = predict_network(bundle, "Plain", dropout=True), torch.get_rng_state()
        first = dropping(*rows[:2])
        torch.rand(3)
        np.testing.assert_array_equal(dropping(*rows[:2]), first)
        torch.set_rng_state(before)
        dropping(*rows[:2])
        assert torch.equal(torch.get_rng_state(), before)

    def test_untrained_is_deterministic_and_knows_no_style(self, bundle, rows):
        before = torch.get_rng_state()
        one, other = (predict_network(untrained(bundle), style)(*rows[:2]) for style in STYLES)
        np.testing.assert_array_equal(one, other)
        assert torch.equal(torch.get_rng_state(), before)
        assert np.abs(one - predict_network(bundle, "Plain")(*rows[:2])).max() > 1e-3


class TestRows:
    def style(self, tests: int) -> StyleVectors:
        part = np.concatenate([np.zeros(50, dtype=int), np.full(tests, PARTS.index("test"))])
        blank = [np.zeros((len(part), width)) for width in (1, 8, 1)]
        return StyleVectors(
            "a", False, ("FW",), *blank, *np.zeros((2, len(part))), np.zeros(len(part), dtype=int), part
        )

    @pytest.mark.parametrize(("tests", "count"), [(0, 0), (1, 1), (999, 999), (1000, 1000), (5000, 1000)])
    def test_they_are_test_rows_and_at_most_1000(self, tests, count):
        style = self.style(tests)
        rows = module.test_rows(style)
        assert len(rows) == len(set(rows)) == count
        assert (style.part[rows] == PARTS.index("test")).all()

    def test_they_are_spread_over_all_of_them(self):
        rows = module.test_rows(self.style(5000))
        assert rows[0] == 50 and rows[-1] == 5049 and np.diff(rows).max() <= 6

    def test_the_distance_to_training_frames_is_within_a_take(self):
        style = self.style(10)
        assert module.distance_to_training(style) == 1
        guarded = replace(style, part=np.where(np.arange(60) < 55, style.part * 0 - 1, style.part))
        guarded.part[:50] = 0
        assert module.distance_to_training(guarded) == 6
        assert module.distance_to_training(replace(style, take=style.part)) == np.inf


class TestErrors:
    def test_a_predictor_that_is_right_has_no_error_and_bones_are_in_metres(self, bundle, styles):
        lengths = bone_lengths(tiny.BODY)
        rows = module.test_rows(styles[0])
        right = module.error_of(lambda x, p: styles[0].y[rows].astype(float), styles[0], bundle, lengths, "test")
        assert (right.mse, right.bll) == (0.0, 0.0)

        def larger(x, p):
            y = styles[0].y[rows].astype(float)
            y[:, LAYOUT.y_pose].reshape(len(y), -1, 4, 3)[:, :, 0] *= 1.1
            return y

        bones = np.mean([np.linalg.norm(tiny.BODY.skeleton.offsets[tiny.BODY.joints[c]]) for _, c in tiny.BODY.bones])
        grown = module.error_of(larger, styles[0], bundle, lengths, "test")
        assert grown.bll == pytest.approx(0.1 * bones, rel=0.02)

    def test_an_error_of_one_deviation_is_one(self, bundle, styles):
        rows = module.test_rows(styles[0])
        off = bundle.normaliser.y_std
        found = module.error_of(
            lambda x, p: styles[0].y[rows] + off, styles[0], bundle, bone_lengths(tiny.BODY), "test"
        )
        assert found.mse == pytest.approx(1.0)

    def test_twice_gives_identical_numbers(self, bundle, styles):
        first = module.test_errors(bundle, styles)
        torch.rand(5)
        assert module.test_errors(bundle, styles) == first
        assert not bundle.network.synthesis.training

    def test_every_style_has_the_network_and_all_its_rivals(self, bundle, styles):
        found = module.test_errors(bundle, styles)
        assert list(found) == list(STYLES)
        names = {"network", "dropout", "wrong code", "mean", "hold", "ridge", "untrained"}
        assert all(set(one) == names for one in found.values())
        assert found["Plain"]["ridge"].mse < found["Plain"]["hold"].mse < found["Plain"]["mean"].mse
        assert found["Plain"]["network"] == module.error_of(
            predict_network(bundle, "Plain"), styles[0], bundle, bone_lengths(tiny.BODY), "test"
        )

    def test_the_wrong_code_is_that_of_the_others(self, bundle, styles):
        found = module.test_errors(bundle, styles)
        assert found["Plain"]["wrong code"] == module.error_of(
            predict_network(bundle, "Giant"), styles[0], bundle, bone_lengths(tiny.BODY), "test"
        )

    def test_a_style_alone_has_no_wrong_code(self, styles):
        found = module.test_errors(tiny.bundle("Plain"), styles[:1])
        assert "wrong code" not in found["Plain"] and "network" in found["Plain"]

    def test_a_style_without_test_frames_is_left_out(self, bundle, styles):
        blank = replace(styles[1], part=np.zeros_like(styles[1].part))
        assert list(module.test_errors(bundle, [styles[0], blank])) == ["Plain"]


@pytest.mark.parametrize("count", [1, 2, 4, 6, 22, 100])
def test_wrong_codes_never_include_the_right_one(count):
    styles = [f"style{n}" for n in range(count)]
    for style in styles:
        others = module.other_styles(styles, style)
        assert style not in others and len(others) == len(set(others)) == min(5, count - 1)


class TestMeans:
    @pytest.fixture
    def errors(self) -> dict:
        made = {
            "a": {"network": (1.0, 0.1, 0.01), "wrong code": (4.0, 0.4, 0.04)},
            "b": {"network": (3.0, 0.3, 0.03), "wrong code": (6.0, 0.6, 0.06)},
            "c": {"network": (9.0, 0.9, 0.09)},
        }
        return {style: {name: module.Error(*error) for name, error in one.items()} for style, one in made.items()}

    def test_they_are_plain_means_over_the_styles_asked_for(self, errors):
        found = module.mean_over(errors, ["a", "b"])
        assert {name: pytest.approx(astuple(error)) for name, error in found.items()} == {
            "network": (2.0, 0.2, 0.02),
            "wrong code": (5.0, 0.5, 0.05),
        }

    def test_what_not_all_styles_have_has_no_mean(self, errors):
        assert list(module.mean_over(errors, ["a", "c"])) == ["network"]

    def test_styles_without_errors_are_passed_over(self, errors):
        assert module.mean_over(errors, ["a", "z"])["network"] == module.Error(1.0, 0.1, 0.01)
        assert module.mean_over(errors, ["z"]) == {}
