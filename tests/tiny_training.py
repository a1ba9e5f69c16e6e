"""A data set in memory and a preset, both so small that a run takes a second."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import torch

from stylephase.data.catalogue import Catalogue
from stylephase.data.layouts import Entry
from stylephase.data.registry import Dataset
from stylephase.data.split import PARTS
from stylephase.features.body import Body
from stylephase.features.store import StyleVectors, VectorStore
from stylephase.files import read_json
from stylephase.models.bundle import Bundle
from stylephase.models.generator import GeneratorSettings
from stylephase.models.lpn import NetworkSettings
from stylephase.motion.contacts import ContactRule
from stylephase.motion.synthetic import SKELETON
from stylephase.training.checkpoint import LOG
from stylephase.training.loop import Trainer
from stylephase.training.presets import Preset
from stylephase.training.team import Team

PRESET = Preset(
    network=NetworkSettings(
        experts=2,
        units=16,
        gating_units=4,
        input_rate=0.1,
        generator=GeneratorSettings(filters=3, kernel=3, hidden=8, leak=0.1),
    ),
    steps=24,
    styles_per_step=2,
    frames_per_style=8,
    steps_per_code=2,
    warm_up=4,
    network_rate=5e-3,
    bone_weight=0.1,
    mixed=False,
    log_every=6,
    save_every=8,
)
BODY = Body(SKELETON, np.tile(np.eye(3), (len(SKELETON), 1, 1)))
ROWS = {"Plain": 300, "Sway": 120}


class TinyStore(VectorStore):
    """Vectors made up in memory: six hidden values make input and output, and the style moves the output."""

    def __init__(self, *styles: str, validation: bool = True, version: str = "1"):
        dataset = Dataset("tiny", "Made up", "synthetic", "none", "nobody", "nowhere", "own", ContactRule(0.3, 0.03))
        entries = tuple(
            Entry(Path(f"{style}_{gait}.bvh"), style, gait) for style in styles or ROWS for gait in ("FR", "FW")
        )
        self.catalogue, self.phases, self.validation = Catalogue(dataset, entries), "adaptive", validation
        self.folder = Path(f"tiny-adaptive-{version}")

    @property
    def body(self) -> Body:
        return BODY

    def load(self, style: str) -> StyleVectors:
        return vectors(style, list(ROWS).index(style), ROWS[style], validation=self.validation)


def vectors(style: str, number: int, rows: int, *, validation: bool = True) -> StyleVectors:
    """Two takes of equal length, of which the last tenth of the first validates and that of the second tests."""
    layout, rng = BODY.layout, np.random.default_rng(number)
    shared = np.random.default_rng(99)
    hidden, p = rng.normal(size=(rows, 6)), rng.normal(size=(rows, layout.gate_inputs))
    x, y = (hidden @ shared.normal(size=(6, width)) for width in (layout.inputs, layout.outputs))
    y += number * np.linspace(-2, 2, layout.outputs)
    part = np.full(rows, PARTS.index("train"))
    if validation:
        half, tenth = rows // 2, rows // 10
        part[half - tenth : half], part[rows - tenth :] = PARTS.index("validation"), PARTS.index("test")
    phase, update = rng.uniform(0, 2 * np.pi, rows), np.full(rows, 0.1)
    arrays = (array.astype(np.float32) for array in (x, p, y, phase, update))
    return StyleVectors(style, number == 0, ("FR", "FW"), *arrays, np.repeat([0, 1], rows // 2), part)


def trainer(*styles: str, model: str = "lpn-film", seed: int = 0, **changes) -> Trainer:
    """A run of the tiny preset, with some of its values changed."""
    return Trainer(TinyStore(*styles), model, replace(PRESET, **changes), "tiny", seed)


def still(model: str, team: Team) -> Trainer:
    """A run without dropout, which alone differs between one process and several."""
    generator = replace(PRESET.network.generator, rate=0.0)
    network = replace(PRESET.network, input_rate=0.0, hidden_rate=0.0, gating_rate=0.0, generator=generator)
    return Trainer(TinyStore(), model, replace(PRESET, network=network), "tiny", 0, team)


def read_log(folder: Path) -> list[dict]:
    """The log of a run."""
    return read_json(folder / LOG)


def ignore(steps: int) -> None:
    """Tell nobody of the progress."""


def weights(bundle: Bundle) -> dict[str, torch.Tensor]:
    """All that a run has learned."""
    return dict(bundle.network.state_dict()) | bundle.codes


def same(one: dict[str, torch.Tensor], other: dict[str, torch.Tensor]) -> bool:
    """Whether all tensors are equal to the last bit."""
    assert one.keys() == other.keys()
    return all(torch.equal(one[name], other[name]) for name in one)


def untimed(log: list[dict]) -> list[dict]:
    """A log without its times, which no two runs share."""
    return [{key: value for key, value in entry.items() if not key.endswith("seconds")} for entry in log]
