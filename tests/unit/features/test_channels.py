"""Channels of an autoencoder: the joints, steps and contacts that the vectors tell, and back to a path in the world."""

import numpy as np
import pytest
from tiny_walker import BODY, style_vectors, take

from stylephase.features.channels import Channels, channels_of, from_table


@pytest.fixture(scope="module")
def walk() -> Channels:
    return channels_of(style_vectors(), np.arange(100, 340), BODY.layout)


def test_a_table_and_back_is_the_same(walk):
    again = from_table(walk.table)
    assert walk.table.shape == (240, 3 * BODY.layout.joints + 5)
    np.testing.assert_array_equal(again.positions, walk.positions)
    np.testing.assert_array_equal(again.steps, walk.steps)
    np.testing.assert_array_equal(again.contacts, walk.contacts)


@pytest.mark.parametrize("turn", [0.0, 0.6])
def test_the_world_is_the_take_s_own_but_for_a_turn_and_a_shift(turn):
    made = take("Plain", 8.0, turn)
    joints = made.pose.positions[:, list(BODY.joints)]
    vectors = style_vectors()
    rows = np.arange(200)
    own = type(vectors)(
        "Plain", False, ("FW",), *(getattr(made.vectors, name) for name in ("x", "p", "y", "phase", "phase_update")),
        np.zeros(len(made.vectors.x), dtype=int), np.zeros(len(made.vectors.x), dtype=int),
    )  # fmt: skip
    found = channels_of(own, rows, BODY.layout).world
    # Distances between any two joints at any two times do not change.
    for first, last in ((0, 199), (50, 120)):
        apart = np.linalg.norm(found[first, :, None] - found[last], axis=-1)
        true = np.linalg.norm(joints[first, :, None] - joints[last], axis=-1)
        np.testing.assert_allclose(apart, true, atol=1e-6)


def test_poses_have_the_vectors_places_and_velocities(walk):
    rows = np.arange(100, 340)
    real = style_vectors().x[rows][:, BODY.layout.x_pose].reshape(240, -1, 4, 3)
    made = walk.poses.reshape(240, -1, 4, 3)
    np.testing.assert_allclose(made[:, :, 0], real[:, :, 0], atol=1e-6)
    np.testing.assert_allclose(made[1:, :, 3], real[1:, :, 3], atol=1e-3)


def test_contacts_are_those_of_their_own_frame(walk):
    # Frame t of the take has the contacts that row t - 1 foretells.
    np.testing.assert_array_equal(walk.contacts[1:], take("Plain", 16.0).contacts[101:340])


def test_a_mirror_image_mirrored_is_the_walk(walk):
    image = walk.mirrored(BODY.layout.mirrored)
    np.testing.assert_allclose(image.mirrored(BODY.layout.mirrored).table, walk.table)
    assert np.abs(image.table - walk.table).max() > 0.1
