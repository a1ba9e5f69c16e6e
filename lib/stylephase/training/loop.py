"""The training loop of all models ([M22] 4.3), with checkpoints that a killed run resumes from exactly."""

import math
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from stylephase.errors import InputError
from stylephase.features.normaliser import Normaliser, normaliser_of
from stylephase.features.store import StyleVectors, VectorStore, for_gate
from stylephase.files import write_json
from stylephase.models.bundle import Bundle, build_network, load_bundle, save_bundle
from stylephase.models.zoo import layout_for, style_codes
from stylephase.training import checkpoint
from stylephase.training.checkpoint import LOG
from stylephase.training.codes import stored_codes
from stylephase.training.losses import (
    bone_length_loss,
    bone_lengths,
    mean_absolute,
    shared_weights,
    squared_error,
    style_weights,
)
from stylephase.training.presets import Preset
from stylephase.training.progress import validate
from stylephase.training.sampler import Sampler, Scaling
from stylephase.training.team import Team, seed_apart


def identity_of(store: VectorStore, model: str, preset: Preset, preset_name: str, seed: int) -> dict[str, Any]:
    """What makes a run this one and no other: two runs with the same identity give the same weights."""
    catalogue = store.catalogue
    identity = {"model": model, "data": catalogue.dataset.name, "preset": preset_name, "seed": seed}
    return identity | {"styles": list(catalogue.styles), "settings": repr(preset), "vectors": store.folder.name}


class Trainer:
    """One training run: data in memory, network, optimisers, and all random state.

    A FiLM generator learns from clips, with an optimiser of its own; other models are told the style's number. In a
    team all draw the same batch and take their share of it, so that the team learns as one process would.
    """

    def __init__(
        self, store: VectorStore, model: str, preset: Preset, preset_name: str, seed: int, team: Team | None = None
    ):
        self.store, self.model, self.preset, self.preset_name, self.seed = store, model, preset, preset_name, seed
        self.team = team or Team()
        self.team.check(min(preset.styles_per_step, len(store.catalogue.styles)))
        self.identity = identity_of(store, model, preset, preset_name, seed)
        self.body = store.body
        layout = layout_for(model, self.body.layout)
        self.styles: list[StyleVectors] = [for_gate(store.load(style), layout) for style in store.catalogue.styles]
        self.normaliser: Normaliser = normaliser_of(self.styles, layout)
        self.scaling = Scaling(self.normaliser, layout)
        torch.manual_seed(seed)
        self.rng = np.random.default_rng(seed)
        self.network = build_network(model, self.body, len(self.styles), preset.network)
        self.generator = self.network.generator
        self.sampler = Sampler(self.styles, self.scaling, self.rng, preset.style_power)
        self.lengths = bone_lengths(self.body)
        self.optimisers: checkpoint.Optimisers = {
            "synthesis": torch.optim.Adam(self.network.synthesis.parameters(), lr=preset.network_rate, fused=True)
        }
        if self.generator is not None:
            self.generator.start_neutral()
            rate = preset.generator_rate
            self.optimisers["generator"] = torch.optim.Adam(self.generator.parameters(), lr=rate, fused=True)
        modules = {"synthesis": self.network.synthesis, "generator": self.generator}
        self._forward = {name: self.team.together(module) for name, module in modules.items() if module is not None}
        seed_apart(self.team, seed, 0)
        self.step, self.seconds, self.processor_seconds, self.log = 0, 0.0, 0.0, []
        self._clocks = (0.0, 0.0)

    def run(self, out: Path, tick: Callable[[int], object]) -> Bundle:
        """Train to the end, saving checkpoints in `out`; calls `tick` with the number of steps done.

        Raises InputError: the folder cannot be written, or the training diverged; the last checkpoint stays.
        """
        self._clocks = time.monotonic(), time.process_time()
        # Before the first step, so that a folder that cannot be written costs no training.
        if self.team.leads:
            write_json(out / LOG, self.log)
        while self.step < self.preset.steps:
            before, last = self.step, self.step + self.preset.steps_per_code >= self.preset.steps
            errors = self.round()
            if not all(map(math.isfinite, errors.values())):
                raise self._diverged(out)
            tick(self.step - before)
            if not self.team.leads:
                continue
            if last or _passed(before, self.step, self.preset.log_every):
                self._note(out, errors)
            if not last and _passed(before, self.step, self.preset.save_every):
                self._count_time()
                self.save(out)
        return self.finish(out)

    def _note(self, out: Path, errors: dict[str, float]) -> None:
        """Add to the log: times, errors of this round, errors on the validation frames."""
        self._count_time()
        times = {"seconds": self.seconds, "processor_seconds": self.processor_seconds}
        entry = {"step": self.step} | times | errors | validate(self.network, self.styles, self.scaling)
        if not all(value is None or math.isfinite(value) for value in entry.values()):
            raise self._diverged(out)
        self.log.append(entry)
        write_json(out / LOG, self.log)

    def _diverged(self, out: Path) -> InputError:
        return InputError(f"training diverged at step {self.step}: its numbers are no longer finite", out)

    def _count_time(self) -> None:
        """Add the time since the last count: by the clock, and of the processors, which other work does not stretch."""
        clocks = time.monotonic(), time.process_time()
        self.seconds += clocks[0] - self._clocks[0]
        self.processor_seconds += clocks[1] - self._clocks[1]
        self._clocks = clocks

    def round(self) -> dict[str, float]:
        """One generator pass, the synthesis steps that its codes serve, and the generator's update."""
        self.network.train()
        how, chosen = self.preset, self.styles_of_round()
        self._set_rates()
        codes = self._codes(chosen)
        shared = codes.detach().requires_grad_(codes.requires_grad)
        errors = [self._synthesis_step(chosen, shared) for _ in range(how.steps_per_code)]
        if shared.grad is not None:
            self.optimisers["generator"].zero_grad(set_to_none=True)
            codes.backward(shared.grad / how.steps_per_code)
            self.optimisers["generator"].step()
        self.step += how.steps_per_code
        mse, bll = self.team.mean(torch.tensor(errors, dtype=torch.float64).mean(dim=0)).tolist()
        return {"mse": mse, "bll": bll}

    def styles_of_round(self) -> np.ndarray:
        """The styles of the next round, as numbers: drawn, or the next ones in turn."""
        how = self.preset
        if not how.in_turn:
            return self.sampler.draw_styles(how.styles_per_step)
        first = self.step // how.steps_per_code * how.styles_per_step
        return np.arange(first, first + how.styles_per_step) % len(self.styles)

    def l1_terms(self, chosen: np.ndarray) -> Tensor:
        """The L1 terms of a step ([M18] Eq. 3): of the shared weights, and of the adapters of the step's styles."""
        how, network, total = self.preset, self.network.synthesis, torch.zeros(())
        if how.shared_l1:
            total = total + how.shared_l1 * mean_absolute(shared_weights(network))
        if how.style_l1:
            own = [mean_absolute(style_weights(network, style)) for style in chosen.tolist()]
            total = total + how.style_l1 * torch.stack(own).mean()
        return total

    def loss(
        self, y: Float[Tensor, "rows outputs"], predicted: Float[Tensor, "rows outputs"], chosen: np.ndarray
    ) -> tuple[Tensor, Tensor, Tensor]:
        """The loss of a step of some styles, and its parts: squared error and bone-length error ([M22] Eq. 5)."""
        mse = squared_error(y, predicted)
        bll = bone_length_loss(y, predicted, self.lengths, self.scaling)
        return mse + self.preset.bone_weight * bll + self.l1_terms(chosen), mse, bll

    def _codes(self, chosen: np.ndarray) -> Tensor:
        """Codes of the styles drawn: of a clip of each, or which style it is."""
        if self.generator is None:
            return self.team.share(style_codes(self.network, len(self.styles))[chosen])
        clips = self.team.share(self.sampler.draw_clips(chosen))
        with torch.autocast("cpu", dtype=torch.bfloat16, enabled=self.preset.mixed):
            return self._forward["generator"](clips)

    def _synthesis_step(self, chosen: np.ndarray, codes: Tensor) -> tuple[float, float]:
        batch = self.sampler.draw_frames(chosen, self.preset.frames_per_style)
        x, p, y = (self.team.share(rows) for rows in (batch.x, batch.p, batch.y))
        spread = codes.repeat_interleave(self.preset.frames_per_style, dim=0)
        with torch.autocast("cpu", dtype=torch.bfloat16, enabled=self.preset.mixed):
            predicted = self._forward["synthesis"](x, p, spread)
        loss, mse, bll = self.loss(y, predicted, chosen)
        self.optimisers["synthesis"].zero_grad(set_to_none=True)
        loss.backward()
        self.optimisers["synthesis"].step()
        return mse.item(), bll.item()

    def _set_rates(self) -> None:
        factor = rate_factor(self.step, self.preset)
        rates = {"synthesis": self.preset.network_rate, "generator": self.preset.generator_rate}
        for name, optimiser in self.optimisers.items():
            for group in optimiser.param_groups:
                group["lr"] = rates[name] * factor

    def save(self, out: Path) -> None:
        """Write a checkpoint. Raises InputError where it cannot be written, or where the weights are not finite."""
        if not all(torch.isfinite(tensor).all() for tensor in self.network.parameters()):
            raise self._diverged(out)
        state = {"step": self.step, "seconds": self.seconds, "processor_seconds": self.processor_seconds}
        state |= {"rng": self.rng.bit_generator.state, "log": self.log}
        checkpoint.write_checkpoint(out, self.identity | state, checkpoint.pack(self.network, self.optimisers))

    def resume(self, out: Path) -> None:
        """Go on from the checkpoint in `out`, if there is one. Raises InputError if it is damaged or of another run."""
        found = checkpoint.read_checkpoint(out, self.identity)
        if found is None:
            return
        state, tensors = found
        try:
            checkpoint.unpack(tensors, self.network, self.optimisers)
            self.rng.bit_generator.state = state["rng"]
            self.step, self.seconds, self.log = state["step"], state["seconds"], state["log"]
            self.processor_seconds = state["processor_seconds"]
            seed_apart(self.team, self.seed, self.step)
        except (KeyError, TypeError, ValueError, RuntimeError) as error:
            raise checkpoint.damaged(out, error) from error

    def finish(self, out: Path) -> Bundle:
        """Write the trained model, then remove the checkpoint; who does not lead reads what the leader wrote."""
        if not self.team.leads:
            self.team.wait()
            return load_bundle(out)
        self.network.eval()
        codes = stored_codes(self.network, self.styles, self.scaling)
        bundle = Bundle(self.model, self.network, self.preset.network, self.body, self.normaliser, codes, self._about())
        save_bundle(out, bundle)
        checkpoint.remove_checkpoint(out)
        self.team.wait()
        return bundle

    def _about(self) -> dict[str, Any]:
        """Where the weights come from."""
        catalogue = self.store.catalogue
        dataset = catalogue.dataset
        about = {"data": dataset.name, "origin": dataset.origin, "licence": dataset.licence, "credit": dataset.credit}
        about |= {"gaits": sorted(catalogue.gaits), "phases": self.preset.phases}
        about |= {"preset": self.preset_name, "seed": self.seed, "steps": self.step}
        return about | {"seconds": round(self.seconds, 1), "processor_seconds": round(self.processor_seconds, 1)}


def trained(
    store: VectorStore, model: str, preset: Preset, name: str, seed: int, tick: Callable[[int], object]
) -> Bundle:
    """A network trained to be looked at and forgotten: nothing of its training stays on disk."""
    with TemporaryDirectory() as folder:
        return Trainer(store, model, preset, name, seed).run(Path(folder), tick)


def rate_factor(step: int, preset: Preset) -> float:
    """Factor of the learning rates: warm-up, a plateau, then a linear fall."""
    rise = min(1.0, (step + 1) / preset.warm_up) if preset.warm_up else 1.0
    begin = preset.decay_from * preset.steps
    if step <= begin:
        return rise
    share = (step - begin) / max(preset.steps - begin, 1)
    return 1.0 + share * (preset.decay_to - 1.0)


def _passed(before: int, after: int, every: int) -> bool:
    return before // every != after // every
