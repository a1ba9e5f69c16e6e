"""Random movement and what a phase explains of it."""

import numpy as np
import pytest

from stylephase.evaluation.stochastic import explained_of_hands, with_random_hands
from stylephase.motion.clip import forward_kinematics
from stylephase.motion.contacts import ContactRule
from stylephase.motion.synthetic import find_style, walk
from stylephase.phase.local import variant
from stylephase.phase.take import movement_of

RULE = ContactRule(speed=0.3, height=0.03)


def test_only_the_hands_become_random_and_keep_their_size():
    clip, _ = walk(find_style("Plain"), "FW", seconds=8.0)
    movement = movement_of(forward_kinematics(clip), clip.skeleton, 60.0, RULE)
    changed = with_random_hands(movement, 1.0, np.random.default_rng(0))
    np.testing.assert_array_equal(changed.places[:, 2:], movement.places[:, 2:])
    np.testing.assert_allclose(changed.places[:, :2].std(axis=0), movement.places[:, :2].std(axis=0), rtol=0.15)
    np.testing.assert_allclose(with_random_hands(movement, 0.0, np.random.default_rng(0)).places, movement.places)


@pytest.mark.parametrize(("share", "low", "high"), [(0.0, 0.95, 1.0), (1.0, 0.2, 0.6)])
def test_a_phase_explains_what_comes_back_and_little_of_what_does_not(share, low, high):
    found = explained_of_hands(find_style("Plain"), RULE, variant("adaptive"), share=share)
    assert low <= found <= high
