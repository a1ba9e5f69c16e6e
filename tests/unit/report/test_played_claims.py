"""The verdicts of the notebook of the played character: each can come out the other way."""

from dataclasses import replace

import numpy as np
import pytest
import tiny_walker as tiny

from stylephase.evaluation.crowd import Crowd, FromOneClip, Recognised
from stylephase.evaluation.looks import Arms, Looks
from stylephase.evaluation.robustness import Endurance
from stylephase.evaluation.steered import Aside, Blend, Going
from stylephase.report.played_claims import Found, effect, record
from stylephase.report.recorder import Recorder
from stylephase.runtime.rollout import as_rollout

ROWS = 8


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
        crowd=Crowd(95, 1, 100, as_rollout([tiny.start([0])])),
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


def test_an_effect_has_its_mean_within_its_interval():
    value, low, high = effect(np.array([1.0, 2.0, 3.0]))
    assert value == pytest.approx(2.0) and low < value < high
