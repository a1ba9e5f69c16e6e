"""The synthetic walker's vectors, and networks on its body: one of a few random weights, one that knows the answers."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import torch

from stylephase.data.catalogue import Catalogue
from stylephase.data.layouts import Entry
from stylephase.data.registry import Dataset
from stylephase.data.split import PARTS
from stylephase.features.body import Body
from stylephase.features.layout import Layout
from stylephase.features.normaliser import Normaliser, normaliser_of
from stylephase.features.store import StyleVectors, VectorStore, for_gate
from stylephase.features.vectors import Vectors, vectors
from stylephase.models.bundle import Bundle, build_network
from stylephase.models.generator import GeneratorSettings
from stylephase.models.lpn import NetworkSettings
from stylephase.models.zoo import layout_for
from stylephase.motion.clip import Clip, Pose, forward_kinematics
from stylephase.motion.contacts import ContactRule
from stylephase.motion.rest import rest_axes
from stylephase.motion.synthetic import SKELETON, find_style, steady, walk
from stylephase.runtime.controller import State, start_state

BODY = Body(SKELETON, rest_axes(SKELETON, []))
SMALL = NetworkSettings(experts=2, units=8, gating_units=4, generator=GeneratorSettings(filters=2, kernel=3, hidden=4))
STYLES = ("Plain", "Old", "Very old", "set1-not-old")
SPEED = 1.1


@dataclass(frozen=True)
class Take:
    """A take of the walker that goes straight on at SPEED, with what the networks read of it."""

    clip: Clip
    pose: Pose
    vectors: Vectors
    contacts: np.ndarray


@cache
def take(style: str = "Plain", seconds: float = 8.0, turn: float = 0.0) -> Take:
    """A take of some seconds."""
    clip, truth = walk(find_style(style), "FW", plan=steady(seconds, forward=SPEED, turn=turn))
    pose, angle = forward_kinematics(clip), 2 * np.pi * truth.phase
    phases = np.stack([np.sin(angle), np.cos(angle)], axis=-1).reshape(len(clip), 8)
    return Take(
        clip,
        pose,
        vectors(pose, SKELETON, BODY.rest, clip.fps, phases, truth.contacts, truth.global_phase),
        truth.contacts,
    )


@cache
def style_vectors(style: str = "Plain", seconds: float = 16.0) -> StyleVectors:
    """Vectors of a style: seven tenths train, one validates, the rest tests."""
    made = take(style, seconds).vectors
    rows = len(made.x)
    part = np.full(rows, PARTS.index("train"))
    part[7 * rows // 10 : 8 * rows // 10] = PARTS.index("validation")
    part[8 * rows // 10 :] = PARTS.index("test")
    arrays = (array.astype(np.float32) for array in (made.x, made.p, made.y, made.phase, made.phase_update))
    return StyleVectors(style, False, ("FW",), *arrays, np.zeros(rows, dtype=int), part)


@cache
def statistics() -> Normaliser:
    """Means and deviations of the walker."""
    return normaliser_of([style_vectors()], BODY.layout)


def bundle(*styles: str, network: torch.nn.Module | None = None) -> Bundle:
    """Weights that were never trained, a random code for each style, and statistics of the walker.

    A `network` takes the place of the synthesis network.
    """
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        whole = build_network("lpn-film", BODY, len(styles or STYLES), SMALL).eval()
        codes = {style: torch.randn(4 * SMALL.units) for style in styles or STYLES}
    if network is not None:
        whole.synthesis = network
    about = {"data": "made", "phases": "adaptive", "licence": "none"}
    return Bundle("lpn-film", whole, SMALL, BODY, statistics(), codes, about)


def of_model(model: str) -> Bundle:
    """Weights of any model that were never trained, with the walker's statistics and a code for each style."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        network = build_network(model, BODY, len(STYLES), SMALL).eval()
        codes = torch.randn(len(STYLES), network.synthesis.modulator.values)
    normaliser = normaliser_of(*_seen_by(model))
    return Bundle(model, network, SMALL, BODY, normaliser, dict(zip(STYLES, codes, strict=True)), {"data": "made"})


def _seen_by(model: str) -> tuple[list[StyleVectors], Layout]:
    """Before the first step and after the last there is no global phase, which counts as none here."""
    layout = layout_for(model, BODY.layout)
    seen = for_gate(style_vectors(), layout)
    return [replace(seen, p=np.nan_to_num(seen.p), y=np.nan_to_num(seen.y))], layout


class Store(VectorStore):
    """Vectors in memory, of the walker's body."""

    def __init__(self, *styles: StyleVectors):
        entries = tuple(Entry(Path(f"{style.style}.bvh"), style.style, "FW") for style in styles)
        dataset = Dataset("made", "Made", "synthetic", "none", "nobody", "nowhere", "own", ContactRule())
        self.catalogue, self.known = Catalogue(dataset, entries), BODY
        self.styles = {style.style: style for style in styles}

    @property
    def body(self) -> Body:
        return self.known

    def load(self, style: str) -> StyleVectors:
        return self.styles[style]


class Fixed(torch.nn.Module):
    """A network that gives prepared outputs, in metres, one row after the other, to all characters alike."""

    def __init__(self, outputs: np.ndarray, normaliser: Normaliser):
        super().__init__()
        self.rows = iter(torch.from_numpy((outputs - normaliser.y_mean) / normaliser.y_std))

    def forward(self, x: torch.Tensor, p: torch.Tensor, code: torch.Tensor) -> torch.Tensor:
        return next(self.rows).expand(len(x), -1)


def knowing(outputs: np.ndarray) -> Bundle:
    """A bundle whose network knows the outputs."""
    return bundle("Plain", network=Fixed(outputs, statistics()))


def start(rows: Sequence[int] | slice, style: str = "Plain") -> State:
    """Characters at the origin in the state of some frames of a take."""
    made = take(style).vectors
    return start_state(made.x[rows], made.p[rows], BODY.layout)


def codes(count: int) -> torch.Tensor:
    """A different code for each of some characters."""
    return torch.from_numpy(np.random.default_rng(3).normal(size=(count, 4 * SMALL.units))).float()


def turned(state: State, angle: float, shift: np.ndarray) -> State:
    """The same characters with the whole world turned about the origin (rad, to the left), then shifted (x, z)."""
    sine, cosine = np.sin(angle), np.cos(angle)
    ground, world = np.array([[cosine, sine], [-sine, cosine]]), np.eye(3)
    world[np.ix_([0, 2], [0, 2])] = ground
    path = replace(
        state.path, positions=state.path.positions @ ground.T + shift, directions=state.path.directions @ ground.T
    )
    return replace(
        state,
        path=path,
        positions=state.positions @ world.T + np.array([shift[0], 0.0, shift[1]]),
        rotations=world @ state.rotations,
        velocities=state.velocities @ world.T,
    )


class Obedient(torch.nn.Module):
    """A network that keeps a pose and goes along the path that it is shown, at the speed of the path's beginning.

    The pose leans with the first number of the style code.
    """

    def forward(self, x: torch.Tensor, p: torch.Tensor, code: torch.Tensor) -> torch.Tensor:
        n, layout = statistics(), BODY.layout
        seen = x.double() * torch.from_numpy(n.x_std) + torch.from_numpy(n.x_mean)
        ahead = seen[:, layout.x_trajectory].reshape(len(x), -1, 4)[:, 6:]
        step = torch.zeros_like(ahead[:, :1])
        step[..., :2] = ahead[:, 1:2, :2] / 12
        turned = torch.nn.functional.normalize(ahead[:, :1, 2:] * 11 / 12 + ahead[:, 1:2, 2:] / 12, dim=-1)
        samples = torch.cat([torch.cat([step[..., :2], turned], dim=-1), ahead[:, 1:] + step], dim=1)
        still = torch.from_numpy(take().vectors.y[0]).expand(len(x), -1).clone()
        still[:, layout.y_trajectory] = samples.reshape(len(x), -1)
        joints = still[:, layout.y_pose].reshape(len(x), -1, 4, 3)
        joints[:, :, 0, 2] += step[:, :1, 1] + 0.1 * code[:, :1] * joints[:, :, 0, 1]
        joints[:, :, 0, 0] += step[:, :1, 0]
        joints[:, :, 3] = 60 * torch.cat([step[..., :1], 0 * step[..., :1], step[..., 1:2]], dim=-1)
        return ((still - torch.from_numpy(n.y_mean)) / torch.from_numpy(n.y_std)).float()
