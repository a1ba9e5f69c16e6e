"""Leading a network along a recorded path: one that knows the answers walks as recorded."""

import numpy as np
import pytest
import tiny_adapters as tiny
import torch
from tiny_walker import BODY

from stylephase.evaluation import driven
from stylephase.evaluation.driven import Driven, apart, cycle_of, drive, recorded_part
from stylephase.evaluation.new_clips import take_rows
from stylephase.features.store import for_gate

LAYOUT = tiny.base().layout
TAKE = for_gate(tiny.clip_of("Plain", 4.0), LAYOUT)


class Knowing(torch.nn.Module):
    """Gives the recorded output of each frame in turn, normalised."""

    def __init__(self, y: np.ndarray):
        super().__init__()
        n = tiny.base().normaliser
        self.y, self.frame = torch.from_numpy((y - n.y_mean) / n.y_std).float(), 0

    def forward(self, x, p, code):
        self.frame += 1
        return self.y[[self.frame - 1]].expand(len(x), -1)


def led(network, takes=(TAKE,)) -> list[Driven]:
    return drive(network, LAYOUT, tiny.base().normaliser, torch.zeros(len(takes), 2), takes)


def test_a_network_that_knows_the_answers_walks_as_recorded():
    (ours,), real = led(Knowing(TAKE.y)), recorded_part(TAKE, LAYOUT)
    assert ours.poses.shape == real.poses.shape
    np.testing.assert_allclose(ours.places, real.places, atol=2e-3)
    np.testing.assert_allclose(np.sin(ours.phase), np.sin(real.phase), atol=2e-3)
    assert apart(cycle_of(ours), cycle_of(real)) < 0.2


class Stretching(Knowing):
    """The same, with the axes of all joints grown and sheared: as rotations they are the recorded ones."""

    def __init__(self, y: np.ndarray):
        y = y.copy()
        joints = y[:, LAYOUT.y_pose].reshape(len(y), -1, 4, 3)
        joints[:, :, 2] = 3 * joints[:, :, 2] + 0.5 * joints[:, :, 1]
        joints[:, :, 1] *= 7
        y[:, LAYOUT.y_pose] = joints.reshape(len(y), -1)
        super().__init__(y)


def test_predicted_axes_become_rotations_as_in_the_controller():
    """What grows frame by frame breaks nobody in the runtime, so it must break nobody here."""
    (plain,), (ours,) = led(Knowing(TAKE.y)), led(Stretching(TAKE.y))
    np.testing.assert_allclose(ours.poses, plain.poses, atol=1e-4)
    forward, up = (ours.poses.reshape(len(ours.poses), -1, 4, 3)[:, :, k] for k in (1, 2))
    np.testing.assert_allclose(np.linalg.norm([forward, up], axis=-1), 1, atol=1e-6)
    np.testing.assert_allclose((forward * up).sum(axis=-1), 0, atol=1e-6)


def test_characters_side_by_side_do_not_touch_one_another():
    network = tiny.base().network.synthesis
    other = for_gate(tiny.clip_of("GiantStrides", 3.0), LAYOUT)
    both, alone = led(network, (TAKE, other)), led(network, (other,))
    np.testing.assert_allclose(both[1].poses, alone[0].poses, atol=1e-4)
    assert len(both[0].poses) > len(both[1].poses)


def test_what_turns_infinite_is_told():
    network = Knowing(TAKE.y)
    network.y = network.y * float("inf")
    (ours,) = led(network)
    assert not ours.finite


@pytest.mark.parametrize("shift", [0.0, 2 * np.pi / 3])
def test_the_error_does_not_depend_on_where_the_phase_begins(shift):
    real = recorded_part(TAKE, LAYOUT)
    later = Driven(real.places, (real.phase + shift) % (2 * np.pi), real.poses)
    assert apart(cycle_of(later), cycle_of(real)) == pytest.approx(0, abs=0.05)


def test_the_error_is_the_mean_distance_of_the_joints():
    real = cycle_of(recorded_part(TAKE, LAYOUT))
    moved = real.copy()
    moved[:, :, 1] += 0.03
    assert apart(moved, real) == pytest.approx(3.0, abs=1e-9)


def test_another_style_is_farther_than_the_same():
    takes = [for_gate(tiny.clip_of(name, seconds), LAYOUT) for name, seconds in (("Plain", 6.0), ("StoopedOver", 4.0))]
    own, other = (cycle_of(recorded_part(take, LAYOUT)) for take in takes)
    real = cycle_of(recorded_part(TAKE, LAYOUT))
    assert apart(own, real) < 2.5 < apart(other, real)


def test_only_what_comes_after_settling_counts():
    short = take_rows(TAKE, np.arange(100))
    assert len(recorded_part(short, LAYOUT).poses) == 100 - driven.SETTLE
    assert len(BODY.joints) == recorded_part(short, LAYOUT).places.shape[1]
