"""Trainings checked on what they do: batches, passes through the data, terms of the loss ([M22] 4.3, [M18] 6)."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from jaxtyping import Bool, Float, Int
from numpy import ndarray
from torch import Tensor

from stylephase.data.layouts import Entry
from stylephase.evaluation.comparison import Effect, ratio
from stylephase.evaluation.predictors import predict_network
from stylephase.evaluation.test_error import error_of, test_rows
from stylephase.features.store import StyleVectors, VectorStore
from stylephase.models.bundle import Bundle
from stylephase.runtime.rollout import quiet
from stylephase.training.loop import Trainer, trained
from stylephase.training.losses import bone_lengths, shared_weights, style_weights
from stylephase.training.presets import Preset

# The styles of 100STYLE that [M22] 4.3 keeps back to learn later.
KEPT_BACK = ("HandsInPockets", "Roadrunner", "Skip", "Star", "WildArms")
# The held-out windows of a take: a tenth to validate and a tenth to test; transitions have none ([M22] release 4.1).
_WINDOWS, _SHARE, _TRANSITION = 2, 10, "TR"
# Frames on which the loss is held against Eq. 5; rounds of training that are watched.
_ROWS, _ROUNDS = 64, 3


def drawn_styles(
    store: VectorStore, model: str, preset: Preset, name: str, rounds: int
) -> Int[ndarray, "rounds styles"]:
    """The styles in the batch of each of the first rounds of a training, as numbers."""
    trainer = Trainer(store, model, preset, name, 0)
    drawn = []
    for _ in range(rounds):
        drawn.append(trainer.styles_of_round())
        trainer.step += preset.steps_per_code
    return np.stack(drawn)


def in_turn(drawn: Int[ndarray, "rounds styles"], styles: int) -> bool:
    """Whether each batch holds one style, and all styles follow one another in the same order again and again."""
    first = drawn[:styles, 0]
    whole = len(drawn) // styles * styles
    return (
        drawn.shape[1] == 1
        and len(np.unique(first)) == styles
        and bool((drawn[:whole, 0].reshape(-1, styles) == first).all())
    )


@dataclass(frozen=True)
class Rounds:
    """Some rounds of a training: the styles of each, as numbers, and whether the shared weights (row 0) and the adapter
    of each style (the other rows) were others after it."""

    drawn: Int[ndarray, "rounds styles"]
    changed: Bool[ndarray, "parts rounds"]

    @property
    def own_alone(self) -> bool:
        """Whether every round changed the shared weights and the adapters of its own styles, and no other."""
        own = np.zeros_like(self.changed[1:])
        own[self.drawn, np.arange(len(self.drawn))[:, None]] = True
        return bool(self.changed[0].all() and (self.changed[1:] == own).all())


def rounds_of(trainer: Trainer, rounds: int) -> Rounds:
    """Train for some rounds and look which weights each has changed ([M18] Fig. 5).

    The styles are to follow one another: a trainer that draws them would draw others when asked before the round.
    """
    network, drawn, changed = trainer.network.synthesis, [], []
    parts = [shared_weights(network), *(style_weights(network, k) for k in range(len(trainer.styles)))]
    for _ in range(rounds):
        before = [[weight.detach().clone() for weight in part] for part in parts]
        drawn.append(trainer.styles_of_round())
        trainer.round()
        changed.append([not all(map(torch.equal, part, old)) for part, old in zip(parts, before, strict=True)])
    return Rounds(np.array(drawn), np.array(changed).T)


def l1_slopes_off(trainer: Trainer, style: int) -> dict[str, float]:
    """How far the slopes of the loss's L1 terms ([M18] Eq. 3) in a step of one style are from the sign of each weight
    over the number of its kind, times the kind's weight; for other styles, from zero."""
    network, how = trainer.network.synthesis, trainer.preset
    parts = {"shared": shared_weights(network)}
    parts |= {f"style {k}": style_weights(network, k) for k in range(len(trainer.styles))}
    network.zero_grad()
    trainer.l1_terms(np.array([style])).backward()
    weights = dict.fromkeys(parts, 0.0) | {"shared": how.shared_l1, f"style {style}": how.style_l1}
    off = {name: _slope_off(part, weights[name]) for name, part in parts.items()}
    network.zero_grad()
    own = off.pop(f"style {style}")
    return {"shared": off.pop("shared"), "its own": own, "other styles'": max(off.values(), default=0.0)}


def _slope_off(weights: Sequence[Tensor], weight: float) -> float:
    """The largest difference of slopes, times the number of weights."""
    count = sum(w.numel() for w in weights)
    found = [torch.zeros_like(w) if w.grad is None else w.grad for w in weights]
    return max(float((count * a - weight * w.detach().sign()).abs().max()) for a, w in zip(found, weights, strict=True))


def changed_by_training(trainer: Trainer) -> dict[str, float]:
    """The share of tensors of each network (`synthesis`, `generator`) that some rounds of training change.

    Where one of them is not trained, its share is 0; who trains both end to end has 1 and 1 ([M22] 4.3). More than one
    round, as a generator begins with codes that do not yet heed the clip.
    """
    before = {name: weight.detach().clone() for name, weight in trainer.network.named_parameters()}
    for _ in range(_ROUNDS):
        trainer.round()
    changed: dict[str, list[bool]] = {}
    for name, weight in trainer.network.named_parameters():
        changed.setdefault(name.partition(".")[0], []).append(not torch.equal(weight, before[name]))
    return {network: float(np.mean(some)) for network, some in changed.items()}


def off_from_equation_5(trainer: Trainer) -> float:
    """The relative difference of the trainer's loss from [M22] Eq. 5 written out, for outputs that are off at random.

    The mean of squares over all outputs, and over all bones the difference of their lengths in metres.
    """
    chosen = np.zeros(1, dtype=int)
    y = trainer.sampler.draw_frames(chosen, _ROWS).y
    predicted = y + torch.randn(y.shape, generator=torch.Generator().manual_seed(0))
    ours, weight = trainer.loss(y, predicted, chosen)[0], trainer.preset.bone_weight
    mean, std = trainer.normaliser.y_mean, trainer.normaliser.y_std
    lengths = [_bones(rows.numpy().astype(float) * std + mean, trainer) for rows in (y, predicted)]
    written = np.square((predicted - y).numpy()).mean() + weight * np.abs(lengths[0] - lengths[1]).mean()
    return abs(float(ours) - float(written)) / float(written)


def _bones(y: np.ndarray, trainer: Trainer) -> np.ndarray:
    places = y[:, trainer.body.layout.y_pose].reshape(len(y), -1, 12)[:, :, :3]
    return np.stack([np.linalg.norm(places[:, a] - places[:, b], axis=1) for a, b in trainer.body.bones], axis=1)


def epochs(steps: int, batch: int, takes: Iterable[Entry]) -> float:
    """Epochs of a training in which the styles of the takes follow one another, a batch of one style a step.

    An epoch is one pass through the style of fewest training frames, less what does not fill a batch ([M22] 4.3,
    release 4.5). Takes need their cuts; nine tenths less one of each train, of transitions all.
    """
    frames: dict[str, int] = {}
    for take in takes:
        assert take.stop is not None
        length = take.stop - take.start
        held_out = 0 if take.gait.startswith(_TRANSITION) else _WINDOWS * (length // _SHARE)
        frames[take.style] = frames.get(take.style, 0) + length - held_out
    return steps / (len(frames) * (min(frames.values()) // batch))


def passes(preset: Preset, styles: Sequence[StyleVectors]) -> float:
    """How often a training with a preset that draws its styles sees each frame of the style of fewest frames."""
    counts = np.array([len(style.rows("train")) for style in styles], dtype=float)
    drawn = preset.steps * min(preset.styles_per_step, len(styles)) * preset.frames_per_style
    chance = counts**preset.style_power / (counts**preset.style_power).sum()
    least = counts.argmin()
    return float(drawn * chance[least] / counts[least])


@dataclass(frozen=True)
class BoneTerm:
    """Bone-length error of networks trained without the bone-length term over that with it, on test frames.

    `again` is a second seed with the term over the first: as far from 1 as nothing at all may lie. `squared` is the
    same for the squared error, which the term might cost.
    """

    error: Effect
    again: Effect
    squared: Effect


def try_bone_term(store: VectorStore, preset: Preset, name: str, rng: np.random.Generator) -> BoneTerm:
    """Train LPN with FiLM with the bone-length term of [M22] Eq. 5, without it, and with another seed."""
    without = replace(preset, bone_weight=0.0)
    held, flat, other = (
        _errors(trained(store, "lpn-film", how, name, seed, quiet), store)
        for how, seed in ((preset, 0), (without, 0), (preset, 1))
    )
    return BoneTerm(
        error=ratio(flat[:1], held[:1], rng),
        again=ratio(other[:1], held[:1], rng),
        squared=ratio(flat[1:], held[1:], rng),
    )


def _errors(bundle: Bundle, store: VectorStore) -> Float[ndarray, "2 styles"]:
    """Bone-length error (m) and squared error of each style that has test frames."""
    lengths, errors = bone_lengths(bundle.body), []
    for style in map(store.load, bundle.styles):
        if len(test_rows(style)):
            errors.append(error_of(predict_network(bundle, style.style), style, bundle, lengths, "test"))
    return np.array([[error.bll for error in errors], [error.shared for error in errors]])
