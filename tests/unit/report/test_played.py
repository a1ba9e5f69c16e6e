"""The verdicts of the notebook of the played character: each can come out the other way."""

from dataclasses import replace

import numpy as np
import pytest
import tiny_walker as tiny

from stylephase.evaluation.character import Arms, Blend, Going, Looks
from stylephase.evaluation.robustness import Endurance
from stylephase.models.bundle import save_bundle
from stylephase.report import played
from stylephase.report.played import (
    Aside,
    Crowd,
    Found,
    FromOneClip,
    Recognised,
    crowd_of,
    drift,
    effect,
    held_at_each,
    looks_table,
    record,
    scripted,
    track_plot,
    triples,
    with_style_network,
)
from stylephase.report.recorder import Recorder
from stylephase.runtime.keyboard import KeySettings
from stylephase.runtime.player import Player
from stylephase.runtime.speeds import SpeedCurve
from stylephase.runtime.trajectory import Steering

ROWS = 8
LINE = SpeedCurve(np.array([0.5, 2.0]), np.array([0.5, 2.0]))


def looks(skate: float, acceleration: float, bones: float = 0.0) -> Looks:
    steady = np.full(ROWS, 1.0) + 0.01 * np.arange(ROWS)
    return Looks(skate * steady, acceleration * steady, np.full(ROWS, bones), steady)


def arms(wrong: float, led: float) -> Arms:
    return Arms(np.full(ROWS, 0.02), np.zeros(ROWS), np.full(ROWS, wrong), np.full(ROWS, led))


LEFT = Going(1.0, 0.5)


def good() -> Found:
    seen = {"raw": looks(0.15, 30, 16.0), "grounded": looks(0.1, 30), "finished": looks(0.001, 35)}
    seen |= {"scrambled": looks(0.4, 120), "sudden": looks(0.0, 90)}
    held = [Endurance(f"s{k}", 60.0, "", (0.8, 0.9), 0.01, 0.2, 1.3) for k in range(ROWS)]
    mixing = np.stack([np.full(4, 31.0), np.full(4, 30.0), np.full(4, 66.0)], axis=1)
    more, costs, speeds = (0.02, 0.01, 0.03), {"finishing": 0.5, "network": 2.0}, np.full(ROWS, 1.2)
    return Found(
        dataset="bandai-namco",
        recorded=np.full(ROWS, 50.0),
        looks=seen,
        pure=arms(0.03, 0.0),
        half=arms(0.05, 0.0),
        more_wrong=more,
        mixing=mixing,
        costs=costs,
        wanted=speeds,
        led=1.02 * speeds,
        gaits={"walk": (20, 20), "run": (19, 20)},
        aside=[Aside("s0", "walk-left", LEFT, Going(1.05, 0.6), Going(1.0, 0.0))],
        endured=held,
        alone=held,
        one_clip=FromOneClip(held, Recognised(18, 1, 20), "lpn-film"),
        blend=Blend(np.array([0.2, 0.7]), np.full(2, 0.25), np.full(ROWS, 5.0), np.full(ROWS, 88.0)),
        recognised=Recognised(18, 1, 20),
        crowd=Crowd(motions=[], right=95, dealt=1, count=100),
        released=False,
        seconds=60.0,
    )


def verdicts(found: Found) -> dict[str, str]:
    recorder = Recorder("09_play", dataset="bandai-namco", preset="cpu", params={})
    record(recorder, found)
    return {result.id: result.verdict for result in recorder.record.results}


def test_what_is_good_is_reproduced():
    assert all(verdict.startswith("reproduced") for verdict in verdicts(good()).values())


@pytest.mark.parametrize(
    ("claim", "change"),
    [
        ("m22-demo-trajectory-blend", lambda f: {"blend": replace(f.blend, network=np.zeros(2))}),
        ("m22-demo-trajectory-blend", lambda f: {"blend": replace(f.blend, user=np.array([0.7, 0.2]))}),
        ("m22-demo-trajectory-blend", lambda f: {"blend": replace(f.blend, turned=f.blend.unheard)}),
        ("m22-fig1-many-styles", lambda f: {"crowd": replace(f.crowd, right=60)}),
        ("m22-fig1-many-styles", lambda f: {"crowd": replace(f.crowd, dealt=90)}),
        (
            "m22-arbitrary-length",
            lambda f: {"one_clip": replace(f.one_clip, endured=[replace(f.alone[0], broken="x"), *f.alone[1:]])},
        ),
        ("m22-demo-foot-ik", lambda f: {"looks": f.looks | {"finished": looks(0.15, 35)}}),
        ("m22-demo-foot-ik", lambda f: {"looks": f.looks | {"grounded": looks(0.001, 35)}}),
        ("m22-demo-foot-ik", lambda f: {"looks": f.looks | {"scrambled": looks(0.001, 35)}}),
        ("m22-demo-arm-ik", lambda f: {"more_wrong": (0.0, -0.01, 0.01)}),
        ("m22-demo-arm-ik", lambda f: {"half": arms(0.05, 0.04)}),
        ("m22-demo-three-styles", lambda f: {"mixing": f.mixing * np.array([2, 1, 2])}),
        ("m22-demo-three-styles", lambda f: {"mixing": f.mixing * np.array([1, 1, 0.4])}),
        ("m22-demo-precomputed-code", lambda f: {"alone": [replace(e, broken="too fast") for e in f.alone]}),
        ("m22-demo-precomputed-code", lambda f: {"recognised": Recognised(8, 1, 20)}),
        ("m22-demo-precomputed-code", lambda f: {"one_clip": replace(f.one_clip, recognised=Recognised(18, 12, 20))}),
        ("ours-play-skate", lambda f: {"looks": f.looks | {"finished": looks(0.03, 35)}}),
        ("ours-play-pops", lambda f: {"looks": f.looks | {"finished": looks(0.001, 90)}}),
        ("ours-play-bones", lambda f: {"looks": f.looks | {"finished": looks(0.001, 35, 1.0)}}),
        ("ours-play-finishing-cost", lambda f: {"costs": {"finishing": 2.0, "network": 2.0}}),
        ("ours-play-speeds", lambda f: {"led": 1.2 * f.wanted}),
        ("ours-play-gaits", lambda f: {"gaits": {"walk": (20, 20), "run": (10, 20)}}),
        ("ours-play-aside", lambda f: {"aside": [replace(f.aside[0], ours=f.aside[0].ahead)]}),
        ("ours-play-aside", lambda f: {"aside": [replace(f.aside[0], ours=Going(0.7, 0.5))]}),
        ("ours-play-endurance", lambda f: {"endured": [replace(f.endured[0], broken="too fast"), *f.endured[1:]]}),
        ("ours-play-crowd-recognised", lambda f: {"recognised": Recognised(8, 1, 20)}),
    ],
)
def test_what_is_not_differs(claim, change):
    found = good()
    assert verdicts(replace(found, **change(found)))[claim] == "differs"


def test_speeds_are_counted_by_gait():
    found = played.reached_by_gait(["walk", "run", "walk"], np.array([1.05, 0.5, 1.2]))
    assert found == {"walk": (1, 2), "run": (0, 1)}


def test_without_takes_aside_there_is_nothing_to_test():
    assert verdicts(replace(good(), aside=[]))["ours-play-aside"] == "not testable here"


def test_without_a_style_network_one_clip_cannot_be_tested():
    found = verdicts(replace(good(), one_clip=None))
    assert found["m22-arbitrary-length"] == "not testable here"
    assert found["m22-demo-precomputed-code"] == "reproduced on other data"


def test_how_long_is_told_with_the_claim():
    recorder = Recorder("09_play", dataset="bandai-namco", preset="cpu", params={})
    record(recorder, good())
    (endured,) = [result for result in recorder.record.results if result.id == "ours-play-endurance"]
    assert endured.note == "for 60 s each; none broke"


def test_who_walks_beside_the_way_with_the_right_heading_is_found_out(monkeypatch):
    """It faces ahead as it is asked to, and goes half a metre a second aside."""
    bundle, start = tiny.bundle(network=tiny.Obedient()), tiny.start([0])
    how = (bundle, tiny.codes(1), start, np.ones(1), np.ones(1), KeySettings())
    straight = drift(*how, seconds=3.0)
    keys = played.steer_by_keys

    def aside(*given) -> Steering:
        wish = keys(*given)
        return Steering(wish.velocity + [[1.0, 0.0]], wish.facing)

    monkeypatch.setattr(played, "steer_by_keys", aside)
    gone = drift(*how, seconds=3.0, straightens=False)
    assert gone.degrees[0] < 1 and straight.degrees[0] < 1
    assert gone.metres[0] > 0.8 and straight.metres[0] < 0.05


def test_a_crowd_has_a_second_of_each_and_tells_who_is_recognised(monkeypatch):
    """Untrained styles differ by how they lean: own codes are recognised, dealt ones are not."""
    monkeypatch.setattr(played, "_CROWD_SECONDS", 6.5)
    bundle = tiny.bundle(network=tiny.Obedient())
    found = crowd_of(bundle, tiny.start([0] * len(bundle.styles)), gains=np.ones(len(bundle.styles)))
    assert [len(motion) for motion in found.motions] == [60] * found.count and found.count == len(bundle.styles)
    assert (found.right, found.dealt) == (found.count, 0)
    fewer = crowd_of(bundle, tiny.start([0] * found.count), gains=np.ones(found.count), uncounted=bundle.styles[:1])
    assert (len(fewer.motions), fewer.count, fewer.right) == (found.count, found.count - 1, found.count - 1)


def test_a_run_counts_only_with_its_style_network(tmp_path):
    assert with_style_network(tmp_path, "made-cpu-lpn-film") is None
    save_bundle(tmp_path / "made-cpu-lpn-film-seed0", tiny.bundle(), to_run=True)
    assert with_style_network(tmp_path, "made-cpu-lpn-film") is None
    save_bundle(tmp_path / "made-cpu-lpn-film-seed1", tiny.bundle())
    found = with_style_network(tmp_path, "made-cpu-lpn-film")
    assert found is not None and found.makes_codes


def test_a_table_has_a_row_for_each_way():
    lines = looks_table(good().looks, np.full(ROWS, 50.0)).splitlines()
    assert len(lines) == 7 and lines[2].startswith("| raw | 0.155, at most 0.161 | 0.621")


def test_threes_share_no_style_and_few_styles_make_one():
    found = triples([f"s{k}" for k in range(22)])
    assert len(found) == 7 and len({style for three in found for style in three}) == 21
    assert len(triples(["a", "b"])) == 1


def test_an_effect_has_its_mean_within_its_interval():
    value, low, high = effect(np.array([1.0, 2.0, 3.0]))
    assert value == pytest.approx(2.0) and low < value < high


def test_the_way_from_above_has_a_colour_for_what_is_held():
    script = [("w", 0.5), (["w", "shift"], 0.5), ("", 0.25)]
    player = Player(tiny.bundle(network=tiny.Obedient()), tiny.STYLES[:3], curves=dict.fromkeys(tiny.STYLES[:3], LINE))
    states, held = scripted(player, script), held_at_each(script)
    assert [held[k] for k in (0, 29, 30, 59, 60)] == ["W", "W", "Shift W", "Shift W", "no key"]
    assert len(held) == len(states) == 75
    axes = track_plot(states, held)
    names = [text.get_text() for text in axes.get_legend().get_texts()]
    assert names == ["W", "Shift W", "no key", "start"]
