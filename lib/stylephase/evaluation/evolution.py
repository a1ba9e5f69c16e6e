"""The evolutionary search by which the authors fitted sinusoids, small, for comparison ([M22] release).

One population of fifty for every frame, ten generations, all frames side by side; between two generations each
window is drawn anew to what its neighbours have by then. It stops long before it has converged, and a sinusoid that
does not yet follow the signal does best when it is small: its amplitudes are below those of the optimum.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from stylephase.phase.circular import wrap
from stylephase.phase.sinusoid import FREQUENCIES, Sinusoids

# Individuals, those that live on unchanged, generations, and the share of children that are drawn anew.
INDIVIDUALS, ELITES, GENERATIONS, EXPLORATION = 50, 5, 10, 0.2


@dataclass(frozen=True)
class _Task:
    """Samples of all windows: `times` (s) in the signal, `weights` those of the neighbours' fits where below 1."""

    at: Int[ndarray, "frames samples"]
    weights: Float[ndarray, " samples"]
    signal: Float[ndarray, " frames"]
    fps: float

    def losses(self, genes: Float[ndarray, "frames n 4"], fitted: Float[ndarray, " frames"]) -> ndarray:
        """Root of the weighted mean square of each individual, against the window and the neighbours' fits."""
        values = np.where(self.weights == 1, self.signal[self.at], fitted[self.at])
        rows = [self._losses(*block) for block in zip(genes, values, self.at / self.fps, strict=True)]
        return np.stack(rows)

    def _losses(self, genes: ndarray, values: ndarray, times: ndarray) -> ndarray:
        off = _waves(genes, times) - values
        return np.sqrt(np.square(off) @ self.weights / self.weights.sum())

    def bounds(self) -> tuple[Float[ndarray, "frames 4"], Float[ndarray, "frames 4"]]:
        """Bounds of amplitude, frequency, shift and offset of each window."""
        inner = self.signal[self.at[:, self.weights == 1]]
        low, high, one = inner.min(axis=1), inner.max(axis=1), np.ones(len(inner))
        lower = (0 * one, FREQUENCIES[0] * one, -0.5 * one, low)
        return np.stack(lower, axis=1), np.stack((high - low, FREQUENCIES[1] * one, 0.5 * one, high), axis=1)


def _waves(genes: Float[ndarray, "n 4"], times: Float[ndarray, " samples"]) -> Float[ndarray, "n samples"]:
    amplitude, frequency, shift, offset = genes.T[:, :, None]
    return amplitude * np.sin(2 * np.pi * (frequency * times - shift)) + offset


def evolve(
    signal: Float[ndarray, " frames"],
    fps: float,
    rng: np.random.Generator,
    *,
    window_seconds: float = 0.5,
    generations: int = GENERATIONS,
    coupled: bool = True,
) -> Sinusoids:
    """Fit a sinusoid around every frame as the release does; uncoupled, each window is on its own."""
    task = _task(signal, fps, round(window_seconds * fps / 2), coupled)
    low, high = task.bounds()
    genes = low[:, None] + (high - low)[:, None] * rng.random((len(signal), INDIVIDUALS, 4))
    genes[:, 0] = (low + high) / 2
    momentum, fitted = np.zeros_like(genes), np.zeros(len(signal))
    genes, momentum, losses = _ranked(task, genes, momentum, fitted)
    for _ in range(generations):
        genes, momentum = _next(genes, momentum, losses, low[:, None], high[:, None], rng)
        genes, momentum, losses = _ranked(task, genes, momentum, fitted)
        fitted = _own_values(genes[:, 0], fps)
    amplitude, frequency, shift, offset = genes[:, 0].T
    phase = wrap(frequency * np.arange(len(signal)) / fps - shift)
    return Sinusoids(amplitude, frequency, phase, offset)


def _task(signal: ndarray, fps: float, half: int, coupled: bool) -> _Task:
    centres = np.clip(np.arange(len(signal)), half, len(signal) - 1 - half)
    reach = np.arange(-2 * half, 2 * half + 1) if coupled else np.arange(-half, half + 1)
    weights = (1 - np.clip(np.abs(reach) - half, 0, half) / half) ** 2
    return _Task(np.clip(centres[:, None] + reach, 0, len(signal) - 1), weights, signal, fps)


def _own_values(best: Float[ndarray, "frames 4"], fps: float) -> Float[ndarray, " frames"]:
    """Each frame's best sinusoid at that frame."""
    amplitude, frequency, shift, offset = best.T
    return amplitude * np.sin(2 * np.pi * (frequency * np.arange(len(best)) / fps - shift)) + offset


def _ranked(task: _Task, genes: ndarray, momentum: ndarray, fitted: ndarray) -> tuple[ndarray, ndarray, ndarray]:
    """Individuals from the fittest on, and their losses."""
    losses = task.losses(genes, fitted)
    order = losses.argsort(axis=1)
    genes, momentum = (np.take_along_axis(part, order[..., None], axis=1) for part in (genes, momentum))
    return genes, momentum, np.take_along_axis(losses, order, axis=1)


def _next(
    genes: ndarray, momentum: ndarray, losses: ndarray, low: ndarray, high: ndarray, rng: np.random.Generator
) -> tuple[ndarray, ndarray]:
    """The next generation: elites as they are, children of two parents drawn to a third, and some drawn anew."""
    frames, children = len(genes), INDIVIDUALS - ELITES
    chance = np.arange(INDIVIDUALS, 0, -1) / np.arange(1, INDIVIDUALS + 1).sum()
    chosen = rng.choice(INDIVIDUALS, size=(3, frames, children), p=chance)
    chosen[1] = np.where(chosen[1] == chosen[0], (chosen[1] + 1) % INDIVIDUALS, chosen[1])
    one, other, model = (np.take_along_axis(genes, pick[..., None], axis=1) for pick in chosen)
    first = rng.random(one.shape) < 0.5
    pushes = (np.take_along_axis(momentum, pick[..., None], axis=1) for pick in chosen[:2])
    start, push = np.where(first, one, other), np.where(first, *pushes)
    child = start + rng.random(one.shape) * push
    child = _mutated(child, _extinction(losses, chosen[:2]), high - low, rng)
    middle = (one + other) / 2
    pull = rng.random(one.shape) * (middle - child) + rng.random(one.shape) * (model - child)
    child = np.clip(child + pull / 2, low, high)
    anew = rng.random((frames, children, 1)) < EXPLORATION
    child = np.where(anew, low + (high - low) * rng.random(one.shape), child)
    moved = np.where(anew, 0.0, rng.random(one.shape) * push + child - start)
    return np.concatenate([genes[:, :ELITES], child], axis=1), np.concatenate([momentum[:, :ELITES], moved], axis=1)


def _extinction(losses: Float[ndarray, "frames n"], parents: Int[ndarray, "2 frames children"]) -> ndarray:
    """How near to dying out the parents are, 0 for the fittest and 1 for the worst, at the mean of both."""
    rank = np.arange(losses.shape[1]) / (losses.shape[1] - 1)
    share = (losses + losses[:, :1] * (rank - 1)) / np.maximum(losses[:, -1:], 1e-12)
    return np.mean([np.take_along_axis(share, pick, axis=1) for pick in parents], axis=0)[..., None]


def _mutated(child: ndarray, extinction: ndarray, span: ndarray, rng: np.random.Generator) -> ndarray:
    """Genes moved by up to the extinction's share of their span, the more likely the larger that is."""
    hit = rng.random(child.shape) < 0.25 + 0.75 * extinction
    return child + hit * rng.uniform(-1, 1, child.shape) * extinction * span
