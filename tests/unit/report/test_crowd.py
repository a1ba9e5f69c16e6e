"""A crowd in one picture: everybody is seen, each where the grid puts it."""

import numpy as np
import pytest

from stylephase.errors import InputError
from stylephase.motion.clip import forward_kinematics
from stylephase.report.render import Motion, crowd


def test_everybody_is_seen_in_a_place_of_their_own(limping):
    """Three characters in a row of three are three separate patches of colour."""
    motion = Motion(limping.skeleton, forward_kinematics(limping).positions[:30])
    pixels = crowd([motion] * 3, columns=3, spacing=(2.0, 3.0), width=300)
    inked = (np.ptp(pixels.astype(int), axis=2) > 60).any(axis=0)
    starts = np.flatnonzero(np.diff(np.insert(inked.astype(int), 0, 0)) == 1)
    assert pixels.shape[1] == 300 and len(starts) >= 3
    assert starts[-1] - starts[0] == pytest.approx(2 * 300 * 2.0 / 8.0, abs=30)


def test_an_empty_crowd_is_refused():
    with pytest.raises(InputError, match="no motion"):
        crowd([])
