"""A stored style code is made from training clips, walking ones where there are any."""

from dataclasses import replace

import numpy as np
import pytest
import tiny_training as tiny
import torch

from stylephase.data.split import PARTS
from stylephase.features.normaliser import normaliser_of
from stylephase.features.store import StyleVectors
from stylephase.models.generator import FilmGenerator
from stylephase.models.synthesis import StyledNetwork
from stylephase.training.codes import CLIPS_PER_CODE, clip_codes, stored_codes
from stylephase.training.sampler import Scaling

LAYOUT = tiny.BODY.layout


class Recorder(FilmGenerator):
    """A generator that notes the clips it is shown."""

    def forward(self, clips):
        self.seen = clips
        return super().forward(clips)


@pytest.fixture
def generator() -> Recorder:
    torch.manual_seed(0)
    return Recorder(LAYOUT.pose, 16, tiny.PRESET.network.generator).train()


def style(*gaits: str, rows: int = 2000) -> StyleVectors:
    """One take of each gait; the last fifth of each is for the test. Rows carry their number in the pose."""
    made = tiny.vectors("Plain", 0, rows * len(gaits), validation=False)
    made.x[:, LAYOUT.x_pose.start + 1] = np.arange(len(made.x))
    part = np.where(np.arange(len(made.x)) % rows < 0.8 * rows, PARTS.index("train"), PARTS.index("test"))
    return replace(made, gaits=gaits, take=np.repeat(np.arange(len(gaits)), rows), part=part)


def scaling(vectors: StyleVectors) -> Scaling:
    return Scaling(normaliser_of([vectors], LAYOUT), LAYOUT)


def rows_seen(generator: Recorder, how: Scaling) -> np.ndarray:
    mean, std = (part[1] for part in how.clip)
    return (generator.seen[:, :, 1] * std + mean).round().int().numpy()


@pytest.mark.parametrize("walk", ["walk", "FW"])
def test_codes_come_from_training_clips_of_the_walk(generator, walk):
    vectors = style("run", walk)
    clip_codes(generator, vectors, scaling(vectors))
    seen = rows_seen(generator, scaling(vectors))
    assert seen.shape == (CLIPS_PER_CODE, 240)
    assert seen.min() >= 2000 and seen.max() < 3600


def test_clips_are_spread_over_the_take(generator):
    vectors = style("walk", rows=10_000)
    clip_codes(generator, vectors, scaling(vectors), most=4)
    seen = rows_seen(generator, scaling(vectors))
    assert len(seen) == 4 and seen.min() == 0 and seen.max() > 7000


def test_a_style_that_never_walks_takes_other_training_clips(generator):
    vectors = style("run", "walk-back")
    clip_codes(generator, vectors, scaling(vectors))
    assert (vectors.part[rows_seen(generator, scaling(vectors))] == PARTS.index("train")).all()


def test_a_walk_that_only_tests_gives_way_to_other_training_clips(generator):
    vectors = style("run", "walk")
    vectors.part[vectors.take == 1] = PARTS.index("test")
    clip_codes(generator, vectors, scaling(vectors))
    assert rows_seen(generator, scaling(vectors)).max() < 1600


def test_test_clips_are_used_where_they_are_asked_for(generator):
    vectors = style("walk")
    clip_codes(generator, vectors, scaling(vectors), part="test")
    assert rows_seen(generator, scaling(vectors)).min() >= 1600


def test_a_stored_code_is_the_mean_of_the_clips_codes_without_dropout(generator):
    vectors = style("walk")
    network = StyledNetwork(tiny.trainer().network.synthesis, generator)
    code = stored_codes(network, [vectors], scaling(vectors))[vectors.style]
    assert code.shape == (64,) and not generator.training and not code.requires_grad
    torch.testing.assert_close(code, clip_codes(generator, vectors, scaling(vectors)).mean(dim=0))
    assert torch.equal(code, stored_codes(network, [vectors], scaling(vectors))[vectors.style])
