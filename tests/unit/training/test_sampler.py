"""Batches are balanced over styles, come from training rows alone, and mirror only what may be mirrored."""

import numpy as np
import pytest
import torch

from stylephase.data.split import PARTS
from stylephase.features.layout import CLIP_FRAMES, Layout
from stylephase.features.normaliser import Normaliser
from stylephase.features.store import StyleVectors
from stylephase.training.sampler import Sampler, Scaling

LAYOUT = Layout(joints=3, mirrored=(0, 2, 1))
# Elements of x that tell where a row comes from: one that mirroring keeps, one whose sign it turns. The same of a clip.
_KEPT, _TURNED = LAYOUT.x_pose.start + 1, LAYOUT.x_pose.start


def normaliser(mean: float = 0.0, std: float = 1.0) -> Normaliser:
    widths = (LAYOUT.inputs, LAYOUT.gate_inputs, LAYOUT.outputs)
    return Normaliser(*(np.full(width, value) for width in widths for value in (mean, std)))


def numbered(style: str, first: int, rows: int, *, symmetric: bool, train: float = 0.6) -> StyleVectors:
    """Rows that carry their number, from `first` on; all after a share are no training rows."""
    x, y = np.zeros((rows, LAYOUT.inputs), np.float32), np.zeros((rows, LAYOUT.outputs), np.float32)
    p = np.zeros((rows, 8), np.float32)
    x[:, _TURNED] = 1
    x[:, _KEPT] = p[:, 0] = p[:, 2] = y[:, LAYOUT.y_pose.start + 1] = np.arange(first, first + rows)
    y[:, LAYOUT.y_contacts] = (1, 2)
    part = np.where(np.arange(rows) < train * rows, PARTS.index("train"), PARTS.index("test"))
    return StyleVectors(style, symmetric, ("FW",), x, p, y, *np.zeros((2, rows), np.float32), np.zeros(rows, int), part)


STYLES = [
    numbered("A", 0, 1000, symmetric=True),
    numbered("B", 1000, 4000, symmetric=False),
    numbered("C", 5000, 500, symmetric=True),
]


@pytest.fixture
def sampler() -> Sampler:
    return Sampler(STYLES, Scaling(normaliser(), LAYOUT), np.random.default_rng(0))


def test_a_styles_chance_goes_with_the_root_of_its_training_frames(sampler):
    """5,000 draws of one style: shares within four standard errors of the roots of 600, 2400 and 300."""
    draws = np.concatenate([sampler.draw_styles(1) for _ in range(5_000)])
    expected = np.sqrt([600, 2400, 300]) / np.sqrt([600, 2400, 300]).sum()
    shares = np.bincount(draws, minlength=3) / len(draws)
    assert (np.abs(shares - expected) < 4 * np.sqrt(expected * (1 - expected) / len(draws))).all()


def test_styles_of_one_draw_differ_and_there_are_no_more_than_asked_or_exist(sampler):
    for asked, given in ((1, 1), (2, 2), (3, 3), (8, 3)):
        drawn = sampler.draw_styles(asked)
        assert len(drawn) == len(set(drawn.tolist())) == given


def test_frames_are_training_frames_in_one_group_per_style(sampler):
    batch = sampler.draw_frames(np.array([2, 0, 1]), 400)
    groups = batch.x[:, _KEPT].reshape(3, 400)
    for group, style, first in zip(groups, (2, 0, 1), (5000, 0, 1000), strict=True):
        rows = group - first
        assert rows.min() >= 0 and rows.max() < 0.6 * len(STYLES[style].x)
        assert len(rows.unique()) > 150, "rows are drawn at random"


def test_x_p_and_y_are_of_the_same_row(sampler):
    batch = sampler.draw_frames(np.array([0, 1]), 200)
    number = batch.x[:, _KEPT]
    assert torch.equal(batch.p[:, 0], number) and torch.equal(batch.y[:, LAYOUT.y_pose.start + 1], number)


def test_half_the_frames_of_symmetric_styles_are_mirrored_and_none_of_the_others(sampler):
    batch = sampler.draw_frames(np.array([0, 1, 2]), 4000)
    mirrored = (batch.x[:, _TURNED] == -1).reshape(3, 4000).double().mean(dim=1)
    assert abs(mirrored[0] - 0.5) < 0.04 and mirrored[1] == 0 and abs(mirrored[2] - 0.5) < 0.04
    swapped = batch.y[:, LAYOUT.y_contacts.start] == 2
    assert torch.equal(swapped, batch.x[:, _TURNED] == -1), "x and y are mirrored together"


def test_clips_are_of_training_rows_one_for_each_style(sampler):
    for _ in range(20):
        clips = sampler.draw_clips(np.array([1, 0]))
        assert clips.shape == (2, CLIP_FRAMES, LAYOUT.pose)
        for clip, style, first in zip(clips, (1, 0), (1000, 0), strict=True):
            rows = clip[:, 1] - first
            assert (rows.diff() == 1).all() and rows[0] >= 0 and rows[-1] < 0.6 * len(STYLES[style].x)


def test_whole_clips_are_mirrored_half_the_time_for_symmetric_styles_only(sampler):
    turned = torch.stack([sampler.draw_clips(np.array([0, 1]))[:, :, 0] == -1 for _ in range(400)])
    assert (turned.all(dim=2) == turned.any(dim=2)).all(), "a clip is mirrored as a whole"
    assert 0.4 < turned[:, 0].double().mean() < 0.6 and not turned[:, 1].any()


def test_a_style_shorter_than_a_clip_repeats_itself():
    short = numbered("Short", 0, 100, symmetric=False, train=1.0)
    clip = Sampler([short], Scaling(normaliser(), LAYOUT), np.random.default_rng(0)).draw_clips(np.array([0]))[0]
    assert torch.equal(clip[:, 1], torch.arange(CLIP_FRAMES) % 100)


def test_the_same_seed_draws_the_same_batches_and_another_seed_others():
    def draw(seed: int) -> torch.Tensor:
        sampler = Sampler(STYLES, Scaling(normaliser(), LAYOUT), np.random.default_rng(seed))
        return sampler.draw_frames(sampler.draw_styles(2), 50).x

    assert torch.equal(draw(1), draw(1)) and not torch.equal(draw(1), draw(2))


def test_drawing_leaves_the_vectors_as_they_are(sampler):
    before = [style.x.copy() for style in STYLES]
    sampler.draw_frames(np.array([0, 1, 2]), 100)
    sampler.draw_clips(np.array([0, 1, 2]))
    assert all(np.array_equal(style.x, copy) for style, copy in zip(STYLES, before, strict=True))


# Scaling


def test_scaled_outputs_come_back_in_metres():
    scaling = Scaling(normaliser(mean=3.0, std=0.5), LAYOUT)
    y = torch.randn(5, LAYOUT.outputs, generator=torch.Generator().manual_seed(0))
    torch.testing.assert_close(scaling.scaled("y", y), (y - 3) / 0.5)
    torch.testing.assert_close(scaling.metric(scaling.scaled("y", y)), y)


def test_a_clip_is_scaled_as_the_pose_of_x():
    rng = np.random.default_rng(0)
    widths = np.repeat((LAYOUT.inputs, LAYOUT.gate_inputs, LAYOUT.outputs), 2)
    scaling = Scaling(Normaliser(*(rng.uniform(0.5, 2, width) for width in widths)), LAYOUT)
    x = torch.randn(4, LAYOUT.inputs, generator=torch.Generator().manual_seed(0))
    pose = x[:, LAYOUT.x_pose]
    assert torch.equal(scaling.scaled("clip", pose), scaling.scaled("x", x)[:, LAYOUT.x_pose])
    flip = torch.tensor([True, False, True, True])
    assert torch.equal(scaling.mirrored("clip", pose, flip), scaling.mirrored("x", x, flip)[:, LAYOUT.x_pose])


@pytest.mark.parametrize(("kind", "width"), [("x", LAYOUT.inputs), ("p", 8), ("y", LAYOUT.outputs)])
def test_mirroring_twice_gives_the_row_back_and_touches_only_rows_asked_for(kind, width):
    scaling = Scaling(normaliser(), LAYOUT)
    rows = torch.randn(3, width, generator=torch.Generator().manual_seed(0))
    flip = torch.tensor([True, False, True])
    once = scaling.mirrored(kind, rows, flip)
    assert torch.equal(once[1], rows[1]) and not torch.equal(once[0], rows[0])
    assert torch.equal(scaling.mirrored(kind, once, flip), rows)
