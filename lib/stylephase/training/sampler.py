"""Batches that are balanced over styles, drawn from vectors in memory ([M22] 4.3, release 4.5)."""

from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float, Int
from numpy import ndarray
from torch import Tensor

from stylephase.features.clips import clip_rows
from stylephase.features.layout import Layout
from stylephase.features.normaliser import Normaliser
from stylephase.features.store import StyleVectors


@dataclass(frozen=True)
class Batch:
    """Normalised rows in consecutive groups of equal size, one group for each style drawn, in the order drawn."""

    x: Float[Tensor, "rows inputs"]
    p: Float[Tensor, "rows gate_inputs"]
    y: Float[Tensor, "rows outputs"]


class Scaling:
    """The normaliser and the mirror as tensors, for whole batches."""

    def __init__(self, normaliser: Normaliser, layout: Layout):
        def tensors(kind: str):
            return [torch.from_numpy(getattr(normaliser, f"{kind}_{part}")).float() for part in ("mean", "std")]

        self.layout = layout
        self.x, self.p, self.y = tensors("x"), tensors("p"), tensors("y")
        self.clip = [part[layout.x_pose] for part in self.x]
        self.mirrors = {
            name: (torch.from_numpy(source), torch.from_numpy(sign).float(), shift)
            for name, (source, sign, shift) in zip(
                "xpy", (layout.mirror_x, layout.mirror_p, layout.mirror_y), strict=True
            )
        }
        pose = slice(layout.x_trajectory.stop, None)
        source, sign, shift = self.mirrors["x"]
        self.mirrors["clip"] = (source[pose] - pose.start, sign[pose], shift)

    def mirrored(self, kind: str, values: Tensor, flip: Tensor) -> Tensor:
        """Rows of a kind (x, p, y or clip), mirrored where `flip` says so."""
        source, sign, shift = self.mirrors[kind]
        shape = (-1,) + (1,) * (values.ndim - 1)
        return torch.where(flip.view(shape), values[..., source] * sign + shift, values)

    def scaled(self, kind: str, values: Tensor) -> Tensor:
        """Rows of a kind, normalised."""
        mean, std = getattr(self, kind)
        return (values - mean) / std

    def metric(self, y: Float[Tensor, "rows outputs"]) -> Float[Tensor, "rows outputs"]:
        """Outputs in metres and metres per second again."""
        mean, std = self.y
        return y * std + mean


class Sampler:
    """Draws styles, their clips and their frames.

    A style's chance goes with a power of its training frames ([M22] 4.3 draws all styles alike): every style is met
    often, and frames of a style with few takes are not worn out. Frames and clips of symmetric styles are mirrored
    half the time.
    """

    def __init__(self, styles: list[StyleVectors], scaling: Scaling, rng: np.random.Generator, power: float = 0.5):
        self.styles, self.scaling, self.rng = styles, scaling, rng
        self.rows = [style.rows("train") for style in styles]
        self.clips = [clip_rows(style, "train") for style in styles]
        weight = np.array([len(rows) for rows in self.rows], dtype=float) ** power
        self.chance = weight / weight.sum()

    def draw_styles(self, count: int) -> Int[ndarray, " drawn"]:
        """Different styles, as many as asked or as there are."""
        return self.rng.choice(len(self.styles), size=min(count, len(self.styles)), replace=False, p=self.chance)

    def draw_clips(self, chosen: Int[ndarray, " drawn"]) -> Float[Tensor, "drawn frames pose"]:
        """One normalised training clip of each style."""
        parts = []
        for number in chosen:
            rows = self.clips[number][self.rng.integers(len(self.clips[number]))]
            parts.append(self.styles[number].x[rows][:, self.scaling.layout.x_pose])
        flip = self._flip(chosen, 1)
        return self.scaling.scaled("clip", self.scaling.mirrored("clip", torch.from_numpy(np.stack(parts)), flip))

    def draw_frames(self, chosen: Int[ndarray, " drawn"], frames: int) -> Batch:
        """Training frames of each style."""
        picked = [(self.styles[n], self.rng.choice(self.rows[n], size=frames)) for n in chosen]
        flip = self._flip(chosen, frames)
        kinds = (torch.from_numpy(np.concatenate([getattr(s, kind)[rows] for s, rows in picked])) for kind in "xpy")
        scaled = (self.scaling.scaled(k, self.scaling.mirrored(k, v, flip)) for k, v in zip("xpy", kinds, strict=True))
        return Batch(*scaled)

    def _flip(self, chosen: Int[ndarray, " drawn"], each: int) -> Tensor:
        symmetric = np.repeat([self.styles[number].symmetric for number in chosen], each)
        return torch.from_numpy(symmetric & (self.rng.random(len(symmetric)) < 0.5))
