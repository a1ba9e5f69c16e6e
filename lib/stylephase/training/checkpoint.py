"""Checkpoints of a training run: a killed run goes on from the last one exactly, and no run overwrites another."""

from pathlib import Path
from typing import Any

import torch
from torch import Tensor, nn

from stylephase.errors import InputError
from stylephase.files import read_json, write_json
from stylephase.models.bundle import description, is_bundle, load_tensors, save_tensors

LOG = "log.json"
_STATE, _TENSORS = "state.json", "checkpoint.safetensors"
# What a kill in the middle of writing leaves: the temporary files of `files.replacing`.
_LEFT_BY_A_KILL = (".*-checkpoint.*.safetensors", ".weights.*.safetensors", ".state.*.json")
# The part of a run's identity that its finished model tells.
_TOLD = ("model", "data", "preset", "seed", "styles")

Optimisers = dict[str, torch.optim.Optimizer]


def check_folder(out: Path, identity: dict[str, Any], *, resume: bool) -> None:
    """Raise InputError where a run with this identity must not use the folder.

    Without `resume` the folder must hold no run, finished or interrupted; with it, none but this very run.
    """
    finished, interrupted = is_bundle(out), (out / _STATE).exists()
    if (finished or interrupted) and not resume:
        kind = "a finished" if finished else "an interrupted"
        raise InputError(f"holds {kind} run; choose another folder, or keep to that run with --resume", out)
    if finished:
        _check_same(description(out), {key: identity[key] for key in _TOLD}, out)
    elif interrupted:
        _check_same(_read_state(out), identity, out)


def write_checkpoint(out: Path, state: dict[str, Any], tensors: dict[str, Tensor]) -> None:
    """Write the tensors under a name of their own, then the state that points to them, then remove the older ones.

    At any moment the state points to a whole file. `state` holds the run's identity and its `step`.
    """
    file = f"{state['step']}-{_TENSORS}"
    save_tensors(out / file, tensors)
    write_json(out / _STATE, state | {"tensors": file})
    _remove_tensors(out, but=file)


def read_checkpoint(out: Path, identity: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Tensor]] | None:
    """State and tensors of the checkpoint in `out`, if there is one.

    Raises InputError: the checkpoint is of another run, or a file of it is missing or damaged.
    """
    if not (out / _STATE).exists():
        return None
    state = _read_state(out)
    _check_same(state, identity, out)
    return state, load_tensors(out / str(state.get("tensors")))


def remove_checkpoint(out: Path) -> None:
    """Remove the checkpoint of a finished run, and what a kill left of an unfinished one."""
    (out / _STATE).unlink(missing_ok=True)
    _remove_tensors(out)


def pack(network: nn.Module, optimisers: Optimisers) -> dict[str, Tensor]:
    """Weights, moments of the optimisers and torch's random state, by name."""
    tensors = {f"network.{name}": tensor for name, tensor in network.state_dict().items()}
    for name, optimiser in optimisers.items():
        for number, moments in optimiser.state_dict()["state"].items():
            tensors |= {f"{name}.{number}.{kind}": value for kind, value in moments.items()}
    return tensors | {"random": torch.get_rng_state()}


def unpack(tensors: dict[str, Tensor], network: nn.Module, optimisers: Optimisers) -> None:
    """The inverse of `pack`; raises KeyError, RuntimeError or ValueError where the tensors are of something else."""
    network.load_state_dict(_under("network.", tensors))
    for name, optimiser in optimisers.items():
        moments: dict[int, dict[str, Tensor]] = {}
        for key, tensor in _under(f"{name}.", tensors).items():
            number, _, kind = key.partition(".")
            moments.setdefault(int(number), {})[kind] = tensor
        optimiser.load_state_dict({"state": moments, "param_groups": optimiser.state_dict()["param_groups"]})
    torch.set_rng_state(tensors["random"])


def damaged(out: Path, error: Exception) -> InputError:
    """The error that tells of a checkpoint whose content does not fit."""
    what = f"it lacks {error}" if isinstance(error, KeyError) else str(error)
    return InputError(f"not a checkpoint of this run: {what}", out / _STATE)


def _read_state(out: Path) -> dict[str, Any]:
    state = read_json(out / _STATE)
    if not isinstance(state, dict):
        raise InputError("not the state of a training run", out / _STATE)
    return state


def _check_same(held: dict[str, Any], identity: dict[str, Any], out: Path) -> None:
    differing = [key for key, value in identity.items() if held.get(key) != value]
    if differing:
        raise InputError(f"holds another run, of which these differ: {', '.join(differing)}", out)


def _remove_tensors(out: Path, but: str = "") -> None:
    for pattern in (f"*-{_TENSORS}", *_LEFT_BY_A_KILL):
        for path in out.glob(pattern):
            if path.name != but:
                path.unlink()


def _under(prefix: str, tensors: dict[str, Tensor]) -> dict[str, Tensor]:
    return {name.removeprefix(prefix): tensor for name, tensor in tensors.items() if name.startswith(prefix)}
