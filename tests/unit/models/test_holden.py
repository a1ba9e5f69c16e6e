"""The parts of Holden's vectors fill them, one after the other."""

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
