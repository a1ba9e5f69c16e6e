"""Means and deviations against a two-pass computation in double precision, mirror images written out."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stylephase.data.split import PARTS
from stylephase.features.layout import Layout, layout_of
from stylephase.features.normaliser import Moments, normaliser_of
from stylephase.features.store import StyleVectors


def vectors_of(layout: Layout, *, rows: int, symmetric: bool, seed: int) -> StyleVectors:
    """Single-precision vectors with means from -3 to 3 and deviations from 0.1 to 2; some rows in each part or none."""
    rng = np.random.default_rng(seed)

    def values(width: int) -> np.ndarray:
        spread = rng.normal(size=(rows, width)) * rng.uniform(0.1, 2.0, width)
        return (rng.uniform(-3, 3, width) + spread).astype(np.float32)

    part = rng.integers(-1, len(PARTS), rows)
    take = np.zeros(rows, dtype=int)
    made = (values(layout.inputs), values(layout.gate_inputs), values(layout.outputs))
    return StyleVectors("any", symmetric, ("walk",), *made, *np.zeros((2, len(take)), np.float32), take, part)


def two_pass(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    rows = rows.astype(np.longdouble)
    mean = rows.mean(axis=0)
    return mean, np.sqrt(((rows - mean) ** 2).mean(axis=0))


@pytest.fixture(scope="module")
def layout(skeletons) -> Layout:
    return layout_of(skeletons["100style"])


def test_only_training_rows_count_and_symmetric_styles_with_their_mirror_images(layout):
    styles = [vectors_of(layout, rows=200, symmetric=symmetric, seed=n) for n, symmetric in enumerate((True, False))]
    found = normaliser_of(styles, layout)
    for name, mirror in (("x", layout.mirror_x), ("p", layout.mirror_p), ("y", layout.mirror_y)):
        rows = [getattr(style, name)[style.part == PARTS.index("train")] for style in styles]
        source, sign, _ = mirror
        mean, std = two_pass(np.concatenate([rows[0], rows[0][:, source] * sign, rows[1]]))
        np.testing.assert_allclose(getattr(found, f"{name}_mean"), mean.astype(float), atol=1e-12)
        np.testing.assert_allclose(getattr(found, f"{name}_std"), std.astype(float), rtol=1e-10)


def test_the_mean_of_symmetric_styles_alone_is_its_own_mirror_image(layout):
    """What is odd under mirroring, such as sideways speed, has mean zero; the hips' x among them."""
    found = normaliser_of([vectors_of(layout, rows=50, symmetric=True, seed=3)], layout)
    source, sign, _ = layout.mirror_x
    np.testing.assert_allclose(found.x_mean[source] * sign, found.x_mean, atol=1e-12)
    assert abs(found.x_mean[48]) < 1e-12


def test_a_large_mean_does_not_swallow_a_small_deviation():
    """Heights of 1.5 m that vary by 7 cm, in single precision: sums in single precision go wrong here by decimetres."""
    rows = np.random.default_rng(0).normal(1.5, 0.07, (200_000, 1)).astype(np.float32)
    rows[:, 0] += 300
    moments = Moments(1)
    for piece in np.array_split(rows, 7):
        moments.add(piece, None)
    mean, std = two_pass(rows)
    np.testing.assert_allclose(moments.mean_std()[0], mean.astype(float), atol=1e-9)
    np.testing.assert_allclose(moments.mean_std()[1], std.astype(float), rtol=1e-6)


def test_constants_get_one_and_small_deviations_the_floor():
    """A constant, single-precision noise about one, one below the floor, one above it."""
    rng = np.random.default_rng(1)
    rows = np.full((1000, 4), 0.7)
    rows += rng.choice([-1, 1], (1000, 4)) * [0.0, 1e-7, 0.004, 0.02]
    moments = Moments(4)
    moments.add(rows, None)
    np.testing.assert_allclose(moments.mean_std()[1], [1.0, 1.0, 0.01, 0.02], rtol=1e-3)


@settings(max_examples=15)
@given(st.integers(1, 6), st.integers(0, 2**32 - 1))
def test_rows_may_come_in_any_pieces(pieces, seed):
    rows = np.random.default_rng(seed).normal(2.0, 1.0, (60, 3))
    whole, cut = Moments(3), Moments(3)
    whole.add(rows, None)
    for piece in np.array_split(rows, pieces):
        cut.add(piece, None)
    np.testing.assert_allclose(cut.mean_std(), whole.mean_std(), rtol=1e-12)


def test_what_is_added_is_not_changed(layout, frozen):
    rows = frozen(np.random.default_rng(2).normal(size=(5, layout.inputs)))
    Moments(layout.inputs).add(rows, layout.mirror_x)
