"""Steps alternate, feet are half a cycle apart, time runs on: what is counted, and that recorded walks have it."""

from dataclasses import replace

import numpy as np
import pytest

from stylephase.data.catalogue import Catalogue, load_catalogue
from stylephase.errors import InputError
from stylephase.evaluation.gaits import gait_scores, score_take, summed
from stylephase.phase.local import LocalPhases, variant
from stylephase.phase.source import Sourcing
from stylephase.phase.take import TakePhases

FRAMES = np.arange(600)
CONTACTS = np.stack([FRAMES % 60 < 30, (FRAMES + 30) % 60 < 30], axis=1)


def take(phase: np.ndarray, contacts: np.ndarray = CONTACTS, magnitude: float = 1.0) -> TakePhases:
    size = np.full((600, 4), magnitude)
    local = LocalPhases(phase % 1, size, np.ones((600, 4)), np.zeros((600, 4)))
    return TakePhases(local, contacts, Sourcing(np.zeros((4, 3))), 60.0)


def running(*offsets: float) -> np.ndarray:
    return FRAMES[:, None] / 60 + np.array(offsets)


def test_a_perfect_walk_has_a_perfect_score():
    score = score_take(take(running(0, 0.5, 0, 0.5)))
    assert score.alternating == score.changes > 15 and score.apart_p90 < 1e-9
    assert score.backward == 0 and score.moving == 599 * 4


def test_feet_off_by_a_tenth_and_steps_of_one_foot_are_seen():
    assert score_take(take(running(0, 0.5, 0, 0.6))).apart == pytest.approx(0.1)
    hop = score_take(take(running(0, 0.5, 0, 0.5), CONTACTS & [True, False]))
    assert hop.changes > 5 and hop.alternating == 0


def test_ends_do_not_count_unless_asked_for():
    phase = running(0, 0.5, 0, 0.5)
    phase[:29, 3] += 0.3
    assert score_take(take(phase)).apart_p90 < 1e-9
    phase[:70, 3] = phase[:70, 2]
    assert score_take(take(phase), ends=0.0).apart_p90 > 0.4


def test_only_moving_frames_can_run_backward():
    back = -running(0, 0.5, 0, 0.5)
    assert score_take(take(back)).backward == 599 * 4
    still = score_take(take(back, magnitude=0.01))
    assert still.moving == 0 and summed([still]).backward == 0


def test_takes_of_a_gait_are_summed_by_their_steps_and_frames():
    good, bad = score_take(take(running(0, 0.5, 0, 0.5))), score_take(take(-running(0, 0.5, 0, 0.5)))
    both = summed([good, bad, replace(bad, changes=0, alternating=0.0)])
    assert both.takes == 3 and both.backward == pytest.approx(2 / 3) and both.alternation == 1.0
    assert summed([replace(good, changes=0, alternating=0.0)]).alternation == 1.0


@pytest.fixture(scope="module")
def recorded(mirror, tmp_path_factory) -> Catalogue:
    if not (mirror / "bandai-namco-locomotion.tar.xz").exists():
        pytest.skip("needs recordings of Bandai-Namco: their archive is not in the mirror")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("STYLEPHASE_MIRROR", str(mirror))
        patch.setenv("STYLEPHASE_CACHE", str(tmp_path_factory.mktemp("cache")))
        return load_catalogue("bandai-namco", ["set1-tired", "set1-proud", "set2-feminine", "set2-active"])


def test_recorded_walks_hold(recorded):
    """All 22 styles: alternation 0.978 (dash) to 1.00, feet 0.005 to 0.013 off, up to 0.04 at the 90th percentile."""
    scores = gait_scores(recorded, variant("adaptive"), each=1)
    assert {"walk", "run", "dash", "walk-back", "walk-left", "walk-turn-left"} <= set(scores)
    for gait, score in scores.items():
        assert score.alternation >= 0.98, gait
        assert score.apart <= 0.05 and score.apart_p90 <= 0.10, gait
        assert score.backward <= 0.02, gait


def test_a_gait_without_a_long_take_is_no_gait(recorded):
    short = [e for e in recorded.entries if e.gait == "dash"][:1]
    only = replace(recorded, entries=tuple(replace(entry, stop=20) for entry in short))
    with pytest.raises(InputError, match="no take is long enough"):
        gait_scores(only, variant("adaptive"))
