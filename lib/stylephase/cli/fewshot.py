"""Teach a trained PFNN with adapters a new style from one short clip."""

import time
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from tqdm import tqdm

from stylephase.cli.output import AsJson, emit
from stylephase.errors import InputError
from stylephase.evaluation.inspection import gait_of
from stylephase.features.captures import captured_clip, clip_vectors
from stylephase.features.cycles import cycles_of
from stylephase.features.layout import FPS
from stylephase.features.store import StyleVectors
from stylephase.models.bundle import check_new_style, load_bundle, save_bundle
from stylephase.models.zoo import adapter_forms
from stylephase.training.fewshot import ADAPTERS, FewShot, Lesson, Schedule, add_styles

# With fewer whole cycles than this a style is learned from next to nothing.
_FEW = 2
_AHEAD = "walks ahead"
_ONE_CYCLE = "a single cycle of walking; turns and other speeds will come out worse than from two or more"


def fewshot(
    weights: Annotated[Path, typer.Option(help="Folder of a trained PFNN with adapters, such as pfnn-cp.")],
    clip: Annotated[Path, typer.Option(help="BVH file of someone who walks in the new style, on the weights' body.")],
    style: Annotated[str, typer.Option(help="Name of the new style.")],
    out: Annotated[Path, typer.Option(help="Folder for the weights that know one style more.")],
    adapter: Annotated[str, typer.Option(help=", ".join(ADAPTERS))] = FewShot.adapter,
    factors: Annotated[int, typer.Option(min=1, help="Factors of the adapter cp.")] = FewShot.factors,
    dropout: Annotated[float, typer.Option(min=0.0, max=0.95, help="Dropout in front of it.")] = FewShot.dropout,
    asymmetric: Annotated[bool, typer.Option("--asymmetric", help="The mirrored clip is of another style.")] = False,
    steps: Annotated[int, typer.Option(min=1, help="Steps of the training.")] = Schedule.steps,
    seed: Annotated[int, typer.Option(min=0, help="Seed of everything random.")] = 0,
    as_json: AsJson = False,
) -> None:
    """Learn an adapter for one more style; the network and the styles that it knows stay as they are."""
    check_new_style(style, out)
    how = FewShot(adapter, factors, dropout)
    # Raises for an adapter that there is not.
    _ = how.form
    base, begun = load_bundle(weights), time.monotonic()
    # Before the clip is read: weights of another kind learn a style in other ways.
    adapter_forms(base.model, len(base.styles), base.settings)
    data = str(base.about.get("data", ""))
    moving = captured_clip(clip, base.body, data)
    vectors = clip_vectors(moving, style, base.body, "adaptive", data, symmetric=not asymmetric)
    cycles = cycles_of(vectors)
    if not len(cycles):
        raise InputError("no walking cycle in it: neither foot comes down twice", clip)
    if len(cycles) < _FEW:
        typer.echo(f"stylephase: {clip}: {_ONE_CYCLE}", err=True)
    if (gait := _gait(vectors)) != _AHEAD:
        typer.echo(f"stylephase: {clip}: who {gait} in it teaches no walk; expected a clip that {_AHEAD}", err=True)
    with tqdm(total=steps, desc=style, unit="step", disable=None) as bar:
        found = add_styles(base, [Lesson(vectors, how)], Schedule(steps), seed=seed, tick=bar.update)
    learned = {"style": style, "frames": len(cycles.rows()), "cycles": len(cycles), "symmetric": not asymmetric}
    learned |= {"adapter": adapter, "dropout": dropout, "steps": steps, "seed": seed}
    if adapter == "cp":
        learned["factors"] = factors
    about = base.about | {"few_shot": [*base.about.get("few_shot", []), learned]}
    save_bundle(out, replace(found, about=about))
    seconds = time.monotonic() - begun
    text = (
        f"{out}: {style} learned from {learned['frames']} frames, {len(cycles)} whole cycles of {len(moving) / FPS:.1f}"
    )
    emit(
        {"out": out} | learned | {"seconds": seconds, "styles": list(found.styles)},
        as_json=as_json,
        text=f"{text} s of motion, in {seconds:.0f} s",
    )


def _gait(vectors: StyleVectors) -> str:
    """What is done in a clip: y begins with the root's step to its left and ahead, and ends with the contacts."""
    left, ahead = FPS * vectors.y[:, :2].mean(axis=0)
    in_the_air = (vectors.y[:, -2:] < 0.5).all(axis=1)
    return gait_of(float(np.hypot(left, ahead)), float(np.degrees(np.arctan2(left, ahead))), float(in_the_air.mean()))
