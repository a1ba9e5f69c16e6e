"""Measures of walking: they find nothing wrong with a copy, and each notices the damage that it is there for."""

import numpy as np
import pytest

from stylephase.data.catalogue import load_catalogue
from stylephase.evaluation.damage import DAMAGES, damaged
from stylephase.evaluation.measures import MEASURES, Reference, windows_in
from stylephase.evaluation.stretches import Stretch
from stylephase.evaluation.validation import (
    Trial,
    halves,
    kept_measures,
    reference_of,
    split,
    try_measures,
)
from stylephase.features.store import VectorStore

STYLES = ("Plain", "StoopedOver", "OffbeatArms")
OF_RATIOS = ("frechet", "variety", "spectrum", "detail", "jerk")


@pytest.fixture(scope="module")
def reference() -> Reference:
    store = VectorStore(load_catalogue("synthetic", STYLES), "adaptive")
    return reference_of(store, STYLES, most=20.0)


def value(reference: Reference, measure: str, walks, style: str = "Plain") -> float:
    return MEASURES[measure][0](reference, style, walks)


@pytest.mark.parametrize("measure", [*OF_RATIOS, "other style"])
def test_recorded_walks_have_nothing_wrong_against_themselves(reference, measure):
    assert value(reference, measure, reference.walks["Plain"]) == pytest.approx(0, abs=1e-4)


@pytest.mark.parametrize(
    ("measure", "damage"), [(name, damage) for name, (_, _, meant) in MEASURES.items() for damage in meant]
)
def test_much_damage_is_worse_than_none_for_the_measure_that_is_there_for_it(reference, measure, damage):
    walks, degrees = reference.walks["Plain"], DAMAGES[damage][1]
    found = [
        value(reference, measure, damaged(damage, reference, "Plain", walks, d, 0))
        for d in degrees[:: len(degrees) - 1]
    ]
    assert found[1] > found[0] + 1e-6


@pytest.mark.parametrize("damage", list(DAMAGES))
def test_no_damage_leaves_a_walk_as_it_is_and_chance_follows_from_the_seed(reference, damage):
    walks, most = reference.walks["Plain"][:1], DAMAGES[damage][1][-1]
    same = damaged(damage, reference, "Plain", walks, 0.0, 0)[0]
    assert np.allclose(same.poses, walks[0].poses[: len(same)], atol=1e-9)
    one, two = (damaged(damage, reference, "Plain", walks, most, 3)[0].poses for _ in range(2))
    assert np.array_equal(one, two) and not np.allclose(one, walks[0].poses[: len(one)])


def test_sliding_is_measured_in_metres_per_second_and_sinking_in_millimetres(reference):
    walks = reference.walks["Plain"]
    slid = damaged("sliding", reference, "Plain", walks, 5.0, 0)
    assert value(reference, "skate", slid) == pytest.approx(5.0, abs=2 * value(reference, "skate", walks) + 0.01)
    sunk = damaged("sinking", reference, "Plain", walks, 0.5, 0)
    resting = [
        walk.poses.reshape(len(walk), -1, 4, 3)[:, list(reference.body.layout.effectors[2:]), 0, 1] for walk in walks
    ]
    low = np.concatenate(resting).min(axis=1)
    assert value(reference, "sunk", sunk) == pytest.approx(1000 * (0.5 + np.quantile(low, 0.01) - low.mean()), abs=0.5)


def test_halves_are_whole_together_and_windows_never_reach_across(reference):
    walk = reference.walks["Plain"][0]
    first, second = halves([walk])
    assert np.array_equal(np.concatenate([first[0].poses, second[0].poses]), walk.poses)
    assert all(len(window) == 120 for window in windows_in(first)) and not windows_in(
        [Stretch(walk.poses[:119], walk.phase[:119], walk.contacts[:119])]
    )


def test_what_is_held_back_is_of_other_takes_where_there_are_two(reference):
    walk = reference.walks["Plain"][0]
    takes = Reference(reference.body, {"Plain": [walk, walk], "Old": [walk], "Short": [walk.at(slice(130))]})
    lots = split(takes, windows=2)
    assert lots.whole == ("Plain",) and set(lots.held) == {"Plain", "Old"}
    assert [len(lot["Plain"][0]) for lot in (lots.first.walks, lots.held)] == [len(walk), len(walk)]
    assert len(lots.held["Old"][0]) == len(walk) - len(walk) // 2


def test_trials_cover_every_measure_and_damage_and_only_what_fails_is_dropped(reference):
    lots = split(reference, windows=2)
    first, held = lots.first, lots.held
    trials = try_measures(first, {style: held[style] for style in ("Plain", "StoopedOver")})
    assert trials.keys() == MEASURES.keys() and all(some.keys() == DAMAGES.keys() for some in trials.values())
    kept = kept_measures(trials)
    assert {"skate", "sunk", "bones"} <= set(kept)
    dull = {name: {d: Trial(np.ones_like(t.values), t.meant) for d, t in some.items()} for name, some in trials.items()}
    assert kept_measures(dull) == []


def test_a_single_window_has_a_place_and_no_spread_and_no_warning(reference):
    one = [reference.walks["Plain"][0].at(slice(120))]
    assert len(windows_in(one)) == 1 and np.isfinite(value(reference, "frechet", one))
    alone = Reference(reference.body, {**reference.walks, "Plain": one})
    assert value(alone, "frechet", one) == pytest.approx(0, abs=1e-4)
