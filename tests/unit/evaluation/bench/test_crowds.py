"""The rows of the crowds: one for each size, against one character by itself."""

import pytest

from stylephase.evaluation.bench import crowds
from stylephase.evaluation.bench.frames import made_bundle
from stylephase.models.lpn import NetworkSettings


def test_each_size_has_a_row_and_a_crowd_is_made_faster_than_one_by_one(monkeypatch):
    small = NetworkSettings(experts=2, units=64, gating_units=4)
    monkeypatch.setattr(crowds, "bundle_at_hand", lambda: made_bundle(small))
    monkeypatch.setattr(crowds, "_SIZES", (1, 16))
    one, many = crowds.crowd_rows()
    assert one.ratio == pytest.approx(1) and many.ratio > 1.5 and many.unit == "1/s"
