"""What a trainer does, looked at from outside: which weights it changes, and whether its loss is the paper's."""

import numpy as np
import torch

from stylephase.training.loop import Trainer

_ROWS = 64


def changed_by_training(trainer: Trainer, rounds: int = 3) -> dict[str, float]:
    """The share of tensors of each network (`synthesis`, `generator`) that some rounds of training change.

    Where one of them is not trained, its share is 0; who trains both end to end has 1 and 1 ([M22] 4.3). More than one
    round, as a generator begins with codes that do not yet heed the clip.
    """
    before = {name: weight.detach().clone() for name, weight in trainer.network.named_parameters()}
    for _ in range(rounds):
        trainer.round()
    changed: dict[str, list[bool]] = {}
    for name, weight in trainer.network.named_parameters():
        changed.setdefault(name.partition(".")[0], []).append(not torch.equal(weight, before[name]))
    return {network: float(np.mean(some)) for network, some in changed.items()}


def off_from_equation_5(trainer: Trainer, seed: int = 0) -> float:
    """The relative difference of the trainer's loss from [M22] Eq. 5 written out, for outputs that are off at random.

    The mean of squares over all outputs, and over all bones the difference of their lengths in metres.
    """
    chosen = np.zeros(1, dtype=int)
    y = trainer.sampler.draw_frames(chosen, _ROWS).y
    predicted = y + torch.randn(y.shape, generator=torch.Generator().manual_seed(seed))
    ours, weight = trainer.loss(y, predicted, chosen)[0], trainer.preset.bone_weight
    mean, std = trainer.normaliser.y_mean, trainer.normaliser.y_std
    lengths = [_bones(rows.numpy().astype(float) * std + mean, trainer) for rows in (y, predicted)]
    written = np.square((predicted - y).numpy()).mean() + weight * np.abs(lengths[0] - lengths[1]).mean()
    return abs(float(ours) - float(written)) / float(written)


def _bones(y: np.ndarray, trainer: Trainer) -> np.ndarray:
    places = y[:, trainer.body.layout.y_pose].reshape(len(y), -1, 12)[:, :, :3]
    return np.stack([np.linalg.norm(places[:, a] - places[:, b], axis=1) for a, b in trainer.body.bones], axis=1)
