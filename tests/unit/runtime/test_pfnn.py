"""The controller of Holden's PFNN: its vectors, its path, and that the released network walks."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from stylephase.evaluation.motion import steps_of
from stylephase.models import holden
from stylephase.models.pfnn import Pfnn
from stylephase.models.released_pfnn import ReleasedPfnn, fetch_pfnn, holden_skeleton, load_pfnn, mirrored
from stylephase.models.synthesis import NetworkSettings
from stylephase.motion.clip import forward_kinematics
from stylephase.runtime.calibration import speed_of
from stylephase.runtime.pfnn import pfnn_clip, pfnn_input, roll_out_pfnn, start_pfnn, step_pfnn
from stylephase.runtime.plans import Steady
from stylephase.runtime.trajectory import Steering


def steering(characters: int, speed: float, angle: float = 0.0) -> Steering:
    way = np.array([np.sin(angle), np.cos(angle)])
    return Steering(np.tile(speed * way, (characters, 1)), np.full(characters, angle))


@pytest.fixture
def made() -> ReleasedPfnn:
    """A small network that always says the mean: a step ahead of 2 cm, a turn to the right, a share of the phase."""
    network = Pfnn(holden.INPUTS, holden.OUTPUTS, NetworkSettings(units=8)).eval()
    torch.nn.init.zeros_(network.layers[2].weight)
    y = np.zeros(holden.OUTPUTS)
    y[holden.Y_STEP], y[holden.Y_TURN], y[holden.Y_PHASE] = (0.0, 0.02), 0.01, 0.25
    y[holden.Y_CONTACTS] = (0.1, 0.2, 0.3, 0.4)
    y[holden.Y_PLACES] = [0] * 6 + [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]
    y[holden.Y_FACINGS] = [0] * 6 + [1.0] * 6
    y[holden.Y_POSITIONS] = np.tile([0.1, 0.9, 0.0], holden.JOINTS)
    x = np.zeros(holden.INPUTS)
    x[holden.X_PLACES] = [0.0] * 12 + [0.02 * k for k in holden.SAMPLES]
    return ReleasedPfnn(network, x, np.ones(holden.INPUTS), y, np.ones(holden.OUTPUTS))


def test_a_step_moves_root_phase_and_path(made):
    before = start_pfnn(made, 2)
    after = step_pfnn(made, before, steering(2, 1.2))
    np.testing.assert_allclose(after.root.positions, [[0, 0.02]] * 2, atol=1e-12)
    np.testing.assert_allclose(after.root.angles, [-0.01] * 2, atol=1e-12)
    np.testing.assert_allclose(after.phase, [np.pi / 2] * 2)
    np.testing.assert_array_equal(after.places[:, 59], before.places[:, 60])
    ahead = after.places[:, 110] - after.root.positions
    np.testing.assert_allclose(ahead, [[np.sin(-0.01), np.cos(-0.01)]] * 2, atol=1e-9)
    assert after.contacts.tolist() == [[0.4, 0.2]] * 2


def test_the_joints_stand_about_the_root_of_their_frame(made):
    """In the world they are where the root was before the step."""
    state = start_pfnn(made, 1)
    turned = replace(state, facings=np.tile([1.0, 0.0], (1, 120, 1)), places=state.places + [2.0, 3.0])
    positions = step_pfnn(made, turned, steering(1, 1.0)).positions
    # Half from the last pose, which stood at the origin, half from the predicted one: left of +x is -z.
    last, predicted = np.array([0.1, 0.9, 0.0]), np.array([2.0, 0.9, 2.9])
    np.testing.assert_allclose(positions[0, 0], (last + predicted) / 2, atol=1e-9)


def test_the_input_does_not_depend_on_place_and_facing_in_the_world(made):
    state = start_pfnn(made, 1)
    state = replace(
        state,
        facings=np.tile([0.6, 0.8], (1, 120, 1)),
        places=state.places[..., [1, 0]] * [0.6, 0.0] + state.places * [0, 0.8],
    )
    plain = pfnn_input(start_pfnn(made, 1))
    np.testing.assert_allclose(pfnn_input(state)[0, holden.X_FACINGS], plain[0, holden.X_FACINGS], atol=1e-12)
    moved = replace(start_pfnn(made, 1), places=start_pfnn(made, 1).places + [5.0, -3.0])
    np.testing.assert_allclose(pfnn_input(moved), plain, atol=1e-12)


def test_the_gait_is_labelled_at_every_point(made):
    labels = pfnn_input(start_pfnn(made, 1), "jog")[0, holden.X_GAITS].reshape(6, 12)
    assert labels.sum(axis=1).tolist() == [0, 0, 12, 0, 0, 0]


@pytest.fixture(scope="module")
def released(mirror, tmp_path_factory) -> ReleasedPfnn:
    """The released network."""
    if not (mirror / "pfnn-release.npz").exists():
        pytest.skip("needs the release: pfnn-release.npz is not in the mirror")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("STYLEPHASE_MIRROR", str(mirror))
        patch.setenv("STYLEPHASE_CACHE", str(tmp_path_factory.mktemp("cache")))
        return load_pfnn(fetch_pfnn())


def test_the_released_network_walks(released):
    """Straight at two speeds, and jogging: feet alternate, hips stay up, and it goes ahead."""
    speeds = np.array([0.9, 1.4])
    wanted = Steering(np.stack([0 * speeds, speeds], axis=1), np.zeros(2))
    run = roll_out_pfnn(released, start_pfnn(released, 2), 600, lambda frame, state: wanted)
    for k in range(2):
        steps = steps_of(run.contacts[180:, k] > 0.5)
        assert steps.alternate and 0.9 < steps.cycle < 1.4
        assert 0.8 < speed_of(run.root_positions[180:, k]) < 1.4
    hips = run.positions[180:, :, holden.HIPS, 1]
    assert hips.min() > 0.9 and hips.max() < 1.05
    assert run.root_positions[-1, :, 1].min() > 5.0
    jog = roll_out_pfnn(released, start_pfnn(released, 1), 480, lambda frame, state: steering(1, 3.0), "jog")
    assert steps_of(jog.contacts[180:, 0] > 0.5).cycle < 0.9
    assert speed_of(jog.root_positions[180:, 0]) > 1.5


def test_its_clip_has_the_joints_where_the_network_puts_them(released, mirror, monkeypatch, tmp_path):
    """Rotations and positions are separate outputs: bones of Holden's takes bring both within a centimetre or two."""
    if not (mirror / "pfnn-locomotion.tar.xz").exists():
        pytest.skip("needs Holden's takes: pfnn-locomotion.tar.xz is not in the mirror")
    monkeypatch.setenv("STYLEPHASE_MIRROR", str(mirror))
    monkeypatch.setenv("STYLEPHASE_CACHE", str(tmp_path))
    skeleton = holden_skeleton()
    run = roll_out_pfnn(released, start_pfnn(released, 1), 180, Steady(np.array([1.2]), turn=0.5))
    moving = [joint for joint in range(len(skeleton)) if not skeleton.sites[joint]]
    found = forward_kinematics(pfnn_clip(run, 0, skeleton, "walk")).positions[60:, moving]
    off = np.linalg.norm(found - run.positions[60:, 0], axis=-1)
    assert off.mean() < 0.01 and off.mean(axis=0).max() < 0.02


def drift(released: ReleasedPfnn, speeds: np.ndarray) -> np.ndarray:
    """Angle (degrees, to the left) of the way that characters go who are asked to walk straight ahead."""
    run = roll_out_pfnn(released, start_pfnn(released, len(speeds)), 900, Steady(speeds))
    way = run.root_positions[-1] - run.root_positions[300]
    return np.degrees(np.arctan2(way[:, 0], way[:, 1]))


def test_its_drift_to_the_right_is_the_networks_and_not_the_controllers(released):
    """A mirrored network drifts as far to the left, which it would not if the controller preferred a side."""
    speeds = np.array([1.0, 1.4])
    plain, turned = drift(released, speeds), drift(mirrored(released), speeds)
    assert (plain < -4).all() and plain == pytest.approx(-turned, abs=0.5)


def test_the_released_network_turns_where_it_is_told_to(released):
    run = roll_out_pfnn(released, start_pfnn(released, 2), 480, lambda frame, state: steering(2, 1.2, np.pi / 2))
    assert run.root_angles[-1] == pytest.approx([np.pi / 2] * 2, abs=0.1)
