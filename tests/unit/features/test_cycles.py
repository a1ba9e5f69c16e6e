"""Whole cycles of a clip, counted by the foot that comes down more often ([M18] Table 2)."""

from dataclasses import replace

import numpy as np
import tiny_adapters as tiny

from stylephase.features.cycles import cycle_rows, cycles_of


def test_the_walkers_cycles_are_counted_and_begin_where_its_phase_does():
    clip = tiny.clip_of("Plain", 6.0)
    turns = np.unwrap(clip.phase)[-1] - np.unwrap(clip.phase)[0]
    cycles = cycles_of(clip)
    assert len(cycles) == int(turns / (2 * np.pi)) or len(cycles) == int(turns / (2 * np.pi)) - 1
    begins = clip.phase[cycles.starts[:-1]] - (np.pi if cycles.foot == "left" else 0)
    assert np.abs(np.sin(begins)).max() < 0.05 and np.cos(begins).min() > 0.9


def test_rows_are_of_the_first_cycles_and_of_no_more_than_there_are():
    cycles = cycles_of(tiny.clip_of("Plain", 6.0))
    one, whole = cycles.rows(1), cycles.rows()
    assert len(one) == cycles.starts[1] - cycles.starts[0] and np.array_equal(cycles.rows(99), whole)
    assert len(whole) == cycles.starts[-1] - cycles.starts[0] and np.array_equal(one, whole[: len(one)])


def test_where_no_foot_comes_down_twice_there_is_no_cycle():
    clip = tiny.clip_of("Plain")
    for contact in (0.0, 1.0):
        y = clip.y.copy()
        y[:, -2:] = contact
        none = cycles_of(replace(clip, y=y))
        assert len(none) == 0 and len(none.rows()) == 0


def joined(first, second):
    """Two clips as takes of one style."""
    kinds = ("x", "p", "y", "phase", "phase_update", "part")
    arrays = {kind: np.concatenate([getattr(first, kind), getattr(second, kind)]) for kind in kinds}
    take = np.repeat([0, 1], [len(first.x), len(second.x)])
    return replace(first, gaits=(*first.gaits, *second.gaits), take=take, **arrays)


def test_cycles_go_on_in_the_next_take():
    one, other = tiny.clip_of("Plain", 6.0), tiny.clip_of("Plain", 4.0)
    both, first = joined(one, other), cycles_of(one)
    assert np.array_equal(cycle_rows(both, len(first)), first.rows())
    more = cycle_rows(both, len(first) + 1)
    assert np.array_equal(more[: len(first.rows())], first.rows())
    assert np.array_equal(more[len(first.rows()) :], len(one.x) + cycles_of(other).rows(1))
    assert len(cycle_rows(both)) == len(first.rows()) + len(cycles_of(other).rows())
