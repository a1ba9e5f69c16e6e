"""Phases from contacts alone: only a foot that never touches the floor loses its own."""

from dataclasses import replace

import numpy as np
import tiny_training as tiny
import torch

from stylephase.evaluation.contact_based import ContactBasedStore, contact_based, untouched

LAYOUT = tiny.BODY.layout


def style(right: float, left: float):
    """Rows of which each foot is in contact for a share."""
    rows = tiny.vectors("Plain", 0, 100)
    y = rows.y.copy()
    y[:, LAYOUT.y_contacts] = np.arange(100)[:, None] < 100 * np.array([right, left])
    return replace(rows, y=y)


def test_a_foot_in_the_air_is_told_by_its_side():
    assert untouched(style(0.5, 0.6)).tolist() == [False, False]
    assert untouched(style(0.5, 0.0)).tolist() == [True, False]
    assert untouched(style(0.01, 0.5)).tolist() == [False, True]


def test_only_the_phase_of_the_raised_foot_is_taken_away():
    hop, walk = style(0.5, 0.0), style(0.5, 0.5)
    blind = contact_based(hop, LAYOUT)
    left = slice(4, 6)
    changed = {"p": blind.p != hop.p, "y": blind.y != hop.y}
    assert changed["p"][:, left].all() and (blind.p[:, left] == 0).all()
    start = LAYOUT.y_phases.start
    columns = np.flatnonzero(changed["y"].any(axis=0)).tolist()
    assert columns == [start + 4, start + 5, start + 12, start + 13] and (blind.y[:, columns] == 0).all()
    assert not changed["p"][:, :4].any() and not changed["p"][:, 6:].any()
    same = contact_based(walk, LAYOUT)
    assert np.array_equal(same.p, walk.p) and np.array_equal(same.y, walk.y)


def test_such_a_store_trains_like_any_other(tmp_path):
    class Blind(ContactBasedStore, tiny.TinyStore):
        pass

    one, other = (
        tiny.Trainer(store(), "lpn-film", replace(tiny.PRESET, steps=2, steps_per_code=1), "tiny", 0)
        for store in (Blind, tiny.TinyStore)
    )
    for rows, plain in zip(one.styles, other.styles, strict=True):
        assert np.array_equal(rows.x, plain.x)
    assert all(torch.isfinite(t).all() for t in tiny.weights(one.run(tmp_path, tiny.ignore)).values())
