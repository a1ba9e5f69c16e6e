"""Values behind the claims: the worst seed counts, and what did not stay finite counts as failed."""

from copy import deepcopy
from typing import Any

import pytest

from stylephase.errors import InputError
from stylephase.report import judged, walks


def walk(style: str, **changes: Any) -> dict[str, Any]:
    """One style's rollout as an evaluation has it."""
    bones = {"median": 0.4, "worst": 2.0, "off": 5.0, "drift": 1.0} | changes.pop("bones", {})
    made = {"style": style, "finite": True, "gain": 1.2, "speed": 1.0, "data_speed": 1.0, "speed_ratio": 1.0}
    made |= {"bones": bones, "hips": 0.90, "data_hips": 0.91, "skate": 0.2, "nearest": style, "correlation": -0.8}
    return made | {"steps": {"count": 20, "alternation": 1.0, "cycle": 1.0}, "alternate": True} | changes


def lost(style: str) -> dict[str, Any]:
    """One that did not stay finite."""
    none = dict.fromkeys(("speed", "speed_ratio", "hips", "skate", "correlation"))
    bones = dict.fromkeys(("median", "worst", "off", "drift"))
    return walk(style) | none | {"finite": False, "alternate": False, "nearest": "", "bones": bones}


def result(*styles: dict[str, Any], turns: float = 3.0, stops: float | None = 0.4, **errors: float) -> dict[str, Any]:
    mse = {"network": 0.02, "hold": 0.2, "mean": 1.0, "ridge": 0.01, "untrained": 2.0, "wrong code": 0.08} | errors
    names = [one["style"] for one in styles]
    rollouts = {"walks": list(styles), "turns": dict.fromkeys(names, turns), "stops": dict.fromkeys(names, stops)}
    groups = {"set2": {name: {"mse": value, "bll": 0.001} for name, value in mse.items()}}
    return {"groups": groups, "rollouts": rollouts, "codes": {"between": 0.5, "within": 0.1}}


GOOD = walk("set1-old"), walk("set2-old"), walk("set2-sad")


class TestOneStep:
    def test_the_worst_seed_counts(self):
        """The largest share of a rival's error, and the smallest factor of a wrong code."""
        found = judged.one_step_values([result(*GOOD), result(*GOOD, network=0.04)], "set2")
        assert found == {
            "ours-onestep-hold-set2": pytest.approx(0.2),
            "ours-onestep-mean-set2": pytest.approx(0.04),
            "ours-onestep-ridge-set2": pytest.approx(4.0),
            "ours-onestep-untrained-set2": pytest.approx(0.02),
            "ours-wrong-code-set2": pytest.approx(2.0),
        }


class TestRollouts:
    def test_when_all_is_well(self):
        found = judged.rollout_values([result(*GOOD)])
        assert found == {
            "ours-rollout-finite": 3,
            "ours-rollout-bone-median": pytest.approx(0.4),
            "ours-rollout-bone-worst": 2.0,
            "ours-rollout-bone-drift": 1.0,
            "ours-rollout-bone-off": 5.0,
            "ours-rollout-hips": pytest.approx(0.01),
            "ours-rollout-alternation": 3,
            "ours-rollout-alternation-set2": 2,
            "ours-rollout-speed": [1.0, 1.0],
            "ours-rollout-style-set2": 2,
            "ours-rollout-style-all": 3,
            "ours-rollout-turns": 3.0,
        }

    def test_of_two_seeds_the_worse_counts_whatever_their_order(self):
        worse = result(
            walk("set1-old", speed_ratio=1.3, hips=0.99, bones={"worst": 9.0, "median": 3.0}),
            walk("set2-old", nearest="set2-sad", speed_ratio=0.6, bones={"median": 1.0}),
            walk("set2-sad", alternate=False, bones={"off": 60.0, "drift": 20.0}),
            turns=40.0,
        )
        for results in ([result(*GOOD), worse], [worse, result(*GOOD)]):
            found = judged.rollout_values(results)
            assert found["ours-rollout-bone-median"] == 1.0 and found["ours-rollout-bone-worst"] == 9.0
            assert found["ours-rollout-bone-off"] == 60.0 and found["ours-rollout-bone-drift"] == 20.0
            assert found["ours-rollout-hips"] == pytest.approx(0.08)
            assert found["ours-rollout-alternation"] == 2 and found["ours-rollout-alternation-set2"] == 1
            assert found["ours-rollout-style-all"] == 2 and found["ours-rollout-style-set2"] == 1
            assert found["ours-rollout-speed"] == [0.6, 1.3] and found["ours-rollout-turns"] == 40.0

    def test_two_seeds_that_fail_in_different_styles_are_not_added_up(self):
        one = result(walk("set1-old"), walk("set2-old", alternate=False))
        other = result(walk("set1-old", alternate=False), walk("set2-old"))
        assert judged.rollout_values([one, other])["ours-rollout-alternation"] == 1

    def test_what_did_not_stay_finite_is_counted_and_not_measured(self):
        found = judged.rollout_values([result(walk("set1-old"), walk("set2-old"), lost("set2-sad"))])
        assert found["ours-rollout-finite"] == 2 and found["ours-rollout-alternation-set2"] == 1
        assert found["ours-rollout-style-all"] == 2 and found["ours-rollout-bone-worst"] == 2.0
        assert found["ours-rollout-speed"] == [1.0, 1.0]

    def test_a_seed_of_which_nothing_stayed_finite_is_refused(self):
        with pytest.raises(InputError, match="no rollout that stayed finite"):
            judged.rollout_values([result(*GOOD), result(lost("set2-sad"))])

    def test_stops_and_codes(self):
        mixed = result(walk("a"), stops=0.2), result(walk("a"), stops=None), result(walk("a"), stops=0.9)
        assert judged.stop_range(mixed) == (0.2, 0.9)
        other = deepcopy(result(*GOOD)) | {"codes": {"between": 0.4, "within": 0.2}}
        assert judged.code_ratio([result(*GOOD), other]) == pytest.approx(2.0)

    def test_nothing_given_is_changed(self):
        given = [result(*GOOD, lost("set1-sad"))]
        before = deepcopy(given)
        judged.rollout_values(given)
        assert given == before


class TestSummary:
    def rows(self, *styles: dict[str, Any]) -> list[list[str]]:
        lines = walks.summary(result(*styles)).splitlines()
        return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]

    def test_each_style_has_a_row_as_wide_as_the_head(self):
        head, rule, *rows = self.rows(walk("set1-old"), lost("set1-sad"), walk("set2-sad"))
        assert {len(row) for row in (head, rule, *rows)} == {12}
        assert [row[0] for row in rows] == ["set1-old", "set1-sad", "set2-sad"]

    def test_numbers_have_their_units(self):
        row = self.rows(walk("set1-old", hips=0.93))[2]
        assert row == [
            *("set1-old", "1.00", "1.00", "0.40", "2.00", "1.0", "+2.0", "20", "0.20", "3.0", "0.40", "the right one")
        ]

    def test_feet_that_do_not_alternate_and_a_wrong_style_are_marked(self):
        row = self.rows(walk("set1-old", alternate=False, nearest="set1-sad"))[2]
        assert (row[7], row[11]) == ("20 !", "set1-sad")

    def test_what_did_not_stay_finite_says_so(self):
        assert self.rows(lost("set1-sad"))[2] == ["set1-sad", "not finite", *[""] * 10]


def test_telling_styles_come_first_and_none_twice():
    styles = ["set1-active", "set1-happy", "set1-old", "set2-elderly", "set1-proud", "set2-normal"]
    assert walks.pick(styles, 4) == ["set1-old", "set2-elderly", "set1-proud", "set2-normal"]
    assert walks.pick(styles[:2]) == styles[:2]
    assert sorted(walks.pick(styles, 10)) == sorted(styles)


def test_an_interval_is_mean_least_and_most():
    assert walks.interval([1.0, 2.0, 6.0]) == (3.0, 1.0, 6.0)
