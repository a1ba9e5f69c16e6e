"""Frames as they are shown: finished by default, raw when asked for, and fed back only when asked for."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import tiny_walker as tiny

from stylephase.runtime.controller import State
from stylephase.runtime.finish import finish
from stylephase.runtime.finishing import RAW, Finisher, Finishing, landed
from stylephase.runtime.foot_lock import Feet
from stylephase.runtime.limits import JUMP, teleported
from stylephase.runtime.plans import Steady
from stylephase.runtime.rig import rig_of
from stylephase.runtime.rollout import roll_out
from stylephase.runtime.walkers import NetworkWalker, drive


def states() -> list[State]:
    """A pose of a take that is kept, with bones that breathe and a body that slides, both feet in contact."""
    found = []
    for k in range(30):
        state = tiny.start([100])
        positions = state.positions * (1 + 0.02 * np.sin(k / 3)) + np.array([0.004 * k, 0, 0])
        found.append(replace(state, positions=positions, contacts=np.ones((1, 2))))
    return found


def run(how: Finishing) -> list[tuple[State, State]]:
    finisher, made = Finisher(tiny.BODY, how), states()
    return [finisher(before, after) for before, after in pairwise(made)]


def lengths(state: State) -> np.ndarray:
    rig = rig_of(tiny.BODY)
    return np.linalg.norm(state.positions[0, 1:] - state.positions[0, list(rig.parents[1:])], axis=-1)


def test_raw_frames_pass_as_they_are():
    for (on, shown), state in zip(run(RAW), states()[1:], strict=True):
        assert on is shown
        np.testing.assert_array_equal(shown.positions, state.positions)


def test_finished_frames_have_the_rigs_bones_and_held_feet_and_the_network_goes_on_with_its_own():
    made, toes = run(Finishing(grounded=False)), [leg.tip for leg in rig_of(tiny.BODY).legs]
    own = np.linalg.norm(rig_of(tiny.BODY).offsets[1:], axis=-1)
    for (on, shown), state in zip(made, states()[1:], strict=True):
        np.testing.assert_allclose(lengths(shown), own, atol=1e-9)
        np.testing.assert_array_equal(on.positions, state.positions)
    feet = np.stack([shown.positions[0, toes][:, ::2] for _, shown in made[10:]])
    assert np.linalg.norm(np.diff(feet, axis=0), axis=-1).max() < 1e-3


def test_fed_back_the_network_sees_what_is_shown():
    for on, shown in run(Finishing(fed_back=True)):
        assert on is shown


def test_grounding_moves_path_and_pose_alike():
    for (on, _), state in zip(run(Finishing(finished=False)), states()[1:], strict=True):
        moved = on.positions - state.positions
        np.testing.assert_allclose(moved, np.broadcast_to(moved[:, :1], moved.shape), atol=1e-12)
        np.testing.assert_allclose(on.path.root.positions - state.path.root.positions, moved[:, 0, ::2], atol=1e-12)


def test_after_forgetting_a_frame_follows_nothing():
    finisher, (first, *_) = Finisher(tiny.BODY), states()
    far = replace(first, positions=first.positions + np.array([50.0, 0, 0]))
    finisher(first, first)
    finisher.forget()
    _, shown = finisher(far, far)
    assert np.linalg.norm(shown.positions - far.positions, axis=-1).max() < 0.1


def test_nonsense_is_left_for_the_caller_to_judge():
    first = states()[0]
    _, shown = Finisher(tiny.BODY)(first, replace(first, positions=first.positions * np.nan))
    assert not np.isfinite(shown.positions).all()


@pytest.mark.parametrize("grounded", [True, False])
def test_a_drive_is_a_rollout_that_is_finished_afterwards(grounded):
    bundle, codes, start = tiny.bundle(network=tiny.Obedient()), tiny.codes(2), tiny.start([0, 60])
    plan, rig = Steady(np.array([1.0, 1.4])), rig_of(tiny.BODY)
    found = drive(NetworkWalker(bundle), codes, start, 90, plan, Finishing(grounded=grounded))
    raw = roll_out(bundle, codes, start, 90, plan, grounded=grounded)
    np.testing.assert_allclose(found.positions, finish(raw, rig).positions, atol=1e-9)
    np.testing.assert_allclose(found.root_positions, raw.root_positions, atol=1e-12)


def test_after_a_jump_elsewhere_feet_are_where_they_are_predicted_and_nothing_is_torn():
    """A walk that goes on 50 m away, through what follows: no toe beyond the reach of the lock, bones constant."""
    finisher, toes = Finisher(tiny.BODY), [leg.tip for leg in rig_of(tiny.BODY).legs]
    contacts = tiny.take().contacts[100:190, None].astype(float)
    walk = [replace(tiny.start([100 + k]), contacts=stands) for k, stands in enumerate(contacts)]
    assert 0 < contacts.mean() < 1
    there = [teleported(s, s.path.root.positions + [30.0, 40.0], s.path.root.angles + 1.0) for s in walk]
    off = []
    for k in range(1, 90):
        before, after = (walk[k - 1], walk[k]) if k < 40 else (there[k - 1], there[k])
        on, shown = finisher(before, after)
        off.append(np.linalg.norm((shown.positions - on.positions)[0, toes][:, ::2], axis=-1).max())
    off = np.array(off)
    assert off[39] < 1e-6 and off[39:].max() <= max(1.1 * off[:39].max(), 0.01)


def test_an_ordinary_step_is_no_jump():
    ones = np.ones((1, 2, 2))
    feet = Feet(ones, 2 * ones, np.ones((1, 2), dtype=bool), ones, ones)
    predicted = feet.predicted + np.array([[[0.2, 0.0], [0.0, JUMP]]])
    found = landed(feet, predicted)
    np.testing.assert_array_equal(found.held, [[True, False]])
    np.testing.assert_array_equal(found.places[0, 0], feet.places[0, 0])
    np.testing.assert_array_equal(found.places[0, 1], predicted[0, 1])
    assert (found.drift[0, 0] == 2).all() and not found.drift[0, 1].any() and not found.moving[0, 1].any()
