"""The split: parts never touch, guards are kept, every style keeps frames to train on, one seed gives one result."""

from collections import Counter
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stylephase.data.layouts import Entry
from stylephase.data.split import GUARD, MANY_FILES, SHORTEST_CUT, frames_by_part, left_out, split


def takes(*groups: tuple[str, str, int]) -> list[Entry]:
    """So many takes of a style and gait for each group."""
    return [Entry(Path(f"{s}_{g}_{n}.bvh"), s, g) for s, g, count in groups for n in range(count)]


GROUPS = st.lists(
    st.tuples(st.sampled_from("ABC"), st.sampled_from(["FW", "BR", "TR1"]), st.integers(1, 14)), min_size=1
)


@given(groups=GROUPS, data=st.data(), seed=st.integers(0, 2**31))
def test_parts_are_disjoint_and_guarded(groups, data, seed):
    entries = takes(*groups)
    lengths = data.draw(st.lists(st.integers(1, 900), min_size=len(entries), max_size=len(entries)))
    by_entry: dict[int, list] = {}
    for segment in split(entries, lengths, seed=seed):
        assert 0 <= segment.start < segment.stop <= lengths[segment.entry]
        by_entry.setdefault(segment.entry, []).append(segment)
    for segments in by_entry.values():
        for one, next_one in pairwise(segments):
            gap = next_one.start - one.stop
            assert gap >= (GUARD if "train" in (one.part, next_one.part) else 0)
    assert set(by_entry) == {n for n, length in enumerate(lengths) if length >= 70}


@given(count=st.integers(1, 40), length=st.integers(70, 2000), seed=st.integers(0, 2**31))
def test_every_style_and_gait_keeps_frames_to_train_on(count, length, seed):
    entries = takes(("A", "FW", count))
    parts = frames_by_part(split(entries, [length] * count, seed=seed), entries)["A"]
    assert parts["train"] >= 0.5 * count * length
    assert parts["test"] == parts["validation"]
    if count >= MANY_FILES or length >= SHORTEST_CUT:
        assert 0.05 * count * length <= parts["test"] <= 0.15 * count * length


def test_with_many_files_each_belongs_to_one_part():
    entries = takes(("A", "FW", 23))
    segments = split(entries, [300] * 23, seed=1)
    assert [segment.entry for segment in segments] == list(range(23))
    assert all((segment.start, segment.stop) == (0, 300) for segment in segments)
    assert Counter(segment.part for segment in segments) == {"train": 19, "validation": 2, "test": 2}


def test_with_few_files_each_gives_a_window_of_a_tenth_to_either():
    entries = takes(("A", "FW", 9))
    segments = split(entries, [1000] * 9, seed=1)
    windows = [segment for segment in segments if segment.part != "train"]
    assert len(windows) == 18 and all(len(window) == 100 for window in windows)
    # Places and order differ from file to file.
    assert len({window.start for window in windows}) > 9
    assert len({segment.part for segment in segments if segment.start == min(w.start for w in windows)}) == 1


def test_short_takes_and_transitions_only_train():
    entries = takes(("A", "FW", 2), ("A", "TR1", 12))
    lengths = [SHORTEST_CUT - 1, SHORTEST_CUT, *[5000] * 12]
    parts = Counter((segment.entry, segment.part) for segment in split(entries, lengths, seed=0))
    assert {part for entry, part in parts if entry != 1} == {"train"}
    assert {part for entry, part in parts if entry == 1} == {"train", "validation", "test"}


def test_takes_too_short_to_be_of_use_are_left_out_and_reported():
    entries = takes(("A", "FW", 3))
    assert [segment.entry for segment in split(entries, [69, 70, 71], seed=0)] == [1, 2]
    assert left_out(entries, [69, 70, 71]) == (entries[0],)


def test_unusable_files_do_not_count_as_many():
    entries = takes(("A", "FW", MANY_FILES))
    segments = split(entries, [10] + [1000] * (MANY_FILES - 1), seed=0)
    assert len({segment.entry for segment in segments if segment.part == "test"}) == MANY_FILES - 1


def test_the_seed_decides_and_other_styles_do_not():
    """Training on some of the styles must test on the same frames as training on all."""
    some, all_ = takes(("A", "FW", 4), ("A", "BR", 12)), takes(("A", "FW", 4), ("A", "BR", 12), ("B", "FW", 30))
    first = split(some, [800] * 16, seed=3)
    assert first == split(some, [800] * 16, seed=3) == split(all_, [800] * 46, seed=3)[: len(first)]
    assert first != split(some, [800] * 16, seed=4)


def test_a_length_is_needed_for_each_take():
    with pytest.raises(ValueError, match="one length for each of 2 entries, got 1"):
        split(takes(("A", "FW", 2)), [100], seed=0)
