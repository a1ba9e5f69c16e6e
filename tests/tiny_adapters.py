"""A small PFNN with adapters on the walker's body, that knows two styles, and short clips of others."""

from functools import cache

import torch
from tiny_walker import BODY, take

from stylephase.features.captures import clip_vectors
from stylephase.features.normaliser import normaliser_of
from stylephase.features.store import StyleVectors, for_gate
from stylephase.models.bundle import Bundle, build_network
from stylephase.models.lpn import NetworkSettings
from stylephase.models.zoo import layout_for
from stylephase.training.fewshot import Schedule

SETTINGS = NetworkSettings(units=24, input_rate=0.0, hidden_rate=0.0)
STYLES = ("Plain", "ChestOut")
QUICK = Schedule(steps=40, frames=16, rate=3e-3, mixed=False)


@cache
def base(model: str = "pfnn-cp", styles: tuple[str, ...] = STYLES) -> Bundle:
    """Weights that were never trained, with statistics of some clips, and know several by name."""
    layout = layout_for(model, BODY.layout)
    seen = [for_gate(clip_of(style), layout) for style in ("Plain", "StoopedOver", "KneesUp", "GiantStrides")]
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        network = build_network(model, BODY, len(styles), SETTINGS).eval()
        codes = torch.eye(len(styles), network.synthesis.modulator.values)
    about = {"data": "synthetic", "phases": "adaptive", "licence": "none"}
    named = dict(zip(styles, codes, strict=True))
    return Bundle(model, network, SETTINGS, BODY, normaliser_of(seen, layout), named, about)


@cache
def clip_of(style: str, seconds: float = 4.0, *, symmetric: bool = True) -> StyleVectors:
    """Vectors of a short clip of the walker in a style."""
    clip = take(style, seconds).clip
    return clip_vectors(clip, style, BODY, "adaptive", "synthetic", symmetric=symmetric)
