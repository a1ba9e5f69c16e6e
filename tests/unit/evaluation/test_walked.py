"""The walker's own takes, once as recorded and once as if a network had made them: both are measured alike."""

from dataclasses import replace

import numpy as np
import pytest
import tiny_walker as tiny

from stylephase.errors import InputError
from stylephase.evaluation.runs import Run
from stylephase.evaluation.stretches import free_walks, generated, recorded, starts_of
from stylephase.evaluation.walked import Recorded, Walked, recordings, walk_all
from stylephase.features.layout import FPS
from stylephase.features.store import StyleVectors
from stylephase.files import write_json
from stylephase.models.bundle import save_bundle
from stylephase.motion.root import root_of
from stylephase.phase.global_phase import global_phase
from stylephase.runtime.rollout import Rollout

STYLES, SECONDS = ("OffbeatArms", "Plain"), 30.0


@pytest.fixture(scope="module")
def data() -> Recorded:
    return recordings(tiny.Store(*map(style_vectors, STYLES)), STYLES)


def style_vectors(style: str) -> StyleVectors:
    """Vectors with the global phase of the contacts, as of recorded takes: the true one has no ends."""
    phase = global_phase(tiny.take(style, SECONDS).contacts[:-1], FPS).astype(np.float32)
    return replace(tiny.style_vectors(style, SECONDS), phase=phase)


def played(stiff: str = "") -> Rollout:
    """The takes as a rollout, the hands of one style held at their first place in the hips' frame."""
    joints, hands, columns = list(tiny.BODY.joints), list(tiny.BODY.layout.effectors[:2]), []
    for style in STYLES:
        take = tiny.take(style, SECONDS)
        root, positions = root_of(take.pose, take.clip.skeleton), take.pose.positions[:, joints].copy()
        rotations = take.pose.rotations[:, joints] @ tiny.BODY.rest[joints]
        if style == stiff:
            held = (positions[0, hands] - positions[0, 0]) @ rotations[0, 0]
            positions[:, hands] = positions[:, :1] + np.einsum("tij,kj->tki", rotations[:, 0], held)
        columns.append((positions, rotations, root.positions, root.angles, take.contacts.astype(float)))
    places, rotations, roots, angles, contacts = (np.stack(part, axis=1) for part in zip(*columns, strict=True))
    return Rollout(places, rotations, roots, angles, contacts, np.zeros((*places.shape[:2], 8)))


def walked(data: Recorded, run: Rollout) -> Walked:
    return Walked(tiny.bundle(*STYLES), dict.fromkeys(STYLES, 1.0), run, data)


def test_only_arms_with_a_beat_of_their_own_are_free_of_the_steps(data):
    assert data.free == ("OffbeatArms",)
    assert data.hands["OffbeatArms"].tied < 0.15 and data.hands["Plain"].tied > 0.9
    assert data.hands["OffbeatArms"].peak == pytest.approx(1 / 0.78, abs=0.03)


def test_a_motion_measures_as_itself(data):
    found = walked(data, played())
    for style in STYLES:
        np.testing.assert_allclose(found.hands[style].against(data.hands[style]), 1.0, atol=0.05)
        assert found.hands[style].off(data.hands[style]).max() < 0.01
        assert found.collars[style].angles(data.collars[style]).max() < 0.5
        assert found.hands[style].tied == pytest.approx(data.hands[style].tied, abs=0.1)
        assert found.stuck(style) == 0


def test_hands_that_are_held_are_stuck_and_those_of_the_other_style_are_not(data):
    found = walked(data, played(stiff="OffbeatArms"))
    assert (found.stuck("OffbeatArms"), found.stuck("Plain")) == (2, 0)
    assert found.hands["OffbeatArms"].against(data.hands["OffbeatArms"]).max() < 0.05


def test_a_walk_that_did_not_stay_finite_is_left_out(data):
    run = played()
    run.positions[-1, 0] = np.nan
    found = walked(data, run)
    assert generated(run, 0) is None and list(found.walks) == ["Plain"] == list(found.hands)


def test_stretches_are_the_long_walks_of_a_style():
    whole = tiny.style_vectors("Plain", SECONDS)
    half = len(whole.take) // 8
    cut = replace(whole, take=(np.arange(len(whole.take)) >= half).astype(int), gaits=("FW", "FW"))
    lengths = [len(walk) for walk in recorded(cut, tiny.BODY.layout)]
    assert lengths == [len(whole.take) - half]
    other = replace(cut, gaits=("FW", "BW"))
    assert [len(walk) for walk in recorded(other, tiny.BODY.layout)] == [half], "the longest, where none is long"


def test_starts_are_different_training_frames():
    style = tiny.style_vectors("Plain", SECONDS)
    state = starts_of(style, tiny.BODY, 5)
    assert state.positions.shape[0] == 5 and np.abs(np.diff(state.positions, axis=0)).max(axis=(1, 2)).min() > 1e-3


def test_a_run_is_walked_at_the_gains_of_its_evaluation(data, tmp_path):
    bundle = tiny.bundle(*STYLES)
    save_bundle(tmp_path, bundle)
    walks = [{"style": style, "gain": gain} for style, gain in zip(STYLES, (0.7, 1.3), strict=True)]
    write_json(tmp_path / "evaluation.json", {"rollouts": {"walks": walks}})
    found = walk_all(Run(tmp_path, "lpn-film", "", 0), data, seconds=0.5)
    same = free_walks(bundle, data.styles, [0.7, 1.3], 0.5)
    np.testing.assert_array_equal(found.rollout.positions, same.positions)
    assert all(np.isfinite(found.step_error(style)) for style in STYLES)


def test_an_unknown_style_is_refused(data):
    with pytest.raises(InputError, match="no recorded walks of Unknown"):
        data.style("Unknown")
