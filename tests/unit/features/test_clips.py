"""Style clips never straddle two takes or two parts, and short stretches give one clip that repeats them."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from stylephase.data.split import PARTS
from stylephase.features.clips import clip_rows
from stylephase.features.store import StyleVectors

GAITS = ("walk", "run", "walk")


def style_of(take: np.ndarray, part: np.ndarray) -> StyleVectors:
    """A style with the given take and part of each row; its vectors are of no interest."""
    rows = len(take)
    empty, phase = np.zeros((rows, 1), dtype=np.float32), np.zeros(rows, dtype=np.float32)
    p = np.zeros((rows, 8), dtype=np.float32)
    return StyleVectors("any", False, GAITS, empty, p, empty, phase, phase, take, part)


def runs(lengths: list[int], parts: list[str | None]) -> StyleVectors:
    """Stretches of the first take, one after the other; None is a guard."""
    part = np.repeat([-1 if name is None else PARTS.index(name) for name in parts], lengths)
    return style_of(np.zeros(len(part), dtype=int), part)


# Stretches of three takes, in their order.
STRETCHES = st.lists(
    st.tuples(st.integers(0, 2), st.integers(-1, len(PARTS) - 1), st.integers(1, 40)), min_size=1, max_size=8
).map(lambda rows: sorted(rows, key=lambda row: row[0]))


@settings(max_examples=40)
@given(STRETCHES, st.sampled_from(PARTS), st.integers(1, 15))
def test_every_row_of_a_clip_lies_in_one_take_and_in_the_part_asked_for(stretches, part, frames):
    take = np.concatenate([np.full(length, take) for take, _, length in stretches])
    parts = np.concatenate([np.full(length, part) for _, part, length in stretches])
    style = style_of(take, parts)
    found = clip_rows(style, part, frames=frames)
    assert found.shape[1] == frames
    for rows in found:
        assert len(set(take[rows])) == 1
        assert set(parts[rows]) == {PARTS.index(part)}
        # Neighbours, or back to the start of a stretch that is too short.
        steps = np.diff(rows)
        assert np.all((steps == 1) | (rows[1:] == rows[0]))
        if np.any(steps != 1):
            assert not np.any(steps == 1) or rows.max() - rows.min() + 1 < frames
    inside = parts == PARTS.index(part)
    assert (len(found) > 0) == inside.any()


def test_a_long_stretch_gives_a_clip_every_two_seconds():
    """600 rows: at 0, 120, 240 and 360; what is left at the end is too short for another."""
    found = clip_rows(runs([600], ["train"]), "train")
    assert found.shape == (4, 240)
    np.testing.assert_array_equal(found[:, 0], [0, 120, 240, 360])
    np.testing.assert_array_equal(found[3], np.arange(360, 600))


def test_a_short_stretch_is_repeated():
    found = clip_rows(runs([30, 100], ["test", "train"]), "train")
    np.testing.assert_array_equal(found, [np.concatenate([np.arange(30, 130), np.arange(30, 130), np.arange(30, 70)])])


def test_a_guard_and_another_part_break_a_stretch():
    style = runs([240, 5, 240, 24, 240], ["train", None, "train", "validation", "train"])
    np.testing.assert_array_equal(clip_rows(style, "train")[:, 0], [0, 245, 509])
    np.testing.assert_array_equal(np.unique(clip_rows(style, "validation")), np.arange(485, 509))


def test_gaits_keep_their_takes_only():
    style = style_of(np.repeat([0, 1, 2], 10), np.zeros(30, dtype=int))
    part = PARTS[0]
    np.testing.assert_array_equal(clip_rows(style, part, gaits=("run",), frames=10), [np.arange(10, 20)])
    assert len(clip_rows(style, part, gaits=("walk",), frames=10)) == 2
    assert clip_rows(style, part, gaits=("dash",), frames=10).shape == (0, 10)


def test_a_part_without_rows_gives_no_clip():
    assert clip_rows(runs([300], ["train"]), "test").shape == (0, 240)
