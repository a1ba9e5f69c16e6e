"""The objective: squared error over all outputs, and differences of bone lengths in metres."""

import numpy as np
import pytest
import tiny_training as tiny
import torch

from stylephase.features.layout import Layout
from stylephase.features.normaliser import Normaliser
from stylephase.training.losses import BoneLengths, bone_length_loss, bone_lengths, squared_error
from stylephase.training.sampler import Scaling

LAYOUT = Layout(joints=3, mirrored=(0, 2, 1))
# A chain of three joints: two bones.
LENGTHS = BoneLengths(LAYOUT.y_pose, (0, 1), (1, 2))


def scaling(mean: float, std: float) -> Scaling:
    widths = (LAYOUT.inputs, LAYOUT.gate_inputs, LAYOUT.outputs)
    return Scaling(Normaliser(*(np.full(width, value) for width in widths for value in (mean, std))), LAYOUT)


def with_joints(*joints: tuple[float, float, float]) -> torch.Tensor:
    """One row of outputs in metres, with its three joints at these places."""
    y = torch.full((1, LAYOUT.outputs), 0.7)
    for number, place in enumerate(joints):
        start = LAYOUT.y_pose.start + 12 * number
        y[0, start : start + 3] = torch.tensor(place)
    return y


STRAIGHT = with_joints((0, 1, 0), (0, 1.5, 0), (0, 1.5, 0.2))
# The first bone is 0.05 m longer; the second, from (0.3, 1.4, 0) over (0, 0.3, 0.4), is 0.5 instead of 0.2 m long.
BENT = with_joints((0.3, 0.85, 0), (0.3, 1.4, 0), (0.3, 1.7, 0.4))


def test_bone_lengths_are_distances_between_neighbouring_joints():
    torch.testing.assert_close(LENGTHS(torch.cat([STRAIGHT, BENT])), torch.tensor([[0.5, 0.2], [0.55, 0.5]]))


def test_the_bone_length_loss_is_the_mean_difference_in_metres_whatever_the_normalisation():
    """By hand: (0.05 + 0.3) / 2 for one row, nothing for the other."""
    how = scaling(mean=0.4, std=3.0)
    y, predicted = (how.scaled("y", torch.cat(rows)) for rows in ((STRAIGHT, BENT), (BENT, BENT)))
    assert float(bone_length_loss(y, predicted, LENGTHS, how)) == pytest.approx(0.175 / 2, rel=1e-4)


def test_equal_poses_lose_nothing_and_moved_ones_neither():
    how = scaling(mean=0.0, std=1.0)
    moved = STRAIGHT.clone()
    moved[:, LAYOUT.y_pose] += torch.tensor([0.5, -0.25, 2.0]).repeat(12)
    assert float(bone_length_loss(STRAIGHT, STRAIGHT, LENGTHS, how)) == 0
    assert float(bone_length_loss(STRAIGHT, moved, LENGTHS, how)) == pytest.approx(0, abs=1e-6)


def test_the_squared_error_is_the_mean_over_rows_and_outputs():
    y, predicted = torch.zeros(2, 4), torch.tensor([[1.0, 2.0, 0.0, 0.0], [0.0, 0.0, 3.0, 0.0]])
    assert float(squared_error(y, predicted)) == (1 + 4 + 9) / 8


def test_gradients_are_finite_even_where_a_predicted_bone_has_no_length():
    how = scaling(mean=0.0, std=1.0)
    predicted = with_joints((0, 1, 0), (0, 1, 0), (0, 1, 0)).requires_grad_()
    (bone_length_loss(STRAIGHT, predicted, LENGTHS, how) + squared_error(STRAIGHT, predicted)).backward()
    assert predicted.grad is not None and predicted.grad.isfinite().all() and predicted.grad.abs().max() > 0


def test_a_body_has_one_bone_less_than_joints_in_its_vectors_with_the_skeletons_lengths():
    skeleton, lengths = tiny.BODY.skeleton, bone_lengths(tiny.BODY)
    assert len(lengths.parents) == tiny.BODY.layout.joints - 1
    for parent, child in zip(lengths.parents, lengths.children, strict=True):
        assert skeleton.parents[tiny.BODY.joints[child]] == tiny.BODY.joints[parent]
