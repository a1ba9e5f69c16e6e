"""Hand labels: what of them counts, how far a phase lies from them, and where in a step they stand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stylephase.data.catalogue import load_catalogue
from stylephase.errors import InputError
from stylephase.evaluation.labels import (
    footfalls,
    label_delays,
    labelled_halves,
    landing_delays,
    read_labelled,
    score_phase,
    scored_frames,
    stance_shares,
    steady_phase,
)
from stylephase.motion.contacts import foot_contacts
from stylephase.phase.circular import wrap
from stylephase.phase.global_phase import fitted_phase, global_phase

FPS = 120.0
TURN = 2 * np.pi


def labels(*marks: tuple[int, float], frames: int) -> np.ndarray:
    """Labels (rad) that are linear between marks of (frame, cycles) and rest outside of them."""
    at, cycles = np.array(marks).T
    return wrap(TURN * np.interp(np.arange(frames), at, cycles), TURN)


# Rests to frame 50, a right step, a left one, a rest of half a cycle in three seconds, two more, then it rests.
WALKED = labels((50, 0.0), (100, 0.5), (160, 1.0), (520, 1.5), (600, 2.0), (640, 2.5), frames=800)


def test_a_half_cycle_counts_that_is_walked_through_in_at_most_a_second():
    assert labelled_halves(WALKED, FPS) == [(50, 100), (100, 160), (520, 600), (600, 640)]
    assert footfalls(WALKED, FPS) == [(50, 0), (100, 1), (520, 1), (600, 0)]
    assert scored_frames(WALKED, FPS).sum() == 50 + 60 + 80 + 40


def test_a_half_cycle_that_rests_within_or_is_cut_off_does_not_count():
    resting = labels((20, 0.0), (40, 0.3), (60, 0.3), (80, 0.5), (120, 1.0), frames=121)
    assert labelled_halves(resting, FPS) == [(80, 120)]
    begun = labels((0, 0.3), (20, 0.5), (60, 1.0), (80, 1.2), frames=81)
    assert labelled_halves(begun, FPS) == [(20, 60)]


def test_labels_of_which_nothing_counts_are_refused():
    resting = np.zeros(300)
    assert labelled_halves(resting, FPS) == []
    with pytest.raises(InputError, match="no half cycle of the labels counts"):
        score_phase(resting, resting, scored_frames(resting, FPS))


@given(shift=st.floats(-0.5, 0.5))
def test_a_phase_that_is_off_by_the_same_everywhere_is_right(shift):
    counted = scored_frames(WALKED, FPS)
    score = score_phase(WALKED + TURN * shift, WALKED, counted)
    assert abs(np.angle(np.exp(1j * TURN * (score.offset - shift)))) < 1e-6
    assert score.median < 1e-6 and score.ninth_decile < 1e-6 and score.frames == counted.sum()


def test_distances_are_those_of_the_frames_that_count():
    """A tenth of them 0.2 cycles off shows in neither median nor offset by much; outside anything may stand."""
    counted = scored_frames(WALKED, FPS)
    phase = np.where(counted, WALKED, 1.0)
    phase[np.flatnonzero(counted)[: counted.sum() // 5]] += 0.2 * TURN
    score = score_phase(phase, WALKED, counted)
    assert score.offset == pytest.approx(0.03, abs=0.02) and score.median < 0.06
    assert score.ninth_decile == pytest.approx(0.2 - score.offset, abs=1e-6)


def test_the_null_model_has_the_mean_rate_of_the_frames_that_count():
    counted = scored_frames(WALKED, FPS)
    steps = np.diff(np.unwrap(steady_phase(WALKED, counted)))
    assert np.allclose(steps, steps[0])
    assert steps[0] == pytest.approx(2.0 * TURN / counted.sum(), rel=0.02)


def test_delays_run_from_the_first_slow_frame_after_the_swing():
    """0.1 m/s after frame 80, 0.01 m/s after frame 92; the slow frames before the swing are another step's."""
    speeds = np.full((200, 2), 0.01)
    speeds[40:80, 0], speeds[80:92, 0] = 2.0, 0.1
    falls = [(95, 0), (70, 0), (95, 1)]
    assert label_delays(speeds, falls, FPS, 0.3)[:2] == pytest.approx([15 / FPS, -10 / FPS])
    assert label_delays(speeds, falls, FPS, 0.05)[0] == pytest.approx(3 / FPS)
    assert np.isnan(label_delays(speeds, falls, FPS, 0.3)[2]), "a foot that never swung"
    assert np.isnan(label_delays(speeds, falls, FPS, 0.001)).all(), "a foot that is never so slow"


def test_a_landing_is_where_the_fall_ends():
    heights = np.full((200, 2), 0.1)
    heights[:100, 0] = 0.4
    heights[100:130, 0] = np.linspace(0.4, 0.1, 30)
    delays = landing_delays(heights, [(140, 0), (140, 1)], FPS)
    assert delays[0] == pytest.approx(10 / FPS, abs=4 / FPS) and np.isnan(delays[1])


def test_the_share_of_a_stance_is_that_of_the_nearest():
    contacts = np.zeros((300, 2), dtype=bool)
    contacts[100:200, 0] = contacts[250:, 0] = True
    assert stance_shares(contacts, [(125, 0), (90, 0), (260, 0)]) == pytest.approx([0.25, -0.1, 0.2])
    assert np.isnan(stance_shares(contacts, [(125, 1)])).all()


@pytest.fixture(scope="module")
def recorded(mirror, tmp_path_factory) -> tuple:
    """Holden's two labelled takes with their data set's contact rule."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("STYLEPHASE_MIRROR", str(mirror))
        patch.setenv("STYLEPHASE_CACHE", str(tmp_path_factory.mktemp("cache")))
        catalogue = load_catalogue("pfnn")
        takes = [read_labelled(entry, catalogue.dataset) for entry in catalogue.entries]
    return takes, catalogue.dataset.contact


def test_contacts_give_the_phase_of_hand_labels_and_a_constant_rate_does_not(recorded):
    takes, rule = recorded
    assert [take.name for take in takes] == ["LocomotionFlat04_000", "NewCaptures10_000"]
    for take in takes:
        counted = scored_frames(take.own, take.fps)
        phase = global_phase(foot_contacts(take.toes, take.fps, rule), take.fps)
        score = score_phase(phase, take.own, counted)
        assert counted.sum() > 300 and score.median <= 0.07 and score.ninth_decile <= 0.15
        null = score_phase(steady_phase(take.own, counted), take.own, counted)
        assert null.median > 0.07 and null.ninth_decile > 0.15


def test_a_fitted_phase_follows_the_labels_of_steady_walking_too(recorded):
    """Not those of single steps between rests, which the first take has."""
    take = recorded[0][1]
    score = score_phase(fitted_phase(take.speeds, take.fps), take.own, scored_frames(take.own, take.fps))
    assert score.median <= 0.07 and score.ninth_decile <= 0.15


def test_the_labels_stand_where_a_toe_comes_to_rest(recorded):
    """Why they are late: our contacts begin at 0.3 m/s, theirs below 0.02."""
    for take in recorded[0]:
        falls = footfalls(take.own, take.fps)
        at_rest, down = (np.nanmedian(label_delays(take.speeds, falls, take.fps, v)) for v in (0.02, 0.3))
        assert abs(at_rest) <= 0.03 and 0.08 <= down <= 0.18


def test_two_sets_of_labels_of_one_take_differ_as_much_as_ours_does_from_one(recorded):
    takes, rule = recorded
    take = takes[1]
    both = scored_frames(take.own, take.fps) & scored_frames(take.copy, take.fps)
    phase = global_phase(foot_contacts(take.toes, take.fps, rule), take.fps)
    noise = score_phase(take.copy, take.own, both)
    assert noise.median > 0.02
    assert score_phase(phase, take.own, both).median < 1.5 * noise.median
