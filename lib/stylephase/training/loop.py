"""The training loop of LPN-FiLM ([M22] 4.3), with checkpoints that a killed run resumes from exactly."""

import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from stylephase.errors import InputError
from stylephase.features.normaliser import Normaliser, normaliser_of
from stylephase.features.store import StyleVectors, VectorStore
from stylephase.files import read_json, write_json
from stylephase.models.bundle import Bundle, build_network, load_tensors, save_bundle, save_tensors
from stylephase.training.codes import style_code
from stylephase.training.losses import bone_length_loss, bone_lengths, squared_error
from stylephase.training.presets import Preset
from stylephase.training.progress import validate
from stylephase.training.sampler import Sampler, Scaling

_STATE, _TENSORS, _LOG = "state.json", "checkpoint.safetensors", "log.json"


class Trainer:
    """One training run: data in memory, network, two optimisers, and all random state."""

    def __init__(self, store: VectorStore, model: str, preset: Preset, preset_name: str, seed: int):
        self.store, self.model, self.preset, self.seed = store, model, preset, seed
        self.identity = {"model": model, "data": store.catalogue.dataset.name, "preset": preset_name, "seed": seed}
        self.identity |= {"styles": list(store.catalogue.styles), "settings": repr(preset)}
        self.styles: list[StyleVectors] = [store.load(style) for style in store.catalogue.styles]
        self.body, self.preset_name = store.body, preset_name
        self.normaliser: Normaliser = normaliser_of(self.styles, self.body.layout)
        self.scaling = Scaling(self.normaliser, self.body.layout)
        torch.manual_seed(seed)
        self.rng = np.random.default_rng(seed)
        self.network = build_network(self.body, preset.network)
        self.network.generator.start_neutral()
        self.sampler = Sampler(self.styles, self.scaling, self.rng)
        self.lengths = bone_lengths(self.body)
        self.optimisers = {
            "synthesis": torch.optim.Adam(self.network.synthesis.parameters(), lr=preset.network_rate, fused=True),
            "generator": torch.optim.Adam(self.network.generator.parameters(), lr=preset.generator_rate, fused=True),
        }
        self.step, self.seconds, self.processor_seconds, self.log = 0, 0.0, 0.0, []
        self._clocks = (0.0, 0.0)

    def run(self, out: Path, tick: Callable[[int], None]) -> Bundle:
        """Train to the end, saving checkpoints in `out`; calls `tick` with the number of steps done."""
        self._clocks = time.monotonic(), time.process_time()
        while self.step < self.preset.steps:
            before = self.step
            errors = self.round()
            if not np.isfinite(errors["mse"]):
                raise InputError(f"training diverged at step {self.step}: the loss is not finite")
            tick(self.step - before)
            if _passed(before, self.step, self.preset.log_every) or self.step >= self.preset.steps:
                self._count_time()
                times = {"seconds": self.seconds, "processor_seconds": self.processor_seconds}
                self.log.append({"step": self.step} | times | errors | validate(self))
                write_json(out / _LOG, self.log)
            if _passed(before, self.step, self.preset.save_every) and self.step < self.preset.steps:
                self._count_time()
                self.save(out)
        return self.finish(out)

    def _count_time(self) -> None:
        """Add the time since the last count: by the clock, and of the processors, which other work does not stretch."""
        clocks = time.monotonic(), time.process_time()
        self.seconds += clocks[0] - self._clocks[0]
        self.processor_seconds += clocks[1] - self._clocks[1]
        self._clocks = clocks

    def round(self) -> dict[str, float]:
        """One generator pass, the synthesis steps that its codes serve, and the generator's update."""
        self.network.train()
        how, chosen = self.preset, self.sampler.draw_styles(self.preset.styles_per_step)
        self._set_rates()
        with torch.autocast("cpu", dtype=torch.bfloat16, enabled=how.mixed):
            codes = self.network.generator(self.sampler.draw_clips(chosen))
        shared = codes.detach().requires_grad_()
        errors = [self._synthesis_step(chosen, shared) for _ in range(how.steps_per_code)]
        assert shared.grad is not None
        self.optimisers["generator"].zero_grad(set_to_none=True)
        codes.backward(shared.grad / how.steps_per_code)
        self.optimisers["generator"].step()
        self.step += how.steps_per_code
        mse, bll = np.mean(errors, axis=0)
        return {"mse": float(mse), "bll": float(bll)}

    def _synthesis_step(self, chosen: np.ndarray, codes: Tensor) -> tuple[float, float]:
        batch = self.sampler.draw_frames(chosen, self.preset.frames_per_style)
        spread = codes.repeat_interleave(self.preset.frames_per_style, dim=0)
        with torch.autocast("cpu", dtype=torch.bfloat16, enabled=self.preset.mixed):
            predicted = self.network.synthesis(batch.x, batch.p, spread)
        mse = squared_error(batch.y, predicted)
        bll = bone_length_loss(batch.y, predicted, self.lengths, self.scaling)
        self.optimisers["synthesis"].zero_grad(set_to_none=True)
        (mse + self.preset.bone_weight * bll).backward()
        self.optimisers["synthesis"].step()
        return mse.item(), bll.item()

    def _set_rates(self) -> None:
        factor = rate_factor(self.step, self.preset)
        for name, rate in (("synthesis", self.preset.network_rate), ("generator", self.preset.generator_rate)):
            for group in self.optimisers[name].param_groups:
                group["lr"] = rate * factor

    def save(self, out: Path) -> None:
        """Write a checkpoint: first the tensors under a name of their own, then the state that points to them."""
        tensors = {f"network.{name}": tensor for name, tensor in self.network.state_dict().items()}
        for name, optimiser in self.optimisers.items():
            for number, moments in optimiser.state_dict()["state"].items():
                tensors |= {f"{name}.{number}.{key}": torch.as_tensor(value) for key, value in moments.items()}
        tensors["random"] = torch.get_rng_state()
        file = f"{self.step}-{_TENSORS}"
        save_tensors(out / file, tensors)
        state = {"step": self.step, "seconds": self.seconds, "processor_seconds": self.processor_seconds}
        state |= {"tensors": file, "rng": self.rng.bit_generator.state}
        write_json(out / _STATE, self.identity | state | {"log": self.log})
        for old in out.glob(f"*-{_TENSORS}"):
            if old.name != file:
                old.unlink()

    def resume(self, out: Path) -> None:
        """Go on from the checkpoint in `out`, if there is one. Raises InputError if it is of another run."""
        if not (out / _STATE).exists():
            return
        state = read_json(out / _STATE)
        differing = [key for key, value in self.identity.items() if state.get(key) != value]
        if differing:
            raise InputError(f"the checkpoint is of another run: {', '.join(differing)} differ", out / _STATE)
        tensors = load_tensors(out / state["tensors"])
        self.network.load_state_dict(_take(tensors, "network."))
        for name, optimiser in self.optimisers.items():
            moments: dict[int, dict[str, Tensor]] = {}
            for key, tensor in _take(tensors, f"{name}.").items():
                number, _, kind = key.partition(".")
                moments.setdefault(int(number), {})[kind] = tensor
            optimiser.load_state_dict({"state": moments, "param_groups": optimiser.state_dict()["param_groups"]})
        torch.set_rng_state(tensors["random"])
        self.rng.bit_generator.state = state["rng"]
        self.step, self.seconds, self.log = state["step"], state["seconds"], state["log"]
        self.processor_seconds = state["processor_seconds"]

    def finish(self, out: Path) -> Bundle:
        """Write the trained model and remove the checkpoint."""
        self.network.eval()
        codes = {style.style: style_code(self.network.generator, style, self.scaling) for style in self.styles}
        dataset = self.store.catalogue.dataset
        about = {"data": dataset.name, "origin": dataset.origin, "licence": dataset.licence, "credit": dataset.credit}
        about |= {"preset": self.preset_name, "seed": self.seed, "phases": self.preset.phases, "steps": self.step}
        about |= {"seconds": round(self.seconds, 1), "processor_seconds": round(self.processor_seconds, 1), "gaits": sorted(self.store.catalogue.gaits)}
        bundle = Bundle(self.model, self.network, self.preset.network, self.body, self.normaliser, codes, about)
        save_bundle(out, bundle)
        for name in (_STATE, *(path.name for path in out.glob(f"*-{_TENSORS}"))):
            (out / name).unlink(missing_ok=True)
        return bundle

    def description(self) -> dict[str, Any]:
        """What this run is, for its folder."""
        return self.identity | {"preset_values": asdict(self.preset)}


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


def _take(tensors: dict[str, Tensor], prefix: str) -> dict[str, Tensor]:
    return {name.removeprefix(prefix): tensor for name, tensor in tensors.items() if name.startswith(prefix)}
