"""Circles of both hands: their shape, and what counts as broken."""

from dataclasses import replace

import numpy as np
import pytest
import tiny_adapters as tiny

from stylephase.evaluation.circles import Limits, circle, walk_courses
from stylephase.evaluation.rollouts import start_of
from stylephase.features.store import for_gate

BASE = tiny.base()
CLIPS = [for_gate(tiny.clip_of(name), BASE.layout) for name in tiny.STYLES]


def walked(bundle=BASE, **options):
    codes = [bundle.code(name) for name in tiny.STYLES]
    given = np.full(2, 1.0), np.full(2, 0.9)
    import torch

    start = start_of(CLIPS, bundle.body)
    return walk_courses(bundle, tiny.STYLES, torch.stack(codes), start, *given, radii=(2.0,), seconds=3.0, **options)


@pytest.mark.parametrize(("sign", "side"), [(1.0, 1), (-1.0, -1)])
def test_a_circle_leaves_the_origin_straight_on_and_bends_to_its_side(sign, side):
    points = circle(2.0, sign, 12.0)
    assert np.allclose(points[0], 0) and points[1, 1] > 5 * abs(points[1, 0])
    np.testing.assert_allclose(np.hypot(points[:, 0] - side * 2.0, points[:, 1]), 2.0, atol=0.01)
    assert np.allclose(circle(0.0, sign)[:, 0], 0)


def test_every_style_walks_every_course_and_broken_ones_are_named():
    found = walked()
    assert [(c.style, c.radius, c.hand) for c in found.courses[:3]] == [
        ("Plain", 0.0, "straight"),
        ("Plain", 2.0, "left"),
        ("Plain", 2.0, "right"),
    ]
    assert found.of("ChestOut", 2.0, "right") == 5 and found.run.positions.shape[1] == 6
    assert all(course.broken for course in found.courses), "weights that were never trained hold nothing"
    assert not found.held(2.0, "left").any()


def test_limits_decide():
    loose = Limits(bones=np.inf, off_path=np.inf, hips=(-np.inf, np.inf), speed=-np.inf)
    assert walked(limits=loose).held(2.0, "left").all()
    strict = walked(limits=replace(loose, off_path=-1.0))
    assert {course.broken for course in strict.courses} == {"off its path"}
