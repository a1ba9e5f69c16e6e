"""The parts of Holden's vectors fill them, one after the other; in a mirror left and right change places."""

import numpy as np
import pytest

from stylephase.models import holden


def lengths(prefix: str) -> dict[str, slice]:
    named = {name: part for name, part in vars(holden).items() if name.startswith(prefix)}
    return {name: slice(part, part + 1) if isinstance(part, int) else part for name, part in named.items()}


def test_the_parts_follow_one_another_from_the_first_value_to_the_last():
    for prefix, width in (("X_", holden.INPUTS), ("Y_", holden.OUTPUTS)):
        parts = sorted((part.start, part.stop) for part in lengths(prefix).values())
        assert [start for start, _ in parts] == [0] + [stop for _, stop in parts[:-1]] and parts[-1][1] == width


def test_metres_are_places_joints_and_heights_but_no_facing_gait_or_rotation():
    x, y = holden.x_lengths(), holden.y_lengths()
    assert x[holden.X_PLACES].all() and x[holden.X_VELOCITIES].all() and x[holden.X_GROUND].all()
    assert not x[holden.X_FACINGS].any() and not x[holden.X_GAITS].any()
    assert y[holden.Y_STEP].all() and y[holden.Y_POSITIONS].all()
    assert not y[[holden.Y_TURN, holden.Y_PHASE]].any() and not y[holden.Y_ROTATIONS].any()


def test_twelve_points_six_of_them_present_or_future():
    assert len(holden.SAMPLES) == 12 and holden.SAMPLES[6:] == holden.FUTURE_SAMPLES == (0, 10, 20, 30, 40, 50)


@pytest.mark.parametrize("mirror", [holden.x_mirror, holden.y_mirror])
def test_a_mirror_twice_changes_nothing(mirror):
    columns, signs = mirror()
    values = np.random.default_rng(0).normal(size=len(columns))
    once = signs * values[columns]
    np.testing.assert_array_equal(signs * once[columns], values)
    assert not np.array_equal(once, values)


def test_in_a_mirror_feet_arms_and_slopes_change_sides_and_a_turn_its_sign():
    (columns, signs), values = holden.y_mirror(), np.zeros(holden.OUTPUTS)
    joints = values[holden.Y_POSITIONS].reshape(holden.JOINTS, 3)
    joints[5], joints[20], values[holden.Y_TURN], values[holden.Y_CONTACTS] = [1, 2, 3], [4, 5, 6], 0.1, [1, 2, 3, 4]
    found = signs * values[columns]
    turned = found[holden.Y_POSITIONS].reshape(holden.JOINTS, 3)
    assert turned[10].tolist() == [-1, 2, 3] and turned[27].tolist() == [-4, 5, 6]
    assert found[holden.Y_TURN] == -0.1 and found[holden.Y_CONTACTS].tolist() == [3, 4, 1, 2]
    ground = np.repeat([1.0, 2.0, 3.0], 12)
    columns = holden.x_mirror()[0]
    assert np.concatenate([np.zeros(holden.X_GROUND.start), ground])[columns][holden.X_GROUND][::12].tolist() == [
        3,
        2,
        1,
    ]
