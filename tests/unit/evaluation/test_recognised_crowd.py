"""Characters are recognised by their own code, and not by each other's."""

from dataclasses import replace

import numpy as np
import tiny_walker as tiny
import torch

from stylephase.evaluation import crowd as crowds
from stylephase.evaluation.crowd import crowd, crowd_of, dealt_anew, nearest_styles
from stylephase.evaluation.style import StyleSpace


def test_a_crowd_is_told_apart_by_its_nearest_styles():
    """In a space of one statistic, the height of the first joint; the third does not stay finite."""
    run = crowd(tiny.bundle(network=tiny.Obedient()), tiny.codes(3), tiny.start([0, 0, 0]), np.ones(3), 1.5)
    positions = run.positions.copy()
    positions[:, 1, :, 1] += 5.0
    positions[-1, 2] = np.nan
    size = tiny.BODY.layout.pose
    whitening = np.zeros((size, 1))
    whitening[1] = 1
    space = StyleSpace(("low", "high"), np.array([[0.9], [5.9]]), np.ones(size), whitening)
    assert nearest_styles(replace(run, positions=positions), space, 10) == ["low", "high", ""]
    ways = run.root_positions[-1] - run.root_positions[0]
    assert np.linalg.norm(ways[0] - ways[1]) > 0.01


def test_dealt_anew_nobody_keeps_a_code():
    codes = tiny.codes(4)
    assert not any(torch.equal(a, b) for a, b in zip(codes, dealt_anew(codes), strict=True))


def test_a_crowd_tells_who_is_recognised(monkeypatch):
    """Untrained styles differ by how they lean: own codes are recognised, dealt ones are not."""
    monkeypatch.setattr(crowds, "_CROWD_SECONDS", 6.5)
    bundle = tiny.bundle(network=tiny.Obedient())
    found = crowd_of(bundle, tiny.start([0] * len(bundle.styles)), gains=np.ones(len(bundle.styles)))
    assert found.count == len(bundle.styles)
    assert (found.right, found.dealt) == (found.count, 0)
    fewer = crowd_of(bundle, tiny.start([0] * found.count), gains=np.ones(found.count), uncounted=bundle.styles[:1])
    assert (fewer.count, fewer.right) == (found.count - 1, found.count - 1)
