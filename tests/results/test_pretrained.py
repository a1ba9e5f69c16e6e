"""The weights in the repository: small enough, described, whole, and walking without any data at hand."""

from pathlib import Path

import numpy as np
import torch

from stylephase.features.layout import FPS
from stylephase.models.bundle import load_bundle
from stylephase.models.card import CARD
from stylephase.runtime.calibration import speed_of, warm_start
from stylephase.runtime.pace import at_pace
from stylephase.runtime.plans import Steady
from stylephase.runtime.rollout import roll_out

_MOST_BYTES = 40_000_000


def folders(root: Path) -> list[Path]:
    return sorted(path.parent for path in (root / "data/pretrained").glob("*/model.json"))


def test_all_together_stay_small_and_each_has_a_card_with_its_licence(root):
    found = folders(root)
    assert found and sum(path.stat().st_size for f in found for path in f.iterdir()) < _MOST_BYTES
    for folder in found:
        assert load_bundle(folder).about["licence"] in (folder / CARD).read_text()


def test_every_style_walks_on_at_a_walking_speed_and_keeps_its_height(root):
    for folder in folders(root):
        bundle = load_bundle(folder)
        codes, speed = torch.stack([bundle.code(style) for style in bundle.styles]), np.ones(len(bundle.styles))
        plan = at_pace(Steady(speed), speed)
        run = roll_out(bundle, codes, warm_start(bundle, codes, speed), int(5 * FPS), plan)
        speeds = [speed_of(run.root_positions[int(3 * FPS) :, k]) for k in range(len(codes))]
        hips = run.positions[:, :, 0, 1]
        assert run.finite.all() and min(speeds) > 0.3 and max(speeds) < 4.0, dict(
            zip(bundle.styles, speeds, strict=True)
        )
        assert hips.min() > 0.6 and hips.max() < 1.2
        # Codes matter: led to one speed, styles still differ in where their joints are.
        heights = run.positions[int(3 * FPS) :, :2, :, 1].mean(axis=0)
        assert np.abs(heights[0] - heights[1]).max() > 0.005
