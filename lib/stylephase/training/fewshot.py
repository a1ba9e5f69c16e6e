"""A new style from one short clip: an adapter of its own learns it while everything else stays ([M18] 7).

What is shared is frozen, so that of each frame the first two layers' outputs are computed once; with the dropout of
the shared network's own training, some times over. Many styles, or many ways to learn one, are learned side by side.
"""

import copy
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional

from stylephase.errors import InputError
from stylephase.features.cycles import cycle_rows
from stylephase.features.store import StyleVectors, for_gate
from stylephase.models.adapters import CpLayer
from stylephase.models.bundle import Bundle, build_network
from stylephase.models.dropout import dropout
from stylephase.models.modulators import Adapters
from stylephase.models.pfnn import RANK, adapter
from stylephase.models.synthesis import Synthesis
from stylephase.models.zoo import adapter_forms
from stylephase.training.losses import mean_absolute, squared_error
from stylephase.training.presets import L1
from stylephase.training.sampler import Scaling

# Adapters by the names of [M18] Table 1, and their forms (models/pfnn.py).
ADAPTERS = {"cp": "cp", "diagonal": "diag", "full": "full"}
# Draws of the shared network's dropout that are kept of each frame.
_COPIES = 8


@dataclass(frozen=True)
class FewShot:
    """How a new style is learned.

    `adapter` is `cp` with so many `factors`, `diagonal` or `full`; `dropout` is the rate in front of it ([M18] 7.2),
    `l1` weighs its mean absolute weight (Eq. 3). With `silent` it adds nothing at first, else it is drawn as a layer.

    `noisy` keeps the shared network's own dropout on, of its input above all.

    Differs: the paper does not say how an adapter begins, nor whether the frozen network has dropout.
    """

    adapter: str = "cp"
    factors: int = RANK
    dropout: float = 0.5
    l1: float = L1
    silent: bool = True
    noisy: bool = True

    @property
    def form(self) -> str:
        """The adapter's form; raises InputError for one that is not known, or has no factors."""
        if self.adapter not in ADAPTERS:
            raise InputError(f"no adapter {self.adapter!r}; there are {', '.join(ADAPTERS)}")
        if self.factors < 1:
            raise InputError(f"an adapter needs a factor or more, not {self.factors}")
        return f"cp:{self.factors}" if self.adapter == "cp" else ADAPTERS[self.adapter]


@dataclass(frozen=True)
class Schedule:
    """Steps of Adam on `frames` frames of each style at a `rate` that falls linearly over the second half.

    `mixed` is as in a preset.

    Differs: the paper names neither steps nor rate. Twice as many steps of twice as many frames do not lower the error
    on unseen takes.
    """

    steps: int = 300
    frames: int = 32
    rate: float = 1e-3
    mixed: bool = True

    def factor(self, step: int) -> float:
        """The rate's factor at a step."""
        return min(1.0, 2 * (1 - step / self.steps))


@dataclass(frozen=True)
class Lesson:
    """A clip of one style, and how to learn it. Whole `cycles` of it are learned; left out: all that it has."""

    style: StyleVectors
    how: FewShot = FewShot()
    cycles: int | None = None


@dataclass(frozen=True)
class _Material:
    """A clip as the frozen layers see it, normalised: their outputs, the gate, and what is to come out."""

    h: Float[Tensor, "rows units"]
    f: Float[Tensor, "rows units"]
    gate: Float[Tensor, "rows points"]
    y: Float[Tensor, "rows outputs"]


def lesson_rows(style: StyleVectors, scaling: Scaling, cycles: int | None) -> dict[str, Tensor]:
    """Normalised x, p and y of whole cycles of a clip, and behind them their mirror images where it is symmetric.

    Raises InputError where the clip has no whole cycle.
    """
    rows = cycle_rows(style, cycles)
    if not len(rows):
        raise InputError(f"no walking cycle in the clip of {style.style}: neither foot comes down twice")
    parts = {kind: torch.from_numpy(getattr(style, kind)[rows]) for kind in "xpy"}
    if style.symmetric:
        images = {k: scaling.mirrored(k, v, torch.ones(len(v), dtype=torch.bool)) for k, v in parts.items()}
        parts = {kind: torch.cat([values, images[kind]]) for kind, values in parts.items()}
    return {kind: scaling.scaled(kind, values) for kind, values in parts.items()}


def learn(
    base: Bundle,
    lessons: Sequence[Lesson],
    schedule: Schedule = Schedule(),
    *,
    seed: int = 0,
    tick: Callable[[int], object] = lambda steps: None,
) -> list[nn.Module]:
    """An adapter for each lesson, learned side by side; the weights given are left as they are.

    Raises InputError where the weights are no PFNN with adapters, where a clip has no whole cycle, and where the
    training diverges.
    """
    adapter_forms(base.model, len(base.styles), base.settings)
    network = copy.deepcopy(base.network.synthesis).eval().requires_grad_(False)
    scaling = Scaling(base.normaliser, base.layout)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        # Many lessons may be of one clip.
        seen: dict[tuple[int, int | None, bool], _Material] = {}
        keys = [(id(lesson.style), lesson.cycles, lesson.how.noisy) for lesson in lessons]
        for key, lesson in zip(keys, lessons, strict=True):
            if key not in seen:
                rows = lesson_rows(for_gate(lesson.style, base.layout), scaling, lesson.cycles)
                seen[key] = _material(network, rows, noisy=lesson.how.noisy)
        new = [begun(lesson.how, base.settings.units) for lesson in lessons]
        hows = [lesson.how for lesson in lessons]
        _train(network, new, [seen[key] for key in keys], hows, schedule, tick)
    return new


def begun(how: FewShot, units: int) -> nn.Module:
    """An adapter before it learns."""
    made = adapter(how.form, units)
    if how.silent:
        # Of a product of three factors one is enough: with all at zero none would get a gradient.
        nn.init.zeros_(made.a if isinstance(made, CpLayer) else made.get_parameter("weight"))
    return made


@torch.no_grad()
def _material(network: Synthesis, rows: dict[str, Tensor], *, noisy: bool) -> _Material:
    """What the first two layers make of the rows; with their dropout, of each row `_COPIES` times."""
    (first, second, _), how, copies = network.layers, network.settings, _COPIES if noisy else 1
    x, p, y = (rows[kind].repeat(copies, 1) for kind in "xpy")
    gate = network.gating(p)
    h = functional.elu(first(dropout(x, how.input_rate, noisy), gate))
    h = dropout(h, how.hidden_rate, noisy)
    return _Material(h, second(h, gate), gate, y)


def _train(
    network: Synthesis,
    new: list[nn.Module],
    materials: list[_Material],
    hows: list[FewShot],
    schedule: Schedule,
    tick: Callable[[int], object],
) -> None:
    last = network.layers[2]
    optimiser = torch.optim.Adam([w for one in new for w in one.parameters()], lr=schedule.rate, fused=True)
    for step in range(schedule.steps):
        optimiser.param_groups[0]["lr"] = schedule.rate * schedule.factor(step)
        picks = [torch.randint(len(m.h), (schedule.frames,)) for m in materials]
        gate = torch.cat([m.gate[rows] for m, rows in zip(materials, picks, strict=True)])
        y = torch.cat([m.y[rows] for m, rows in zip(materials, picks, strict=True)])
        with torch.autocast("cpu", dtype=torch.bfloat16, enabled=schedule.mixed):
            hidden = [
                functional.elu(m.f[rows] + one(dropout(m.h[rows], how.dropout, training=True), m.gate[rows]))
                for one, m, rows, how in zip(new, materials, picks, hows, strict=True)
            ]
            predicted = last(torch.cat(hidden), gate)
        # Each adapter has an error of its own, so that none learns the slower for the others.
        loss = squared_error(y, predicted) * len(new)
        penalty = torch.stack([how.l1 * mean_absolute(one.parameters()) for one, how in zip(new, hows, strict=True)])
        optimiser.zero_grad(set_to_none=True)
        (loss + penalty.sum()).backward()
        optimiser.step()
        if not math.isfinite(loss.item()):
            raise InputError(f"learning from the clip diverged at step {step}: its numbers are no longer finite")
        tick(1)


def with_styles(base: Bundle, names: Sequence[str], new: Sequence[nn.Module], forms: Sequence[str]) -> Bundle:
    """The same weights with one adapter and one code more for each new style.

    Earlier styles stay bit-identical: their adapters are the same, and the new ones have no weight in their codes
    ([M18] 1: lifelong learning). Raises InputError where the weights know a name already.
    """
    if known := [name for name in names if name in base.codes]:
        raise InputError(f"these weights know the style {known[0]!r} already; choose another name")
    before = len(base.styles)
    settings = replace(base.settings, adapters=(*adapter_forms(base.model, before, base.settings), *forms))
    network = copy.deepcopy(base.network)
    modulator = network.synthesis.modulator
    assert isinstance(modulator, Adapters)
    modulator.adapters.extend(new)
    modulator.values = before + len(new)
    codes = {name: functional.pad(code, (0, len(new))) for name, code in base.codes.items()}
    codes |= dict(zip(names, torch.eye(modulator.values)[before:], strict=True))
    return replace(base, network=network.eval(), settings=settings, codes=codes)


def add_styles(base: Bundle, lessons: Sequence[Lesson], schedule: Schedule = Schedule(), **options) -> Bundle:
    """The weights with each lesson's style learned; see `learn` and `with_styles`."""
    new = learn(base, lessons, schedule, **options)
    return with_styles(base, [x.style.style for x in lessons], new, [x.how.form for x in lessons])


def train_alone(base: Bundle, style: StyleVectors, schedule: Schedule = Schedule(), *, seed: int = 0) -> Bundle:
    """A rival: a PFNN that learns from the clip alone, with the normaliser of `base` ([M18] 8.1)."""
    settings = replace(base.settings, adapters=())
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        network = build_network("pfnn", base.body, 1, settings)
        bundle = replace(base, model="pfnn", network=network, settings=settings, codes={style.style: torch.zeros(0)})
        return _train_whole(bundle, style, schedule)


def fine_tune_whole(base: Bundle, style: StyleVectors, schedule: Schedule = Schedule(), *, seed: int = 0) -> Bundle:
    """A rival: a PFNN that knows one style goes on learning from the clip, with all its weights ([M18] 8.1)."""
    (code,) = base.codes.values()
    bundle = replace(base, network=copy.deepcopy(base.network), codes={style.style: code})
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        return _train_whole(bundle, style, schedule)


def _train_whole(bundle: Bundle, style: StyleVectors, schedule: Schedule) -> Bundle:
    """All weights of a network on one clip, with the dropout of its settings."""
    network, code = bundle.network.synthesis.train(), bundle.code(style.style)
    rows = lesson_rows(for_gate(style, bundle.layout), Scaling(bundle.normaliser, bundle.layout), None)
    optimiser = torch.optim.Adam(network.parameters(), lr=schedule.rate, fused=True)
    for step in range(schedule.steps):
        optimiser.param_groups[0]["lr"] = schedule.rate * schedule.factor(step)
        pick = torch.randint(len(rows["x"]), (schedule.frames,))
        with torch.autocast("cpu", dtype=torch.bfloat16, enabled=schedule.mixed):
            predicted = network(rows["x"][pick], rows["p"][pick], code.expand(len(pick), -1))
        optimiser.zero_grad(set_to_none=True)
        squared_error(rows["y"][pick], predicted).backward()
        optimiser.step()
    bundle.network.eval()
    return bundle
