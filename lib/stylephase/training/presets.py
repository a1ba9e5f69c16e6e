"""One preset per scale of experiment: the same network and loop, sized for a test, a laptop or a GPU."""

from dataclasses import dataclass, replace

from stylephase.errors import InputError
from stylephase.models.generator import GeneratorSettings
from stylephase.models.lpn import NetworkSettings
from stylephase.models.zoo import PAPER_2018


@dataclass(frozen=True)
class Preset:
    """Everything that a training run is told besides model, data and seed.

    A step updates the synthesis network on `styles_per_step` styles with `frames_per_style` frames each; the style
    codes of one generator pass serve `steps_per_code` steps, then their summed gradient updates the generator, which
    costs more than all those steps. A style is drawn by its number of training frames to the power `style_power`: 0
    draws all alike, 1 all frames alike. Learning rates warm up over `warm_up` steps and fall linearly from the share
    `decay_from` of the run to the factor `decay_to`. `phases` names the variant of the local phases, `mixed` takes
    products in bf16, `bone_weight` weighs the bone length loss (m) against the squared error ([M22] Eq. 5: 1).
    With `in_turn` the styles follow one another in place of being drawn. `shared_l1` and `style_l1` weigh the mean
    absolute weight of what all styles share and of the adapters of the step's styles ([M18] Eq. 3).
    """

    network: NetworkSettings
    steps: int
    styles_per_step: int = 8
    frames_per_style: int = 64
    steps_per_code: int = 4
    style_power: float = 0.5
    network_rate: float = 1e-3
    generator_rate: float = 3e-4
    warm_up: int = 100
    decay_from: float = 0.6
    decay_to: float = 0.03
    bone_weight: float = 1.0
    in_turn: bool = False
    shared_l1: float = 0.0
    style_l1: float = 0.0
    phases: str = "adaptive"
    mixed: bool = True
    log_every: int = 400
    save_every: int = 400


# Plain rectifiers die within minutes at these learning rates, after which all styles share one code; the leak, the
# layer normalisation and the clamp keep the generator alive.
_LIVELY = {"leak": 0.1, "normalise": True, "clamp": 5.0}

PRESETS = {
    # Seconds: shows that everything runs, not how well it works.
    "quick": Preset(
        network=NetworkSettings(
            experts=4,
            units=128,
            gating_units=16,
            input_rate=0.2,
            hidden_rate=0.1,
            gating_rate=0.0,
            generator=GeneratorSettings(filters=32, kernel=13, hidden=128, **_LIVELY),
        ),
        steps=1200,
        styles_per_step=6,
        frames_per_style=24,
        mixed=False,
        log_every=200,
        save_every=600,
    ),
    # The paper's sizes in half an hour on two cores. Input dropout must stay at 0.3: without it the previous pose
    # tells the network the style, the code goes unused, and rollouts slide into one gait.
    "cpu": Preset(
        network=NetworkSettings(
            input_rate=0.3, hidden_rate=0.15, gating_rate=0.05, generator=GeneratorSettings(**_LIVELY)
        ),
        steps=9200,
        decay_from=0.4,
        decay_to=0.02,
        bone_weight=3.0,
    ),
    # The paper's own: one style a batch of 32 frames, Adam at 1e-4 ([M22] 4.3, release 4.5).
    # Differs: all frames of a batch share one clip, where the release gives each a clip of its own.
    "paper": Preset(
        network=NetworkSettings(),
        steps=4_300_000,
        styles_per_step=1,
        frames_per_style=32,
        steps_per_code=1,
        style_power=0.0,
        network_rate=1e-4,
        generator_rate=1e-4,
        warm_up=0,
        decay_from=1.0,
        decay_to=1.0,
        in_turn=True,
        phases="release",
        mixed=False,
        log_every=10_000,
        save_every=10_000,
    ),
}


def preset(name: str) -> Preset:
    """The named preset; raises InputError with the names there are."""
    if name not in PRESETS:
        raise InputError(f"no preset {name!r}; there are {', '.join(PRESETS)}")
    return PRESETS[name]


# The weight of both L1 terms in [M18] 6, there called lambda_ag and lambda_s.
L1 = 0.01


def preset_for(name: str, model: str) -> Preset:
    """The named preset as a model trains with it; raises InputError for an unknown preset.

    The networks of [M18] see one style a batch, the styles in turn, and their loss is the squared error with L1 terms
    ([M18] 6, Eq. 3, 5); the batch is as large as that of the other models.
    """
    how = preset(name)
    if model not in PAPER_2018:
        return how
    batch = how.styles_per_step * how.frames_per_style
    how = replace(how, styles_per_step=1, frames_per_style=batch, steps_per_code=1, in_turn=True)
    return replace(how, bone_weight=0.0, shared_l1=L1, style_l1=L1)
