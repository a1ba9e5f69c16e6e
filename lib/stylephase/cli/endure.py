"""Let styles wander at random for an hour, side by side, and tell which became implausible, when and why."""

from functools import partial
from typing import Annotated

import numpy as np
import torch
import typer
from tqdm import tqdm

from stylephase.cli.output import AsJson, emit
from stylephase.data.catalogue import check_styles
from stylephase.errors import InputError
from stylephase.evaluation import robustness
from stylephase.evaluation.robustness import Endurance
from stylephase.features.layout import FPS
from stylephase.models.released import RELEASE, load_weights
from stylephase.models.released_pfnn import PFNN_RELEASE
from stylephase.runtime.finishing import RAW, Finishing
from stylephase.runtime.graph import FastNetwork, to_onnx
from stylephase.runtime.limits import FASTEST
from stylephase.runtime.walkers import NetworkWalker

# An hour is what is meant; a day is the most. Shorter than settling says nothing.
_SHORTEST, _LONGEST = 4.0, 86_400.0


def endure(
    weights: Annotated[str, typer.Option(help="Folder of weights, or `release` for the authors' own.")],
    seconds: Annotated[float, typer.Option(help="How long each style wanders, of its own time.")] = 3600.0,
    styles: Annotated[str | None, typer.Option(help="Some styles alone, with commas between.")] = None,
    speed: Annotated[
        float | None, typer.Option(help="Speed in m/s about which each changes its own, instead of the style's.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of everything random.")] = 0,
    raw: Annotated[bool, typer.Option("--raw", help="As the network gives it, not grounded and not finished.")] = False,
    as_json: AsJson = False,
) -> None:
    """Let each style follow a random path of its own at random speeds with stops, faster than real time.

    A style counts as broken from the first frame that no person could do: hips out of height, bones of wrong lengths,
    far off its path, too fast, not a number. The report is the result, so the exit status is 0 whatever it says.
    """
    if not _SHORTEST <= seconds <= _LONGEST:
        raise InputError(f"--seconds is {seconds:g}; expected {_SHORTEST:g} to {_LONGEST:g}")
    if speed is not None and not 0 < speed <= FASTEST:
        raise InputError(f"--speed is {speed:g}; expected above 0 and at most {FASTEST:g} m/s")
    if weights == PFNN_RELEASE:
        raise InputError(f"{PFNN_RELEASE} has gaits and no styles; expected a folder of trained weights or {RELEASE}")
    bundle = load_weights(weights)
    names = bundle.styles if styles is None else tuple(name.strip() for name in styles.split(","))
    check_styles(names, bundle.styles)
    codes = torch.stack([bundle.code(name) for name in names])
    walker = NetworkWalker(bundle)
    start, curves = walker.start(codes), walker.curves(names, grounded=not raw)
    gains = np.array([curves[name].gain(speed or curves[name].own) for name in names])
    fast = FastNetwork(to_onnx(bundle), threads=torch.get_num_threads())
    led, finishing = ((), RAW) if raw else ([curves[name] for name in names], Finishing())
    with tqdm(total=int(seconds * FPS), desc="endure", unit="frame", disable=None) as bar:
        run = partial(robustness.endure, bundle, names, codes, start, gains, seconds, tick=bar.update)
        found = run(seed=seed, curves=led, finishing=finishing, fast=fast)
    held = sum(not each.broken for each in found)
    result = {"weights": weights, "licence": bundle.about.get("licence"), "seconds": seconds, "seed": seed, "raw": raw}
    result |= {"plausible": held, "of": len(found), "styles": robustness.as_json(found)}
    emit(result, as_json=as_json, text=_text(found, seconds))


def _text(found: list[Endurance], seconds: float) -> str:
    """A line for each style, who broke first on top."""
    held = sum(not each.broken for each in found)
    lines = [f"{held} of {len(found)} styles stay plausible for {seconds:g} s"]
    for each in sorted(found, key=lambda e: (not e.broken, e.after)):
        verdict = f"{each.broken} after {each.after:.1f} s" if each.broken else "plausible"
        extremes = f"hips {each.hips[0]:.2f} to {each.hips[1]:.2f} m, bones off {100 * each.bones:.1f} %"
        lines.append(f"{each.style:24} {verdict:32} {extremes}, off path {each.off_path:.2f} m, {each.speed:.2f} m/s")
    return "\n".join(lines)
